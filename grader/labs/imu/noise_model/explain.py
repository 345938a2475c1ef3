"""Hypotheses on the faults of a noise model: the size of the noise, its law, and the biases.

A fault of the size or of a bias is a number that it predicts for a sensor, beside the other sensor: the spread of its reads, or the
mean. It explains the readings if it predicts every sensor that is wrong.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from grader.engine import hypothesis
from grader.engine.charging import Part
from grader.engine.findings import Deviation
from grader.engine.hypothesis import Reason
from grader.labs.imu import statistics as st
from grader.labs.imu.compare import Array, same
from grader.labs.imu.lab import LAB
from grader.labs.imu.noise_model.measure import ALL, FORM, Facts, Sensor, measure
from grader.labs.imu.noise_model.reads import EXACT, TRUTH_ATOL, Reads
from grader.labs.imu.parameters import departure, reads_global

SIZE, GIVEN, DEFAULT, LAW, APART = ALL
ALONE = "leaves_simulation_alone"
BOTH = (0, 1)
NO_CHANGE = 1e-12
"""Largest change of the simulation's data by a read, in its own units. Nothing has to change at all."""
_ROUGHLY = 0.3
"""Share by which noise beside a drift may be off: 117 differences of two instances tell its size to a tenth."""
_NEAR = 0.07
"""Of a predicted spread: how far one may be off that is told from the next prediction, a tenth away."""
_THE_SAME = 0.99
"""Least correlation of two channels that have one noise. A tenth of other noise leaves 0.995 of it, half leaves 0.8."""

Holds = Callable[[Facts], bool]


def which(facts: Facts, holds: Callable[[Sensor], bool]) -> list[int]:
    """Return the numbers of the sensors for which something holds."""
    return [i for i in BOTH if holds(facts.sensors[i])]


def _is(find: Callable[[Facts], str], told: str) -> Holds:
    """Return a test whether this fault is what explains the facts."""
    return lambda facts: find(facts) == told


# ---- the size of the noise


def sizes_off(facts: Facts) -> list[int]:
    """Return the sensors whose noise has another size than the one that was asked for, whatever its law is."""
    return which(facts, lambda sensor: not _has_size(sensor))


def _has_size(sensor: Sensor) -> bool:
    """Return whether the noise has the size, also beside a drift; or goes with it and only has another law."""
    noise, twins = sensor.noise, sensor.twins
    if noise.size_is_right:
        return True
    if sensor.drifts:
        return not twins.seeded or abs(twins.noise_size() / noise.std - 1) < _ROUGHLY
    return sensor.law_is_off and (twins.scales() or not twins.seeded)


def no_draw(facts: Facts) -> bool:
    """Return whether all reads are equal and hold no draw: more noise changes nothing, or a multiple of what was asked is added."""
    beside = np.array([(s.reads.offset - s.reads.bias) / s.reads.std for s in facts.sensors])
    same_for_all = np.ptp(beside) <= TRUTH_ATOL / min(s.reads.std for s in facts.sensors)
    unmoved = all(s.twins.seeded and same(s.twins.scaled, s.twins.base, TRUTH_ATOL) for s in facts.sensors)
    return facts.still and bool(same_for_all or unmoved)


def _repeated(facts: Facts) -> str:
    """Return which fault repeats one draw: the same in all instances, or each instance's own; "" where none is repeated."""
    if not (facts.follows and facts.still) or no_draw(facts):
        return ""
    firsts = [(s.reads.residual[0, 0] + s.reads.truth[0], s.twins.base[0]) for s in facts.sensors]
    return "reseeded" if all(same(one, other, EXACT) for one, other in firsts) else "frozen-noise"


_SPREADS: Mapping[str, Callable[[Reads, Reads, float], Sequence[float]]] = {
    "stds-swapped": lambda _, other, dt: [other.std],
    "variance-as-std": lambda reads, _, dt: [reads.std**2, reads.std**0.5],
    "noise-density": lambda reads, _, dt: [reads.std * dt**0.5, reads.std / dt**0.5],
}
"""The spreads that a fault predicts for a sensor, beside the other one, at this time step in seconds."""


def _spread_is(told: str) -> Holds:
    """Return a test whether a fault predicts the spread of each sensor whose noise has another size."""

    def fits(facts: Facts) -> bool:
        pairs = [(facts.sensors[i].noise, facts.sensors[1 - i].noise) for i in sizes_off(facts)]
        predicted = [(reads, _SPREADS[told](reads, other, facts.timestep)) for reads, other in pairs]
        return all(any(abs(r.pooled_spread / s - 1) < _NEAR for s in spreads) for r, spreads in predicted)

    return fits


# ---- a bias that is given


@dataclass(frozen=True)
class Offset:
    """A fault of the bias: means of a sensor's readings less the truth that it predicts, beside the other sensor.

    Attributes
    ----------
    together : whether it is a fault of both sensors at once
    """

    cost: int
    told: str
    predict: Callable[[Reads, Reads], Iterable[Array]]
    together: bool = False

    def fits(self, seen: Sequence[tuple[Reads, Reads]], /) -> bool:
        """Return whether it predicts each sensor of these pairs of one that is off and the other one."""
        enough = len(seen) == len(BOTH) or not self.together
        return enough and all(any(map(reads.offset_is, self.predict(reads, other))) for reads, other in seen)


def _middle(values: Array) -> Array:
    """Return the middle between the least and the most of each column."""
    return np.asarray((values.min(axis=0) + values.max(axis=0)) / 2)


OFFSETS = (
    Offset(1, "no-bias", lambda reads, _: [np.zeros(3)]),
    Offset(2, "bias-sign-flipped", lambda reads, _: [-reads.bias]),
    Offset(3, "stale-clean-reading", lambda reads, _: [reads.truth[0] + reads.bias - reads.truth]),
    Offset(4, "swapped-sensors", lambda reads, other: [other.truth - reads.truth + reads.bias], together=True),
    Offset(5, "biases-exchanged", lambda _, other: [other.bias], together=True),
    Offset(6, "bias-axes-exchanged", lambda reads, _: list(map(np.array, itertools.permutations(reads.bias)))),
    Offset(7, "bias-shared", lambda reads, other: [other.bias, np.full(3, reads.bias[0])]),
    Offset(8, "noise-not-zero-mean", lambda reads, _: [reads.bias + _middle((reads.offset - reads.bias).ravel())]),
    Offset(10, "bias-argument-ignored", lambda reads, _: [_middle(reads.offset)]),
)
_UNUSED = ("no-bias", "bias-argument-ignored")


def offset_fault(facts: Facts) -> str:
    """Return the cheapest fault that predicts the mean of each sensor whose mean is not the given bias; "" if none does."""
    reads = [sensor.reads for sensor in facts.sensors]
    wrong = [(reads[i], reads[1 - i]) for i in BOTH if not reads[i].bias_is_right]
    used = any(s.twins.seeded and not s.twins.ignores_bias() for s in facts.sensors)
    known = [each for each in OFFSETS if not (used and each.told in _UNUSED)]
    found = hypothesis.explain(known, wrong) if wrong else None
    return found.told if found else ""


def _off(facts: Facts) -> list[int]:
    return which(facts, lambda s: not s.reads.bias_is_right)


def _is_added(sensor: Sensor) -> bool:
    """Return whether another bias changes the readings by just that, whatever else is in them."""
    twins = sensor.twins
    return twins.begins_with_bias() if sensor.drifts else twins.adds_bias(sensor.reads.grain)


def missing_bias(facts: Facts) -> list[int]:
    """Return the sensors whose readings do not have the bias that was given."""
    exchanged = offset_fault(facts) == "swapped-sensors"
    return [i for i in _off(facts) if exchanged or not _is_added(facts.sensors[i])]


def bias_beside(facts: Facts) -> list[int]:
    """Return the sensors with another bias beside the given one, or in the place of one of zero."""
    return which(facts, _has_another)


def _has_another(sensor: Sensor) -> bool:
    """Return whether an instance that is asked for no noise and no bias has an offset, and another one than the noisy instance."""
    reads, silent = sensor.reads, sensor.silent
    apart = np.abs(silent.offset - (reads.offset - reads.bias)).max() > 2 * reads.mean_bound
    return bool(silent.still and np.abs(silent.offset).max() > TRUTH_ATOL + reads.grain / 2 and apart)


# ---- a bias that is drawn


def _shows_default(facts: Facts) -> bool:
    """Return whether reads without noise are equal, or differ by the bias alone, so that they tell a default bias."""
    return facts.redrawn or all(s.obeys_zero for s in facts.sensors)


def drifts(facts: Facts) -> list[int]:
    return which(facts, lambda s: s.drifts)


def moves(facts: Facts) -> list[int]:
    """Return the sensors whose default bias differs from read to read in one instance."""
    moved = which(facts, lambda s: np.ptp(s.default, axis=1).max() > EXACT * max(1.0, np.abs(s.default).max()))
    return moved if _shows_default(facts) else []


def none_drawn(facts: Facts) -> list[int]:
    return which(facts, lambda s: np.abs(s.means).max() <= TRUTH_ATOL)


def one_for_all_instances(facts: Facts) -> list[int]:
    same = which(facts, lambda s: s.has_default and np.ptp(s.means[1:], axis=0).max() <= EXACT)
    return same if _shows_default(facts) else []


def one_for_all_axes(facts: Facts) -> list[int]:
    return which(facts, lambda s: s.has_default and np.ptp(s.means, axis=1).max() <= TRUTH_ATOL)


def one_for_both_sensors(facts: Facts) -> list[int]:
    accel, gyro = (sensor.means for sensor in facts.sensors)
    both = all(sensor.has_default for sensor in facts.sensors)
    return [*BOTH] if both and np.ptp(gyro / accel) <= 1e-3 * np.abs(gyro / accel).max() else []


DEFAULTS = (drifts, moves, none_drawn, one_for_all_instances, one_for_all_axes, one_for_both_sensors)
"""Faults of default biases, each as a function that returns the sensors that have it; later ones may follow from earlier ones."""


def _moving(holds: Callable[[Array], bool]) -> Holds:
    """Return a test of the default bias (instances, reads, 3) of the first sensor whose bias moves."""
    return lambda facts: bool(moves(facts)) and holds(facts.sensors[moves(facts)[0]].default)


_gone_after_one_read = _moving(lambda bias: bool(np.abs(bias[:, 1:]).max() <= TRUTH_ATOL))


def _one_for_every_bias(facts: Facts) -> bool:
    """Return whether none, or a constant, replaces each bias, given or drawn: one fault, which given_bias charges."""
    constant = {*one_for_all_instances(facts), *none_drawn(facts)}
    known = [(s.reads, s.means[1]) for s in (facts.sensors[i] for i in constant & {*missing_bias(facts)})]
    given_too = [np.abs(reads.offset - mean).max() <= 2 * reads.mean_bound for reads, mean in known]
    return bool(constant) and not facts.still and sum(given_too) == len(constant)


def _never_random(facts: Facts) -> bool:
    """Return whether instances have one bias, or none, by a fault that is not charged as one of the noise or of given biases."""
    constant = none_drawn(facts) or (one_for_all_instances(facts) and not _repeated(facts))
    return bool(constant) and not _one_for_every_bias(facts)


def _is_shared(facts: Facts) -> bool:
    return bool(one_for_all_axes(facts) or one_for_both_sensors(facts)) and not _one_for_every_bias(facts)


# ---- the law of the noise, and what goes together


def odd_laws(facts: Facts) -> list[int]:
    """Return the sensors whose noise is not white and normal with zero mean; both where there is no noise, or it is rounded."""
    odd = which(facts, lambda s: s.law_is_off) or off_centre(facts)
    coarse = any(sensor.reads.grain for sensor in facts.sensors)
    return odd or ([*BOTH] if coarse or facts.still else [])


def off_centre(facts: Facts) -> list[int]:
    """Return the sensors whose readings are off on average by something else than the bias, which is added."""
    off = [facts.sensors[i] for i in _off(facts)]
    if not off or drifts(facts) or not all(map(_is_added, off)):
        return []
    return [] if offset_fault(facts) == "swapped-sensors" or _has_another(off[0]) else _off(facts)


def _any(holds: Callable[[Reads], bool]) -> Holds:
    return lambda facts: any(holds(sensor.noise) for sensor in facts.sensors)


def columns(facts: Facts) -> Array:
    """(reads, 6) what is new in each read, in units of its own spread; what is slow looks alike by chance."""
    slow = any(s.drifts or s.accumulates or s.noise.memory for s in facts.sensors)
    return np.concatenate([(s.reads.paired if slow else s.reads).standardised for s in facts.sensors], axis=1)


def most_correlated(values: Array) -> tuple[float, int, int]:
    """Return the largest correlation of two of six channels, to the two digits that are told, and which two they are."""
    matrix = st.correlations(values)
    pairs = [(abs(float(matrix[i, j])), i, j) for i, j in itertools.combinations(range(6), 2)]
    return max(pairs, key=lambda pair: round(pair[0], 2))


def _one_for_axes(facts: Facts) -> bool:
    values = columns(facts)
    first = 3 * (most_correlated(values)[1] // 3)
    return bool(st.correlations(values)[first : first + 3, first : first + 3].min() > _THE_SAME)


def changed(facts: Facts) -> Array:
    """Return a mask of time, qpos, qvel and sensordata: which of them a read changes."""
    return np.asarray(~(facts.disturbance <= NO_CHANGE))


# ---- the reasons


_WITH_DEFAULT = frozenset({DEFAULT})
_REPEATED = ("frozen-noise", "reseeded")
REASONS: tuple[Reason[Facts], ...] = (
    Reason(SIZE, 0, "reads-no-sensor", lambda f: not f.follows),
    Reason(SIZE, 1, "one-sensor-twice", lambda f: f.one_twice),
    Reason(SIZE, 2, "bias-redrawn", lambda f: f.redrawn),
    Reason(SIZE, 3, "no-noise", no_draw),
    *(Reason(SIZE, 4, told, _is(_repeated, told), frozenset({DEFAULT, APART})) for told in _REPEATED),
    Reason(SIZE, 6, "gyro-not-noisy", lambda f: any(s.noise.still for s in f.sensors)),
    Reason(SIZE, 7, "multiplicative-noise", _any(lambda reads: reads.proportional)),
    Reason(SIZE, 8, "std-ignored", lambda f: any(s.silent.restless and not s.drifts for s in f.sensors)),
    *(Reason(SIZE, 9, told, _spread_is(told)) for told in _SPREADS),
    Reason(GIVEN, 0, "swapped-sensors", lambda f: f.exchanged),
    Reason(GIVEN, 0, "one-sensor-twice", lambda f: f.one_twice and not f.exchanged, _WITH_DEFAULT),
    Reason(GIVEN, 0, "bias-drifts", lambda f: bool(missing_bias(f)) and _gone_after_one_read(f)),
    Reason(GIVEN, 1, "bias-redrawn", lambda f: f.redrawn and bool(missing_bias(f))),
    *(Reason(GIVEN, 1 + each.cost, each.told, _is(offset_fault, each.told), _WITH_DEFAULT) for each in OFFSETS),
    Reason(GIVEN, 12, "another-bias-beside", lambda f: bool(_off(f) and bias_beside(f)), _WITH_DEFAULT),
    Reason(GIVEN, 12, "bias-argument-ignored", lambda f: not _off(f)),
    Reason(GIVEN, 99, f"noise_model.{GIVEN}", lambda _: True, _WITH_DEFAULT),
    Reason(DEFAULT, 1, "bias-drifts", lambda f: bool(drifts(f)) or _gone_after_one_read(f)),
    Reason(DEFAULT, 3, "bias-shared", _moving(lambda bias: np.ptp(bias[:, 1:], axis=(0, 1)).max() <= EXACT)),
    Reason(DEFAULT, 5, "bias-redrawn", _moving(lambda bias: np.median(np.ptp(bias, axis=1).max(axis=1)) > EXACT)),
    Reason(DEFAULT, 7, "bias-not-random", _never_random),
    Reason(DEFAULT, 11, "bias-shared", _is_shared),
    *(Reason(LAW, 0, told, _is(_repeated, told)) for told in _REPEATED),
    Reason(LAW, 1, "precision-lost", lambda f: any(sensor.reads.grain for sensor in f.sensors)),
    Reason(LAW, 2, "noise-accumulates", lambda f: any(sensor.accumulates for sensor in f.sensors)),
    Reason(LAW, 3, "noise-correlated", _any(lambda reads: reads.memory > 0)),
    Reason(LAW, 4, "noise-not-zero-mean", _any(lambda reads: reads.one_signed)),
    Reason(LAW, 5, "noise-clipped", _any(lambda reads: reads.clipped)),
    Reason(
        LAW, 8, "not-gaussian", _any(lambda reads: not reads.is_normal), frozenset({APART})
    ),  # far values look alike
    *(Reason(LAW, 9, told, _is(offset_fault, told)) for told in ("noise-not-zero-mean", "stale-clean-reading")),
    Reason(LAW, 99, f"noise_model.{LAW}", lambda _: True),
    Reason(APART, 0, "one-sensor-twice", lambda f: f.one_twice),
    Reason(APART, 1, "same-noise-on-axes", _one_for_axes),
    Reason(ALONE, 1, "mutates-sensordata", lambda f: not changed(f)[:3].any()),
    Reason(ALONE, 2, "disturbs-simulation", lambda f: bool(changed(f)[:3].any())),
    Reason("form", 1, "wrong-return-type", lambda _: True),
    Reason("parameters", 1, "global-for-parameter", lambda f: reads_global(f.departs)),
    Reason("parameters", 2, "other-parameters", lambda _: True),
)


PART: Part[Facts] = Part(
    LAB,
    "noise_model",
    measure,
    REASONS,
    {
        "form": lambda facts: Deviation({"form": FORM, "came": facts.odd}) if facts.odd else None,
        "parameters": lambda facts: departure("NoisyIMU", facts.departs),
    },
)
