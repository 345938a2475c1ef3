"""Noise model: white Gaussian noise of the size that was asked for, a constant bias, independent on every axis."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from .. import statistics as st
from ..answers import Fault, NoiseRun
from ..compare import Array, vector
from ..diagnosis import noise as diagnosis
from ..diagnosis.noise import Facts
from ..plugin import check
from ..student import Student
from ..traces import Traces
from ..verdicts import Lost, Skipped, raised
from .check_data_collection import torso_ids

_INSTANCES = 24
_MANY = 100
"""Reads of one instance in one state: their mean is off by a tenth of the noise."""
_ROUGHLY = 0.3
"""600 noise-free values tell their spread to 3 %; the rest is for the shape of the law that the biases are drawn from."""
_SILENT, _ALMOST_SILENT = (0.0, 0.0), (1e-12, 1e-12)
"""Standard deviations. A constructor may refuse a zero, and a picometre a second squared is as good as none."""
_TRUTH_OF_ARRAY = "truth value of an array"
"""What NumPy says where a bias is tested with `or`, with `not`, or with `==`."""
_UNITS = ("m/s²", "rad/s")
_NAMES = ("accel", "gyro")
_ORDER = (
    "Keep the two sensors apart in read(), the accelerometer first: look at the order of the ids, of what you unpack and "
    "of what you return, and at the bias that each one gets (Step 5)."
)


@check("noise_model.noise_size", lab_step=5)
def check_noise_size(student: Student, truth: Traces) -> None:
    """The noise of each sensor has the standard deviation that was asked for"""
    sensors = _given(student, truth)
    if all(map(_size_is_right, sensors)):
        return
    again, silent = _given_again(student, truth), _silent(student, truth)
    if _redrawn_bias_explains(sensors, silent):
        return
    wrong = next(i for i, facts in enumerate(sensors) if not _size_is_right(facts))
    raise Lost(
        f"{_NAMES[wrong]} noise with a standard deviation of {sensors[wrong].std:g} {_UNITS[wrong]}",
        f"{sensors[wrong].pooled_spread:.3g} {_UNITS[wrong]} over {sensors[wrong].residual[..., 0].size} reads",
        mistakes=diagnosis.size_mistakes(sensors, again, silent),
        keeps=0.5 if any(map(_size_is_right, sensors)) else 0.0,
    )


def _size_is_right(facts: Facts) -> bool:
    """The size, in the light of a fault that another check charges: a law that is not normal, noise that adds up."""
    if diagnosis.accumulates(facts):
        return diagnosis.size_is_right(facts, float(np.sqrt(np.mean(facts.increments**2))))
    if diagnosis.one_signed(facts):  # |normal| has the root mean square that was asked for, an exponential law the mean
        beside = np.abs(facts.residual - facts.bias)
        return any(diagnosis.size_is_right(facts, float(s)) for s in (np.sqrt(np.mean(beside**2)), beside.mean()))
    return diagnosis.size_is_right(facts) or diagnosis.half_width_is_std(facts)


def _redrawn_bias_explains(sensors: list[Facts], silent: list[Facts]) -> bool:
    """Whether what is too much is a bias that is drawn anew on every read, which default_bias charges."""
    if not diagnosis.bias_is_redrawn(sensors, silent):
        return False
    whole = [float(np.hypot(f.std, s.pooled_spread)) for f, s in zip(sensors, silent, strict=True)]
    return all(abs(f.pooled_spread / w - 1) < _ROUGHLY for f, w in zip(sensors, whole, strict=True))


@check("noise_model.given_bias", lab_step=5)
def check_given_bias(student: Student, truth: Traces) -> None:
    """A bias that is given is added to every reading, zero included"""
    sensors, silent = _given(student, truth), _silent(student, truth)
    for key in ("given", "silent"):
        _is_taken(_asked(student, truth, key, given=True).fault)
    if _returns_exchanged(student, truth):
        raise Lost(
            "accel first and gyro second from read(), each with its own bias",
            "gyro first and accel second",
            mistakes=["swapped-sensors"],
            hint=_ORDER,
        )
    wrong = [i for i, facts in enumerate(sensors) if not _bias_is_right(facts)]
    redrawn = diagnosis.bias_is_redrawn(sensors, silent)
    if wrong:
        facts, unit = sensors[wrong[0]], _UNITS[wrong[0]]
        mistakes = ["bias-redrawn"] if redrawn else diagnosis.bias_mistakes(sensors)
        crossed = mistakes == ["swapped-sensors"] or diagnosis.biases_exchanged(sensors)
        raise Lost(
            f"readings that are {vector(facts.bias)} {unit} off the clean ones on average ({_NAMES[wrong[0]]})",
            f"{vector(facts.offset[-1])} {unit}",
            off=f"an average that is off by up to {np.abs(facts.offset - facts.bias).max():.3g} {unit}",
            mistakes=mistakes,
            keeps=0.5 if len(wrong) == 1 else 0.0,
            hint=_ORDER if crossed else "",
        )
    exact = [diagnosis.TRUTH_ATOL + facts.grain / 2 for facts in sensors]
    moved = [f for f, least in zip(silent, exact, strict=True) if np.abs(f.offset).max() > least]
    if any(facts.still for facts in moved):
        got = moved[0]
        raise Lost(
            "no offset where the given bias is zero",
            vector(got.offset[0]),
            mistakes=["bias-argument-ignored"],
            keeps=0.5,
        )


def _is_taken(fault: Fault | None) -> None:
    if fault is not None and _TRUTH_OF_ARRAY in fault.message:
        raise Lost(
            "a bias given as an array of three that is used as it is",
            f"an exception{f' at {fault.where}' if fault.where else ''}: an array was tested for truth, and has none",
            off="an exception: an array was tested for truth, and has none",
            mistakes=["bias-argument-ignored"],
        )
    raised(fault, "reading the noisy IMU with given biases")


def _bias_is_right(facts: Facts) -> bool:
    if diagnosis.accumulates(facts):  # where the walk starts is all that can be seen of the bias
        start = np.abs(facts.residual[0, 0] - facts.bias)
        return bool(start.max() <= 2 * st.Z * facts.std)
    if diagnosis.one_signed(facts):
        return True
    return diagnosis.bias_is_right(facts)


@check("noise_model.default_bias", lab_step=5)
def check_default_bias(student: Student, truth: Traces) -> None:
    """Without a given bias, each instance draws its own, keeps it, and has one for every axis"""
    biases = _default_biases(student, truth)
    sensors, silent = _given(student, truth), _silent(student, truth)
    noisy = any(not facts.still for facts in silent) and not diagnosis.bias_is_redrawn(sensors, silent)
    none = [bool(np.abs(bias.mean(axis=1)).max() <= diagnosis.TRUTH_ATOL) for bias in biases]
    for which, (bias, name) in enumerate(zip(biases, _NAMES, strict=True)):
        _bias_is_constant(bias, name, noisy=noisy)
        mean = bias.mean(axis=1)
        if none[which]:
            if _drawn_with_noise(student, truth, which):
                continue
            mistake = "no-bias" if diagnosis.bias_mistakes(sensors) == ["no-bias"] else "bias-not-random"
            keeps = 0.0 if mistake == "no-bias" else 0.5
            raise Lost(f"a random {name} bias for each instance", "none", mistakes=[mistake], keeps=keeps)
        if np.ptp(mean[1:], axis=0).max() <= diagnosis.EXACT and not noisy:
            got = f"{vector(mean[1])} for each of {len(mean)} instances"
            reseeded = all(f.still for f in sensors) and diagnosis.size_mistakes(
                sensors, _given_again(student, truth), silent
            )
            mistakes = reseeded or ["bias-not-random"]
            raise Lost(f"another {name} bias for each instance", got, mistakes=mistakes, keeps=0.5)
        if np.ptp(mean, axis=1).max() <= diagnosis.TRUTH_ATOL:
            got = f"{vector(mean[0])}: the same on each axis"
            raise Lost(f"a {name} bias of its own on each axis", got, mistakes=["bias-shared"], keeps=0.5)
    if any(none):
        return
    ratio = biases[1].mean(axis=1) / biases[0].mean(axis=1)
    if np.ptp(ratio) <= 1e-3 * np.abs(ratio).max():
        got = f"{ratio[0, 0]:.3g} times the accelerometer's for the gyroscope, on every axis"
        raise Lost("a bias of its own for each sensor", got, mistakes=["bias-shared"], keeps=0.5)


def _drawn_with_noise(student: Student, truth: Traces, which: int) -> bool:
    """Whether a sensor that has no bias where there is no noise has one where there is: its size may go with the noise's.

    Its mean over many reads then scatters from instance to instance, by more than the noise alone lets it.
    """
    mean = _default_biases(student, truth, stds=_stds(truth), reads=_MANY)[which].mean(axis=1)
    _, most = st.spread_bounds(mean.size, mean.shape[1])
    return bool(np.sqrt(np.mean(np.var(mean, axis=0))) > most * _stds(truth)[which] / np.sqrt(_MANY))


def _bias_is_constant(bias: Array, name: str, *, noisy: bool) -> None:
    moves = np.ptp(bias, axis=1)
    if moves.max() <= diagnosis.EXACT * max(1.0, np.abs(bias).max()) or noisy:
        return
    row = int(np.argmax(moves.max(axis=1)))
    wanted = f"a {name} bias that stays the same from read to read"
    got = f"{vector(bias[row, 0])}, then {vector(bias[row, 1])} from the same instance"
    if np.ptp(bias[:, 1:], axis=(0, 1)).max() <= diagnosis.EXACT:  # the first read was before the next one was made
        got += ", and from every other one that was made meanwhile"
        raise Lost(wanted, got, mistakes=["bias-shared"], keeps=0.5)
    raise Lost(wanted, got, mistakes=["bias-redrawn"])


@check("noise_model.white_and_gaussian", lab_step=5)
def check_white_and_gaussian(student: Student, truth: Traces) -> None:
    """The noise is Gaussian with zero mean, and no read depends on the one before"""
    both = _given(student, truth)
    if any(facts.grain for facts in both):
        grains = " and ".join(f"{f.grain:g} {u} ({n})" for f, u, n in zip(both, _UNITS, _NAMES, strict=True) if f.grain)
        raise Lost("readings as fine as float64 has them", f"multiples of {grains} alone", mistakes=["precision-lost"])
    sensors = [(f, n) for f, n in zip(both, _NAMES, strict=True) if not f.still]
    if not sensors:
        raise Skipped("noise that differs from read to read")
    for facts, name in sensors:
        _is_white(facts, name)
        if diagnosis.one_signed(facts):
            raise Lost(f"{name} noise of both signs", "noise of one sign only", mistakes=["noise-not-zero-mean"])
        values = facts.standardised[:, facts.standardised.any(axis=0)]  # an axis without noise is charged by noise_size
        low, high = st.geary_bounds(values.size)
        ratio = st.geary(values.ravel())
        if not low <= ratio <= high:
            got = f"{ratio:.3f} over {values.size} values"
            wanted = f"{name} noise with a ratio of mean deviation to standard deviation of 0.798, as a normal law has"
            raise Lost(wanted, got, mistakes=["not-gaussian"])


def _is_white(facts: Facts, name: str) -> None:
    if diagnosis.accumulates(facts):
        raise Lost(
            f"{name} noise drawn anew on every read",
            "noise that adds up from read to read",
            mistakes=["noise-accumulates"],
        )
    bound = st.correlation_bound(facts.residual.shape[1])
    for lag in (1, 2, 3):
        worst = max((abs(r) for state in facts.centred for r in st.autocorrelation(state, lag)), default=0.0)
        if worst > bound:
            raise Lost(
                f"{name} reads that do not depend on each other",
                f"a correlation of {worst:.2f} with the read {lag} before",
            )


@check("noise_model.axes_and_sensors_independent", lab_step=5)
def check_axes_and_sensors_independent(student: Student, truth: Traces) -> None:
    """Each axis of each sensor has noise of its own"""
    sensors = _given(student, truth)
    if all(facts.still for facts in sensors):
        raise Skipped("noise that differs from read to read")
    columns = np.concatenate([_innovations(facts) for facts in sensors], axis=1)
    matrix = st.correlations(columns)
    bound = st.correlation_bound(len(columns))
    channels = [f"{sensor} {axis}" for sensor in _NAMES for axis in "xyz"]
    pairs = [(abs(matrix[i, j]), i, j) for i, j in itertools.combinations(range(6), 2)]
    worst, i, j = max(pairs)
    if worst > bound:
        raise Lost(
            f"independent noise on {channels[i]} and {channels[j]}",
            f"a correlation of {worst:.2f} over {len(columns)} reads",
            mistakes=["same-noise-on-axes"] if worst > 0.99 else [],
        )


def _innovations(facts: Facts) -> Array:
    if diagnosis.accumulates(facts):
        steps = np.concatenate([facts.increments[:, :1] * 0, facts.increments], axis=1)
        return np.asarray(steps.reshape(-1, 3))
    return facts.standardised


@check("noise_model.leaves_simulation_alone", lab_step=5)
def check_leaves_simulation_alone(student: Student, truth: Traces) -> None:
    """A noisy read changes nothing in the simulator's own data"""
    run = _run(student, truth, "given")
    change = run.disturbance.max(axis=0, initial=0.0)
    names = ("data.time", "data.qpos", "data.qvel", "data.sensordata")
    changed = [f"{name} changed by {size:.3g}" for name, size in zip(names, change, strict=True) if not size <= 1e-12]
    if changed:
        only_sensors = change[:3].max() <= 1e-12
        mistake = "mutates-sensordata" if only_sensors else "disturbs-simulation"
        raise Lost("the same data before and after a read", "; ".join(changed), mistakes=[mistake])


# --- what the checks share -----------------------------------------------------------------------------------------------


def _run(student: Student, truth: Traces, key: str) -> NoiseRun:
    """What the checks judge: reads with given biases; with the submission's own where it stumbles over given ones only."""
    return _sound_form(student, truth, _asked(student, truth, key, given=_takes_biases(student, truth, key)))


def _sound_form(student: Student, truth: Traces, run: NoiseRun) -> NoiseRun:
    """A run of whole vectors, the accelerometer's first: given_bias charges it where they come the other way round."""
    raised(run.fault, "reading the noisy IMU")
    if not _is_whole(run):
        mistake = "wrong-return-type" if run.odd else "not-finite"
        raise Lost("a tuple of two arrays of shape (3,) from read()", run.odd or "NaN or infinity", mistakes=[mistake])
    return _exchanged(run) if _returns_exchanged(student, truth) else run


def _is_whole(run: NoiseRun) -> bool:
    return bool(np.isfinite(run.accel).all() and np.isfinite(run.gyro).all())


def _returns_exchanged(student: Student, truth: Traces) -> bool:
    """Whether each vector is the other sensor's, with that sensor's bias."""
    return student.once("noise exchanged", lambda: _fits_exchanged(student, truth))


def _fits_exchanged(student: Student, truth: Traces) -> bool:
    run = _asked(student, truth, "given", given=True)
    if run.fault is not None or not _is_whole(run):
        return False
    straight, exchanged = (_facts_of(r, truth, _biases(truth)) for r in (run, _exchanged(run)))
    return all(map(diagnosis.bias_is_right, exchanged)) and not any(map(diagnosis.bias_is_right, straight))


def _exchanged(run: NoiseRun) -> NoiseRun:
    return replace(run, accel=run.gyro, gyro=run.accel)


def _takes_biases(student: Student, truth: Traces, key: str) -> bool:
    """Whether a run with given biases is as good as one without: otherwise given_bias charges what it raises."""
    return (
        _asked(student, truth, key, given=True).fault is None
        or _asked(student, truth, key, given=False).fault is not None
    )


def _stds(truth: Traces) -> tuple[float, float]:
    return float(truth["noise"].scalars["accel_noise_std"]), float(truth["noise"].scalars["gyro_noise_std"])


def _biases(truth: Traces) -> tuple[Array, Array]:
    return truth["noise"]["accel_bias"], truth["noise"]["gyro_bias"]


def _asked(student: Student, truth: Traces, key: str, *, given: bool) -> NoiseRun:
    scenario = truth["noise"]
    settings = {
        "given": (st.READS, _stds(truth), _biases(truth)),
        "again": (3, _stds(truth), _biases(truth)),
        "silent": (_MANY, _SILENT, (np.zeros(3), np.zeros(3))),
        "almost silent": (_MANY, _ALMOST_SILENT, (np.zeros(3), np.zeros(3))),
    }
    reads, stds, biases = settings[key]
    run = student.noise(
        key if given else f"{key}, without biases",
        qpos=scenario["qpos"],
        qvel=scenario["qvel"],
        ids=torso_ids(truth),
        reads=reads,
        stds=stds,
        biases=biases if given else None,
    )
    return _asked(student, truth, "almost silent", given=given) if run.fault and key == "silent" else run


def _facts(student: Student, truth: Traces, key: str) -> list[Facts]:
    return student.once(("noise facts", key), lambda: _told_by(student, truth, key))


def _told_by(student: Student, truth: Traces, key: str) -> list[Facts]:
    run = _run(student, truth, key)
    if key == "silent":
        return _facts_of(run, truth, (np.zeros(3), np.zeros(3)))
    return _facts_of(run, truth, _biases(truth) if _takes_biases(student, truth, key) else None)


def _facts_of(run: NoiseRun, truth: Traces, biases: tuple[Array, Array] | None) -> list[Facts]:
    """The facts of both sensors, about these biases, or about the mean where they are not known."""
    clean = (truth["noise"]["acceleration"], truth["noise"]["angular_velocity"])
    residuals = [r - c[:, None, :] for r, c in zip((run.accel, run.gyro), clean, strict=True)]
    about = biases or [r.mean(axis=(0, 1)) for r in residuals]
    return [Facts(r, c, s, b) for r, c, s, b in zip(residuals, clean, _stds(truth), about, strict=True)]


def _given(student: Student, truth: Traces) -> list[Facts]:
    return _facts(student, truth, "given")


def _given_again(student: Student, truth: Traces) -> list[Facts]:
    return _facts(student, truth, "again")


def _silent(student: Student, truth: Traces) -> list[Facts]:
    return _facts(student, truth, "silent")


def _default_biases(
    student: Student, truth: Traces, stds: tuple[float, float] = _SILENT, reads: int = 3
) -> list[Array]:
    """(instances, reads, 3) offsets of each sensor, without noise if nothing else is asked for."""
    scenario = truth["noise"]
    run = student.default_bias(
        qpos=scenario["qpos"], qvel=scenario["qvel"], ids=torso_ids(truth), instances=_INSTANCES, reads=reads, stds=stds
    )
    if run.fault and stds == _SILENT:
        return _default_biases(student, truth, _ALMOST_SILENT, reads)
    run = _sound_form(student, truth, run)
    return [run.accel - scenario["acceleration"][0], run.gyro - scenario["angular_velocity"][0]]
