"""Facts about a `NoisyIMU`: reads with and without noise, in two states and of many instances, sensor by sensor."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from grader.base.errors import NoAnswer
from grader.engine.findings import Fault, Missing, Raised, Unusable, raised
from grader.engine.traces import Traces
from grader.labs.imu import statistics as st
from grader.labs.imu.answers import NoiseRun
from grader.labs.imu.compare import Array
from grader.labs.imu.noise_model.reads import EXACT, TRUTH_ATOL, UNSEEDED, Reads, Twins
from grader.labs.imu.robot import torso_ids
from grader.labs.imu.student import Student

FORM = "a tuple of two arrays of shape (3,) from read()"
ALL = ("noise_size", "given_bias", "default_bias", "white_and_gaussian", "axes_and_sensors_independent")
_INSTANCES = 24
_MANY = 100
"""Reads of one instance in one state: their mean is off by a tenth of the noise."""
_SILENT, _ALMOST_SILENT = (0.0, 0.0), (1e-12, 1e-12)
"""Standard deviations. Code may refuse a zero, or divide by it, and a picometre a second squared is as good as none."""
_TWINS, _LARGER = 40, 1.5
"""Reads of each twin, and how much larger the noise of the last one is."""
_BY_CHANCE = 10.0
"""Smallest change of a reading with the state, in units of what a twin in the same state differs by. Counters reach 2; the sheet's
noise at 20 times its size reaches 50."""
_CREEPS = 0.3
"""Of the spread between instances: a bias drawn anew on every read moves by 1.4 of it from one read to the next."""

_UNKNOWN = np.full((_INSTANCES, 3, 3), np.nan)
Pair = tuple[Array, Array]
"""What belongs to the accelerometer, and to the gyroscope."""


@dataclass(frozen=True)
class Sensor:
    """Facts about one sensor of a noise model.

    Attributes
    ----------
    reads : many reads in two states, with noise and a bias that is given
    silent : fewer reads, with neither
    default : (instances, reads, 3) offsets without noise where no bias is given; NaN where it could not be run, or has no default
        bias without noise
    drifts : whether the bias moves from read to read
    twins : differences of instances from one seed; unseeded where there was nothing to tell apart
    """

    reads: Reads
    silent: Reads
    default: Array = field(default_factory=lambda: _UNKNOWN)
    drifts: bool = False
    twins: Twins = UNSEEDED

    @cached_property
    def noise(self) -> Reads:
        """The reads as if no bias drifted and no noise added up."""
        return self.reads.paired if self.drifts or self.reads.accumulates else self.reads

    @cached_property
    def accumulates(self) -> bool:
        return self.reads.accumulates and not self.drifts

    @cached_property
    def law_is_off(self) -> bool:
        return self.accumulates or self.noise.law_is_off

    @cached_property
    def obeys_zero(self) -> bool:
        """Return whether no noise comes where none is asked for."""
        return self.silent.still or self.drifts

    @cached_property
    def means(self) -> Array:
        """(instances, 3) the default bias of each instance."""
        return np.asarray(self.default.mean(axis=1))

    @cached_property
    def has_default(self) -> bool:
        return bool(np.abs(self.means).max() > TRUTH_ATOL)


@dataclass(frozen=True)
class Facts:
    """Facts about one noise model.

    Attributes
    ----------
    sensors : the accelerometer and the gyroscope
    follows : whether the readings follow the state; exchanged : each is the other's; one_twice : both are the same numbers
    disturbance : (4,) largest change of time, qpos, qvel and sensordata in a read
    timestep : of the robot's model, in seconds
    odd : in words, the form that both vectors were made out of; departs : parameters that it could not be called with
    stopped : by check, what kept its property from being measured
    """

    sensors: tuple[Sensor, Sensor]
    follows: bool = True
    exchanged: bool = False
    one_twice: bool = False
    disturbance: Array = field(default_factory=lambda: np.zeros(4))
    timestep: float = 0.002
    odd: str = ""
    departs: tuple[str, ...] = ()
    stopped: Mapping[str, Exception] = field(default_factory=dict)

    @cached_property
    def still(self) -> bool:
        """Return whether neither sensor's reads differ."""
        return all(sensor.noise.still for sensor in self.sensors)

    @cached_property
    def redrawn(self) -> bool:
        """Return whether reads without noise vary, and the noisy ones clearly more: a bias drawn on every read, with noise on top.

        Noise of a fixed size, whatever was asked for, varies as much in both. The spread of 600 values errs by 3 %. Reads of which
        a few are off have jumps, and their bias stays.
        """
        more = [s.reads.pooled_spread > 1.12 * s.silent.pooled_spread for s in self.sensors if s.silent.restless]
        return any(more) and not any(sensor.drifts for sensor in self.sensors)


# ---- the questions


class _Questions:
    """The questions about one noise model."""

    def __init__(self, student: Student, truth: Traces) -> None:
        scenario = truth["noise"]
        self._student = student
        self._place: dict[str, Any] = {"qpos": scenario["qpos"], "qvel": scenario["qvel"], "ids": torso_ids(truth)}
        self.truth: Pair = scenario["acceleration"], scenario["angular_velocity"]
        self.stds = float(scenario.scalars["accel_noise_std"]), float(scenario.scalars["gyro_noise_std"])
        self.biases: Pair = scenario["accel_bias"], scenario["gyro_bias"]
        self.other_biases = np.array(self.biases)[:, [2, 0, 1]] * np.array([1.5, -2.0, 3.0])
        self.exchanged = False
        """Whether each vector that comes is the other sensor's."""

    def noisy(self, *, given: bool) -> NoiseRun:
        """Ask for many reads of one instance in each state; a report draws those with given biases."""
        biases, called = (self.biases, "noise") if given else (None, "")
        return self._student.noise(**self._place, reads=st.READS, stds=self.stds, biases=biases, called=called)

    def silent(self, *, given: bool) -> NoiseRun:
        """Ask for reads with no noise and biases of zero."""
        biases = (np.zeros(3), np.zeros(3)) if given else None
        return _without_noise(lambda stds: self._student.noise(**self._place, reads=_MANY, stds=stds, biases=biases))

    def default_bias(self, stds: tuple[float, float], reads: int) -> NoiseRun:
        """Ask for reads of many instances that are given no bias."""
        return self._student.default_bias(**self._place, instances=_INSTANCES, reads=reads, stds=stds)

    def twins(self) -> NoiseRun:
        """Ask for the same arguments twice, then in another state, with another bias, and with larger noise, from one seed."""
        biases = self.biases
        return self._student.noise_twins(
            **self._place,
            reads=_TWINS,
            stds=[*[self.stds] * 4, (_LARGER * self.stds[0], _LARGER * self.stds[1])],
            biases=np.array([biases, biases, biases, self.other_biases, biases]),
            states=(0, 0, 1, 0, 0),
        )

    def clean(self) -> Pair | None:
        """Ask the submission's own reader for both sensors in both states; None where it does not answer with numbers."""
        place = {key: self._place[key] for key in ("qpos", "qvel")}
        try:
            pairs = np.array([self._place["ids"]])
            readings = self._student.read(model=self._student.robot.xml, pairs=pairs, **place)
        except (Missing, NoAnswer):
            return None
        both = readings.accel[0], readings.gyro[0]
        return both if np.isfinite(both).all() else None

    def in_order(self, run: NoiseRun) -> Pair:
        return (run.gyro, run.accel) if self.exchanged else (run.accel, run.gyro)

    def reads(self, run: NoiseRun, clean: Pair, biases: Pair | None) -> tuple[Reads, Reads]:
        """Return the reads of both sensors, about these biases, or about their mean where they are not known."""
        residuals = [r - c[:, None, :] for r, c in zip(self.in_order(run), clean, strict=True)]
        about = biases or [r.mean(axis=(0, 1)) for r in residuals]
        accel, gyro = (Reads(*each) for each in zip(residuals, clean, self.stds, about, strict=True))
        return accel, gyro


def _without_noise(ask: Callable[[tuple[float, float]], NoiseRun]) -> NoiseRun:
    return run if _is_sound(run := ask(_SILENT)) else ask(_ALMOST_SILENT)


def _with_biases(ask: Callable[..., NoiseRun]) -> tuple[NoiseRun, Fault | None]:
    """Return a run with given biases; where the model fails only with those, one without and what it raised."""
    run = ask(given=True)
    if run.fault is not None and (own := ask(given=False)).fault is None:
        return own, run.fault
    return run, None


def _is_whole(run: NoiseRun) -> bool:
    return bool(np.isfinite(run.accel).all() and np.isfinite(run.gyro).all())


def _is_sound(run: NoiseRun) -> bool:
    return run.fault is None and _is_whole(run)


def _usable(run: NoiseRun) -> None:
    """Stop where the model raised, or did not return whole vectors."""
    raised(run.fault, "reading the noisy IMU")
    if not _is_whole(run):
        mistake = "wrong-return-type" if run.odd else "not-finite"
        raise Unusable(FORM, run.odd or "NaN or infinity", mistakes=[mistake])


# ---- the facts


def measure(student: Student, truth: Traces) -> Facts:
    """Ask for reads with and without noise, and for what tells two causes apart only where something is off."""
    ask = _Questions(student, truth)
    failing: tuple[str, ...] = (*ALL, "leaves_simulation_alone")
    disturbance = np.zeros(4)
    try:
        run, refused = _with_biases(ask.noisy)
        _usable(run)
        failing, disturbance = ALL, run.disturbance.max(axis=0, initial=0.0)
        ask.exchanged = refused is None and _are_exchanged(ask, run)
        clean = _clean_readings(ask, run)
        quiet, refused_quiet = _with_biases(ask.silent)
        _usable(quiet)
    except (Raised, Unusable) as stop:
        nothing = Reads(np.zeros((1, 1, 3)), np.zeros((1, 3)), 1.0, np.zeros(3))
        return Facts((Sensor(nothing, nothing),) * 2, disturbance=disturbance, stopped=dict.fromkeys(failing, stop))
    stopped: dict[str, Exception] = {}
    if fault := refused or refused_quiet:
        stopped["given_bias"] = Raised(fault, "reading the noisy IMU with given biases")
    reads = ask.reads(run, clean, None if refused else ask.biases)
    silent = ask.reads(quiet, clean, (np.zeros(3), np.zeros(3)))
    follows = _follow(ask, reads, truth)
    defaults: Pair = _UNKNOWN, _UNKNOWN
    try:
        defaults = _default_biases(ask, _without_noise(lambda stds: ask.default_bias(stds, reads=3)), clean)
        if any(np.abs(bias.mean(axis=1)).max() <= TRUTH_ATOL for bias in defaults):
            defaults = _unless_drawn_with_noise(ask, defaults, clean)
    except (Raised, Unusable) as stop:
        stopped["default_bias"] = stop
    drift = [each.drifts or (each.still and _creeps(bias)) for each, bias in zip(silent, defaults, strict=True)]
    right = all(each.size_is_right and each.bias_is_right for each in reads) and not any(drift)
    twins = (UNSEEDED, UNSEEDED) if right else _twins(ask)
    accel, gyro = map(Sensor, reads, silent, defaults, drift, twins)
    return Facts(
        sensors=(accel, gyro),
        follows=follows,
        exchanged=ask.exchanged,
        one_twice=refused is None and _is_one_twice(run),
        disturbance=disturbance,
        timestep=float(truth["push"].scalars["timestep"]),
        odd=run.odd or "",
        departs=tuple(run.departs),
        stopped=stopped,
    )


def _are_exchanged(ask: _Questions, run: NoiseRun) -> bool:
    """Return whether each vector is the other sensor's, with that sensor's bias: given_bias charges that."""
    straight = ask.reads(run, ask.truth, ask.biases)
    exchanged = ask.reads(replace(run, accel=run.gyro, gyro=run.accel), ask.truth, ask.biases)
    return all(each.bias_is_right for each in exchanged) and not any(each.bias_is_right for each in straight)


def _is_one_twice(run: NoiseRun) -> bool:
    """Return whether one sensor comes in both places, with its noise: what is the same without any is no sensor."""
    return np.array_equal(run.accel, run.gyro) and bool(np.ptp(run.accel, axis=1).all())


def _clean_readings(ask: _Questions, run: NoiseRun) -> Pair:
    """(states, 3) what each sensor reads without noise: the truth, or what the submission's own reader returns.

    The reader's own value counts for a sensor where the noisy readings go with it and not with the truth, so that a fault of the
    reader costs nothing here.
    """
    beside_truth = ask.reads(run, ask.truth, None)
    if all(reads.keeps_its_offset for reads in beside_truth) or (own := ask.clean()) is None:
        return ask.truth
    pairs = zip(beside_truth, ask.reads(run, own, None), strict=True)
    accel, gyro = (t.truth if t.keeps_its_offset or not o.keeps_its_offset else o.truth for t, o in pairs)
    return accel, gyro


def _default_biases(ask: _Questions, run: NoiseRun, clean: Pair) -> Pair:
    """(instances, reads, 3) offsets of each sensor."""
    _usable(run)
    accel, gyro = ask.in_order(run)
    return accel - clean[0][0], gyro - clean[1][0]


def _creeps(biases: Array) -> bool:
    """Return whether biases (instances, reads, 3) move from read to read by little against how they differ between instances."""
    moves = float(np.sqrt(np.mean(np.diff(biases, axis=1) ** 2)))
    between = float(np.sqrt(np.mean(np.var(biases[:, 0], axis=0))))
    return EXACT * max(1.0, float(np.abs(biases).max())) < moves < _CREEPS * between


def _unless_drawn_with_noise(ask: _Questions, defaults: Pair, clean: Pair) -> Pair:
    """Return the default biases; unknown for a sensor whose default bias comes with noise alone.

    The means of many reads then vary between instances by more than noise of that standard deviation explains.
    """
    means = [bias.mean(axis=1) for bias in _default_biases(ask, ask.default_bias(ask.stds, _MANY), clean)]
    spreads = [float(np.sqrt(np.mean(np.var(mean, axis=0)))) for mean in means]
    most = [st.spread_bounds(mean.size, 3)[1] * std / np.sqrt(_MANY) for mean, std in zip(means, ask.stds, strict=True)]
    accel, gyro = (_UNKNOWN if s > m else b for s, m, b in zip(spreads, most, defaults, strict=True))
    return accel, gyro


def _twins(ask: _Questions) -> Sequence[Twins]:
    """Return instances from one seed, each with one parameter changed; unseeded if a reading is not whole."""
    if not _is_sound(run := ask.twins()):
        return UNSEEDED, UNSEEDED
    pairs = zip(ask.in_order(run), ask.other_biases - np.array(ask.biases), strict=True)
    return [Twins(base, again, larger, noisier, change, _LARGER) for (base, again, _, larger, noisier), change in pairs]


def _follow(ask: _Questions, sensors: tuple[Reads, Reads], truth: Traces) -> bool:
    """Return whether the readings follow the state: a new instance in another state reads something else, by more than chance.

    It may be any sensor, in any order, sign, unit or scale. True where nothing can be told.
    """
    if not any(np.ptp(each, axis=0).max() > 2 * TRUTH_ATOL for each in ask.truth):
        return True  # an instructor's robot may read the same in both states
    shows = (np.ptp(reads.truth, axis=0).max() > 4 * reads.mean_bound for reads in sensors)
    if any(reads.keeps_its_offset and shown for reads, shown in zip(sensors, shows, strict=True)):
        return True
    if _are_about_a_start(ask, sensors, truth):
        return True
    run = ask.twins()
    base, again, elsewhere = np.concatenate([run.accel, run.gyro], axis=2)[:3].mean(axis=1)
    if not np.isfinite([base, again, elsewhere]).all():
        return True
    chance = _BY_CHANCE * float(np.abs(again - base).max())
    return bool(np.abs(elsewhere - base).max() > TRUTH_ATOL + chance)


def _are_about_a_start(ask: _Questions, sensors: tuple[Reads, Reads], truth: Traces) -> bool:
    """Return whether the noise and the bias that are asked for stand beside what both sensors read as a simulation starts.

    A `read` that forgets to call the reader uses what an earlier line of the file has read.
    """
    if not all(twins.scales() and twins.adds_bias() for twins in _twins(ask)):
        return False
    starts = [truth["push"][f"alt_no_push_{key}"][0] for key in ("acceleration", "angular_velocity")]
    gaps = [np.abs(r.offset + r.truth - r.bias - start).max() for r, start in zip(sensors, starts, strict=True)]
    return all(gap <= 2 * reads.mean_bound for gap, reads in zip(gaps, sensors, strict=True))
