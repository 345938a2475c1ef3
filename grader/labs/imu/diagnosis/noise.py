"""Explanation of a noise model from its moments: which of them are wrong, and which faults predict that.

The reads of one `NoisyIMU` in two states, with the noise and the biases that it was told, become `Facts` of each sensor; a second
instance, one with zero noise and zero bias, and many without a given bias separate what looks alike in the first.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from grader.engine.hypothesis import Named, mistakes_of
from grader.labs.imu import statistics as st
from grader.labs.imu.compare import Array

SIZE_TOLERANCE = 0.0
"""Share of the standard deviation by which noise may be too small or too large beyond what chance explains (`statistics.ALPHA`).
At 0 a standard deviation that is wrong by 10 % is found with a probability above 0.999."""

EXACT = 1e-9
"""Of one: noise-free arithmetic repeats to rounding; a random draw never comes this close twice."""

TRUTH_ATOL = 1e-5
"""m/s², rad/s. How far the truth itself may be off: bundles recorded with another MuJoCo differ by 1.3e-7."""

_DECIMALS = (1e-1, 1e-2, 1e-3, 1e-4)
"""Steps of a rounding that are looked for. Larger ones leave nothing of the sheet's noise that could be judged."""
_FINEST = 0.99e-4
"""Of a step that counts as one: finer ones are as good as the truth."""


_FAR = 1e4
"""m/s², rad/s. Half precision ends at 65504; no reading of the lab comes near."""


@dataclass(frozen=True)
class Facts:
    """One sensor's reads.

    Attributes
    ----------
    residual : (states, reads, 3) ndarray, reading minus truth
    truth : (states, 3) ndarray; std : the standard deviation asked for; bias : (3,) ndarray, the bias given
    """

    residual: Array
    truth: Array
    std: float
    bias: Array

    @cached_property
    def offset(self) -> Array:
        """(states, 3) mean of the reading minus the truth."""
        return np.asarray(self.residual.mean(axis=1))

    @cached_property
    def centred(self) -> Array:
        """(states, reads, 3) residuals without their mean in each state."""
        return np.asarray(self.residual - self.residual.mean(axis=1, keepdims=True))

    @cached_property
    def spread(self) -> Array:
        """(states, 3) standard deviation."""
        return np.asarray(self.residual.std(axis=1))

    @cached_property
    def pooled_spread(self) -> float:
        return float(np.sqrt(np.mean(self.centred**2)))

    @cached_property
    def still(self) -> bool:
        """Return whether reads in one state do not differ."""
        return bool(np.all(self.spread <= EXACT * self.std))

    @cached_property
    def standardised(self) -> Array:
        """(states × reads, 3) residuals in units of their own spread; zero where there is none."""
        spread = np.where(self.spread > EXACT * self.std, self.spread, np.inf)
        return np.asarray((self.centred / spread[:, None, :]).reshape(-1, 3))

    @cached_property
    def restless(self) -> bool:
        """Return whether most reads differ from the one before."""
        return bool(np.median(np.abs(self.increments).max(axis=2)) > EXACT * self.std)

    @cached_property
    def grain(self) -> float:
        """The step that noisy readings are multiples of, or that of half precision; 0 where they are neither."""
        readings = self.residual + self.truth[:, None, :]
        if self.still:
            return 0.0
        largest = float(np.abs(readings).max())
        if largest < _FAR and np.abs(readings - readings.astype(np.float16)).max() < EXACT:
            return float(np.spacing(np.float16(largest)))
        steps = (_closest(readings), *_DECIMALS)
        return next((s for s in steps if s > _FINEST and _are_multiples(readings, s)), 0.0)

    @cached_property
    def increments(self) -> Array:
        """(states, reads - 1, 3) differences of successive reads."""
        return np.diff(self.residual, axis=1)


def _closest(values: Array) -> float:
    """Return the smallest distance between two different values; 0 if all are equal."""
    apart = np.diff(np.unique(values))
    return round(float(apart[apart > EXACT].min(initial=np.inf)), 15) if (apart > EXACT).any() else 0.0


def _are_multiples(values: Array, step: float) -> bool:
    return bool(np.abs(values - (values / step).round() * step).max() < EXACT)


def accumulates(facts: Facts) -> bool:
    """Return whether each read carries the noise of the reads before: successive ones hardly differ from each other."""
    return not facts.still and bool(min(st.autocorrelation(state, 1).min() for state in facts.centred) > 0.9)


def one_signed(facts: Facts) -> bool:
    """Return whether, on every axis, the reads begin at truth plus bias and go to one side of it, as absolute values do."""
    if facts.still:
        return False
    beside, edge = facts.residual - facts.bias, 0.05 * facts.pooled_spread
    least, most = beside.min(axis=(0, 1)), beside.max(axis=(0, 1))
    return bool(np.all((least >= -TRUTH_ATOL) & (least < edge)) or np.all((most <= TRUTH_ATOL) & (most > -edge)))


def half_width_is_std(facts: Facts) -> bool:
    """Return whether the noise fills ± std evenly: a uniform law with the standard deviation taken for its half width."""
    largest = float(np.abs(facts.centred).max())
    return 0.95 * facts.std < largest < 1.05 * facts.std and abs(facts.pooled_spread / facts.std - 3**-0.5) < 0.05


def size_is_right(facts: Facts, spread: float | None = None) -> bool:
    """Return whether the pooled spread and that of each axis agree with the standard deviation asked for.

    Rounding adds to each value half a grain at most, and so to a spread: the triangle inequality.
    """
    states, reads, _ = facts.residual.shape
    off = SIZE_TOLERANCE + facts.grain / 2 / facts.std
    low, high = st.spread_bounds(3 * states * reads, 3 * states)
    if not low - off <= (facts.pooled_spread if spread is None else spread) / facts.std <= high + off:
        return False
    low, high = st.spread_bounds(states * reads, states)
    per_axis = np.sqrt(np.mean(facts.centred**2, axis=(0, 1))) / facts.std
    return spread is not None or bool(np.all((low - off <= per_axis) & (per_axis <= high + off)))


def proportional(facts: Facts) -> bool:
    """Return whether the spread goes with the size of the reading, over axes and states."""
    size = np.abs(facts.truth).ravel()
    spread = facts.spread.ravel()
    if facts.still or len(np.unique(size.round(6))) < 3:
        return False
    ratio = spread / size
    return bool(ratio.std() < 0.1 * ratio.mean() and spread.std() > 0.2 * spread.mean())


@dataclass(frozen=True)
class _Sizes:
    """Facts about the size of the noise: of one instance, of a second one, and of one with a standard deviation of zero."""

    sensors: Sequence[Facts]
    again: Sequence[Facts]
    silent: Sequence[Facts]

    @cached_property
    def still(self) -> list[bool]:
        return [facts.still for facts in self.sensors]

    @cached_property
    def noisy(self) -> bool:
        """Return whether both sensors' reads differ."""
        return not any(self.still)

    @cached_property
    def obeyed(self) -> bool:
        """Return whether both sensors' reads differ, and only where noise was asked for."""
        return self.noisy and all(facts.still for facts in self.silent)


def size_mistakes(sensors: Sequence[Facts], again: Sequence[Facts], silent: Sequence[Facts]) -> list[str]:
    """Return the faults that a wrong standard deviation shows.

    Parameters
    ----------
    sensors : accelerometer and gyroscope of the long run
    again : the same of a second instance; silent : of one that was asked for no noise and given zero biases
    """
    return mistakes_of(_SIZES, _Sizes(sensors, again, silent))


def bias_is_redrawn(sensors: Sequence[Facts], silent: Sequence[Facts]) -> bool:
    """Return whether reads without noise vary, and the noisy ones clearly more: a bias drawn on every read, with the noise on top.

    Noise of a fixed size, whatever was asked for, varies as much in both. The spread of 600 values errs by 3 %. Reads of which a
    few are off have jumps, and their bias stays.
    """
    both = zip(sensors, silent, strict=True)
    return any(noisy.pooled_spread > 1.12 * quiet.pooled_spread for noisy, quiet in both if quiet.restless)


def _only_offsets(seen: _Sizes) -> bool:
    """Return whether nothing is drawn: each read is the truth plus the bias, a constant or a multiple of the standard deviation."""
    beside = np.array([(f.offset - f.bias) / f.std for f in seen.sensors])
    return bool(np.ptp(beside) <= TRUTH_ATOL / min(f.std for f in seen.sensors)) or all(
        np.allclose(f.offset, f.bias, atol=TRUTH_ATOL)
        or np.allclose(f.offset, 0, atol=TRUTH_ATOL)
        or _is_constant(f, silent)
        for f, silent in zip(seen.sensors, seen.silent, strict=True)
    )


def _is_constant(facts: Facts, silent: Facts) -> bool:
    """Return whether an offset stays the same where no noise is asked for, with the bias or without it."""
    if not silent.still:
        return False
    beside = facts.offset - silent.offset
    return any(np.allclose(beside, bias, atol=TRUTH_ATOL) for bias in (np.zeros(3), facts.bias))


def _one_draw(seen: _Sizes) -> bool:
    """Return whether every read is the clean reading and one draw that is repeated."""
    return all(np.ptp(f.offset, axis=0).max() <= 2 * st.Z * f.std for f in seen.sensors)


def _same_again(seen: _Sizes) -> bool:
    pairs = zip(seen.sensors, seen.again, strict=True)
    return all(np.allclose(a.offset, b.offset, atol=EXACT) for a, b in pairs)


def _of_other_power(seen: _Sizes) -> bool:
    wrong = [f for f in seen.sensors if not size_is_right(f)]
    return bool(wrong) and all(_near(f.pooled_spread, f.std**2) or _near(f.pooled_spread, f.std**0.5) for f in wrong)


def _stds_swapped(seen: _Sizes) -> bool:
    """Return whether the noise of each sensor whose size is wrong has the standard deviation of the other one."""
    accel, gyro = seen.sensors
    wrong = [(f, other) for f, other in ((accel, gyro), (gyro, accel)) if not size_is_right(f)]
    return bool(wrong) and all(_near(f.pooled_spread, other.std) for f, other in wrong)


def _near(value: float, target: float) -> bool:
    return abs(value / target - 1) < 0.07


_SIZES: list[Named[_Sizes]] = [
    Named(1, "no-noise", lambda seen: all(seen.still) and _only_offsets(seen)),
    Named(2, "reseeded", lambda seen: all(seen.still) and _one_draw(seen) and _same_again(seen)),
    Named(2, "frozen-noise", lambda seen: all(seen.still) and _one_draw(seen) and not _same_again(seen)),
    Named(2, "gyro-not-noisy", lambda seen: any(seen.still) and not all(seen.still)),
    Named(3, "multiplicative-noise", lambda seen: seen.noisy and any(proportional(f) for f in seen.sensors)),
    Named(
        4,
        "std-ignored",
        lambda seen: (
            seen.noisy and any(f.restless for f in seen.silent) and not bias_is_redrawn(seen.sensors, seen.silent)
        ),
    ),
    Named(4, "stds-swapped", lambda seen: seen.obeyed and _stds_swapped(seen)),
    Named(4, "variance-as-std", lambda seen: seen.obeyed and _of_other_power(seen)),
]


@dataclass(frozen=True)
class _Biases:
    """Facts about the biases: the sensors whose offset is not the given bias, each beside the other sensor, and both."""

    wrong: list[tuple[Facts, Facts]]
    sensors: Sequence[Facts]


def bias_mistakes(sensors: Sequence[Facts]) -> list[str]:
    """Return the faults that an offset other than the given bias shows."""
    pairs = zip(sensors, reversed(sensors), strict=True)
    wrong = [(facts, other) for facts, other in pairs if not bias_is_right(facts)]
    return mistakes_of(_BIASES, _Biases(wrong, sensors)) if wrong else []


def _each(predicts: Callable[[Facts, Facts], bool]) -> Callable[[_Biases], bool]:
    """Return a test that holds if `predicts` holds for every wrong sensor, beside the other one."""
    return lambda seen: all(predicts(facts, other) for facts, other in seen.wrong)


def _shared(seen: _Biases) -> bool:
    """Return whether a sensor has the other's bias, or every wrong one the bias of its first axis on all three."""
    others = any(_offset_is(facts, other.bias) for facts, other in seen.wrong)
    return others or all(_offset_is(facts, np.full(3, facts.bias[0])) for facts, _ in seen.wrong)


def _shifted(facts: Facts, other: Facts) -> bool:
    """Return whether the noise has a mean, the same on all axes and in all states."""
    del other
    return bool(np.ptp(facts.offset - facts.bias) <= 2 * mean_bound(facts))


def _permutes(facts: Facts) -> bool:
    """Return whether the components of the given bias are there, on other axes."""
    others = [list(order) for order in itertools.permutations(range(3)) if order != (0, 1, 2)]
    return sum(_offset_is(facts, facts.bias[order]) for order in others) == 1


def _biases_exchanged(sensors: Sequence[Facts]) -> bool:
    """Return whether each sensor has the other's given bias."""
    return all(_offset_is(f, g.bias) for f, g in zip(sensors, reversed(sensors), strict=True))


def mean_bound(facts: Facts) -> float:
    reads = facts.residual.shape[1]
    return st.mean_bound(reads, max(facts.std, facts.pooled_spread)) + TRUTH_ATOL


def bias_is_right(facts: Facts) -> bool:
    """Return whether truth plus bias is the mean, in each state and over both."""
    states, reads, _ = facts.residual.shape
    gap = np.abs(facts.offset - facts.bias)
    overall = np.abs(facts.offset.mean(axis=0) - facts.bias)
    sigma, exact = max(facts.std, facts.pooled_spread), TRUTH_ATOL + facts.grain / 2
    if facts.still:  # one draw that is repeated, or none: the offset may be off by that draw
        return bool(gap.max() <= st.Z * facts.std + exact)
    return bool(
        gap.max() <= st.mean_bound(reads, sigma) + exact
        and overall.max() <= st.mean_bound(states * reads, sigma) + exact
    )


def _offset_is(facts: Facts, wanted: Array) -> bool:
    return bool(np.abs(facts.offset - wanted).max() <= mean_bound(facts))


def _follows_bias(facts: Facts) -> bool:
    """Return whether the offset is some multiple of the given bias."""
    factor = float(facts.offset.mean(axis=0) @ facts.bias / (facts.bias @ facts.bias))
    return _offset_is(facts, factor * facts.bias)


def _stale(facts: Facts) -> bool:
    """Return whether every state gives what the first one gave, bias included."""
    first = facts.truth[0] + facts.bias - facts.truth
    return bool(np.abs(facts.offset - first).max() <= mean_bound(facts))


_BIASES: list[Named[_Biases]] = [
    Named(1, "no-bias", _each(lambda f, _: _offset_is(f, np.zeros(3)))),
    Named(2, "bias-sign-flipped", _each(lambda f, _: _offset_is(f, -f.bias))),
    Named(3, "stale-clean-reading", _each(lambda f, _: _stale(f))),
    Named(
        4,
        "swapped-sensors",
        lambda seen: (
            len(seen.wrong) == 2 and all(_offset_is(f, other.truth - f.truth + f.bias) for f, other in seen.wrong)
        ),
    ),
    Named(5, "biases-exchanged", lambda seen: _biases_exchanged(seen.sensors)),
    Named(6, "bias-axes-exchanged", _each(lambda f, _: _permutes(f))),
    Named(7, "bias-shared", _shared),
    Named(8, "noise-not-zero-mean", _each(_shifted)),
    Named(9, None, lambda seen: any(_follows_bias(f) for f, _ in seen.wrong)),  # whatever was done to it, it counts
    Named(
        10,
        "bias-argument-ignored",
        _each(lambda f, _: bool(np.ptp(f.offset, axis=0).max() <= 2 * mean_bound(f))),
    ),
]
