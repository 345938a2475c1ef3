"""Hypotheses on the faults of a noise model: size of the noise, its distribution, and the biases."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np

from grader.engine.charging import Part
from grader.engine.findings import Deviation
from grader.engine.hypothesis import Named, Reason
from grader.labs.imu import statistics as st
from grader.labs.imu.compare import Array, same
from grader.labs.imu.diagnosis import noise as diagnosis
from grader.labs.imu.diagnosis import noise_laws as laws
from grader.labs.imu.diagnosis.noise import Facts as Reads
from grader.labs.imu.lab import LAB
from grader.labs.imu.noise_model.measure import ALL, Facts, measure
from grader.labs.imu.parameters import departure, reads_global

FORM = "a tuple of two arrays of shape (3,) from read()"
SIZE, GIVEN, DEFAULT, LAW, APART = ALL
ALONE = "leaves_simulation_alone"
BOTH = (0, 1)
NO_CHANGE = 1e-12
"""Largest change of the simulation's data by a read, in its own units. Nothing has to change at all."""
_ROUGHLY = 0.3
"""600 noise-free values tell their spread to 3 %; the rest is for the shape of the law that the biases are drawn from."""
_THE_SAME = 0.99
"""Least correlation of two channels that have one noise. A tenth of other noise leaves 0.995 of it, half leaves 0.8."""
_SHEETS_BIASES, TOO_LARGE = (0.1, 0.01), 20.0
"""m/s², rad/s: the standard deviations of the sheet's default biases; no sensor's are so many times as large."""


# ---- the size of the noise


def sizes_off(facts: Facts) -> list[int]:
    """The sensors whose noise has another size than the one that was asked for, whatever its law is."""
    wrong = [i for i in BOTH if not _size_is_right(facts, i)]
    return [] if wrong and _law_explains(facts, wrong) else wrong


def _size_is_right(facts: Facts, which: int) -> bool:
    reads, twins = facts.steady[which], facts.twins[which] if facts.twins else None
    if _has_size(reads):
        return True
    if laws.correlated(reads) and (
        (twins and twins.scales()) or diagnosis.size_is_right(reads, laws.innovation(reads))
    ):
        return True
    return bool(facts.drifting[which] and twins and abs(twins.noise_size() / reads.std - 1) < _ROUGHLY)


def _has_size(reads: Reads) -> bool:
    """Return whether noise of this law has the size, also where it adds up, has one sign, is cut off or is uniform."""
    if diagnosis.accumulates(reads):
        return diagnosis.size_is_right(reads, float(np.sqrt(np.mean(reads.increments**2))))
    if diagnosis.one_signed(reads):  # |normal| has the root mean square that was asked for, an exponential law the mean
        beside = np.abs(reads.residual - reads.bias)
        return any(diagnosis.size_is_right(reads, float(s)) for s in (np.sqrt(np.mean(beside**2)), beside.mean()))
    return laws.clipped(reads) or diagnosis.size_is_right(reads) or diagnosis.half_width_is_std(reads)


def _law_explains(facts: Facts, wrong: Sequence[int]) -> bool:
    """Return whether the noise goes with the size asked for, or has it but for a few reads, and only has another law."""
    reads = [facts.steady[i] for i in wrong]
    if not all(diagnosis.one_signed(each) or not laws.is_normal(each) for each in reads):
        return False
    return all(map(_right_but_for_strays, reads)) or bool(facts.twins and all(facts.twins[i].scales() for i in wrong))


def _right_but_for_strays(reads: Reads) -> bool:
    strays = laws.strays(reads)
    return strays is not None and diagnosis.size_is_right(reads, strays.spread)


def _known_size(named: Named[diagnosis._Sizes]) -> Callable[[Facts], bool]:
    return lambda facts: named.fits(diagnosis._Sizes(facts.steady, facts.again, facts.steady_silent))


def without_draw(facts: Facts) -> bool:
    """Return whether all reads are equal, also with more noise: an offset, not one draw that is repeated."""
    seeded = bool(facts.twins) and all(twins.seeded for twins in facts.twins)
    return facts.still and seeded and all(same(t.scaled, t.base, diagnosis.TRUTH_ATOL) for t in facts.twins)


def _told_size(facts: Facts) -> list[str]:
    return diagnosis.size_mistakes(facts.steady, facts.again, facts.steady_silent)


def _redrawn_explains_size(facts: Facts) -> bool:
    whole = [float(np.hypot(f.std, s.pooled_spread)) for f, s in zip(facts.sensors, facts.silent, strict=True)]
    near = (abs(f.pooled_spread / w - 1) < _ROUGHLY for f, w in zip(facts.steady, whole, strict=True))
    return facts.redrawn and all(near)


# ---- a bias that is given


def bias_is_right(reads: Reads) -> bool:
    """Return whether the given bias is in the readings, as far as noise that adds up or has one sign lets it be seen."""
    if diagnosis.accumulates(reads):
        return bool(np.abs(reads.residual[0, 0] - reads.bias).max() <= 2 * st.Z * reads.std)
    return diagnosis.one_signed(reads) or diagnosis.bias_is_right(reads)


def _off(facts: Facts) -> list[int]:
    exact = without_draw(facts)
    gaps = [float(np.abs(reads.offset - reads.bias).max()) for reads in facts.sensors]
    return [i for i in BOTH if not bias_is_right(facts.sensors[i]) or (exact and gaps[i] > diagnosis.TRUTH_ATOL)]


def _is_added(facts: Facts, which: int) -> bool:
    """Return whether another bias changes the readings by just that, whatever else is in them."""
    if not facts.twins:
        return False
    twins = facts.twins[which]
    return twins.begins_with_bias() if facts.drifting[which] else twins.adds_bias(facts.sensors[which].grain)


def missing_bias(facts: Facts) -> list[int]:
    """The sensors whose readings do not have the bias that was given."""
    exchanged = diagnosis.bias_mistakes(facts.sensors) == ["swapped-sensors"]
    return [i for i in _off(facts) if exchanged or not _is_added(facts, i)]


def bias_beside(facts: Facts) -> list[int]:
    """The sensors with another bias beside the given one: an instance without any is off, and by something else."""
    return [i for i in _off(facts) if not facts.drifting[i] and _has_another(facts.sensors[i], facts.silent[i])]


def _has_another(reads: Reads, silent: Reads) -> bool:
    beside = reads.offset - reads.bias
    apart = np.abs(silent.offset - beside).max() > 2 * diagnosis.mean_bound(reads)
    return bool(silent.still and np.abs(silent.offset).max() > diagnosis.TRUTH_ATOL and apart)


def offset_of_zero(facts: Facts) -> list[int]:
    """The sensors with an offset where the given bias is zero."""
    if _off(facts):
        return []
    exact = [diagnosis.TRUTH_ATOL + reads.grain / 2 for reads in facts.sensors]
    moved = [i for i in BOTH if np.abs(facts.silent[i].offset).max() > exact[i]]
    return moved if any(facts.silent[i].still for i in moved) else []


def _known_bias(named: Named[diagnosis._Biases]) -> Callable[[Facts], bool]:
    def fits(facts: Facts) -> bool:
        pairs = zip(facts.sensors, reversed(facts.sensors), strict=True)
        wrong = [(reads, other) for reads, other in pairs if not diagnosis.bias_is_right(reads)]
        if not wrong or not missing_bias(facts) or facts.redrawn:
            return False
        unused = named.told in ("no-bias", "bias-argument-ignored")
        there = unused and any(not twins.ignores_bias() for twins in facts.twins if twins.seeded)
        return not there and named.fits(diagnosis._Biases(wrong, facts.sensors))

    return fits


def _ids_exchanged(facts: Facts) -> bool:
    """Return whether each sensor has the other's bias and the other's standard deviation."""
    return diagnosis.bias_mistakes(facts.sensors) == ["biases-exchanged"] and _told_size(facts) == ["stds-swapped"]


# ---- a bias that is drawn


def _means(facts: Facts) -> list[Array]:
    """(instances, 3) mean default bias of each sensor; nothing where none could be asked for."""
    return [bias.mean(axis=1) for bias in facts.defaults or ()]


def noisy(facts: Facts) -> bool:
    """Return whether reads without noise differ, so that a default bias cannot be measured from them."""
    still = [reads.still or drifts for reads, drifts in zip(facts.silent, facts.drifting, strict=True)]
    return not all(still) and not facts.redrawn


def drifts(facts: Facts) -> list[int]:
    return [i for i in BOTH if facts.drifting[i]]


def moves(facts: Facts) -> list[int]:
    """The sensors whose default bias differs from read to read in one instance."""
    biases = () if noisy(facts) else facts.defaults or ()
    most = [(np.ptp(b, axis=1).max(), diagnosis.EXACT * max(1.0, np.abs(b).max())) for b in biases]
    return [i for i, (moved, exact) in enumerate(most) if moved > exact]


def _each_moving(holds: Callable[[Array], bool]) -> Callable[[Facts], bool]:
    def fits(facts: Facts) -> bool:
        return bool(facts.defaults and moves(facts)) and holds((facts.defaults or ())[moves(facts)[0]])

    return fits


def _gone_after_one_read(facts: Facts) -> bool:
    return _each_moving(lambda b: bool(np.abs(b[:, 1:]).max() <= diagnosis.TRUTH_ATOL))(facts)


def none_drawn(facts: Facts) -> list[int]:
    none = [bool(np.abs(mean).max() <= diagnosis.TRUTH_ATOL) for mean in _means(facts)]
    return [i for i, without in enumerate(none) if without and not facts.drawn_with_noise[i]]


def one_for_all_instances(facts: Facts) -> list[int]:
    means = [] if noisy(facts) else _means(facts)
    return [i for i, mean in enumerate(means) if np.ptp(mean[1:], axis=0).max() <= diagnosis.EXACT and _some(mean)]


def _none_at_all(facts: Facts) -> bool:
    """Return whether no bias is in the readings, given or drawn: one fault, which given_bias charges where there is noise."""
    return bool(none_drawn(facts)) and diagnosis.bias_mistakes(facts.sensors) == ["no-bias"]


def _one_number(facts: Facts) -> list[int]:
    return one_for_all_axes(facts) or one_for_both_sensors(facts)


def _one_for_every_bias(facts: Facts) -> bool:
    """Return whether a constant replaces each bias, given or drawn: one fault, no worse than no bias."""
    constant = set(one_for_all_instances(facts))
    return (
        bool(constant)
        and not facts.still
        and constant <= set(missing_bias(facts))
        and all(
            np.abs(facts.sensors[i].offset - _means(facts)[i][1]).max() <= 2 * diagnosis.mean_bound(facts.sensors[i])
            for i in constant
        )
    )


def one_for_all_axes(facts: Facts) -> list[int]:
    means = _means(facts)
    return [i for i, mean in enumerate(means) if np.ptp(mean, axis=1).max() <= diagnosis.TRUTH_ATOL and _some(mean)]


def one_for_both_sensors(facts: Facts) -> list[int]:
    if len(means := _means(facts)) < 2 or not all(map(_some, means)):
        return []
    ratio = means[1] / means[0]
    return [*BOTH] if np.ptp(ratio) <= 1e-3 * np.abs(ratio).max() else []


def too_large(facts: Facts) -> list[int]:
    if noisy(facts) or not all(map(_some, _means(facts))):
        return []
    sizes = [float(np.sqrt(np.mean(bias**2))) for bias in facts.defaults or ()]
    return [i for i, size in enumerate(sizes) if size > TOO_LARGE * _SHEETS_BIASES[i]]


def _some(mean: Array) -> bool:
    return bool(np.abs(mean).max() > diagnosis.TRUTH_ATOL)


DEFAULTS = (drifts, moves, none_drawn, one_for_all_instances, one_for_all_axes, one_for_both_sensors, too_large)
"""Faults of default biases, each as a function that returns the sensors that have it; later ones may follow from earlier ones."""


# ---- the law of the noise, and what goes together


def noisy_sensors(facts: Facts) -> list[int]:
    return [i for i in BOTH if not facts.steady[i].still]


def _any(holds: Callable[[Reads], bool]) -> Callable[[Facts], bool]:
    return lambda facts: any(holds(facts.steady[i]) for i in noisy_sensors(facts))


def coarse(facts: Facts) -> bool:
    return any(reads.grain for reads in facts.sensors)


def remembered(reads: Reads) -> float:
    """The largest correlation of a read with one of the three before it, if it is more than chance; else 0."""
    worst = max(laws.correlation(reads, lag) for lag in (1, 2, 3))
    return worst if worst > st.correlation_bound(reads.residual.shape[1]) else 0.0


def not_normal(reads: Reads) -> bool:
    return not laws.is_normal(reads)


def off_centre(facts: Facts) -> list[int]:
    """The sensors whose readings are off on average by something else than the bias, which is added."""
    off = _off(facts)
    if not off or any(facts.drifting) or not all(_is_added(facts, i) for i in off):
        return []
    exchanged = diagnosis.bias_mistakes(facts.sensors) == ["swapped-sensors"]
    return [] if exchanged or _has_another(facts.sensors[off[0]], facts.silent[off[0]]) else off


def _mean_is(told: str) -> Callable[[Facts], bool]:
    return lambda facts: bool(off_centre(facts)) and diagnosis.bias_mistakes(facts.sensors) == [told]


def _strays(facts: Facts) -> bool:
    return _any(lambda reads: not_normal(reads) and laws.strays(reads) is not None)(facts)


def columns(facts: Facts) -> Array:
    """(reads, 6) what is new in each read, in units of its own spread."""
    sensors = facts.steady
    if any(map(laws.correlated, sensors)):  # what is slow looks alike by chance
        sensors = (laws.paired(sensors[0]), laws.paired(sensors[1]))
    return np.concatenate([_innovations(reads) for reads in sensors], axis=1)


def _innovations(reads: Reads) -> Array:
    if diagnosis.accumulates(reads):
        steps = np.concatenate([reads.increments[:, :1] * 0, reads.increments], axis=1)
        return np.asarray(steps.reshape(-1, 3))
    return reads.standardised


def most_correlated(values: Array) -> tuple[float, int, int]:
    """The largest correlation of two of six channels, to the two digits that are told, and which two they are."""
    matrix = st.correlations(values)
    pairs = [(abs(float(matrix[i, j])), i, j) for i, j in itertools.combinations(range(6), 2)]
    return max(pairs, key=lambda pair: round(pair[0], 2))


def _one_for_axes(facts: Facts) -> bool:
    values = columns(facts)
    first = 3 * (most_correlated(values)[1] // 3)
    return bool(st.correlations(values)[first : first + 3, first : first + 3].min() > _THE_SAME)


def _by_strays_alone(facts: Facts) -> bool:
    """Return whether two channels are correlated by no more than what a few far values of theirs make."""
    values = columns(facts)
    _, i, j = most_correlated(values)
    signs = st.correlations(np.sign(values))
    return abs(float(signs[i, j])) <= st.correlation_bound(len(values))


def changed(facts: Facts) -> Array:
    """Return a mask of time, qpos, qvel and sensordata: which of them a read changes."""
    return np.asarray(~(facts.disturbance <= NO_CHANGE))


# ---- the reasons


def _general(of: str, cost: int, holds: Callable[[Facts], bool], *predicts: str) -> Reason[Facts]:
    return Reason(of, cost, f"noise_model.{of}", holds, frozenset(predicts))


def _repeats(told: str) -> Callable[[Facts], bool]:
    return lambda facts: facts.follows and facts.still and not without_draw(facts) and _told_size(facts) == [told]


_REPEATED = [(told, of) for told in ("frozen-noise", "reseeded") for of in (LAW, APART)]
REASONS: tuple[Reason[Facts], ...] = (
    Reason(SIZE, 0, "reads-no-sensor", lambda f: not f.follows),
    Reason(SIZE, 1, "one-sensor-twice", lambda f: f.one_twice),
    Reason(SIZE, 2, "bias-redrawn", _redrawn_explains_size),
    Reason(SIZE, 3, "no-noise", without_draw),
    *(Reason(SIZE, 2 + each.cost, str(each.told), _known_size(each)) for each in diagnosis._SIZES),
    Reason(SIZE, 7, "noise-density", lambda f: laws.density(f.steady, f.timestep)),
    Reason(SIZE, 8, "no-noise-known", lambda f: f.still),
    Reason(GIVEN, 0, "swapped-sensors", lambda f: f.exchanged),
    Reason(GIVEN, 0, "one-sensor-twice", lambda f: f.one_twice and not f.exchanged, frozenset({DEFAULT})),
    Reason(GIVEN, 1, "stds-swapped", _ids_exchanged),
    Reason(GIVEN, 1, "bias-redrawn", lambda f: f.redrawn and bool(missing_bias(f))),
    Reason(GIVEN, 0, "bias-drifts", lambda f: bool(missing_bias(f)) and _gone_after_one_read(f)),
    *(
        Reason(GIVEN, 1 + each.cost, each.told or f"noise_model.{GIVEN}", _known_bias(each), frozenset({DEFAULT}))
        for each in diagnosis._BIASES
    ),
    Reason(GIVEN, 12, "another-bias-beside", lambda f: bool(bias_beside(f)), frozenset({DEFAULT})),
    Reason(GIVEN, 12, "bias-argument-ignored", lambda f: bool(offset_of_zero(f))),
    _general(GIVEN, 99, lambda _: True, DEFAULT),
    Reason(DEFAULT, 1, "bias-drifts", lambda f: bool(drifts(f))),
    Reason(DEFAULT, 2, "bias-drifts", _gone_after_one_read),
    Reason(DEFAULT, 3, "bias-shared", _each_moving(lambda b: np.ptp(b[:, 1:], axis=(0, 1)).max() <= diagnosis.EXACT)),
    Reason(
        DEFAULT, 5, "bias-redrawn", _each_moving(lambda b: np.median(np.ptp(b, axis=1).max(axis=1)) > diagnosis.EXACT)
    ),
    Reason(DEFAULT, 6, "no-bias-drawn", lambda f: f.still and _none_at_all(f)),
    Reason(DEFAULT, 7, "bias-not-random", lambda f: bool(none_drawn(f)) and not _none_at_all(f)),
    *(
        Reason(DEFAULT, 8, told, lambda f, told=told: bool(one_for_all_instances(f)) and _repeats(told)(f))  # type: ignore[misc]
        for told in ("frozen-noise", "reseeded")
    ),
    Reason(DEFAULT, 9, "bias-not-random", lambda f: bool(one_for_all_instances(f)) and not _one_for_every_bias(f)),
    Reason(DEFAULT, 11, "bias-shared", lambda f: bool(_one_number(f)) and not _one_for_every_bias(f)),
    Reason(LAW, 1, "precision-lost", coarse),
    *(Reason(of, 0, told, _repeats(told)) for told, of in _REPEATED),
    Reason(LAW, 2, "noise-accumulates", _any(diagnosis.accumulates)),
    Reason(LAW, 3, "noise-correlated", _any(lambda reads: remembered(reads) > 0)),
    Reason(LAW, 4, "noise-not-zero-mean", _any(diagnosis.one_signed), frozenset({DEFAULT})),
    Reason(LAW, 5, "noise-clipped", _any(laws.clipped)),
    Reason(LAW, 6, "stray-values", lambda f: _strays(f) and _by_strays_alone(f), frozenset({DEFAULT, APART})),
    Reason(LAW, 7, "stray-values", _strays, frozenset({DEFAULT})),
    Reason(LAW, 8, "not-gaussian", _any(not_normal)),
    *(Reason(LAW, 9, t, _mean_is(t), frozenset({DEFAULT})) for t in ("noise-not-zero-mean", "stale-clean-reading")),
    _general(LAW, 99, lambda f: bool(off_centre(f)), DEFAULT),
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
