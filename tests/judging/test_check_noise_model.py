"""The checks of Noise model, on made-up noisy IMUs."""

from __future__ import annotations

import itertools
from typing import Any
from unittest import mock

import numpy as np
import pytest

from grader.labs.imu.noise_model import checks, measure
from tests.judging import fake_students
from tests.judging.fake_students import FakeStudent, Marked, Row, is_as_marked, truth

CHECKS = SIZE, GIVEN, DEFAULT, WHITE, APART, ALONE = (
    checks.check_noise_size,
    checks.check_given_bias,
    checks.check_default_bias,
    checks.check_white_and_gaussian,
    checks.check_axes_and_sensors_independent,
    checks.check_leaves_simulation_alone,
)


class Sound:
    """The sheet's noisy IMU, in steps that a faulty one changes."""

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
        return self.one(0), self.one(1)


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


class Drifting(Sound):
    """A bias that walks."""

    def one(self, which: int) -> Any:
        self.biases[which] = self.biases[which] + self.rng.normal(0, (0.002, 0.0002)[which], 3)
        return super().one(which)


class GyroWalking(Remembering):
    """Noise of the gyroscope that adds up."""

    keeps = 1.0

    def noise(self, which: int) -> Any:
        return super().noise(which) if which else self.drawn(which)


class Frozen(Sound):
    """The noise of the first read in all of them, beside a count of the reads."""

    drift = 0.0

    def begin(self) -> None:
        self.kept = [Sound.noise(self, which) for which in (0, 1)]
        self.count = 0

    def one(self, which: int) -> Any:
        self.count += 1
        return super().one(which) + self.drift * self.count

    def noise(self, which: int) -> Any:
        return self.kept[which]


class Stale(Sound):
    """The clean reading of the first read."""

    def begin(self) -> None:
        self.kept: dict[int, np.ndarray] = {}

    def clean(self, which: int) -> np.ndarray:
        return self.kept.setdefault(which, super().clean(which))


def _on_one_axis(factor: float) -> type:
    return of(noise=lambda s, i: Sound.noise(s, i) * [factor, 1, 1])


def _raises(*_: Any) -> Any:
    raise RuntimeError("broken")


def _moving(self: Any) -> Any:
    answer = Sound.read(self)
    self.data.qpos[0] += 0.01
    return answer


def _one_for_all_axes(self: Any, which: int) -> Any:
    return np.full(3, self.rng.normal(0, self.stds[which]))


def _of_one_seed(self: Any, which: int) -> Any:
    return np.random.default_rng(which).normal(0, self.stds[which], 3)


SILENT = of(noise=lambda _s, _i: np.zeros(3))

_NO_NOISE: dict[Any, Marked] = dict.fromkeys((SIZE, WHITE, APART), (0.0, ["no-noise"]))
"""Where there is no noise, its law and its axes cannot be judged."""
_NO_READING: dict[Any, Marked] = dict.fromkeys((SIZE, GIVEN, DEFAULT, WHITE, APART), (0.0, ["reads-no-sensor"]))
_OFF_CENTRE: dict[Any, Marked] = {SIZE: (0.6667, ["noise-not-zero-mean"]), WHITE: (0.0, ["noise-not-zero-mean"])}
_DRIFTS: dict[Any, Marked] = {GIVEN: (0.5, ["bias-drifts"]), DEFAULT: (0.0, ["bias-drifts"])}
_SAME_AXES = {APART: (0.0, ["same-noise-on-axes"])}

KINDS: list[tuple[str, type, dict[Any, Marked]]] = [
    ("sound", Sound, {}),
    ("of no seed", unseeded(), {}),
    ("a number", of(read=lambda s: float(Sound.read(s)[0][0])), dict.fromkeys(CHECKS, (0.0, ["wrong-return-type"]))),
    ("no numbers", of(noise=lambda s, i: Sound.noise(s, i) * np.nan), dict.fromkeys(CHECKS, (0.0, ["not-finite"]))),
    ("six numbers", of(read=lambda s: np.concatenate(Sound.read(s))), {SIZE: (0.5, ["wrong-return-type"])}),
    ("raises", of(read=_raises), dict.fromkeys(CHECKS, "raised")),
    ("raises with a bias", of(bias=lambda s, i, z, g: Sound.bias(s, i, z, g) if g is None else _raises()), {GIVEN: "raised"}),
    # how large the noise is
    ("too much on one axis", _on_one_axis(1.12), {SIZE: (0.0, [])}),
    ("twice as much on one axis", _on_one_axis(2.0), {SIZE: (0.0, [])}),
    ("none", SILENT, _NO_NOISE),
    ("none of the gyroscope", of(noise=lambda s, i: Sound.noise(s, i) * (1 - i)), {SIZE: (0.5, ["gyro-not-noisy"])}),
    ("a constant beside the clean reading", of(one=lambda s, i: s.clean(i) + 0.1), _NO_NOISE | {GIVEN: (0.0, ["bias-argument-ignored"]), DEFAULT: (0.5, ["bias-not-random"])}),
    ("on no reading of a sensor, of no seed", unseeded(of(clean=lambda *_: np.zeros(3))), _NO_READING),
    # the bias that is given, and the one that is drawn
    ("not of the gyroscope", of(bias=lambda s, i, z, g: Sound.bias(s, i, z, g) * (g is None or i == 0)), {GIVEN: (0.5, [])}),
    ("its first component on all axes, whatever it is", of(bias=lambda *a: np.full(3, Sound.bias(*a)[0])), {GIVEN: (0.0, ["bias-shared"]), DEFAULT: (0.5, ["bias-shared"])}),
    ("the other sensor first, a fifth too much", of(noise=lambda s, i: Sound.noise(s, i) * (1 + 0.2 * i), read=lambda s: tuple(reversed(Sound.read(s)))), {GIVEN: (0.0, ["swapped-sensors"]), SIZE: (0.5, [])}),
    ("one sensor twice", of(read=lambda s: (Sound.read(s)[1],) * 2), {GIVEN: (0.0, [])}),
    ("one sensor twice, without noise", both(SILENT, read=lambda s: (Sound.read(s)[1],) * 2), _NO_NOISE | {GIVEN: (0.5, [])}),
    ("of one seed", of(seed=lambda s: setattr(s, "rng", np.random.default_rng(42))), {DEFAULT: (0.5, ["bias-not-random"])}),
    ("a drift beside twice the noise", both(Drifting, noise=lambda s, i: 2 * Sound.noise(s, i)), {DEFAULT: (0.0, ["bias-drifts"]), GIVEN: (0.5, ["bias-drifts"]), SIZE: (0.0, [])}),
    # its law
    ("a Laplace law of a fixed size", of(noise=lambda s, i: s.rng.laplace(0, (0.1, 0.01)[i], 3)), {WHITE: (0.0, ["not-gaussian"]), SIZE: (0.0, ["std-ignored"])}),
    ("a mean below zero", of(noise=lambda s, i: Sound.noise(s, i) - 0.8 * s.stds[i]), _OFF_CENTRE),
    ("whole numbers", of(one=lambda s, i: np.trunc(Sound.one(s, i))), {SIZE: (0.0, ["precision-lost"]), GIVEN: (0.0, []), DEFAULT: (0.5, ["bias-not-random"]), WHITE: (0.0, ["precision-lost"]), APART: (0.0, [])}),
    ("a mean above zero, of no seed", unseeded(of(noise=lambda s, i: Sound.noise(s, i) + 0.8 * s.stds[i])), _OFF_CENTRE),
    ("rounded", of(one=lambda s, i: Sound.one(s, i).round(3)), {WHITE: (0.0, ["precision-lost"])}),
    ("on readings of the gyroscope that are enlarged", of(clean=lambda s, i: Sound.clean(s, i) * (1 + 0.05 * i)), {WHITE: (0.0, [])}),
    ("one of the gyroscope that adds up", GyroWalking, {SIZE: (0.6667, ["noise-accumulates"]), **dict.fromkeys((GIVEN, DEFAULT, WHITE), (0.0, ["noise-accumulates"]))}),
    ("on a reading of long ago", Stale, {SIZE: (0.0, ["stale-clean-reading"])}),
    ("drawn once for all reads", Frozen, dict.fromkeys((SIZE, WHITE), (0.0, ["frozen-noise"]))),
    ("drawn from one seed in every read", of(noise=_of_one_seed), dict.fromkeys((SIZE, WHITE), (0.0, ["reseeded"]))),
    ("drawn once for all reads, beside a counter", both(Frozen, drift=1e-6), _NO_NOISE | _DRIFTS),
    ("drawn from one seed in every read, beside a counter", both(Frozen, drift=1e-6, noise=_of_one_seed), _NO_NOISE | _DRIFTS),
    # its axes and sensors
    ("one number for all axes of the gyroscope", of(noise=lambda s, i: (_one_for_all_axes if i else Sound.noise)(s, i)), _SAME_AXES),
    ("one number for two axes of the gyroscope", of(noise=lambda s, i: Sound.noise(s, i)[[0, 1, 1 + (i == 0)]]), {APART: (0.0, [])}),
    ("one for all axes that remembers", both(Remembering, drawn=_one_for_all_axes), _SAME_AXES | {SIZE: (0.5, ["noise-correlated"]), WHITE: (0.0, ["noise-correlated"])}),
    # the simulation
    ("a pose", of(read=_moving), {ALONE: (0.0, ["disturbs-simulation"])}),
]  # fmt: skip
ROWS = [Row(name, lambda kind=kind: FakeStudent(NoisyIMU=kind), marks) for name, kind, marks in KINDS]  # type: ignore[misc]
CASES = [case for row in ROWS for case in row.cases(CHECKS)]


@pytest.mark.quick
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_a_made_up_noisy_imu_is_marked_fairly(row: Row) -> None:
    is_as_marked(*row.cases(CHECKS))


def kept(kind: type) -> dict[str, float]:
    """Points that each check leaves to a noisy IMU."""
    return fake_students.kept(FakeStudent(NoisyIMU=kind), CHECKS)


NO_SENSOR = {
    "a constant": of(one=lambda s, i: s.biases[i] + s.stds[i]),
    "one number for all axes": of(one=lambda s, i: s.biases[i] + _one_for_all_axes(s, i)),
    "a walk": both(Remembering, keeps=1.0, clean=lambda _s, _i: np.zeros(3)),
}


@pytest.mark.quick
@pytest.mark.parametrize("kind", NO_SENSOR.values(), ids=NO_SENSOR)
def test_a_noise_model_without_a_sensor_earns_its_form_at_most(kind: type) -> None:
    points = kept(kind)
    assert points["noise_model.leaves_simulation_alone"] == 2.0, "it did not run"
    assert sum(points.values()) <= 4.0, points


@pytest.mark.quick
def test_what_a_standing_robot_reads_with_sound_noise_and_biases_loses_the_law_of_the_noise() -> None:
    """As a `read` that forgot to call the reader, and uses what an earlier line of the file has read."""
    points = kept(of(clean=lambda _s, i: np.array([0.0, 0.0, -9.81 * (1 - i)])))
    assert (points["noise_model.white_and_gaussian"], sum(points.values())) == (0.0, 17.0)


@pytest.mark.quick
def test_no_bias_earns_no_more_than_a_constant_one_of_the_class_itself() -> None:
    none, own = (kept(of(bias=bias)) for bias in (lambda *_: np.zeros(3), lambda *_: np.array([0.05, -0.03, 0.08])))
    assert (sum(none.values()), sum(own.values())) == (16.0, 16.0)


@pytest.mark.quick
def test_the_reads_that_a_report_draws_are_those_with_given_noise_and_biases() -> None:
    student = FakeStudent(NoisyIMU=Sound)
    with mock.patch.object(student, "noise", wraps=student.noise) as noise:
        measure.measure(student, truth())
    asked = [each.kwargs for each in noise.call_args_list if each.kwargs.get("called")]
    assert [(each["called"], each["biases"] is None) for each in asked] == [("noise", False)]
