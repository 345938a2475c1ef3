"""Facts about a `NoisyIMU`: reads with and without noise, in two states and of many instances, sensor by sensor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from grader.base.errors import NoAnswer
from grader.engine.findings import CheckFailed, Missing, Raised, Unusable, raised
from grader.engine.submission_session import found_once
from grader.engine.traces import Traces
from grader.labs.imu import statistics as st
from grader.labs.imu.answers import NoiseRun
from grader.labs.imu.compare import Array
from grader.labs.imu.diagnosis import noise as diagnosis
from grader.labs.imu.diagnosis import noise_laws as laws
from grader.labs.imu.diagnosis.noise import Facts as Reads
from grader.labs.imu.diagnosis.noise_twins import Twins
from grader.labs.imu.recordings import torso_ids
from grader.labs.imu.student import Student

_FORM = "a tuple of two arrays of shape (3,) from read()"
_INSTANCES = 24
MANY = 100
"""Reads of one instance in one state: their mean is off by a tenth of the noise."""
_SILENT, _ALMOST_SILENT = (0.0, 0.0), (1e-12, 1e-12)
"""Standard deviations. Code may refuse a zero, or divide by it, and a picometre a second squared is as good as none."""
_TWINS, _LARGER = 40, 1.5
"""Reads of each twin, and how much larger the noise of the last one is."""
_BY_CHANCE = 10.0
"""Smallest change of a reading with the state, in units of what a twin in the same state differs by. Counters reach 2; the sheet's
noise at 20 times its size reaches 50."""


def judged(student: Student, truth: Traces, key: str) -> NoiseRun:
    """Return the reads that are judged: with given biases, or with its own if the model fails only with given ones."""
    return _sound_form(student, truth, asked(student, truth, key, given=takes_biases(student, truth, key)))


def _sound_form(student: Student, truth: Traces, run: NoiseRun) -> NoiseRun:
    """A run of whole vectors, the accelerometer's first: given_bias charges it where they come the other way round."""
    raised(run.fault, "reading the noisy IMU")
    if not _is_whole(run):
        mistake = "wrong-return-type" if run.odd else "not-finite"
        raise Unusable(_FORM, run.odd or "NaN or infinity", mistakes=[mistake])
    return _exchanged(run) if returns_exchanged(student, truth) else run


def _is_whole(run: NoiseRun) -> bool:
    return bool(np.isfinite(run.accel).all() and np.isfinite(run.gyro).all())


def _is_sound(run: NoiseRun) -> bool:
    return run.fault is None and _is_whole(run)


@found_once
def returns_exchanged(student: Student, truth: Traces) -> bool:
    """Return whether each vector is the other sensor's, with that sensor's bias."""
    run = asked(student, truth, "given", given=True)
    if not _is_sound(run):
        return False
    clean = (truth["noise"]["acceleration"], truth["noise"]["angular_velocity"])
    straight, exchanged = (_facts_of(r, truth, clean, _biases(truth)) for r in (run, _exchanged(run)))
    return all(map(diagnosis.bias_is_right, exchanged)) and not any(map(diagnosis.bias_is_right, straight))


def is_one_twice(student: Student, truth: Traces) -> bool:
    """Return whether one sensor comes in both places, with its noise: what is the same without any is no sensor."""
    run = asked(student, truth, "given", given=True)
    same = _is_sound(run) and np.array_equal(run.accel, run.gyro)
    return same and bool(np.ptp(run.accel, axis=1).all())


def _exchanged(run: NoiseRun) -> NoiseRun:
    return replace(run, accel=run.gyro, gyro=run.accel)


def takes_biases(student: Student, truth: Traces, key: str) -> bool:
    """Return whether a run with given biases is as good as one without: otherwise given_bias charges what it raises."""
    return (
        asked(student, truth, key, given=True).fault is None
        or asked(student, truth, key, given=False).fault is not None
    )


def asked_stds(truth: Traces) -> tuple[float, float]:
    return float(truth["noise"].scalars["accel_noise_std"]), float(truth["noise"].scalars["gyro_noise_std"])


def _biases(truth: Traces) -> tuple[Array, Array]:
    return truth["noise"]["accel_bias"], truth["noise"]["gyro_bias"]


def asked(student: Student, truth: Traces, key: str, *, given: bool) -> NoiseRun:
    scenario = truth["noise"]
    settings = {
        "given": (st.READS, asked_stds(truth), _biases(truth)),
        "again": (3, asked_stds(truth), _biases(truth)),
        "silent": (MANY, _SILENT, (np.zeros(3), np.zeros(3))),
        "almost silent": (MANY, _ALMOST_SILENT, (np.zeros(3), np.zeros(3))),
    }
    reads, stds, biases = settings[key]
    run = student.noise(
        qpos=scenario["qpos"],
        qvel=scenario["qvel"],
        ids=torso_ids(truth),
        reads=reads,
        stds=stds,
        biases=biases if given else None,
        called="noise" if given and key == "given" else "",
    )
    return run if key != "silent" or _is_sound(run) else asked(student, truth, "almost silent", given=given)


@found_once
def _facts(student: Student, truth: Traces, key: str) -> list[Reads]:
    run, clean = judged(student, truth, key), clean_readings(student, truth)
    if key == "silent":
        return _facts_of(run, truth, clean, (np.zeros(3), np.zeros(3)))
    return _facts_of(run, truth, clean, _biases(truth) if takes_biases(student, truth, key) else None)


def _facts_of(
    run: NoiseRun, truth: Traces, clean: tuple[Array, Array], biases: tuple[Array, Array] | None
) -> list[Reads]:
    """The facts of both sensors, about these biases, or about the mean where they are not known."""
    residuals = [r - c[:, None, :] for r, c in zip((run.accel, run.gyro), clean, strict=True)]
    about = biases or [r.mean(axis=(0, 1)) for r in residuals]
    return [Reads(r, c, s, b) for r, c, s, b in zip(residuals, clean, asked_stds(truth), about, strict=True)]


@found_once
def clean_readings(student: Student, truth: Traces) -> tuple[Array, Array]:
    """(states, 3) what each sensor reads without noise: the truth, or what the submission's own reader returns.

    The reader's own value counts for a sensor where the noisy readings go with it and not with the truth, so that a fault of the
    reader costs nothing here.
    """
    straight = (truth["noise"]["acceleration"], truth["noise"]["angular_velocity"])
    try:
        run = judged(student, truth, "given")
    except (CheckFailed, Raised):
        return straight
    sensors = _facts_of(run, truth, straight, None)
    own = None if all(map(_keeps_its_offset, sensors)) else _own_readings(student, truth)
    if own is None:
        return straight
    beside_own = _facts_of(run, truth, own, None)
    pairs = list(zip(sensors, beside_own, strict=True))
    accel, gyro = (f.truth if _keeps_its_offset(f) or not _keeps_its_offset(o) else o.truth for f, o in pairs)
    return accel, gyro


def _keeps_its_offset(facts: Reads) -> bool:
    return bool(np.ptp(facts.offset, axis=0).max() <= 2 * diagnosis.mean_bound(facts))


def _would_show(facts: Reads) -> bool:
    """Return whether the sensor changes with the state by more than the noise hides."""
    return bool(np.ptp(facts.truth, axis=0).max() > 4 * diagnosis.mean_bound(facts))


def _own_readings(student: Student, truth: Traces) -> tuple[Array, Array] | None:
    scenario = truth["noise"]
    states = {key: scenario[key] for key in ("qpos", "qvel")}
    try:
        readings = student.read(model=student.robot.xml, pairs=np.array([torso_ids(truth)]), **states)
    except (Missing, NoAnswer):
        return None
    return (readings.accel[0], readings.gyro[0]) if np.isfinite([readings.accel, readings.gyro]).all() else None


def given(student: Student, truth: Traces) -> list[Reads]:
    return _facts(student, truth, "given")


@found_once
def which_drift(student: Student, truth: Traces) -> list[bool]:
    silent = without_noise(student, truth)
    try:
        biases = default_biases(student, truth)
    except (Raised, Unusable):  # default_bias charges it
        return [laws.drifts(facts) for facts in silent]
    return [laws.drifts(f) or (f.still and laws.creeps(b)) for f, b in zip(silent, biases, strict=True)]


@found_once
def from_one_seed(student: Student, truth: Traces) -> list[Twins] | None:
    """Return instances from one seed, each with one parameter changed; None if a reading is not whole."""
    run = _twins(student, truth)
    if not _is_sound(run):
        return None
    run = _exchanged(run) if returns_exchanged(student, truth) else run
    biases = np.array(_biases(truth))
    return [
        Twins(base, again, larger, noisier, change, _LARGER)
        for (base, again, _, larger, noisier), change in zip(
            (run.accel, run.gyro), _other(biases) - biases, strict=True
        )
    ]


def _other(biases: Array) -> Array:
    return np.asarray(biases[:, [2, 0, 1]] * np.array([1.5, -2.0, 3.0]))


def _twins(student: Student, truth: Traces) -> NoiseRun:
    """The same arguments twice, then in another state, with another bias, and with larger noise."""
    scenario, stds, biases = truth["noise"], asked_stds(truth), np.array(_biases(truth))
    return student.noise_twins(
        qpos=scenario["qpos"],
        qvel=scenario["qvel"],
        ids=torso_ids(truth),
        reads=_TWINS,
        stds=[*[stds] * 4, (_LARGER * stds[0], _LARGER * stds[1])],
        biases=np.array([biases, biases, biases, _other(biases), biases]),
        states=(0, 0, 1, 0, 0),
    )


@found_once
def reads_the_sensors(student: Student, truth: Traces) -> bool:
    """Return whether the readings follow the state: a new instance in another state reads something else, by more than chance.

    It may be any sensor, in any order, sign, unit or scale. True where nothing can be told.
    """
    series = (truth["noise"]["acceleration"], truth["noise"]["angular_velocity"])
    if not any(np.ptp(each, axis=0).max() > 2 * diagnosis.TRUTH_ATOL for each in series):
        return True  # an instructor's robot may read the same in both states
    if any(_keeps_its_offset(reads) and _would_show(reads) for reads in given(student, truth)):
        return True
    if _is_about_a_start(student, truth):
        return True
    run = _twins(student, truth)
    base, again, elsewhere = np.concatenate([run.accel, run.gyro], axis=2)[:3].mean(axis=1)
    if not np.isfinite([base, again, elsewhere]).all():
        return True
    chance = _BY_CHANCE * float(np.abs(again - base).max())
    return bool(np.abs(elsewhere - base).max() > diagnosis.TRUTH_ATOL + chance)


def _is_about_a_start(student: Student, truth: Traces) -> bool:
    """Return whether the noise and the bias that are asked for stand beside what both sensors read as a simulation starts.

    A `read` that forgets to call the reader uses what an earlier line of the file has read.
    """
    twins = from_one_seed(student, truth)
    if not twins or not all(each.scales() and each.adds_bias() for each in twins):
        return False
    starts = [truth["push"][f"alt_no_push_{key}"][0] for key in ("acceleration", "angular_velocity")]
    return all(
        np.abs(reads.offset + reads.truth - reads.bias - start).max() <= 2 * diagnosis.mean_bound(reads)
        for reads, start in zip(given(student, truth), starts, strict=True)
    )


def given_again(student: Student, truth: Traces) -> list[Reads]:
    return _facts(student, truth, "again")


def without_noise(student: Student, truth: Traces) -> list[Reads]:
    return _facts(student, truth, "silent")


def default_biases(student: Student, truth: Traces, stds: tuple[float, float] = _SILENT, reads: int = 3) -> list[Array]:
    """(instances, reads, 3) offsets of each sensor, without noise if nothing else is asked for."""
    scenario = truth["noise"]
    run = student.default_bias(
        qpos=scenario["qpos"], qvel=scenario["qvel"], ids=torso_ids(truth), instances=_INSTANCES, reads=reads, stds=stds
    )
    if stds == _SILENT and not _is_sound(run):
        return default_biases(student, truth, _ALMOST_SILENT, reads)
    run, (accel, gyro) = _sound_form(student, truth, run), clean_readings(student, truth)
    return [run.accel - accel[0], run.gyro - gyro[0]]


# ---- everything together


ALL = ("noise_size", "given_bias", "default_bias", "white_and_gaussian", "axes_and_sensors_independent")


@dataclass(frozen=True)
class Facts:
    """Facts about one noise model; in each pair the accelerometer comes first.

    Attributes
    ----------
    sensors : many reads in two states, with noise and biases that are given
    silent : fewer reads, with neither; again : three reads of another instance like the first
    defaults : (instances, reads, 3) offsets without noise where no bias is given; None where it could not be run
    drifting : whether the bias moves from read to read; drawn_with_noise : whether a default bias is there with noise alone
    twins : differences of instances from one seed; None where there was nothing to tell apart
    follows : whether the readings follow the state; exchanged : each is the other's; one_twice : both are the same numbers
    disturbance : (4,) largest change of time, qpos, qvel and sensordata in a read
    timestep : of the robot's model, in seconds
    odd : in words, the form that both vectors were made out of; departs : parameters that it could not be called with
    stopped : by check, what kept its property from being measured
    """

    sensors: tuple[Reads, Reads]
    silent: tuple[Reads, Reads]
    again: tuple[Reads, ...] = ()
    defaults: tuple[Array, Array] | None = None
    drifting: tuple[bool, bool] = (False, False)
    drawn_with_noise: tuple[bool, bool] = (False, False)
    twins: tuple[Twins, ...] = ()
    follows: bool = True
    exchanged: bool = False
    one_twice: bool = False
    disturbance: Array = field(default_factory=lambda: np.zeros(4))
    timestep: float = 0.002
    odd: str = ""
    departs: tuple[str, ...] = ()
    stopped: Mapping[str, Exception] = field(default_factory=dict)

    @cached_property
    def steady(self) -> tuple[Reads, Reads]:
        """The reads as if no bias drifted."""
        if not any(self.drifting):
            return self.sensors
        accel, gyro = (laws.steadied(reads, silent) for reads, silent in zip(self.sensors, self.silent, strict=True))
        return accel, gyro

    @cached_property
    def steady_silent(self) -> tuple[Reads, ...]:
        pairs = zip(self.silent, self.drifting, strict=True)
        return tuple(replace(f, residual=0 * f.residual) if drifts else f for f, drifts in pairs)

    @cached_property
    def still(self) -> bool:
        """Return whether neither sensor's reads differ."""
        return all(reads.still for reads in self.steady)

    @cached_property
    def redrawn(self) -> bool:
        return not any(self.drifting) and diagnosis.bias_is_redrawn(self.sensors, self.silent)


def measure(student: Student, truth: Traces) -> Facts:
    """Ask for reads with and without noise, and for what tells two causes apart only where something is off."""
    try:
        run = judged(student, truth, "given")
        (accel, gyro), silent = given(student, truth), without_noise(student, truth)
    except (Raised, Unusable) as stop:
        return _nothing(stop, student, truth)
    follows = reads_the_sensors(student, truth)
    stopped: dict[str, Exception] = {}
    for key in ("given", "silent"):
        if (fault := asked(student, truth, key, given=True).fault) is not None:
            stopped.setdefault("given_bias", Raised(fault, "reading the noisy IMU with given biases"))
    defaults: tuple[Array, Array] | None = None
    try:
        own, gyros = default_biases(student, truth)
        defaults = own, gyros
    except (Raised, Unusable) as stop:
        stopped["default_bias"] = stop
    drifting = which_drift(student, truth)
    right = all(diagnosis.size_is_right(f) and diagnosis.bias_is_right(f) for f in (accel, gyro)) and not any(drifting)
    none = [bool(np.abs(b.mean(axis=1)).max() <= diagnosis.TRUTH_ATOL) for b in defaults or ()]
    return Facts(
        sensors=(accel, gyro),
        silent=(silent[0], silent[1]),
        again=() if right else tuple(given_again(student, truth)),
        defaults=defaults,
        drifting=(drifting[0], drifting[1]),
        drawn_with_noise=_drawn_with_noise(student, truth) if any(none) else (False, False),
        twins=() if right else tuple(from_one_seed(student, truth) or ()),
        follows=follows,
        exchanged=returns_exchanged(student, truth),
        one_twice=is_one_twice(student, truth),
        disturbance=run.disturbance.max(axis=0, initial=0.0),
        timestep=float(truth["push"].scalars["timestep"]),
        odd=run.odd or "",
        departs=tuple(judged(student, truth, "given").departs),
        stopped=stopped,
    )


def _nothing(stop: Exception, student: Student, truth: Traces) -> Facts:
    """Facts where no whole vectors came: all that can be said is what a read changes."""
    still = Reads(np.zeros((1, 1, 3)), np.zeros((1, 3)), 1.0, np.zeros(3))
    stopped: dict[str, Exception] = dict.fromkeys(ALL, stop)
    disturbance = np.zeros(4)
    try:
        disturbance = judged(student, truth, "given").disturbance.max(axis=0, initial=0.0)
    except (Raised, Unusable) as first:
        stopped["leaves_simulation_alone"] = first
    return Facts((still, still), (still, still), disturbance=disturbance, stopped=stopped)


def _drawn_with_noise(student: Student, truth: Traces) -> tuple[bool, bool]:
    """Return whether each sensor has a default bias that comes with noise alone.

    The means of many reads then vary between instances by more than noise of that standard deviation explains.
    """
    stds = asked_stds(truth)
    means = [bias.mean(axis=1) for bias in default_biases(student, truth, stds=stds, reads=MANY)]
    accel, gyro = (
        float(np.sqrt(np.mean(np.var(mean, axis=0))))
        > st.spread_bounds(mean.size, mean.shape[1])[1] * std / np.sqrt(MANY)
        for mean, std in zip(means, stds, strict=True)
    )
    return bool(accel), bool(gyro)
