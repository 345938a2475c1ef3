"""Noise that is not white and normal, and biases that do not stay: which is which, so that the right check charges each.

A bias that drifts shows where there is no noise, or in the first reads of many instances; differences of neighbouring reads
then tell the noise as if the bias stood still. A read that depends on the one before shows in the correlation of reads; noise
that is cut off in its largest value, which a normal law would have gone beyond.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from grader.labs.imu import statistics as st
from grader.labs.imu.compare import Array
from grader.labs.imu.diagnosis.noise import EXACT, Facts, accumulates

_SMOOTH = 0.5
"""Of von Neumann's ratio, which is 1 for white noise (± 0.04 for 600 values) and below 0.2 for a walk of 100 reads."""
_CREEPS = 0.3
"""Of the spread between instances: a bias drawn anew on every read moves by 1.4 of it from one read to the next."""
_UNLIKE_UNIFORM = 0.9
"""Standard deviations. A normal law that is drawn anew beyond a narrower bound is a uniform one, as far as moments tell."""
_CUT = 2.9
"""Standard deviations. 7,500 sound values stay within with a probability of (1 - 0.0037)^7500 = 7e-13."""

_OF_MIDDLE_HALF = 1.4826
"""Standard deviations of a normal law in half the width of its middle half (the median absolute deviation): 1 / 0.6745."""
_FEW = 0.25
"""Of all values: so many at most may be taken off, and the others are still all that there is to judge."""


def drifts(silent: Facts) -> bool:
    """Return whether reads that were asked for no noise move, and each by little against what they move by in the end."""
    if silent.still:
        return False
    return float(np.mean(silent.increments**2) / (2 * np.mean(silent.centred**2))) < _SMOOTH


def creeps(biases: Array) -> bool:
    """Return whether biases (instances, reads, 3) move from read to read by little against how they differ between instances."""
    moves = float(np.sqrt(np.mean(np.diff(biases, axis=1) ** 2)))
    between = float(np.sqrt(np.mean(np.var(biases[:, 0], axis=0))))
    return EXACT * max(1.0, float(np.abs(biases).max())) < moves < _CREEPS * between


def steadied(facts: Facts, silent: Facts) -> Facts:
    """Differences of two neighbouring reads in place of reads: noise of the same size and law, and no drift.

    The part of their spread that the drift itself makes, known from the reads without noise, is taken off.
    """
    pairs = _pairs(facts)
    own, drift = float(np.mean(pairs**2)), float(np.mean(_pairs(silent) ** 2))
    share = np.sqrt(max(1 - drift / own, 0.25)) if own else 1.0
    return replace(facts, residual=facts.bias + share * pairs)


def paired(facts: Facts) -> Facts:
    """The same of reads whose bias stays."""
    return replace(facts, residual=facts.bias + _pairs(facts))


def _pairs(facts: Facts) -> Array:
    even = facts.residual.shape[1] // 2 * 2
    return np.asarray((facts.residual[:, 1:even:2] - facts.residual[:, 0:even:2]) / np.sqrt(2.0))


def correlation(facts: Facts, lag: int) -> float:
    """The largest autocorrelation over axes and states, without its sign."""
    return max((abs(float(r)) for state in facts.centred for r in st.autocorrelation(state, lag)), default=0.0)


def correlated(facts: Facts) -> bool:
    """Return whether a read depends on one of the three before it, other than by adding to it."""
    if facts.still or accumulates(facts):
        return False
    bound = st.correlation_bound(facts.residual.shape[1])
    return any(correlation(facts, lag) > bound for lag in (1, 2, 3))


def innovation(facts: Facts) -> float:
    """The spread of what is new in a read, if it keeps a share of the read before: sqrt(1 - r^2) of the whole."""
    r = float(np.mean([st.autocorrelation(state, 1) for state in facts.centred]))
    return facts.pooled_spread * float(np.sqrt(1 - r**2))


def clipped(facts: Facts) -> bool:
    """Return whether the reads are what a normal law of the size asked for leaves within some bound.

    A bound shows where nothing goes beyond `_CUT`, or where the largest deviation comes again, to the last digit.
    """
    cut = float(np.abs(facts.centred).max()) / facts.std
    if facts.still or not (_UNLIKE_UNIFORM < cut < _CUT or _repeats_extremes(facts)):
        return False
    spread, mean = facts.pooled_spread / facts.std, float(np.abs(facts.centred).mean()) / facts.std
    return any(abs(spread / s - 1) < 0.04 and abs(mean / spread - m / s) < 0.012 for s, m in st.limited_moments(cut))


def _repeats_extremes(facts: Facts) -> bool:
    """Return whether four at least of the largest and least values, one an axis and state, come twice, to the last digit.

    Double precision repeats one with a probability of 1e-12, single precision with 2e-4, and four of twelve with 1e-12.
    """
    ranked = np.sort(facts.residual, axis=1)
    again = np.stack([ranked[:, -1] == ranked[:, -2], ranked[:, 1] == ranked[:, 0]])
    return int(again.sum()) >= 4


def density(sensors: Sequence[Facts], timestep: float) -> bool:
    """Return whether the noise of both sensors is wrong by the root of the rate or of the time step, as a noise density is."""
    ratios = [facts.pooled_spread / facts.std for facts in sensors]
    return any(all(abs(r / root - 1) < 0.07 for r in ratios) for root in (timestep**0.5, timestep**-0.5))


def living(facts: Facts) -> Array:
    """The standardised noise of the axes that have any."""
    return np.asarray(facts.standardised[:, facts.standardised.any(axis=0)].ravel())


def is_normal(facts: Facts) -> bool:
    """Return whether mean deviation and standard deviation are as far apart as a normal law has them; still axes aside."""
    values = living(facts)
    if not values.size:
        return True
    low, high = st.geary_bounds(values.size)
    return bool(low <= st.geary(values) <= high)


@dataclass(frozen=True)
class Strays:
    """Values that are further off than a normal law of the others' spread has any, and the spread of the others."""

    count: int
    spread: float


def strays(facts: Facts) -> Strays | None:
    """The values that are too far off; None where there are none, or many, or where the others are not normal.

    The middle of the reads and half the width of their middle half, by which they are told, hardly change with a few far ones.
    """
    beside = facts.residual - np.median(facts.residual, axis=1, keepdims=True)
    spread = np.median(np.abs(beside), axis=1, keepdims=True) * _OF_MIDDLE_HALF
    far = np.abs(beside) > st.Z * spread
    if not 0 < far.mean() < _FEW:
        return None
    low, high = st.geary_bounds(int((~far).sum()))
    others = (beside / np.where(spread > 0, spread, np.inf))[~far]
    if not low <= st.geary(others[others != 0]) <= high:
        return None
    return Strays(int(far.sum()), float(np.sqrt(np.mean(beside[~far] ** 2))))
