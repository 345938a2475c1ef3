"""The checks of Noise model, on made-up noisy IMUs."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from grader.engine.findings import Charged
from grader.labs.imu.diagnosis.noise import Facts as Reads
from grader.labs.imu.noise_model import checks, explain
from grader.labs.imu.noise_model import measure as runs
from grader.labs.imu.noise_model.measure import Facts
from tests.judging.made import Case, Made, finding, is_as_marked, marked, truth, words
from tests.test_nonsense import kept

SIZE, GIVEN, DEFAULT, WHITE, APART, ALONE = (
    checks.check_noise_size,
    checks.check_given_bias,
    checks.check_default_bias,
    checks.check_white_and_gaussian,
    checks.check_axes_and_sensors_independent,
    checks.check_leaves_simulation_alone,
)


class Sound:
    """The sheet's noisy IMU, in steps that a faulty one changes."""

    seeds = np.random.SeedSequence(11)

    def __init__(
        self, model: Any, data: Any, accel_id: int, gyro_id: int, accel_noise_std: float = 0.05,
        gyro_noise_std: float = 0.005, accel_bias: Any = None, gyro_bias: Any = None,
    ) -> None:  # fmt: skip
        self.model, self.data, self.ids = model, data, (accel_id, gyro_id)
        self.stds = (accel_noise_std, gyro_noise_std)
        self.seed()
        given = (accel_bias, gyro_bias)
        self.biases = [
            self.bias(i, size, value) for i, (size, value) in enumerate(zip((0.1, 0.01), given, strict=True))
        ]
        self.reads = 0
        self.begin()

    def seed(self) -> None:
        """Every instance has a stream of its own; the same global seed gives the same ones."""
        self.rng = np.random.default_rng(np.random.randint(0, 2**31))

    def begin(self) -> None:
        """Whatever else there is to remember."""

    def bias(self, which: int, size: float, given: Any) -> Any:
        return self.rng.normal(0, size, 3) if given is None else np.array(given, float)

    def clean(self, which: int) -> np.ndarray:
        first = self.model.sensor_adr[self.ids[which]]
        return np.array(self.data.sensordata[first : first + 3])

    def noise(self, which: int) -> Any:
        return self.rng.normal(0, self.stds[which], 3)

    def one(self, which: int) -> Any:
        return self.clean(which) + self.biases[which] + self.noise(which)

    def read(self) -> Any:
        answer = self.one(0), self.one(1)
        self.reads += 1
        return answer


def of(**steps: Any) -> type:
    """A noisy IMU that differs from the sound one in these steps."""
    return type("Noisy", (Sound,), steps)


def both(*kinds: type, **steps: Any) -> type:
    """A noisy IMU with the steps of several."""
    return type("Both", kinds, steps)


def unseeded(kind: type = Sound) -> type:
    """One that draws other numbers from the same global seed."""
    seeds = itertools.count(100)
    return both(kind, seed=lambda s: setattr(s, "rng", np.random.default_rng(next(seeds))))


class Refusing(Sound):
    """One that takes no standard deviation of zero."""

    def begin(self) -> None:
        if min(self.stds) <= 0:
            raise ValueError("a standard deviation is positive")


class Dividing(Sound):
    """One that makes its noise in units of the standard deviation, which leaves no number of a zero."""

    def noise(self, which: int) -> Any:
        return np.divide(super().noise(which), self.stds[which]) * self.stds[which]


class RefusingMuch(Sound):
    """One that takes no large standard deviation."""

    def begin(self) -> None:
        if max(self.stds) > 0.1:
            raise ValueError("too much noise")


class OneSeed(Sound):
    """The same numbers in every instance."""

    def seed(self) -> None:
        self.rng = np.random.default_rng(42)


class SeedInRead(OneSeed):
    """The same numbers in every read."""

    def read(self) -> Any:
        self.seed()
        return super().read()


class Renamed(Sound):
    """Other names than the sheet's."""

    def __init__(
        self, model: Any, data: Any, accel_id: int, gyro_id: int, a_std: float = 0.05, gyro_noise_std: float = 0.005,
        accel_bias: Any = None, gyro_bias: Any = None,
    ) -> None:  # fmt: skip
        super().__init__(model, data, accel_id, gyro_id, a_std, gyro_noise_std, accel_bias, gyro_bias)


class Walking(Sound):
    """Noise that adds up."""

    def begin(self) -> None:
        self.sums = [np.zeros(3), np.zeros(3)]

    def drawn(self, which: int) -> Any:
        return super().noise(which)

    def noise(self, which: int) -> Any:
        self.sums[which] = self.sums[which] + self.drawn(which)
        return self.sums[which]


class Remembering(Sound):
    """Each read keeps half of the noise before."""

    def begin(self) -> None:
        self.last = [np.zeros(3), np.zeros(3)]

    def drawn(self, which: int) -> Any:
        return super().noise(which)

    def noise(self, which: int) -> Any:
        self.last[which] = 0.5 * self.last[which] + self.drawn(which)
        return self.last[which]


class OfLongMemory(Sound):
    """Each read has a part of the noise some reads before."""

    lags: tuple[int, ...] = (2,)

    def begin(self) -> None:
        self.drawn = [[np.zeros(3)] * 4 for _ in (0, 1)]

    def noise(self, which: int) -> Any:
        self.drawn[which].append(super().noise(which))
        return self.drawn[which][-1] + sum(0.3 * self.drawn[which][-1 - lag] for lag in self.lags)


class OneBiasOfTheClass(Sound):
    """The bias of the last instance that was made."""

    kept: tuple[Any, Any]

    def begin(self) -> None:
        type(self).kept = (self.biases[0], self.biases[1])

    def one(self, which: int) -> Any:
        return self.clean(which) + self.kept[which] + self.noise(which)


class FirstOnly(Sound):
    """A bias in the first read alone."""

    def one(self, which: int) -> Any:
        return self.clean(which) + self.biases[which] * (self.reads == 0) + self.noise(which)


class OneDraw(Sound):
    """The same three numbers for both sensors, times the size of each."""

    axes = 3

    def begin(self) -> None:
        self.drawn = np.zeros(self.axes)

    def noise(self, which: int) -> Any:
        if which == 0:
            self.drawn = self.rng.normal(0, 1, self.axes)
        noise = super().noise(which)
        noise[: self.axes] = self.drawn * self.stds[which]
        return noise


class Drifting(Sound):
    """A bias that walks."""

    def one(self, which: int) -> Any:
        self.biases[which] = self.biases[which] + self.rng.normal(0, (0.002, 0.0002)[which], 3)
        return super().one(which)


class DriftingMuch(Sound):
    """A bias that walks five times as far in a read as the noise goes."""

    def one(self, which: int) -> Any:
        self.biases[which] = self.biases[which] + self.rng.normal(0, (0.25, 0.025)[which], 3)
        return super().one(which)


class GyroWalking(Walking):
    """Noise of the gyroscope that adds up."""

    def noise(self, which: int) -> Any:
        return super().noise(which) if which else self.drawn(which)


class Redrawn(Sound):
    """A bias that is drawn on every read."""

    def one(self, which: int) -> Any:
        return self.clean(which) + self.rng.normal(0, (0.1, 0.01)[which], 3) + self.noise(which)


class Jumping(Sound):
    """A jump of the accelerometer now and then, whatever noise is asked for."""

    size, share = 2.0, 0.01

    def one(self, which: int) -> Any:
        jump = self.rng.choice([-self.size, self.size], 3) * (self.rng.random() < self.share)
        return super().one(which) + (jump if which == 0 else 0)


class JumpingOnTwoAxes(Jumping):
    """The same jump on two axes."""

    def one(self, which: int) -> Any:
        jump = self.size * (self.rng.random() < self.share) * np.array([1, 1, 0])
        return Sound.one(self, which) + (jump if which == 0 else 0)


class Frozen(Sound):
    """One draw for all reads."""

    def begin(self) -> None:
        self.drawn = [super().noise(0), super().noise(1)]

    def noise(self, which: int) -> Any:
        return self.drawn[which]


class OwnOffset(Sound):
    """An offset of each instance, and no noise."""

    def begin(self) -> None:
        self.own = [self.rng.normal(0, size, 3) for size in (0.1, 0.01)]

    def one(self, which: int) -> Any:
        return self.clean(which) + self.own[which]


class Stale(Sound):
    """The clean reading of the first read."""

    def begin(self) -> None:
        self.kept: dict[int, np.ndarray] = {}

    def clean(self, which: int) -> np.ndarray:
        return self.kept.setdefault(which, super().clean(which))


class Writing(Sound):
    """Noise into the simulator's own data."""

    def one(self, which: int) -> Any:
        answer = super().one(which)
        first = self.model.sensor_adr[self.ids[which]]
        self.data.sensordata[first : first + 3] = answer
        return answer


class Stepping(Sound):
    """A step for each read."""

    def read(self) -> Any:
        answer = super().read()
        mujoco.mj_step(self.model, self.data)
        return answer


def _scaled(by: float, *sensors: int) -> type:
    return of(noise=lambda s, i: Sound.noise(s, i) * (by if i in (sensors or (0, 1)) else 1.0))


def _on_one_axis(factor: float, *sensors: int) -> type:
    return of(noise=lambda s, i: Sound.noise(s, i) * ([factor, 1, 1] if i in (sensors or (0, 1)) else 1.0))


def _larger(kind: type, by: float = 2.0) -> type:
    return both(kind, noise=lambda s, i: kind.noise(s, i) * by)  # type: ignore[attr-defined]


def _of_gyro(kind: type) -> type:
    """The noise of another kind on the gyroscope alone."""
    return of(noise=lambda s, i: kind.noise(s, i) if i else Sound.noise(s, i))  # type: ignore[attr-defined]


def _beside_its_own(*sensors: int) -> type:
    """The bias that is given, added to one that is drawn."""
    drawn = lambda s, z, g: s.rng.normal(0, z, 3) + (0 if g is None else np.array(g))  # noqa: E731
    return of(bias=lambda s, i, z, g: drawn(s, z, g) if i in sensors else Sound.bias(s, i, z, g))


def _beside_its_own_below_zero(self: Any, which: int, size: float, given: Any) -> Any:
    return np.array(0 if given is None else given) - np.abs(self.rng.normal(0, size, 3))


def _unless_zero(self: Any, which: int, size: float, given: Any) -> Any:
    return np.array(given) if given is not None and np.any(given) else self.rng.normal(0, size, 3)


def _below_zero(self: Any, which: int, size: float, given: Any) -> Any:
    return -np.abs(self.rng.normal(0, size, 3)) if given is None else np.array(given)


def _unless_zero_below(self: Any, which: int, size: float, given: Any) -> Any:
    return _below_zero(self, which, size, given if given is not None and np.any(given) else None)


def _of_accel_alone(self: Any, which: int, size: float, given: Any) -> Any:
    return Sound.bias(self, which, size, given) * (given is None or which == 0)


def _first_component(self: Any, which: int, size: float, given: Any) -> Any:
    return Sound.bias(self, which, size, given) if given is None else np.full(3, given[0])


def _raises_without(self: Any, which: int, size: float, given: Any) -> Any:
    if given is None:
        raise ValueError("no bias")
    return np.array(given)


def _of_numbers(self: Any, which: int, size: float, given: Any) -> Any:
    return Sound.bias(self, which, size, given) if given is None else given.to_numpy()


def _enlarged(*sensors: int) -> type:
    return of(clean=lambda s, i: Sound.clean(s, i) * (1.05 if i in sensors else 1.0))


def _adding_to(name: str) -> Any:
    def read(self: Any) -> Any:
        answer = Sound.read(self)
        getattr(self.data, name)[0] += 0.01
        return answer

    return read


def _adding_to_time(self: Any) -> Any:
    answer = Sound.read(self)
    self.data.time += 0.01
    return answer


def _one_for_all_axes(self: Any, which: int) -> Any:
    return np.full(3, self.rng.normal(0, self.stds[which]))


def _opposite(self: Any, which: int) -> Any:
    x, _, z = Sound.noise(self, which)
    return np.array([x, -x, z])


def _nothing_given(self: Any, which: int, size: float, given: Any) -> Any:
    return self.rng.normal(0, size, 3)


def _truth_of_array(self: Any, which: int, size: float, given: Any) -> Any:
    return given or self.rng.normal(0, size, 3)


def _times(factor: float) -> Any:
    return lambda s, i, size, given: Sound.bias(s, i, size, given) * (1 if given is None else factor)


def _rolled(self: Any, which: int, size: float, given: Any) -> Any:
    return np.roll(Sound.bias(self, which, size, given), 1)


def _fixed(self: Any, which: int, size: float, given: Any) -> Any:
    return np.array([0.1, -0.2, 0.3]) * size if given is None else np.array(given)


def _one_number(self: Any, which: int, size: float, given: Any) -> Any:
    return np.full(3, self.rng.normal(0, size)) if given is None else np.array(given)


def _none(self: Any, which: int, size: float, given: Any) -> Any:
    return np.zeros(3) if given is None else np.array(given)


def _only_for(which: int) -> Any:
    return lambda s, i, size, given: Sound.bias(s, i, size, given) if i == which else _none(s, i, size, given)


class SharedBias(Sound):
    """The gyroscope's bias is a tenth of the accelerometer's."""

    def bias(self, which: int, size: float, given: Any) -> Any:
        if given is not None:
            return np.array(given, float)
        self.first = self.rng.normal(0, size, 3) if which == 0 else self.first / 10
        return self.first


def _drawn_times(factor: float) -> Callable[..., Any]:
    """Default biases that are so many times as large; given ones are used as they are."""
    return lambda s, i, z, g: Sound.bias(s, i, z, g) * (1.0 if g is not None else factor)


def _less_of_gyro(self: Any, which: int) -> Any:
    given = 1 if np.any(self.stds) else -1
    return self.clean(which) + self.biases[which] * (given if which else 1) + self.noise(which)


def _swapped(self: Any) -> Any:
    return tuple(reversed(Sound.read(self)))


def _crossed(self: Any, which: int) -> Any:
    return self.clean(which) + self.biases[1 - which] + self.noise(which)


def _raises(self: Any) -> Any:
    raise RuntimeError("broken")


SILENT = of(noise=lambda _s, _i: np.zeros(3))
UNIFORM = of(noise=lambda s, i: s.rng.uniform(-1, 1, 3) * s.stds[i] * 3**0.5)
POSITIVE = of(noise=lambda s, i: np.abs(Sound.noise(s, i)))
CUT = of(noise=lambda s, i: np.clip(Sound.noise(s, i), -2 * s.stds[i], 2 * s.stds[i]))
ROUNDED = of(one=lambda s, i: Sound.one(s, i).round(3))
IN_FIVES = of(one=lambda s, i: (Sound.one(s, i) / (0.005, 0.0005)[i]).round() * (0.005, 0.0005)[i])
JUMPING_OFTEN = both(Jumping, share=0.1)
LOST_READS = of(one=lambda s, i: Sound.one(s, i) * (s.rng.random() > 0.02))
LAPLACE = of(noise=lambda s, i: s.rng.laplace(0, s.stds[i], 3))
SAME_ON_AXES = of(noise=_one_for_all_axes)
NUMBER = of(read=lambda s: float(Sound.read(s)[0][0]))
NAN = of(noise=lambda s, i: Sound.noise(s, i) * np.nan)
MULTIPLICATIVE = of(one=lambda s, i: s.clean(i) * (1 + Sound.noise(s, i)) + s.biases[i])
NOTHING_GIVEN = of(bias=_nothing_given)
SHIFTED = of(noise=lambda s, i: Sound.noise(s, i) + 0.8 * s.stds[i])
ONE_SENSOR_BEYOND = of(noise=lambda s, i: Sound.noise(s, i) if i else np.zeros(3))
SWAPPED_STDS = of(noise=lambda s, i: s.rng.normal(0, s.stds[1 - i], 3))

CASES = [
    Case(name, check, lambda kind=kind: Made(NoisyIMU=kind), marked)  # type: ignore[misc]
    for check, rows in {
        SIZE: [
            ("sound", Sound, None),
            ("other parameters", Renamed, (0.5, ["other-parameters"])),
            ("a fifth too much of one", _scaled(1.2, 0), (0.0, [])),
            ("a fifth too much", _scaled(1.2), (0.0, [])),
            ("three hundredths", _scaled(1.03), None),
            ("stds exchanged", SWAPPED_STDS, (0.0, ["stds-swapped"])),
            ("the other sensor's noise and bias", both(SWAPPED_STDS, one=_crossed), (0.0, ["stds-swapped"])),
            ("three stds in place of a draw", of(noise=lambda s, i: 3 * s.stds[i]), (0.0, ["no-noise"])),
            ("the std in place of a draw", of(noise=lambda s, i: np.full(3, s.stds[i])), (0.0, ["no-noise"])),
            ("the variance", of(noise=lambda s, i: s.rng.normal(0, s.stds[i] ** 2, 3)), (0.0, ["variance-as-std"])),
            ("of a fixed size", of(noise=lambda s, i: s.rng.normal(0, (0.5, 0.05)[i], 3)), (0.0, ["std-ignored"])),
            ("none", SILENT, (0.0, ["no-noise"])),
            ("none of the gyroscope", ONE_SENSOR_BEYOND, (0.5, ["gyro-not-noisy"])),
            ("on no reading of a sensor", of(clean=lambda *_: np.array([1.0, -2.0, -9.81])), (0.0, [])),
            ("on no reading of a sensor, of no seed", unseeded(of(clean=lambda *_: np.zeros(3))), (0.0, [])),
            ("on a reading of long ago", Stale, None),
            ("an offset of each instance in place of a draw", OwnOffset, (0.0, ["no-noise"])),
            ("a constant in place of a draw", of(noise=lambda *_: np.array([0.1, -0.2, 0.3])), (0.0, ["no-noise"])),
            ("frozen", Frozen, (0.0, ["frozen-noise"])),
            ("with the size of the reading", MULTIPLICATIVE, (0.0, ["multiplicative-noise"])),
            ("one that adds up", Walking, None),
            ("one that remembers", Remembering, None),
            ("absolute values", POSITIVE, None),
            ("uniform of this size", UNIFORM, None),
            ("uniform, the size as half width", of(noise=lambda s, i: s.rng.uniform(-1, 1, 3) * s.stds[i]), None),
            ("cut off", CUT, None),
            ("a bias drawn on every read", Redrawn, None),
            ("a drift", Drifting, None),
            ("rounded", ROUNDED, None),
            ("jumps beside it, which are the law's", Jumping, None),
            ("many jumps beside it, which are the law's", JUMPING_OFTEN, None),
            ("jumps beside twice as much", _larger(Jumping), (0.0, [])),
            ("a density", of(noise=lambda s, i: Sound.noise(s, i) / 0.002**0.5), (0.0, ["noise-density"])),
            ("no numbers", NAN, (0.0, ["not-finite"])),
            ("a number", NUMBER, (0.0, ["wrong-return-type"])),
            ("raises", of(read=_raises), "raised"),
            ("too much on one axis", _on_one_axis(1.12), (0.0, [])),
            ("too much on one axis of the gyroscope", _on_one_axis(1.12, 1), (0.0, [])),
            ("a fifth too much of the gyroscope", _scaled(1.2, 1), (0.0, [])),
            ("the scale of a Laplace law", LAPLACE, None),
            (
                "a Laplace law of a fixed size",
                of(noise=lambda s, i: s.rng.laplace(0, (0.1, 0.01)[i], 3)),
                (0.0, ["std-ignored"]),
            ),
            ("an exponential law", of(noise=lambda s, i: s.rng.exponential(s.stds[i], 3)), None),
            ("absolute values, twice", _larger(POSITIVE), None),
            ("uniform, twice", _larger(UNIFORM), None),
            ("cut off, twice", _larger(CUT), (0.0, [])),
            ("one that adds up, twice", _larger(Walking), (0.0, [])),
            ("one that remembers, twice, which is its law's", _larger(Remembering), None),
            ("one that remembers, of no seed", unseeded(Remembering), None),
            ("one that remembers, twice, of no seed", unseeded(_larger(Remembering)), (0.0, [])),
            ("beside a drift, twice", _larger(Drifting), (0.0, [])),
            ("beside a drift, half as large", _larger(Drifting, 0.5), (0.0, [])),
            ("beside a drift that is larger", DriftingMuch, None),
            ("beside a drift that is larger, twice", _larger(DriftingMuch), (0.0, [])),
            ("beside a drift that is larger, half as large", _larger(DriftingMuch, 0.5), (0.0, [])),
            ("an exponential law below zero", of(noise=lambda s, i: -s.rng.exponential(s.stds[i], 3)), None),
            ("one of the gyroscope that adds up", GyroWalking, None),
            ("beside a bias drawn on every read, three times", _larger(Redrawn, 3.0), (0.0, [])),
            ("of no seed", unseeded(), None),
            ("of one seed", OneSeed, None),
            ("that is never zero", Refusing, None),
            ("in units of its size", Dividing, None),
            ("that is never zero, beside a drift", both(Refusing, Drifting), None),
            ("six numbers", of(read=lambda s: np.concatenate(Sound.read(s))), (0.5, ["wrong-return-type"])),
            (
                "vectors under names",
                of(read=lambda s: dict(zip(("accel", "gyro"), Sound.read(s), strict=True))),
                (0.5, ["wrong-return-type"]),
            ),
            ("none, beside a drift", both(Drifting, SILENT), (0.0, [])),
            (
                "no numbers of the accelerometer",
                of(noise=lambda s, i: Sound.noise(s, i) * (np.nan, 1)[i]),
                (0.0, ["not-finite"]),
            ),
            (
                "no numbers of the gyroscope",
                of(noise=lambda s, i: Sound.noise(s, i) * (1, np.nan)[i]),
                (0.0, ["not-finite"]),
            ),
            ("raises without a bias, which is another check's", of(bias=_raises_without), None),
            ("raises with a bias, which is another check's", of(bias=_of_numbers), None),
            ("the other sensor first, a fifth too much", both(_scaled(1.2, 1), read=_swapped), (0.0, [])),
            (
                "the other sensor first, a Laplace law of a fixed size on one",
                of(read=_swapped, noise=lambda s, i: Sound.noise(s, i) if i else s.rng.laplace(0, 0.1, 3)),
                (0.0, ["std-ignored"]),
            ),
            ("none, and raises with a bias", both(SILENT, bias=_of_numbers), (0.0, ["no-noise"])),
            ("the other sensor first, which is the bias's", of(read=_swapped), None),
            ("one sensor twice", of(read=lambda s: (Sound.read(s)[1],) * 2), None),
        ],
        GIVEN: [
            ("sound", Sound, None),
            ("an offset of each instance in its place", OwnOffset, (0.0, ["bias-argument-ignored"])),
            ("zero taken for one below zero", of(bias=_unless_zero_below), (0.5, ["bias-argument-ignored"])),
            (
                "on the other sensor's reading",
                of(clean=lambda s, i: Sound.clean(s, 1 - i)),
                (0.0, ["swapped-sensors"]),
            ),
            ("zero taken for none", of(bias=_unless_zero), (0.5, ["bias-argument-ignored"])),
            ("zero taken for none, without noise", both(SILENT, bias=_unless_zero), (0.5, ["bias-argument-ignored"])),
            ("raises where one is given", of(bias=_of_numbers), "raised"),
            ("beside its own", _beside_its_own(0, 1), (0.0, [])),
            ("beside its own of the gyroscope", _beside_its_own(1), (0.0, [])),
            ("beside its own, which is below zero", of(bias=_beside_its_own_below_zero), (0.0, [])),
            (
                "twice on one axis",
                of(bias=lambda *a: Sound.bias(*a) * ([1, 2, 1] if a[3] is not None else 1)),
                (0.0, []),
            ),
            ("ten times, beside noise that adds up", both(Walking, bias=_times(10.0)), (0.0, [])),
            ("a tenth of it", of(bias=_times(0.1)), (0.0, [])),
            ("a fiftieth of it", of(bias=_times(0.02)), (0.0, [])),
            ("not of the gyroscope", of(bias=_of_accel_alone), (0.5, [])),
            ("its first component on all axes", of(bias=_first_component), (0.0, ["bias-shared"])),
            ("in the first read alone", FirstOnly, (0.0, ["bias-drifts"])),
            ("of the last instance", OneBiasOfTheClass, None),
            ("beside noise that is never zero", Refusing, None),
            ("beside noise in units of its size", Dividing, None),
            (
                "not used, beside noise that is never zero",
                both(Refusing, NOTHING_GIVEN),
                (0.0, ["bias-argument-ignored"]),
            ),
            (
                "beside a shift of noise that is never large",
                both(RefusingMuch, SHIFTED),
                (0.0, ["noise-not-zero-mean"]),
            ),
            ("raises without one, which is another check's", of(bias=_raises_without), None),
            ("not used beside absolute values", both(POSITIVE, NOTHING_GIVEN), (0.0, ["bias-argument-ignored"])),
            ("not used beside noise that adds up", both(Walking, NOTHING_GIVEN), (0.5, ["bias-argument-ignored"])),
            ("not used, beside a drift", both(Drifting, NOTHING_GIVEN), (0.0, [])),
            ("taken off, beside a drift", both(Drifting, bias=_times(-1.0)), (0.0, [])),
            ("not used, of no seed", unseeded(NOTHING_GIVEN), (0.0, ["bias-argument-ignored"])),
            ("beside a shift of the noise, of no seed", unseeded(SHIFTED), (0.0, ["noise-not-zero-mean"])),
            ("of no seed", unseeded(), None),
            ("on readings that are enlarged", _enlarged(0, 1), None),
            ("beside rounding", ROUNDED, None),
            ("beside rounding to fives", IN_FIVES, None),
            ("beside jumps", Jumping, None),
            ("beside frozen noise", Frozen, None),
            ("not used", NOTHING_GIVEN, (0.0, ["bias-argument-ignored"])),
            ("none", of(bias=lambda *_: np.zeros(3)), (0.0, ["no-bias"])),
            ("taken off", of(bias=_times(-1.0)), (0.0, ["bias-sign-flipped"])),
            ("twice", of(bias=_times(2.0)), (0.0, [])),
            ("on other axes", of(bias=_rolled), (0.0, ["bias-axes-exchanged"])),
            ("crossed", of(one=_crossed), (0.0, ["biases-exchanged"])),
            ("one sensor twice, without noise", both(SILENT, read=lambda s: (Sound.read(s)[1],) * 2), (0.5, [])),
            ("crossed, as the noise is", both(SWAPPED_STDS, one=_crossed), None),
            ("the other sensor first", of(read=_swapped), (0.0, ["swapped-sensors"])),
            ("one sensor twice", of(read=lambda s: (Sound.read(s)[1],) * 2), (0.0, [])),
            ("stale", Stale, None),
            ("tested for truth", of(bias=_truth_of_array), "raised"),
            ("drawn on every read", Redrawn, (0.0, ["bias-redrawn"])),
            ("of one sensor", of(bias=lambda s, i, z, g: Sound.bias(s, i, z, g) * (i or g is None)), (0.5, [])),
            ("beside a shift of the noise", SHIFTED, None),
            ("beside one that adds up", Walking, None),
            ("beside absolute values", POSITIVE, None),
            ("beside a drift", Drifting, None),
            ("raises", of(read=_raises), "raised"),
        ],
        DEFAULT: [
            ("sound", Sound, None),
            ("below zero", of(bias=_below_zero), None),
            ("none", of(bias=_none), (0.5, ["bias-not-random"])),
            ("none, whatever is given", of(bias=lambda *_: np.zeros(3)), None),
            ("none of one sensor", of(bias=_only_for(0)), (0.5, ["bias-not-random"])),
            ("always the same", of(bias=_fixed), (0.5, ["bias-not-random"])),
            ("one number for all axes", of(bias=_one_number), (0.5, ["bias-shared"])),
            ("one for both sensors", SharedBias, (0.5, ["bias-shared"])),
            ("drawn on every read", Redrawn, None),
            ("a drift", Drifting, (0.0, ["bias-drifts"])),
            ("beside jumps", JUMPING_OFTEN, None),
            ("as large as the noise", of(bias=lambda s, i, _z, g: Sound.bias(s, i, s.stds[i], g)), None),
            (
                "always the same, as large as the noise",
                of(bias=lambda s, i, _z, g: np.array([1.0, -2.0, 3.0]) * s.stds[i] if g is None else np.array(g)),
                (0.5, ["bias-not-random"]),
            ),
            ("of a fixed noise", of(noise=lambda s, i: s.rng.normal(0, (0.5, 0.05)[i], 3)), None),
            ("of one seed", OneSeed, (0.5, ["bias-not-random"])),
            ("beside noise that is never zero", Refusing, None),
            ("beside noise in units of its size", Dividing, None),
            ("a drift beside noise that is never zero", both(Refusing, Drifting), (0.0, ["bias-drifts"])),
            ("raises without one", of(bias=_raises_without), "raised"),
            ("raises with one, which is another check's", of(bias=_of_numbers), None),
            ("of six numbers", of(read=lambda s: np.concatenate(Sound.read(s))), None),
            ("of a seed in every read", SeedInRead, None),
            ("a constant beside the clean reading", of(one=lambda s, i: s.clean(i) + 0.1), (0.5, ["bias-not-random"])),
            ("of no seed", unseeded(), None),
            ("of the last instance", OneBiasOfTheClass, (0.5, ["bias-shared"])),
            ("in the first read alone", FirstOnly, None),
            ("one for both sensors, taken off the other", both(SharedBias, one=_less_of_gyro), (0.5, ["bias-shared"])),
            ("none, and no noise", both(SILENT, bias=lambda *_: np.zeros(3)), (0.0, [])),
            (
                "always the same of the gyroscope",
                of(bias=lambda *a: (_fixed if a[1] else Sound.bias)(*a)),
                (0.5, ["bias-not-random"]),
            ),
            (
                "one number for all axes of the gyroscope",
                of(bias=lambda *a: (_one_number if a[1] else Sound.bias)(*a)),
                (0.5, ["bias-shared"]),
            ),
            ("none of the accelerometer", of(bias=_only_for(1)), (0.5, ["bias-not-random"])),
            ("ten times as large", of(bias=_drawn_times(10)), None),
            ("thirty times as large", of(bias=_drawn_times(30)), (0.5, [])),
            (
                "thirty times as large of the gyroscope",
                of(bias=lambda *a: (_drawn_times(30) if a[1] else Sound.bias)(*a)),
                (0.5, []),
            ),
            ("where zero is taken for none", of(bias=_unless_zero), None),
            ("the other sensor first", of(read=_swapped), None),
            ("no numbers", NAN, (0.0, ["not-finite"])),
            (
                "its first component on all axes, whatever it is",
                of(bias=lambda *a: np.full(3, Sound.bias(*a)[0])),
                None,
            ),
            ("on no reading of a sensor", of(clean=lambda *_: np.array([1.0, -2.0, -9.81])), "skipped"),
        ],
        WHITE: [
            ("sound", Sound, None),
            ("uniform", UNIFORM, (0.0, ["not-gaussian"])),
            ("absolute values", POSITIVE, (0.0, ["noise-not-zero-mean"])),
            ("a mean of its own", SHIFTED, (0.0, ["noise-not-zero-mean"])),
            ("cut off", CUT, (0.0, ["noise-clipped"])),
            ("one that adds up", Walking, (0.0, ["noise-accumulates"])),
            ("one that remembers", Remembering, (0.0, ["noise-correlated"])),
            ("rounded", ROUNDED, (0.0, ["precision-lost"])),
            ("in fives", IN_FIVES, (0.0, ["precision-lost"])),
            ("jumps now and then", Jumping, (0.0, [])),
            ("lost reads now and then", LOST_READS, (0.0, [])),
            ("none", SILENT, "skipped"),
            ("frozen", Frozen, None),
            ("stale", Stale, (0.0, ["stale-clean-reading"])),
            ("twice too large", _scaled(2.0), None),
            ("a drift", Drifting, None),
            ("a bias drawn on every read", Redrawn, None),
            ("a bias that is not used", NOTHING_GIVEN, None),
            (
                "rounded gyroscope",
                of(one=lambda s, i: Sound.one(s, i).round(3 if i else 15)),
                (0.0, ["precision-lost"]),
            ),
            ("half precision", of(one=lambda s, i: Sound.one(s, i).astype(np.float16)), (0.0, ["precision-lost"])),
            ("none of the gyroscope", of(noise=lambda s, i: Sound.noise(s, i) * (1 - i)), None),
            ("one that remembers the read but one", OfLongMemory, (0.0, ["noise-correlated"])),
            ("one that remembers three reads ago", both(OfLongMemory, lags=(3,)), (0.0, ["noise-correlated"])),
            (
                "one that remembers two and three reads ago",
                both(OfLongMemory, lags=(2, 3)),
                (0.0, ["noise-correlated"]),
            ),
            (
                "a mean below zero",
                of(noise=lambda s, i: Sound.noise(s, i) - 0.8 * s.stds[i]),
                (0.0, ["noise-not-zero-mean"]),
            ),
            ("one that remembers four reads ago", both(OfLongMemory, lags=(4,)), None),
            ("uniform gyroscope", _of_gyro(UNIFORM), (0.0, ["not-gaussian"])),
            ("absolute values of the gyroscope", _of_gyro(POSITIVE), (0.0, ["noise-not-zero-mean"])),
            ("negative values", of(noise=lambda s, i: -np.abs(Sound.noise(s, i))), (0.0, ["noise-not-zero-mean"])),
            ("gyroscope cut off", _of_gyro(CUT), (0.0, ["noise-clipped"])),
            ("a mean of the gyroscope's", _of_gyro(SHIFTED), (0.0, ["noise-not-zero-mean"])),
            ("a mean of its own, of no seed, which is the bias's", unseeded(SHIFTED), None),
            ("a mean of its own, and a bias that is not used", both(SHIFTED, NOTHING_GIVEN), None),
            ("a Laplace law", LAPLACE, (0.0, ["not-gaussian"])),
            ("on readings that are enlarged", _enlarged(0, 1), (0.0, [])),
            ("on readings of the gyroscope that are enlarged", _enlarged(1), (0.0, [])),
            ("a bias beside its own", _beside_its_own(0, 1), None),
            ("raises with a bias, stale", both(Stale, bias=_of_numbers), None),
            ("raises without a bias", of(bias=_raises_without), None),
            (
                "a mean of its own, raises without a bias",
                both(SHIFTED, bias=_raises_without),
                (0.0, ["noise-not-zero-mean"]),
            ),
            ("a mean of its own, never large, which is the bias's", both(RefusingMuch, SHIFTED), None),
            ("the other's bias", of(one=_crossed), None),
            ("the other sensor first", of(read=_swapped), None),
            ("of no seed", unseeded(), None),
        ],
        APART: [
            ("sound", Sound, None),
            ("one of the gyroscope that adds up", GyroWalking, None),
            ("one number for all axes", SAME_ON_AXES, (0.0, ["same-noise-on-axes"])),
            (
                "one number for all axes of the gyroscope",
                of(noise=lambda s, i: (_one_for_all_axes if i else Sound.noise)(s, i)),
                (0.0, ["same-noise-on-axes"]),
            ),
            (
                "one number for two axes of the gyroscope",
                of(noise=lambda s, i: Sound.noise(s, i)[[0, 1, 1 + (i == 0)]]),
                (0.0, []),
            ),
            ("opposite on two axes", of(noise=_opposite), (0.0, [])),
            (
                "one for all axes that adds up",
                type("Both", (Walking,), {"drawn": _one_for_all_axes}),
                (0.0, ["same-noise-on-axes"]),
            ),
            ("half of it shared", of(noise=lambda s, i: Sound.noise(s, i) + _one_for_all_axes(s, i)), (0.0, [])),
            ("one that adds up", Walking, None),
            ("one that remembers", Remembering, None),
            ("a drift", Drifting, None),
            ("none", SILENT, "skipped"),
            ("frozen", Frozen, None),
            ("none of the gyroscope", ONE_SENSOR_BEYOND, None),
            ("one draw for both sensors", OneDraw, (0.0, [])),
            ("one draw for the first axes of both sensors", both(OneDraw, axes=1), (0.0, [])),
            (
                "one number for all axes that remembers",
                both(Remembering, drawn=_one_for_all_axes),
                (0.0, ["same-noise-on-axes"]),
            ),
            ("one sensor twice", of(read=lambda s: (Sound.read(s)[1],) * 2), None),
            ("jumps on two axes at once, which are the law's", JumpingOnTwoAxes, None),
            ("the other sensor first", of(read=_swapped), None),
        ],
        ALONE: [
            ("sound", Sound, None),
            ("into the sensors' data", Writing, (0.0, ["mutates-sensordata"])),
            ("a step", Stepping, (0.0, ["disturbs-simulation"])),
            ("a pose", of(read=_adding_to("qpos")), (0.0, ["disturbs-simulation"])),
            ("a velocity", of(read=_adding_to("qvel")), (0.0, ["disturbs-simulation"])),
            ("the time", of(read=_adding_to_time), (0.0, ["disturbs-simulation"])),
            (
                "a pose, and into the sensors' data",
                both(Writing, read=_adding_to("qpos")),
                (0.0, ["disturbs-simulation"]),
            ),
            ("raises where a bias is given", of(bias=_of_numbers), None),
        ],
    }.items()
    for name, kind, marked in rows
]


@pytest.mark.quick
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_a_made_up_noisy_imu_is_marked_fairly(case: Case) -> None:
    is_as_marked(case)


@pytest.mark.quick
@pytest.mark.parametrize(
    ("kind", "told"),
    [(_scaled(2.0), "0.16 m/s²"), (_on_one_axis(2.0), "0.159 on x and 0.0793 on y"), (SILENT, "the same number")],
)
def test_noise_that_is_off_is_told_by_one_number_and_by_each_axis_where_they_differ(kind: type, told: str) -> None:
    found = finding(Case("", SIZE, lambda: Made(NoisyIMU=kind)))
    assert words(found)["got"].startswith(told)


CHARGED_ONCE = [
    (Sound, []),
    (IN_FIVES, [WHITE]),
    (Jumping, [WHITE]),
    (JUMPING_OFTEN, [WHITE]),
    (JumpingOnTwoAxes, [WHITE]),
    (of(noise=lambda s, i: Sound.noise(s, i) * (20 if s.rng.random() < 0.01 else 1)), [WHITE]),
    (SAME_ON_AXES, [APART]),
]


@pytest.mark.quick
@pytest.mark.parametrize(("kind", "charged"), CHARGED_ONCE)
def test_one_fault_of_the_noise_is_charged_by_one_check(kind: type, charged: list[Any]) -> None:
    student = Made(NoisyIMU=kind)
    found = {check: finding(Case("", check, lambda: student)) for check in (SIZE, GIVEN, DEFAULT, WHITE, APART, ALONE)}
    assert [check for check, each in found.items() if isinstance(each, Charged) and not each.charge.see] == charged


def _moves(bias: np.ndarray) -> tuple[str, ...]:
    """Whether a default bias (instances, reads, 3) without noise moves, and the fault that it shows."""
    still = Reads(np.zeros((2, 4, 3)), np.ones((2, 3)), 1.0, np.zeros(3))
    facts = Facts((still, still), (still, still), defaults=(bias, bias))
    moving = [
        each for each in explain.REASONS if each.of == explain.DEFAULT and 2 <= each.cost <= 5 and each.fits(facts)
    ]
    return tuple(each.told for each in moving[:1]) if explain.moves(facts) else ()


@pytest.mark.quick
@pytest.mark.parametrize("size", [1e6, -1e6])
def test_a_large_bias_stays_where_it_moves_by_its_last_digits(size: float) -> None:
    bias = np.full((4, 3, 3), size)
    bias[:, 1] += 1e-4
    assert _moves(bias) == ()
    bias[:, 1] += 1e-2
    assert _moves(bias) != ()


@pytest.mark.quick
def test_a_bias_that_moves_is_told_by_what_the_later_reads_have() -> None:
    first = np.arange(12.0).reshape(4, 1, 3)
    none, another = np.zeros((4, 1, 3)), -0.1 * (1 + first)
    assert _moves(np.concatenate([first + 1, none, none], axis=1)) == ("bias-drifts",)
    assert _moves(np.concatenate([first + 1, another, none], axis=1)) == ("bias-redrawn",)
    assert _moves(np.concatenate([first + 1, another, another], axis=1)) == ("bias-redrawn",)
    assert _moves(np.concatenate([first + 1, none - 2, none - 2], axis=1)) == ("bias-shared",)


@pytest.mark.quick
def test_no_bias_earns_no_more_than_a_constant_one_of_the_class_itself() -> None:
    none, own = (kept(of(bias=bias)) for bias in (lambda *_: np.zeros(3), lambda *_: np.array([0.05, -0.03, 0.08])))
    assert (sum(none.values()), sum(own.values())) == (16.0, 16.0)


@pytest.mark.quick
def test_noise_that_is_too_large_and_a_bias_that_is_not_used_are_told_as_two() -> None:
    student = Made(NoisyIMU=both(_scaled(2.0), NOTHING_GIVEN))
    found = {check: finding(Case("", check, lambda: student)) for check in (SIZE, GIVEN, DEFAULT, WHITE, APART, ALONE)}
    assert {check: marked(each) for check, each in found.items() if each} == {
        SIZE: (0.0, []),
        GIVEN: (0.0, ["bias-argument-ignored"]),
    }


@pytest.mark.quick
def test_the_reads_that_a_report_draws_are_those_with_given_noise_and_biases() -> None:
    called: list[tuple[str, bool, str]] = []
    sound = Made(NoisyIMU=Sound)

    def noise(**question: Any) -> Any:
        called.append((key, given, question["called"]))
        return sound.noise(**question)

    student: Any = SimpleNamespace(noise=noise)
    for key in ("given", "again", "silent"):
        for given in (True, False):
            runs.asked(student, truth(), key, given=given)
    assert [name for *_, name in called] == ["noise"] + [""] * (len(called) - 1)
    assert called[0][:2] == ("given", True)
