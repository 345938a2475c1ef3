"""The checks of Noise model, on made-up noisy IMUs."""

from __future__ import annotations

import itertools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.engine.findings import Charged
from grader.labs.imu.noise_model import checks, measure
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


class OneSeed(Sound):
    """The same numbers in every instance."""

    def seed(self) -> None:
        self.rng = np.random.default_rng(42)


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


class GyroWalking(Walking):
    """Noise of the gyroscope that adds up."""

    def noise(self, which: int) -> Any:
        return super().noise(which) if which else self.drawn(which)


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


def _times(factor: float) -> Any:
    return lambda s, i, size, given: Sound.bias(s, i, size, given) * (1 if given is None else factor)


def _fixed(self: Any, which: int, size: float, given: Any) -> Any:
    return np.array([0.1, -0.2, 0.3]) * size if given is None else np.array(given)


def _one_number(self: Any, which: int, size: float, given: Any) -> Any:
    return np.full(3, self.rng.normal(0, size)) if given is None else np.array(given)


def _none(self: Any, which: int, size: float, given: Any) -> Any:
    return np.zeros(3) if given is None else np.array(given)


def _only_for(which: int) -> Any:
    return lambda s, i, size, given: Sound.bias(s, i, size, given) if i == which else _none(s, i, size, given)


def _swapped(self: Any) -> Any:
    return tuple(reversed(Sound.read(self)))


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
NOTHING_GIVEN = of(bias=_nothing_given)
SHIFTED = of(noise=lambda s, i: Sound.noise(s, i) + 0.8 * s.stds[i])
ONE_SENSOR_BEYOND = of(noise=lambda s, i: Sound.noise(s, i) if i else np.zeros(3))

CASES = [
    Case(name, check, lambda kind=kind: Made(NoisyIMU=kind), marked)  # type: ignore[misc]
    for check, rows in {
        SIZE: [
            ("sound", Sound, None),
            ("other parameters", Renamed, (0.5, ["other-parameters"])),
            ("a fifth too much of one", _scaled(1.2, 0), (0.0, [])),
            ("a fifth too much", _scaled(1.2), (0.0, [])),
            ("three hundredths", _scaled(1.03), None),
            ("the std in place of a draw", of(noise=lambda s, i: np.full(3, s.stds[i])), (0.0, ["no-noise"])),
            ("none", SILENT, (0.0, ["no-noise"])),
            ("on no reading of a sensor", of(clean=lambda *_: np.array([1.0, -2.0, -9.81])), (0.0, [])),
            ("on no reading of a sensor, of no seed", unseeded(of(clean=lambda *_: np.zeros(3))), (0.0, [])),
            ("on a reading of long ago", Stale, None),
            ("an offset of each instance in place of a draw", OwnOffset, (0.0, ["no-noise"])),
            ("a constant in place of a draw", of(noise=lambda *_: np.array([0.1, -0.2, 0.3])), (0.0, ["no-noise"])),
            ("jumps beside it, which are the law's", Jumping, None),
            ("no numbers", NAN, (0.0, ["not-finite"])),
            ("a number", NUMBER, (0.0, ["wrong-return-type"])),
            ("raises", of(read=_raises), "raised"),
            ("too much on one axis", _on_one_axis(1.12), (0.0, [])),
            ("the scale of a Laplace law", LAPLACE, None),
            (
                "a Laplace law of a fixed size",
                of(noise=lambda s, i: s.rng.laplace(0, (0.1, 0.01)[i], 3)),
                (0.0, ["std-ignored"]),
            ),
            ("uniform, twice", _larger(UNIFORM), None),
            ("cut off, twice", _larger(CUT), (0.0, [])),
            ("one that remembers, of no seed", unseeded(Remembering), None),
            ("beside a drift, twice", _larger(Drifting), (0.0, [])),
            ("one of the gyroscope that adds up", GyroWalking, None),
            ("of no seed", unseeded(), None),
            ("of one seed", OneSeed, None),
            ("that is never zero", Refusing, None),
            ("in units of its size", Dividing, None),
            ("six numbers", of(read=lambda s: np.concatenate(Sound.read(s))), (0.5, ["wrong-return-type"])),
            (
                "vectors under names",
                of(read=lambda s: dict(zip(("accel", "gyro"), Sound.read(s), strict=True))),
                (0.5, ["wrong-return-type"]),
            ),
            (
                "no numbers of the gyroscope",
                of(noise=lambda s, i: Sound.noise(s, i) * (1, np.nan)[i]),
                (0.0, ["not-finite"]),
            ),
            ("raises without a bias, which is another check's", of(bias=_raises_without), None),
            ("raises with a bias, which is another check's", of(bias=_of_numbers), None),
            ("the other sensor first, a fifth too much", both(_scaled(1.2, 1), read=_swapped), (0.0, [])),
            ("the other sensor first, which is the bias's", of(read=_swapped), None),
            ("one sensor twice", of(read=lambda s: (Sound.read(s)[1],) * 2), None),
        ],
        GIVEN: [
            ("sound", Sound, None),
            ("beside its own of the gyroscope", _beside_its_own(1), (0.0, [])),
            ("ten times, beside noise that adds up", both(Walking, bias=_times(10.0)), (0.0, [])),
            ("a fiftieth of it", of(bias=_times(0.02)), (0.0, [])),
            ("not of the gyroscope", of(bias=_of_accel_alone), (0.5, [])),
            ("its first component on all axes", of(bias=_first_component), (0.0, ["bias-shared"])),
            ("beside noise that is never zero", Refusing, None),
            ("raises without one, which is another check's", of(bias=_raises_without), None),
            ("not used beside absolute values", both(POSITIVE, NOTHING_GIVEN), (0.0, ["bias-argument-ignored"])),
            ("not used beside noise that adds up", both(Walking, NOTHING_GIVEN), (0.0, [])),
            ("not used, beside a drift", both(Drifting, NOTHING_GIVEN), (0.0, [])),
            ("not used, of no seed", unseeded(NOTHING_GIVEN), (0.0, ["bias-argument-ignored"])),
            ("beside a shift of the noise, of no seed", unseeded(SHIFTED), (0.0, ["noise-not-zero-mean"])),
            ("of no seed", unseeded(), None),
            ("beside rounding", ROUNDED, None),
            ("twice", of(bias=_times(2.0)), (0.0, [])),
            ("one sensor twice, without noise", both(SILENT, read=lambda s: (Sound.read(s)[1],) * 2), (0.5, [])),
            ("one sensor twice", of(read=lambda s: (Sound.read(s)[1],) * 2), (0.0, [])),
            ("of one sensor", of(bias=lambda s, i, z, g: Sound.bias(s, i, z, g) * (i or g is None)), (0.5, [])),
        ],
        DEFAULT: [
            ("sound", Sound, None),
            ("none, whatever is given", of(bias=lambda *_: np.zeros(3)), None),
            ("none of one sensor", of(bias=_only_for(0)), (0.5, ["bias-not-random"])),
            ("beside jumps", JUMPING_OFTEN, None),
            ("of a fixed noise", of(noise=lambda s, i: s.rng.normal(0, (0.5, 0.05)[i], 3)), None),
            ("beside noise that is never zero", Refusing, None),
            ("beside noise in units of its size", Dividing, None),
            ("a drift beside noise that is never zero", both(Refusing, Drifting), (0.0, ["bias-drifts"])),
            ("raises without one", of(bias=_raises_without), "raised"),
            ("raises with one, which is another check's", of(bias=_of_numbers), None),
            ("a constant beside the clean reading", of(one=lambda s, i: s.clean(i) + 0.1), (0.5, ["bias-not-random"])),
            ("of no seed", unseeded(), None),
            ("none, and no noise", both(SILENT, bias=lambda *_: np.zeros(3)), (0.5, ["bias-not-random"])),
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
            ("in fives", IN_FIVES, (0.0, ["precision-lost"])),
            ("jumps now and then", Jumping, (0.0, ["not-gaussian"])),
            ("lost reads now and then", LOST_READS, (0.0, ["not-gaussian"])),
            ("none", SILENT, "skipped"),
            ("twice too large", _scaled(2.0), None),
            (
                "rounded gyroscope",
                of(one=lambda s, i: Sound.one(s, i).round(3 if i else 15)),
                (0.0, ["precision-lost"]),
            ),
            ("none of the gyroscope", of(noise=lambda s, i: Sound.noise(s, i) * (1 - i)), None),
            ("one that remembers the read but one", OfLongMemory, (0.0, ["noise-correlated"])),
            ("one that remembers three reads ago", both(OfLongMemory, lags=(3,)), (0.0, ["noise-correlated"])),
            (
                "a mean below zero",
                of(noise=lambda s, i: Sound.noise(s, i) - 0.8 * s.stds[i]),
                (0.0, ["noise-not-zero-mean"]),
            ),
            ("one that remembers four reads ago", both(OfLongMemory, lags=(4,)), None),
            ("uniform gyroscope", _of_gyro(UNIFORM), (0.0, ["not-gaussian"])),
            ("absolute values of the gyroscope", _of_gyro(POSITIVE), (0.0, ["noise-not-zero-mean"])),
            ("a mean of its own, of no seed, which is the bias's", unseeded(SHIFTED), None),
            ("a mean of its own, and a bias that is not used", both(SHIFTED, NOTHING_GIVEN), None),
            ("on readings of the gyroscope that are enlarged", _enlarged(1), (0.0, [])),
            ("the other sensor first", of(read=_swapped), None),
            ("of no seed", unseeded(), None),
        ],
        APART: [
            ("sound", Sound, None),
            ("one of the gyroscope that adds up", GyroWalking, None),
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
            ("one that remembers", Remembering, None),
            ("a drift", Drifting, None),
            ("none", SILENT, "skipped"),
            ("none of the gyroscope", ONE_SENSOR_BEYOND, None),
            ("one draw for the first axes of both sensors", both(OneDraw, axes=1), (0.0, [])),
            (
                "one number for all axes that remembers",
                both(Remembering, drawn=_one_for_all_axes),
                (0.0, ["same-noise-on-axes"]),
            ),
            ("one sensor twice", of(read=lambda s: (Sound.read(s)[1],) * 2), None),
            ("jumps on two axes at once, which are the law's", JumpingOnTwoAxes, None),
        ],
        ALONE: [
            ("sound", Sound, None),
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
    called: list[dict[str, Any]] = []
    sound = Made(NoisyIMU=of(bias=_raises_without))

    def noise(**question: Any) -> Any:
        called.append(question)
        return sound.noise(**question)

    student: Any = SimpleNamespace(noise=noise, read=sound.read, default_bias=sound.default_bias, robot=sound.robot)
    measure.measure(student, truth())
    assert [each["called"] for each in called if each.get("called")] == ["noise"]
    assert called[0]["biases"] is not None
