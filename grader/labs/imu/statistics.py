"""Statistical tests with a stated error: each fails a sound sample with a probability of at most `ALPHA`.

All checks together apply fewer than 90 such tests to a submission, so a sound one loses a point by chance with a probability below
1e-9. Docstrings tell the faults that a test catches with a probability of 0.999; `tests/benchmarks` measures both.

References
----------
Geary, R. C. (1936). Moments of the ratio of the mean deviation to the standard deviation for normal samples.
    Biometrika 28, 295-307, eq. (22): mean sqrt(2/pi), variance (1 - 3/pi) / n.
Fisher, R. A. (1921). On the "probable error" of a coefficient of correlation. Metron 1, 3-32: atanh(r) has standard error
    1 / sqrt(n - 3).
Riley, W. J. (2008). Handbook of Frequency Stability Analysis. NIST Special Publication 1065, eq. (11): overlapping Allan deviation.
Cochran, W. G. (1934). The distribution of quadratic forms in a normal system: n s^2 / sigma^2 is chi-squared.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import special

Array = NDArray[np.float64]

ALPHA = 1e-11
"""False-failure rate of one question. Fewer than 90 are asked."""

Z = float(-special.ndtri(ALPHA / 2))
"""Two-sided normal quantile of `ALPHA`, 6.81."""

READS = 1250
"""Reads per state; two states. 2,500 reads catch a correlation of 0.2 and a bias off by a fifth of sigma (see below)."""


def spread_bounds(values: int, estimated_means: int) -> tuple[float, float]:
    """Return (low, high), within which chance keeps sample standard deviation / sigma of normal samples (chi-squared).

    `values` is the size of the sample, `estimated_means` the number of means subtracted from its parts. With 7,500 values the
    bounds are 0.945 and 1.056: a standard deviation wrong by 10 % is outside with probability > 0.9999.
    """
    freedom = values - estimated_means
    low, high = (2.0 * special.gammaincinv(freedom / 2.0, p) for p in (ALPHA / 2, 1 - ALPHA / 2))
    return math.sqrt(low / freedom), math.sqrt(high / freedom)


def mean_bound(values: int, sigma: float) -> float:
    """Return the largest distance of a sample mean from the true mean that chance explains; 0.136 sigma for 2,500 values.

    With a bias of a fifth of sigma, the mean of 2,500 values exceeds the bound with probability 0.9993.
    """
    return Z * sigma / math.sqrt(values)


def correlation_bound(values: int) -> float:
    """Return the largest correlation of independent normal samples that chance explains (Fisher's z); 0.135 for 2,500 values.

    2,500 values whose true correlation is 0.2 exceed that bound with probability 0.9996.
    """
    return math.tanh(Z / math.sqrt(values - 3))


def geary(standardised: Array) -> float:
    """Return Geary's ratio of values of one spread: mean absolute / standard deviation from their mean; 0.798 if normal."""
    centred = standardised - standardised.mean()
    return float(np.mean(np.abs(centred)) / np.sqrt(np.mean(centred**2)))


def geary_bounds(values: int) -> tuple[float, float]:
    """Return (low, high), within which chance keeps Geary's ratio (see `geary`) of normal samples: nine standard errors each way.

    `values` is the size of the sample. The 6.8 errors (`Z`) of the other bounds would be too few: the ratio is not normal in the
    far tail. With 7,500 values the bounds are 0.798 ± 0.022: a uniform (0.866), a Laplace (0.707), an exponential (0.736) and a
    two-point law (1) are outside with probability > 0.9999.
    """
    centre, error = math.sqrt(2 / math.pi), math.sqrt((1 - 3 / math.pi) / values)
    return centre - 9 * error, centre + 9 * error


def limited_moments(cut: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return two pairs (standard deviation, mean absolute deviation): of unit normal noise clipped to ± `cut`, and redrawn outside.

    Clipped at c = `cut`: E x^2 = P - 2 c p(c) + 2 c^2 Q, E |x| = 2 (p(0) - p(c)) + 2 c Q; redrawn: without Q and divided by P. Here
    p is the normal density, P the probability of |x| < c, and Q that of x > c (by parts).
    """
    inside, beyond = float(2 * special.ndtr(cut) - 1), float(special.ndtr(-cut))
    top, edge = 1 / math.sqrt(2 * math.pi), math.exp(-(cut**2) / 2) / math.sqrt(2 * math.pi)
    square, mean = inside - 2 * cut * edge, 2 * (top - edge)
    clipped = math.sqrt(square + 2 * cut**2 * beyond), mean + 2 * cut * beyond
    return clipped, (math.sqrt(square / inside), mean / inside)


def allan_deviation(samples: Array, m: int) -> float:
    """Return the overlapping Allan deviation of samples (n, …) in clusters of m, RMS over all channels; NaN if n < 2 m."""
    integral = np.concatenate([np.zeros_like(samples[:1]), np.cumsum(samples, axis=0)])
    sums = integral[m:] - integral[:-m]
    steps = sums[m:] - sums[:-m]
    return float(np.sqrt(np.mean(steps**2) / 2.0) / m) if steps.size else float("nan")


def correlations(columns: Array) -> Array:
    """Return the correlation matrix (m, m) of the columns of (n, m) samples; zero where a column does not vary."""
    centred = columns - columns.mean(axis=0)
    scale = np.sqrt((centred**2).mean(axis=0))
    scale[scale == 0] = np.inf
    return np.asarray((centred / scale).T @ (centred / scale) / len(columns))


def autocorrelation(columns: Array, lag: int) -> Array:
    """Return the autocorrelation (m,) of each column of (n, m) samples at one lag; zero where a column does not vary."""
    centred = columns - columns.mean(axis=0)
    power = (centred**2).sum(axis=0)
    power[power == 0] = np.inf
    return np.asarray((centred[lag:] * centred[:-lag]).sum(axis=0) / power)
