"""Measurement of a `NoisyIMU`: its reads with and without noise, in two states of the robot, and of many instances."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from grader.base.errors import NoAnswer
from grader.engine.findings import Missing, Raised, StudentError, Unusable, raised
from grader.engine.traces import Traces
from grader.labs.imu import statistics as st
from grader.labs.imu.answers import NoiseRun
from grader.labs.imu.compare import Array, not_finite_in_words
from grader.labs.imu.noise_model.reads import EXACT, TRUTH_ATOL, UNSEEDED, Reads, Twins
from grader.labs.imu.robot import torso_ids
from grader.labs.imu.student import Student

FORM = "a tuple of two arrays of shape (3,) from read()"
ALL = ("noise_size", "given_bias", "default_bias", "white_and_gaussian", "axes_and_sensors_independent")
_INSTANCES = 24
_MANY = 100
"""Reads of one instance in one state: their mean is off by a tenth of the noise."""
ROUGHLY = 0.3
"""Largest relative error of the noise beside a bias that drifts or is redrawn. It is estimated from 117 differences, to a tenth."""
_SILENT, _ALMOST_SILENT = (0.0, 0.0), (1e-12, 1e-12)
"""Standard deviations. Code may refuse a zero, or divide by it, and a picometre a second squared is as good as none."""
_TWINS, _LARGER = 40, 1.5
"""Reads of each twin, and how much larger the noise of the last one is."""
_BY_CHANCE = 10.0
"""Smallest change of a reading with the state, in units of the difference between two instances with the same seed and state.
Code that adds a counter reaches 2; the sheet's noise at 20 times its size reaches 50."""
_CREEPS = 0.3
"""Largest change of a drifting bias per read, as a share of its spread between instances. A bias drawn on every read has 1.4."""
_LEAST, _MOST = 0.25, 2.5
"""Spread, in units of the standard deviation, of noise of another law that takes it as its own parameter. A uniform law from 0 to
the deviation has 0.29, a triangular one within ± the deviation 0.41, an exponential one 1, a Laplace law 1.41."""

_UNKNOWN = np.full((_INSTANCES, 3, 3), np.nan)
Pair = tuple[Array, Array]
"""One array for the accelerometer, and one for the gyroscope."""


@dataclass(frozen=True)
class Sensor:
    """Facts measured of one sensor of a noise model; checks and diagnosis judge it.

    Attributes
    ----------
    reads : many reads in two states, with noise and a bias that is given
    silent : fewer reads, without noise and with a given bias of zero
    default : (instances, reads, 3) biases drawn as none was given: readings without noise minus the truth. If noise hides them or
        none shows, readings with one draw of noise for all, minus the first of these; NaN if the biases cannot be measured
    drifts : whether the bias moves slowly from read to read
    twins : reads with one seed and one argument changed, to find a fault; `UNSEEDED` (no reads) if none is sought, as both sensors
        have noise of the right size, the right bias and no drift, or if reading failed
    """

    reads: Reads
    silent: Reads
    default: Array = field(default_factory=lambda: _UNKNOWN)
    drifts: bool = False
    twins: Twins = UNSEEDED

    @cached_property
    def noise(self) -> Reads:
        """Reads by which noise is judged: `reads`, or their `paired` differences if the bias drifts or the noise accumulates."""
        return self.reads.paired if self.drifts or self.reads.accumulates else self.reads

    @cached_property
    def accumulates(self) -> bool:
        return self.reads.accumulates and not self.drifts

    @cached_property
    def law_is_off(self) -> bool:
        return self.accumulates or self.noise.law_is_off

    @cached_property
    def has_size(self) -> bool:
        """Return whether the noise has the standard deviation that was asked for, also if the bias drifts.

        Noise that is not normal passes if it grows in proportion to that standard deviation, and is about as large: another check
        deducts for its distribution.
        """
        noise, twins = self.noise, self.twins
        if noise.size_is_right or not noise.is_noise:
            return noise.size_is_right
        if self.drifts:
            return abs(twins.noise_size() / noise.std - 1) < ROUGHLY
        enough = bool(noise.memory) or noise.pooled_spread >= _LEAST * noise.std
        return self.law_is_off and twins.scales() and enough and noise.unpredicted <= _MOST * noise.std

    @cached_property
    def means(self) -> Array:
        """Bias (instances, 3) that each instance drew as none was given: its mean error. It shows whether instances differ."""
        return np.asarray(self.default.mean(axis=1))

    @cached_property
    def has_default(self) -> bool:
        return bool(np.abs(self.means).max() > TRUTH_ATOL)


@dataclass(frozen=True)
class Facts:
    """All that is measured of a noise model: `measure` makes it, and checks and diagnosis read nothing else.

    Attributes
    ----------
    sensors : the accelerometer and the gyroscope
    follows : whether the readings change with the robot's state
    exchanged : whether each sensor's readings are returned as the other's
    one_twice : whether both returned vectors are the readings of one sensor
    disturbance : (4,) ndarray, largest change that a read makes in the simulator's time, qpos, qvel and sensordata
    timestep : time step of the robot's model, in seconds
    odd : the form in which the vectors were returned, in words; "" if it is the sheet's
    departs : the sheet's names of parameters that the class has by other names or in other places; "method …" for a renamed method,
        "global …" for a parameter in place of which it reads a global variable; each kind is a fault that loses points
    stopped : by name of a check, the exception with which it ends because its property could not be measured
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
        """Return whether each sensor repeats one reading in each state: without noise, or with one draw for all reads."""
        return all(sensor.noise.still for sensor in self.sensors)

    @cached_property
    def noiseless(self) -> bool:
        """Return whether neither sensor has noise: reads are equal, rarely differ, or can be predicted from those before."""
        return not any(sensor.noise.is_noise for sensor in self.sensors)

    @cached_property
    def redrawn(self) -> bool:
        """Return whether the code draws a new default bias at every read, not once for each instance; False if a bias drifts."""
        pairs = [(sensor.reads, sensor.silent) for sensor in self.sensors]
        return _is_redrawn(*zip(*pairs, strict=True)) and not any(sensor.drifts for sensor in self.sensors)


def _is_redrawn(reads: Sequence[Reads], silent: Sequence[Reads]) -> bool:
    """Return whether reads without noise vary like noise, and noisy ones vary clearly more: by a bias drawn at each read.

    Noise of a fixed size, whatever was asked for, varies as much in both. Code that takes a deviation of 0 for a missing one has
    noise in both, and in the noisy reads its size is right. The spread of 600 values has an error of 3 %.
    """
    noise = [pair for pair in zip(reads, silent, strict=True) if pair[1].is_noise and not pair[0].size_is_right]
    return any(noisy.pooled_spread > 1.12 * quiet.pooled_spread for noisy, quiet in noise)


# ---- the questions


class _Questions:
    """Questions to the worker about one noise model: each makes instances with arguments and states of the noise scenario."""

    def __init__(self, student: Student, truth: Traces) -> None:
        scenario = truth["noise"]
        self._student = student
        self._place: dict[str, Any] = {"qpos": scenario["qpos"], "qvel": scenario["qvel"], "ids": torso_ids(truth)}
        self.truth: Pair = scenario["acceleration"], scenario["angular_velocity"]
        self.stds = float(scenario.scalars["accel_noise_std"]), float(scenario.scalars["gyro_noise_std"])
        self.biases: Pair = scenario["accel_bias"], scenario["gyro_bias"]
        self.other_biases = np.array(self.biases)[:, [2, 0, 1]] * np.array([1.5, -2.0, 3.0])
        self.exchanged = False
        """Whether the submission returns the two sensors in each other's place."""

    def noisy(self, *, given: bool) -> NoiseRun:
        """Ask for many reads of one instance in each state; with given biases, the report draws a chart of the answer."""
        biases, called = (self.biases, "noise") if given else (None, "")
        return self._student.noise(**self._place, reads=st.READS, stds=self.stds, biases=biases, called=called)

    def silent(self, *, given: bool) -> NoiseRun:
        """Ask for reads without noise (standard deviation zero, or next to it where zero fails); biases are zero if `given`."""
        biases = (np.zeros(3), np.zeros(3)) if given else None
        return _without_noise(lambda stds: self._student.noise(**self._place, reads=_MANY, stds=stds, biases=biases))

    def default_bias(self, stds: tuple[float, float], *, one_draw: bool = False) -> NoiseRun:
        """Ask for reads of many instances without a given bias; if `one_draw`, random generators start anew before each read."""
        return self._student.default_bias(**self._place, instances=_INSTANCES, stds=stds, one_draw=one_draw)

    def twins(self, *, given: bool = True) -> NoiseRun:
        """Ask for five series of reads from one seed: the first twice, then in another state, with another bias, with more noise.

        Without `given` no biases are given, and the fourth series is as the first.
        """
        biases = self.biases
        return self._student.noise_twins(
            **self._place,
            reads=_TWINS,
            stds=[*[self.stds] * 4, (_LARGER * self.stds[0], _LARGER * self.stds[1])],
            biases=np.array([biases, biases, biases, self.other_biases, biases]) if given else None,
            states=(0, 0, 1, 0, 0),
        )

    def clean(self) -> Pair | None:
        """Return the readings (states, 3) of each sensor by the submission's own reader; None if missing or not finite."""
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
        """Return the reads of both sensors as errors from `clean`, with the biases that were given, or their own means if None."""
        residuals = [r - c[:, None, :] for r, c in zip(self.in_order(run), clean, strict=True)]
        about = biases or [r.mean(axis=(0, 1)) for r in residuals]
        accel, gyro = (Reads(*each) for each in zip(residuals, clean, self.stds, about, strict=True))
        return accel, gyro


def _without_noise(ask: Callable[[tuple[float, float]], NoiseRun]) -> NoiseRun:
    return run if _is_sound(run := ask(_SILENT)) else ask(_ALMOST_SILENT)


def _with_biases(ask: Callable[..., NoiseRun]) -> tuple[NoiseRun, StudentError | None]:
    """Return a run with given biases, and None; if the model raises only with these, a run without them, and the exception."""
    run = ask(given=True)
    if run.error is not None and (own := ask(given=False)).error is None:
        return own, run.error
    return run, None


def _is_whole(run: NoiseRun) -> bool:
    return bool(np.isfinite(run.accel).all() and np.isfinite(run.gyro).all())


def _is_sound(run: NoiseRun) -> bool:
    return run.error is None and _is_whole(run)


def _require_usable(run: NoiseRun) -> None:
    """End the measurement with `Raised` or `Unusable` if the model raised an exception or returned numbers that are not finite."""
    raised(run.error, "reading the noisy IMU")
    if not _is_whole(run):
        fault = "wrong-return-type" if run.odd else "not-finite"
        came = run.odd or not_finite_in_words(np.array([run.accel, run.gyro]))
        raise Unusable(FORM, came, faults=[fault])


# ---- the facts


def measure(student: Student, truth: Traces) -> Facts:
    """Return the `Facts` of a noise model in the robot states of `truth`; `stopped` names the checks that failed reads end."""
    ask = _Questions(student, truth)
    failing: tuple[str, ...] = (*ALL, "leaves_simulation_alone")
    disturbance = np.zeros(4)
    try:
        run, refused = _with_biases(ask.noisy)
        _require_usable(run)
        failing, disturbance = ALL, run.disturbance.max(axis=0, initial=0.0)
        ask.exchanged = _are_exchanged(ask, run)
        clean = _clean_readings(ask, run)
        quiet, refused_quiet = _with_biases(ask.silent)
        _require_usable(quiet)
    except (Raised, Unusable) as stop:
        nothing = Reads(np.zeros((1, 1, 3)), np.zeros((1, 3)), 1.0, np.zeros(3))
        return Facts((Sensor(nothing, nothing),) * 2, disturbance=disturbance, stopped=dict.fromkeys(failing, stop))
    stopped: dict[str, Exception] = {}
    if error := refused or refused_quiet:
        stopped["given_bias"] = Raised(error, "reading the noisy IMU with given biases")
    reads = ask.reads(run, clean, None if refused else ask.biases)
    silent = ask.reads(quiet, clean, (np.zeros(3), np.zeros(3)))
    follows = _follow(ask, reads, truth)
    defaults: Pair = _UNKNOWN, _UNKNOWN
    try:
        defaults = _default_biases(ask, _without_noise(ask.default_bias), clean)
    except (Raised, Unusable) as stop:
        stopped["default_bias"] = stop
    drift = [each.drifts or (each.still and _creeps(bias)) for each, bias in zip(silent, defaults, strict=True)]
    if "default_bias" not in stopped and not any(drift) and not _is_redrawn(reads, silent):
        defaults = _shown_defaults(ask, defaults, silent)
    right = all(each.size_is_right and each.bias_is_right for each in reads) and not any(drift)
    twins = (UNSEEDED, UNSEEDED) if right else _twins(ask, given=refused is None)
    first, second = map(Sensor, reads, silent, defaults, drift, twins)
    return Facts(
        sensors=(first, second),
        follows=follows,
        exchanged=ask.exchanged,
        one_twice=_is_one_twice(run),
        disturbance=disturbance,
        timestep=float(truth["push"].scalars["timestep"]),
        odd=run.odd or "",
        departs=tuple(run.departs),
        stopped=stopped,
    )


def _are_exchanged(ask: _Questions, run: NoiseRun) -> bool:
    """Return whether each sensor's readings are returned as the other's, each with its own bias or one that is wrong too."""
    straight = ask.reads(run, ask.truth, ask.biases)
    exchanged = ask.reads(replace(run, accel=run.gyro, gyro=run.accel), ask.truth, ask.biases)
    if all(each.bias_is_right for each in exchanged):
        return not any(each.bias_is_right for each in straight)
    follow = all(each.keeps_its_offset and each.size_is_right for each in exchanged)
    return follow and not any(each.keeps_its_offset for each in straight)


def _is_one_twice(run: NoiseRun) -> bool:
    """Return whether both vectors hold the same noisy readings; equal vectors without noise, such as zeros, do not count."""
    return np.array_equal(run.accel, run.gyro) and bool(np.ptp(run.accel, axis=1).all())


def _clean_readings(ask: _Questions, run: NoiseRun) -> Pair:
    """Return the readings (states, 3) of each sensor without noise: the truth, or those of the submission's own reader.

    The reader's values count for a sensor if the noisy readings follow them and not the truth, so that a fault of the reader loses
    no points here.
    """
    beside_truth = ask.reads(run, ask.truth, None)
    if all(reads.keeps_its_offset for reads in beside_truth) or (own := ask.clean()) is None:
        return ask.truth
    pairs = zip(beside_truth, ask.reads(run, own, None), strict=True)
    accel, gyro = (t.truth if t.keeps_its_offset or not o.keeps_its_offset else o.truth for t, o in pairs)
    return accel, gyro


def _default_biases(ask: _Questions, run: NoiseRun, clean: Pair) -> Pair:
    """Return reading minus truth (instances, reads, 3) for each sensor; raise as `_require_usable` does if reads are unusable."""
    _require_usable(run)
    accel, gyro = ask.in_order(run)
    return accel - clean[0][0], gyro - clean[1][0]


def _creeps(biases: Array) -> bool:
    """Return whether biases (instances, reads, 3) drift: they change between reads, by far less than between instances."""
    moves = float(np.sqrt(np.mean(np.diff(biases, axis=1) ** 2)))
    between = float(np.sqrt(np.mean(np.var(biases[:, 0], axis=0))))
    return EXACT * max(1.0, float(np.abs(biases).max())) < moves < _CREEPS * between


def _shown_defaults(ask: _Questions, defaults: Pair, silent: Sequence[Reads]) -> Pair:
    """Return `defaults` where reads without noise show the bias, and else the biases in reads that share one draw of noise.

    Noise of a fixed size hides a bias without noise, and some models draw a default bias only together with noise. The biases of a
    sensor are NaN if even reads that share one draw differ.
    """
    shown = [each.still and bool(np.abs(bias).max() > TRUTH_ATOL) for each, bias in zip(silent, defaults, strict=True)]
    if all(shown):
        return defaults
    run = ask.default_bias(ask.stds, one_draw=True)
    if not _is_sound(run):
        return defaults
    beside = [rows - rows[0, 0] for rows in ask.in_order(run)]
    vary = [float(np.ptp(rows, axis=1).max()) > EXACT * max(1.0, float(np.abs(rows).max())) for rows in beside]
    accel, gyro = (
        bias if fine or (quiet.still and varies) else _UNKNOWN if varies else rows
        for bias, fine, quiet, rows, varies in zip(defaults, shown, silent, beside, vary, strict=True)
    )
    return accel, gyro


def _twins(ask: _Questions, *, given: bool = True) -> Sequence[Twins]:
    """Return, by sensor, reads of instances with the same seed and one parameter changed; `UNSEEDED` if the question failed."""
    if not _is_sound(run := ask.twins(given=given)):
        return UNSEEDED, UNSEEDED
    pairs = zip(ask.in_order(run), ask.other_biases - np.array(ask.biases), strict=True)
    return [Twins(base, again, larger, noisier, change, _LARGER) for (base, again, _, larger, noisier), change in pairs]


def _follow(ask: _Questions, sensors: tuple[Reads, Reads], truth: Traces) -> bool:
    """Return whether readings change with the robot's state: those in another state differ by more than chance.

    They may be of any sensor, in any order, sign, unit or scale. Also True if that cannot be measured.
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
    """Return whether both sensors have right noise and bias, but added to the reading at the start of a simulation.

    That is how a `read` answers that does not call the reader, and uses a reading that an earlier line of the file took.
    """
    if not all(twins.scales() and twins.adds_bias() for twins in _twins(ask)):
        return False
    starts = [truth["push"][f"alt_no_push_{key}"][0] for key in ("acceleration", "angular_velocity")]
    gaps = [np.abs(r.offset + r.truth - r.bias - start).max() for r, start in zip(sensors, starts, strict=True)]
    return all(gap <= 2 * reads.mean_bound for gap, reads in zip(gaps, sensors, strict=True))
