"""Diagnosis of a noise model: the known faults of its noise and its biases, and what each of them makes of the readings.

A fault of the size predicts the standard deviation of a sensor's reads, and a fault of a bias predicts their mean. Both may depend
on the other sensor. A fault explains the readings if its prediction holds for every sensor that is wrong.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from grader.engine import hypothesis
from grader.engine.charging import Judge, Measure
from grader.engine.findings import Deviation, Form
from grader.engine.hypothesis import Reason
from grader.labs.imu import statistics as st
from grader.labs.imu.compare import BOTH, Array, changed, same
from grader.labs.imu.lab import LAB
from grader.labs.imu.noise_model.measure import ALL, FORM, ROUGHLY, Facts, Sensor, measure
from grader.labs.imu.noise_model.reads import EXACT, TRUTH_ATOL, Reads
from grader.labs.imu.parameters import CALL_REASONS, departures

SIZE, GIVEN, DEFAULT, LAW, APART = ALL
ALONE = "leaves_simulation_alone"
_NEAR = 0.07
"""Largest relative difference from a predicted spread. The nearest other prediction is a tenth away."""
_THE_SAME = 0.99
"""Least correlation of two channels that have one noise. A tenth of other noise leaves 0.995 of it, half leaves 0.8."""

Holds = Callable[[Facts], bool]


def sensors_that(facts: Facts, holds: Callable[[Sensor], bool]) -> list[int]:
    """Return the indices of the sensors (0 accelerometer, 1 gyroscope) for which the test `holds` is true: both, one or none."""
    return [i for i in BOTH if holds(facts.sensors[i])]


def _diagnosed_by(find: Callable[[Facts], str], fault: str) -> Holds:
    """Return a test of the facts: whether the function `find`, which names a fault, names this one."""
    return lambda facts: find(facts) == fault


# ---- the size of the noise


def sizes_off(facts: Facts) -> list[int]:
    """Return the sensors (0 or 1) whose noise does not have the standard deviation that was asked for, whatever its distribution.

    If a noise is not white and normal, its size may be right by chance: both sensors are then returned if one fault, such as
    swapped standard deviations, explains both sizes.
    """
    another = any(_spread_is(fault)(facts, BOTH) for fault in _SPREADS) and any(s.law_is_off for s in facts.sensors)
    return [*BOTH] if another else sensors_that(facts, lambda sensor: not sensor.has_size)


def grain(facts: Facts) -> float:
    """Return the step to which a noise model rounds its readings or their noise, for the message; 0 if it does not round."""
    return max(sensor.reads.grain for sensor in facts.sensors)


def _lost_in_rounding(facts: Facts) -> bool:
    """Return whether rounding to steps as large as the noise explains each noise of a wrong size; False if no size is wrong."""
    step = max(sensor.reads.step for sensor in facts.sensors)
    return bool(sizes_off(facts)) and all(facts.sensors[i].reads.std <= step for i in sizes_off(facts))


def no_draw(facts: Facts) -> bool:
    """Return whether reads hold no random draw: they count up, or are all equal for another reason than one draw that is repeated.

    Equal reads hold no draw if a larger standard deviation does not change them, if they are off by the same number of standard
    deviations on every axis, or if all `NoisyIMU`s begin with the same read and have no default bias.
    """
    if counts(facts) or (facts.still and _is_reseeded(facts) and len(none_drawn(facts)) == len(BOTH)):
        return True
    bound = TRUTH_ATOL / min(s.reads.std for s in facts.sensors)
    beside = [
        np.array([(s.reads.offset - given * s.reads.bias) / s.reads.std for s in facts.sensors]) for given in (0, 1)
    ]
    unmoved = all(s.twins.seeded and same(s.twins.scaled, s.twins.base, TRUTH_ATOL) for s in facts.sensors)
    return facts.still and (unmoved or any(bool(np.ptp(each) <= bound) for each in beside))


def counts(facts: Facts) -> bool:
    """Return whether reads change, but rarely or predictably (a counter); False if all are equal or either sensor has noise."""
    return facts.noiseless and not all(sensor.reads.still for sensor in facts.sensors)


def _repeated(facts: Facts) -> str:
    """Return the fault of noise that repeats one draw: "reseeded" (the same in all instances) or "frozen-noise"; "" for none."""
    if not (facts.follows and facts.still) or no_draw(facts):
        return ""
    return "reseeded" if _is_reseeded(facts) else "frozen-noise"


def _is_reseeded(facts: Facts) -> bool:
    """Return whether the first reads of two instances are equal, as where each instance sets the same seed."""
    firsts = [(s.reads.residual[0, 0] + s.reads.truth[0], s.twins.base[0]) for s in facts.sensors]
    return all(same(one, other, EXACT) for one, other in firsts)


_SPREADS: Mapping[str, Callable[[Reads, Reads, float], Sequence[float]]] = {
    "stds-swapped": lambda _, other, dt: [other.std],
    "variance-as-std": lambda reads, _, dt: [reads.std**2, reads.std**0.5],
    "noise-density": lambda reads, _, dt: [reads.std * dt**0.5, reads.std / dt**0.5],
}
"""Standard deviations that a fault predicts, from a sensor's reads, the other sensor's reads and the time step in seconds."""


def _spread_is(fault: str) -> Callable[..., bool]:
    """Return a test of whether a fault predicts the size of the noise of some sensors, without any of those with a wrong size."""

    def fits(facts: Facts, sensors: Iterable[int] | None = None) -> bool:
        off = sizes_off(facts) if sensors is None else sensors
        pairs = [(facts.sensors[i].noise, facts.sensors[1 - i].noise) for i in off]
        predicted = [(reads, _SPREADS[fault](reads, other, facts.timestep)) for reads, other in pairs]
        return all(any(abs(r.pooled_spread / s - 1) < _NEAR for s in spreads) for r, spreads in predicted)

    return fits


# ---- a bias that is given


@dataclass(frozen=True)
class Offset:
    """Hypothesis on a wrong bias: a fault, and the mean error (reading minus truth) of a sensor's reads that it predicts.

    Attributes
    ----------
    cost : how unlikely the fault is; the cheapest that fits is reported
    cause : the id of the fault
    predict : function of a sensor's reads and the other sensor's reads; returns the mean errors that the fault may cause
    together : whether the fault always affects both sensors
    """

    cost: int
    cause: str
    predict: Callable[[Reads, Reads], Iterable[Array]]
    together: bool = False

    def fits(self, seen: Sequence[tuple[Reads, Reads]], /) -> bool:
        """Return whether the fault predicts the mean error in each pair of `seen`: a wrong sensor's reads, and the other's.

        A fault that always affects both sensors needs two pairs.
        """
        enough = len(seen) == len(BOTH) or not self.together
        return enough and all(any(map(reads.offset_is, self.predict(reads, other))) for reads, other in seen)


def _middle(values: Array) -> Array:
    """Return the middle between the smallest and the largest value of each column, as one constant in place of them all."""
    return np.asarray((values.min(axis=0) + values.max(axis=0)) / 2)


OFFSETS = (
    Offset(1, "no-bias", lambda reads, _: [np.zeros(3)]),
    Offset(2, "bias-sign-flipped", lambda reads, _: [-reads.bias]),
    Offset(
        3,
        "stale-clean-reading",
        lambda reads, _: [reads.truth[0] - reads.truth + sign * reads.bias for sign in (1, 0, -1)],
    ),
    Offset(4, "swapped-sensors", lambda reads, other: [other.truth - reads.truth + reads.bias], together=True),
    Offset(5, "biases-exchanged", lambda _, other: [other.bias], together=True),
    Offset(6, "bias-axes-exchanged", lambda reads, _: list(map(np.array, itertools.permutations(reads.bias)))),
    Offset(7, "bias-shared", lambda reads, other: [other.bias, np.full(3, reads.bias[0])]),
    Offset(8, "noise-not-zero-mean", lambda reads, _: [reads.bias + _middle((reads.offset - reads.bias).ravel())]),
    Offset(10, "bias-argument-ignored", lambda reads, _: [_middle(reads.offset)]),
)
_UNUSED = ("no-bias", "bias-argument-ignored")


def offset_fault(facts: Facts) -> str:
    """Return the id of the cheapest fault in `OFFSETS` that predicts the wrong mean (offset) of each sensor that has one.

    "" if no sensor's mean is wrong, or if no fault, or several of one cost, predict it.
    """
    reads = [sensor.reads for sensor in facts.sensors]
    wrong = [(reads[i], reads[1 - i]) for i in BOTH if not reads[i].bias_is_right]
    used = any(s.twins.seeded and not s.twins.ignores_bias() for s in facts.sensors)
    known = [each for each in OFFSETS if not (used and each.cause in _UNUSED)]
    found = hypothesis.explain(known, wrong) if wrong else None
    return found.cause if found else ""


def _off(facts: Facts) -> list[int]:
    return sensors_that(facts, lambda s: not s.reads.bias_is_right)


def _is_added(sensor: Sensor) -> bool:
    """Return whether a change of the given bias changes each reading by as much; of a bias that drifts, only the first reading."""
    twins = sensor.twins
    return twins.begins_with_bias() if sensor.drifts else twins.adds_bias()


def _is_rounded_off(facts: Facts) -> bool:
    """Return whether rounding alone explains each wrong mean: it is off by at most half a step. False if no mean is wrong."""
    off = [facts.sensors[i].reads for i in _off(facts)]
    return bool(off) and all(r.step > 0 and np.abs(r.offset - r.bias).max() <= r.step / 2 + r.mean_bound for r in off)


def missing_bias(facts: Facts) -> list[int]:
    """Return the sensors (0, 1) with a wrong mean, unless seeded reads show the given bias added; both if readings are swapped."""
    exchanged = offset_fault(facts) == "swapped-sensors"
    return [i for i in _off(facts) if exchanged or not _is_added(facts.sensors[i])]


def bias_beside(facts: Facts) -> list[int]:
    """Return the sensors (0, 1) whose readings have a bias of their own although a bias of zero was given."""
    return sensors_that(facts, _has_another)


def _has_another(sensor: Sensor) -> bool:
    """Return whether an instance without noise and with zero bias has an offset that the noisy one lacks beside its given bias."""
    reads, silent = sensor.reads, sensor.silent
    apart = np.abs(silent.offset - (reads.offset - reads.bias)).max() > 2 * reads.mean_bound
    nearest = reads.step / 2  # of a rounded reading; a step that hides more loses the size and the given bias itself
    return bool(silent.still and np.abs(silent.offset).max() > TRUTH_ATOL + nearest and apart)


# ---- a bias that is drawn


def drifts(facts: Facts) -> list[int]:
    return sensors_that(facts, lambda s: s.drifts)


def moves(facts: Facts) -> list[int]:
    """Return the sensors (0, 1) whose default bias, drawn as none was given, differs between the reads of one `NoisyIMU`."""
    return sensors_that(facts, lambda s: np.ptp(s.default, axis=1).max() > EXACT * max(1.0, np.abs(s.default).max()))


def hidden(facts: Facts) -> list[int]:
    """Return the sensors (0 accelerometer, 1 gyroscope) whose default bias no measurement shows: reads with one seed differ."""
    return sensors_that(facts, lambda s: bool(np.isnan(s.default).any()))


def none_drawn(facts: Facts) -> list[int]:
    return sensors_that(facts, lambda s: np.abs(s.means).max() <= TRUTH_ATOL)


def one_for_all_instances(facts: Facts) -> list[int]:
    return sensors_that(facts, lambda s: s.has_default and np.ptp(s.means[1:], axis=0).max() <= EXACT)


def one_for_all_axes(facts: Facts) -> list[int]:
    return sensors_that(facts, lambda s: s.has_default and np.ptp(s.means, axis=1).max() <= TRUTH_ATOL)


def one_for_both_sensors(facts: Facts) -> list[int]:
    accel, gyro = (sensor.means[1:] for sensor in facts.sensors)
    both = all(sensor.has_default for sensor in facts.sensors)
    return [*BOTH] if both and np.ptp(gyro / accel) <= 1e-3 * np.abs(gyro / accel).max() else []


DEFAULTS = (drifts, hidden, moves, none_drawn, one_for_all_instances, one_for_all_axes, one_for_both_sensors)
"""Functions that return the sensors with a fault of the default bias. Earlier faults may cause later ones; the first counts."""


def _moving(holds: Callable[[Array], bool]) -> Holds:
    """Return a test of the default biases (instances, reads, 3) of the first sensor where they move; False if none moves."""
    return lambda facts: bool(moves(facts)) and holds(facts.sensors[moves(facts)[0]].default)


_gone_after_one_read = _moving(lambda bias: bool(np.abs(bias[:, 1:]).max() <= TRUTH_ATOL))


def _one_for_every_bias(facts: Facts) -> bool:
    """Return whether zero or one constant replaces given and drawn biases alike: one fault, deducted by `given_bias` alone."""
    constant = {*one_for_all_instances(facts), *none_drawn(facts)}
    known = [(s.reads, s.means[1]) for s in (facts.sensors[i] for i in constant & {*missing_bias(facts)})]
    given_too = [np.abs(reads.offset - mean).max() <= 2 * reads.mean_bound for reads, mean in known]
    return bool(constant) and not facts.noiseless and sum(given_too) == len(constant)


def _never_random(facts: Facts) -> bool:
    """Return whether all instances have the same bias, or none, unless that comes from a fault of the noise or of given biases."""
    constant = none_drawn(facts) or (one_for_all_instances(facts) and not _repeated(facts))
    return bool(constant) and not _one_for_every_bias(facts)


def _is_shared(facts: Facts) -> bool:
    return bool(one_for_all_axes(facts) or one_for_both_sensors(facts)) and not _one_for_every_bias(facts)


# ---- the law of the noise, and what goes together


def odd_laws(facts: Facts) -> list[int]:
    """Return the sensors (0, 1) with noise not white and normal, else `off_centre`, else both if one rounds or neither is noisy."""
    odd = sensors_that(facts, lambda s: s.law_is_off) or off_centre(facts)
    return odd or ([*BOTH] if grain(facts) or facts.noiseless else [])


def off_centre(facts: Facts) -> list[int]:
    """Return the sensors (0, 1) whose mean is wrong although the given bias is added, such as by noise of non-zero mean.

    A sensor without noise is left out: swapped arguments, as in `normal(std, 0, 3)`, add a constant, which another check deducts.
    """
    off = sensors_that(facts, lambda s: s.noise.is_noise and not (s.reads.bias_is_right or s.reads.is_centred))
    if not off or drifts(facts) or not all(_is_added(facts.sensors[i]) for i in off):
        return []
    return [] if offset_fault(facts) == "swapped-sensors" or _has_another(facts.sensors[off[0]]) else off


def _any(holds: Callable[[Reads], bool]) -> Holds:
    return lambda facts: any(holds(sensor.noise) for sensor in facts.sensors)


def columns(facts: Facts) -> Array:
    """Return the noise of all six channels (reads, 6) in units of their standard deviations, to test if one depends on another.

    Noise that changes slowly is replaced by the differences of neighbouring reads: slow channels correlate by chance.
    """
    slow = any(s.drifts or s.accumulates or s.noise.memory for s in facts.sensors)
    return np.concatenate([(s.reads.paired if slow else s.reads).standardised for s in facts.sensors], axis=1)


def most_correlated(values: Array) -> tuple[float, int, int]:
    """Return the largest absolute correlation of two of six columns, and their indices; of pairs equal to two digits, the first."""
    matrix = st.correlations(values)
    pairs = [(abs(float(matrix[i, j])), i, j) for i, j in itertools.combinations(range(6), 2)]
    return max(pairs, key=lambda pair: round(pair[0], 2))


def _one_for_axes(facts: Facts) -> bool:
    values = columns(facts)
    first = 3 * (most_correlated(values)[1] // 3)
    return bool(st.correlations(values)[first : first + 3, first : first + 3].min() > _THE_SAME)


# ---- the reasons


def _is_loud_beside(facts: Facts) -> bool:
    """Return whether noise beside a bias that is redrawn at each read has a wrong size; False if no seed makes that measurable."""
    twins = [(s.twins.noise_size(), s.reads.std) for s in facts.sensors if s.twins.seeded]
    return any(abs(size / std - 1) > ROUGHLY for size, std in twins)


_REPEATED = ("frozen-noise", "reseeded")
REASONS: tuple[Reason[Facts], ...] = (
    Reason(SIZE, 0, "reads-no-sensor", lambda f: not f.follows),
    Reason(SIZE, 1, "one-sensor-twice", lambda f: f.one_twice and len(sizes_off(f)) == 1),
    Reason(SIZE, 2, "bias-redrawn", lambda f: f.redrawn and not _is_loud_beside(f)),
    Reason(SIZE, 2, f"noise_model.{SIZE}", lambda f: f.redrawn and _is_loud_beside(f)),
    Reason(SIZE, 2, "precision-lost", lambda f: f.noiseless and _lost_in_rounding(f)),
    Reason(SIZE, 3, "no-noise", no_draw),
    *(Reason(SIZE, 4, fault, _diagnosed_by(_repeated, fault)) for fault in _REPEATED),
    Reason(SIZE, 5, "precision-lost", _lost_in_rounding),
    Reason(SIZE, 6, "gyro-not-noisy", lambda f: any(not s.noise.is_noise for s in f.sensors)),
    Reason(SIZE, 7, "multiplicative-noise", _any(lambda reads: reads.proportional)),
    Reason(SIZE, 8, "std-ignored", lambda f: any(s.silent.restless and not s.drifts for s in f.sensors)),
    *(Reason(SIZE, 9, fault, _spread_is(fault)) for fault in _SPREADS),
    # No fault of the law or of a bias gives normal noise another size.
    Reason(SIZE, 10, f"noise_model.{SIZE}", lambda f: not any(f.sensors[i].law_is_off for i in sizes_off(f))),
    Reason(GIVEN, 0, "swapped-sensors", lambda f: f.exchanged),
    Reason(GIVEN, 0, "one-sensor-twice", lambda f: f.one_twice and not f.exchanged),
    Reason(GIVEN, 0, "bias-drifts", lambda f: bool(missing_bias(f)) and _gone_after_one_read(f)),
    Reason(GIVEN, 1, "precision-lost", _is_rounded_off),
    Reason(GIVEN, 1, "bias-argument-ignored", lambda f: f.redrawn and bool(missing_bias(f))),
    *(Reason(GIVEN, 1 + each.cost, each.cause, _diagnosed_by(offset_fault, each.cause)) for each in OFFSETS),
    Reason(GIVEN, 12, "another-bias-beside", lambda f: bool(_off(f) and bias_beside(f))),
    Reason(GIVEN, 12, "bias-argument-ignored", lambda f: not _off(f)),
    Reason(DEFAULT, 0, f"noise_model.{DEFAULT}", lambda f: bool(hidden(f))),
    Reason(DEFAULT, 1, "bias-drifts", lambda f: bool(drifts(f)) or _gone_after_one_read(f)),
    Reason(DEFAULT, 3, "bias-shared", _moving(lambda bias: np.ptp(bias[:, 1:], axis=(0, 1)).max() <= EXACT)),
    Reason(DEFAULT, 5, "bias-redrawn", _moving(lambda bias: np.median(np.ptp(bias, axis=1).max(axis=1)) > EXACT)),
    Reason(DEFAULT, 7, "bias-not-random", _never_random),
    Reason(DEFAULT, 11, "bias-shared", _is_shared),
    *(Reason(LAW, 0, fault, _diagnosed_by(_repeated, fault)) for fault in _REPEATED),
    Reason(LAW, 1, "precision-lost", lambda f: grain(f) > 0),
    Reason(LAW, 2, "noise-accumulates", lambda f: any(sensor.accumulates for sensor in f.sensors)),
    Reason(LAW, 3, "noise-correlated", _any(lambda reads: reads.memory > 0)),
    Reason(LAW, 4, "noise-not-zero-mean", _any(lambda reads: reads.one_signed)),
    Reason(LAW, 5, "noise-clipped", _any(lambda reads: reads.clipped)),
    Reason(LAW, 8, "not-gaussian", _any(lambda reads: not reads.is_normal)),
    Reason(LAW, 9, "noise-not-zero-mean", _diagnosed_by(offset_fault, "noise-not-zero-mean")),
    Reason(LAW, 9, "stale-clean-reading", _diagnosed_by(offset_fault, "stale-clean-reading"), beside=True),
    Reason(APART, 0, "one-sensor-twice", lambda f: f.one_twice),
    Reason(APART, 1, "same-noise-on-axes", _one_for_axes),
    Reason(ALONE, 1, "mutates-sensordata", lambda f: not changed(f.disturbance)[:3].any()),
    Reason(ALONE, 2, "disturbs-simulation", lambda f: bool(changed(f.disturbance)[:3].any())),
    Reason("form", 1, "wrong-return-type", lambda _: True),
    *CALL_REASONS,
)


def _form(facts: Facts) -> Deviation[Form] | None:
    return Deviation({"form": FORM, "came": facts.odd}) if facts.odd else None


OTHERS: Mapping[str, Measure[Facts]] = {"form": _form, **departures("NoisyIMU", lambda facts: facts.departs)}
JUDGE: Judge[Facts] = Judge(LAB, "noise_model", measure, REASONS, OTHERS)
