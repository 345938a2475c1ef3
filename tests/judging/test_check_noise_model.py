"""The checks of Noise model, on made-up noisy IMUs."""

from __future__ import annotations

import itertools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.labs.imu.noise_model import checks, measure
from tests.judging.fake_students import Case, FakeStudent, Marked, Row, finding, is_as_marked, truth, words
from tests.test_useless_code_sweep import kept

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


class Remembering(Sound):
    """Each read keeps a share of the noise before."""

    keeps = 0.5

    def begin(self) -> None:
        self.last = [np.zeros(3), np.zeros(3)]

    def drawn(self, which: int) -> Any:
        return super().noise(which)

    def noise(self, which: int) -> Any:
        self.last[which] = self.keeps * self.last[which] + self.drawn(which)
        return self.last[which]


class Holding(Remembering):
    """New noise on every tenth read."""

    def noise(self, which: int) -> Any:
        if self.reads % 10 == 0:
            self.last[which] = self.drawn(which)
        return self.last[which]


class Walking(Remembering):
    """Noise that adds up."""

    keeps = 1.0


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


def _beside_its_own(*sensors: int) -> type:
    """The bias that is given, added to one that is drawn."""
    drawn = lambda s, z, g: s.rng.normal(0, z, 3) + (0 if g is None else np.array(g))  # noqa: E731
    return of(bias=lambda s, i, z, g: drawn(s, z, g) if i in sensors else Sound.bias(s, i, z, g))


def _of_accel_alone(self: Any, which: int, size: float, given: Any) -> Any:
    return Sound.bias(self, which, size, given) * (given is None or which == 0)


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


def _nothing_given(self: Any, which: int, size: float, given: Any) -> Any:
    return self.rng.normal(0, size, 3)


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


CHECKS = (SIZE, GIVEN, DEFAULT, WHITE, APART, ALONE)
SILENT = of(noise=lambda _s, _i: np.zeros(3))
UNIFORM: Any = of(noise=lambda s, i: s.rng.uniform(-1, 1, 3) * s.stds[i] * 3**0.5)
NOTHING_GIVEN = of(bias=_nothing_given)
SHIFTED = of(noise=lambda s, i: Sound.noise(s, i) + 0.8 * s.stds[i])

_CHECKED_BY_NOISE = dict.fromkeys((WHITE, APART), "skipped")
"""Where there is no noise, its law and its axes cannot be judged."""
_NO_NOISE = {SIZE: (0.0, ["no-noise"]), **_CHECKED_BY_NOISE}
_NO_READING = {SIZE: (0.0, []), **dict.fromkeys((GIVEN, DEFAULT, WHITE, APART), "skipped")}
_GIVEN, _UNUSED, _FIXED = (
    {GIVEN: (0.0, [])},
    {GIVEN: (0.0, ["bias-argument-ignored"])},
    {DEFAULT: (0.5, ["bias-not-random"])},
)
_NOT_NORMAL, _CORRELATED, _SUMS = (
    {WHITE: (0.0, [name])} for name in ("not-gaussian", "noise-correlated", "noise-accumulates")
)
_SAME_AXES, _MOVED = {APART: (0.0, ["same-noise-on-axes"])}, {ALONE: (0.0, ["disturbs-simulation"])}

KINDS: list[tuple[str, type, dict[Any, Marked]]] = [
    ("sound", Sound, {}),
    ("of no seed", unseeded(), {}),
    ("that is never zero", Refusing, {}),
    ("in units of its size", Dividing, {}),
    ("other parameters", Renamed, {SIZE: (0.5, ["other-parameters"])}),
    ("a number", of(read=lambda s: float(Sound.read(s)[0][0])), dict.fromkeys(CHECKS, (0.0, ["wrong-return-type"]))),
    ("six numbers", of(read=lambda s: np.concatenate(Sound.read(s))), {SIZE: (0.5, ["wrong-return-type"])}),
    ("vectors under names", of(read=lambda s: dict(zip(("accel", "gyro"), Sound.read(s), strict=True))), {SIZE: (0.5, ["wrong-return-type"])}),
    ("no numbers", of(noise=lambda s, i: Sound.noise(s, i) * np.nan), dict.fromkeys(CHECKS, (0.0, ["not-finite"]))),
    ("raises", of(read=_raises), dict.fromkeys(CHECKS, "raised")),
    ("raises without a bias", of(bias=_raises_without), {DEFAULT: "raised"}),
    ("raises with a bias", of(bias=_of_numbers), {GIVEN: "raised"}),
    # how large the noise is
    ("three hundredths too much", _scaled(1.03), {}),
    ("a fifth too much", _scaled(1.2), {SIZE: (0.0, [])}),
    ("too much on one axis", _on_one_axis(1.12), {SIZE: (0.0, [])}),
    ("none", SILENT, _NO_NOISE),
    ("none of the gyroscope", of(noise=lambda s, i: Sound.noise(s, i) * (1 - i)), {SIZE: (0.5, ["gyro-not-noisy"])}),
    ("the std in place of a draw", of(noise=lambda s, i: np.full(3, s.stds[i])), _NO_NOISE),
    ("an offset of each instance in place of a draw", OwnOffset, _NO_NOISE | _UNUSED),
    ("a constant beside the clean reading", of(one=lambda s, i: s.clean(i) + 0.1), _NO_NOISE | _UNUSED | _FIXED),
    ("on no reading of a sensor, of no seed", unseeded(of(clean=lambda *_: np.zeros(3))), _NO_READING),
    # the bias that is given, and the one that is drawn
    ("beside its own of the gyroscope", _beside_its_own(1), _GIVEN),
    ("not of the gyroscope", of(bias=_of_accel_alone), {GIVEN: (0.5, [])}),
    ("not of the accelerometer", of(bias=lambda s, i, z, g: Sound.bias(s, i, z, g) * (i or g is None)), {GIVEN: (0.5, [])}),
    ("its first component on all axes, whatever it is", of(bias=lambda *a: np.full(3, Sound.bias(*a)[0])), {GIVEN: (0.0, ["bias-shared"])}),
    ("a bias that is not used, of no seed", unseeded(NOTHING_GIVEN), _UNUSED),
    ("a bias that is not used, beside a mean", both(SHIFTED, NOTHING_GIVEN), _UNUSED),
    ("a bias that is not used, and noise that adds up", both(Walking, NOTHING_GIVEN), _GIVEN | _SUMS),
    ("a bias that is not used, beside a drift", both(Drifting, NOTHING_GIVEN), _GIVEN | {DEFAULT: (0.0, ["bias-drifts"])}),
    ("the other sensor first, a fifth too much", both(_scaled(1.2, 1), read=_swapped), {GIVEN: (0.0, ["swapped-sensors"]), SIZE: (0.0, [])}),
    ("one sensor twice", of(read=lambda s: (Sound.read(s)[1],) * 2), _GIVEN),
    ("one sensor twice, without noise", both(SILENT, read=lambda s: (Sound.read(s)[1],) * 2), _NO_NOISE | {GIVEN: (0.5, [])}),
    ("of one seed", OneSeed, _FIXED),
    ("no bias of one sensor", of(bias=_only_for(0)), _FIXED),
    ("always the same bias of the gyroscope", of(bias=lambda *a: (_fixed if a[1] else Sound.bias)(*a)), _FIXED),
    ("one number as the bias of the gyroscope", of(bias=lambda *a: (_one_number if a[1] else Sound.bias)(*a)), {DEFAULT: (0.5, ["bias-shared"])}),
    ("a drift beside twice the noise", _larger(Drifting), {DEFAULT: (0.0, ["bias-drifts"]), SIZE: (0.0, [])}),
    # its law
    ("a Laplace law of a fixed size", of(noise=lambda s, i: s.rng.laplace(0, (0.1, 0.01)[i], 3)), _NOT_NORMAL | {SIZE: (0.0, ["std-ignored"])}),
    ("a uniform law of the gyroscope", of(noise=lambda s, i: UNIFORM.noise(s, i) if i else Sound.noise(s, i)), _NOT_NORMAL),
    ("cut off, twice", _larger(of(noise=lambda s, i: np.clip(Sound.noise(s, i), -2 * s.stds[i], 2 * s.stds[i]))), {SIZE: (0.0, [])}),
    ("jumps now and then", Jumping, _NOT_NORMAL),
    ("rounded", of(one=lambda s, i: Sound.one(s, i).round(3)), {WHITE: (0.0, ["precision-lost"])}),
    ("rounded so that a small bias is hidden", of(one=lambda s, i: Sound.one(s, i).round(1)), {WHITE: (0.0, ["precision-lost"])}),
    ("noise rounded to hundredths", of(noise=lambda s, i: Sound.noise(s, i).round(2)), {WHITE: (0.0, ["precision-lost"])}),
    ("whole numbers", of(one=lambda s, i: np.trunc(Sound.one(s, i))), {SIZE: (0.5, ["precision-lost"])}),
    ("noise that is held for ten reads", Holding, {WHITE: (0.0, ["noise-correlated"])}),
    ("a mean below zero", of(noise=lambda s, i: Sound.noise(s, i) - 0.8 * s.stds[i]), {WHITE: (0.0, ["noise-not-zero-mean"])}),
    ("a mean above zero, of no seed", unseeded(SHIFTED), {GIVEN: (0.0, ["noise-not-zero-mean"])}),
    *((f"one that remembers {lag} reads ago", both(OfLongMemory, lags=(lag,)), _CORRELATED if lag < 4 else {}) for lag in (2, 3, 4)),
    ("one of the gyroscope that adds up", GyroWalking, _SUMS),
    ("on a reading of long ago", Stale, {SIZE: (0.0, ["stale-clean-reading"])}),
    ("on readings of the gyroscope that are enlarged", _enlarged(1), {WHITE: (0.0, [])}),
    # its axes and sensors
    ("one number for all axes of the gyroscope", of(noise=lambda s, i: (_one_for_all_axes if i else Sound.noise)(s, i)), _SAME_AXES),
    ("one number for two axes of the gyroscope", of(noise=lambda s, i: Sound.noise(s, i)[[0, 1, 1 + (i == 0)]]), {APART: (0.0, [])}),
    ("one draw for the first axes of both sensors", both(OneDraw, axes=1), {APART: (0.0, [])}),
    ("one for all axes that remembers", both(Remembering, drawn=_one_for_all_axes), _CORRELATED | _SAME_AXES),
    # the simulation
    ("a pose", of(read=_adding_to("qpos")), _MOVED),
    ("a velocity", of(read=_adding_to("qvel")), _MOVED),
    ("the time", of(read=_adding_to_time), _MOVED),
    ("a pose, and into the sensors' data", both(Writing, read=_adding_to("qpos")), _NO_NOISE | _FIXED | _MOVED | {GIVEN: (0.0, ["no-bias"])}),
]  # fmt: skip
ROWS = [Row(name, lambda kind=kind: FakeStudent(NoisyIMU=kind), marks) for name, kind, marks in KINDS]  # type: ignore[misc]
CASES = [case for row in ROWS for case in row.cases(CHECKS)]


@pytest.mark.quick
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_a_made_up_noisy_imu_is_marked_fairly(row: Row) -> None:
    is_as_marked(*row.cases(CHECKS))


@pytest.mark.quick
@pytest.mark.parametrize(
    ("kind", "told"),
    [(_scaled(2.0), "0.16 m/s²"), (_on_one_axis(2.0), "0.159 on x and 0.0793 on y"), (SILENT, "the same number")],
)
def test_noise_that_is_off_is_told_by_one_number_and_by_each_axis_where_they_differ(kind: type, told: str) -> None:
    found = finding(Case("", SIZE, lambda: FakeStudent(NoisyIMU=kind)))
    assert words(found)["got"].startswith(told)


@pytest.mark.quick
def test_no_bias_earns_no_more_than_a_constant_one_of_the_class_itself() -> None:
    none, own = (kept(of(bias=bias)) for bias in (lambda *_: np.zeros(3), lambda *_: np.array([0.05, -0.03, 0.08])))
    assert (sum(none.values()), sum(own.values())) == (16.0, 16.0)


@pytest.mark.quick
def test_the_reads_that_a_report_draws_are_those_with_given_noise_and_biases() -> None:
    called: list[dict[str, Any]] = []
    sound = FakeStudent(NoisyIMU=of(bias=_raises_without))

    def noise(**question: Any) -> Any:
        called.append(question)
        return sound.noise(**question)

    student: Any = SimpleNamespace(noise=noise, read=sound.read, default_bias=sound.default_bias, robot=sound.robot)
    measure.measure(student, truth())
    assert [each["called"] for each in called if each.get("called")] == ["noise"]
    assert called[0]["biases"] is not None
