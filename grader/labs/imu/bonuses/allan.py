"""The Allan deviation of a record, and what else a curve over averaging times may be.

References
----------
Riley, W. J. (2008). Handbook of Frequency Stability Analysis. NIST Special Publication 1065, equations (6), (7) and (11).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from grader.labs.imu.compare import Array

EXACT = 1e-6
"""Relative. Double precision keeps 1e-9 of a record of 4,000 samples however it is summed."""
_SCATTER = 5.0
"""Standard errors that an unusual but sound estimate may differ by at one averaging time: 5 / √(number of clusters)."""
_MEAN_LOG = 0.1
"""Largest mean of log(estimate / truth), weighted by clusters. Sound estimates differ by 0.02;
without the factor one half it is 0.35."""

_MOST = 200  # points of a curve that are looked at

Sizes = np.ndarray


def overlapping(samples: Array, m: int) -> float:
    """Equation (11): from all clusters of m samples of (n,), wherever they start."""
    integral = np.concatenate([[0.0], np.cumsum(samples)])
    return _of_differences(integral[2 * m :] - 2.0 * integral[m:-m] + integral[: -2 * m], m)


def _of_differences(second: Array, m: int) -> float:
    return float(np.sqrt(np.mean(second**2) / 2.0) / m) if len(second) else float("nan")


def separate(samples: Array, m: int) -> float:
    """Equation (6): from neighbouring clusters that share no sample, counted from the start."""
    return _of_differences(np.diff(_clusters(samples, m).mean(axis=1)), 1)


def _clusters(samples: Array, m: int) -> Array:
    count = len(samples) // m
    return np.asarray(samples[: count * m].reshape(count, m))


def _forms(samples: Array, m: int) -> Iterator[float]:
    """Sound estimates that agree to rounding with common programs: some lose the first sample in the integral, some the last."""
    for part in (samples, samples[1:], samples[:-1], samples[len(samples) % m :]):
        yield overlapping(part, m)
        yield separate(part, m)


def spread_of_averages(samples: Array, m: int) -> float:
    """Standard deviation of the clusters' averages: what is often taken for the Allan deviation."""
    return float(np.std(_clusters(samples, m).mean(axis=1)))


def _spread_unbiased(samples: Array, m: int) -> float:
    return float(np.std(_clusters(samples, m).mean(axis=1), ddof=1))


def fits(sizes: Sizes, curve: Array, samples: Array, *, factor: float = 1.0) -> bool:
    """Return whether a curve (k,) is `factor` times the Allan deviation at these cluster sizes (k,), or a sound estimate."""
    usable = [(int(m), value / factor) for m, value in zip(sizes, curve, strict=True) if 1 <= m <= len(samples) // 2]
    if len(usable) < max(3, len(curve) // 2):
        return False
    return all(_exact(samples, m, value) for m, value in usable) or _estimates(usable, samples)


def _exact(samples: Array, m: int, value: float) -> bool:
    return any(abs(value - form) <= EXACT * form for form in _forms(samples, m))


def _estimates(usable: list[tuple[int, float]], samples: Array) -> bool:
    """Return whether it is a sound estimate that we do not know, from its distance to the overlapping one."""
    clusters = np.array([len(samples) / m for m, _ in usable])
    if min(value for _, value in usable) <= 0:
        return False
    gap = np.log([value / overlapping(samples, m) for m, value in usable])
    counted = clusters >= 30
    if counted.sum() < 3:
        return False
    mean = float(np.average(gap[counted], weights=clusters[counted]))
    return abs(mean) <= _MEAN_LOG and bool(np.all(np.abs(gap[counted]) <= _SCATTER / np.sqrt(clusters[counted])))


Sized = Callable[[Array, float], Array]

_SIZES: list[tuple[bool, Sized]] = [
    (True, lambda taus, rate: np.round(taus * rate)),
    (True, lambda taus, rate: np.floor(taus * rate + 1e-9)),
    (True, lambda taus, rate: np.ceil(taus * rate - 1e-9)),
    (False, lambda taus, rate: np.round(taus)),
    (False, lambda taus, rate: np.round(taus / rate)),
    (False, lambda taus, rate: np.round(taus * rate**2)),
]


Record = tuple[Array, Array, Array]
"""Averaging times (k,), curve (k,) and samples (n,)."""


def unit_of_times(records: list[Record], rate: float) -> tuple[bool, Sized] | None:
    """Return how averaging times convert to cluster sizes so that every curve is an Allan deviation: in seconds or samples.

    One meaning must fit all records: without the factor one half, white noise alone looks as if times were twice too long.
    """
    for seconds, size in _SIZES:
        if all(fits(size(taus, rate), curve, samples) for taus, curve, samples in records):
            return seconds, size
    return None


def thinned(taus: Array, curve: Array) -> tuple[Array, Array]:
    """At most `_MOST` points of a curve, the first and the last among them: two hundred tell as much as a million."""
    chosen = np.linspace(0, len(taus) - 1, min(len(taus), _MOST)).round().astype(int)
    return taus[chosen], curve[chosen]


def in_seconds(taus: Array, rate: float) -> Sizes:
    """Cluster sizes of averaging times in seconds."""
    return np.round(taus * rate)


def slopes(record: Record, size: Sized, rate: float) -> tuple[float, float]:
    """Return the slope of the overlapping estimate and that of a curve, where the record has thirty clusters or more."""
    taus, curve, samples = record
    sizes = np.clip(size(taus, rate), 1, len(samples) // 2).astype(int)
    wanted = np.array([overlapping(samples, int(m)) for m in sizes])
    clusters = len(samples) / sizes
    return _slope(taus, wanted, clusters), _slope(taus, curve, clusters)


def _slope(taus: Array, curve: Array, clusters: Array) -> float:
    """Return the slope of a curve (k,) on double logarithmic axes; NaN with fewer than three such times."""
    known = (clusters >= 30) & (taus > 0) & (curve > 0) & np.isfinite(curve)
    if len(np.unique(taus[known])) < 3:
        return np.nan
    return float(np.polyfit(np.log(taus[known]), np.log(curve[known]), 1)[0])


def _every(predicts: Callable[[Sizes, Array, Array], bool]) -> Callable[[list[Record], float], bool]:
    """Return whether one meaning of averaging times makes all records what is predicted."""

    def predicted(records: list[Record], rate: float) -> bool:
        return any(
            all(predicts(size(taus, rate), curve, samples) for taus, curve, samples in records) for _, size in _SIZES
        )

    return predicted


def _is_spread(sizes: Sizes, curve: Array, samples: Array) -> bool:
    usable = [(int(m), value) for m, value in zip(sizes, curve, strict=True) if 1 <= m <= len(samples) // 2]
    forms = (spread_of_averages, _spread_unbiased)
    if len(usable) < 3:
        return False
    return all(any(abs(value - form(samples, m)) <= 0.02 * form(samples, m) for form in forms) for m, value in usable)


FAULTS: Mapping[str, Callable[[list[Record], float], bool]] = {
    "allan-factor-missing": _every(lambda sizes, curve, samples: fits(sizes, curve, samples, factor=2**0.5)),
    "std-not-allan": _every(_is_spread),
}
"""For each fault, whether it predicts every curve; the most plausible first."""
