import numpy as np


def allan_deviation(samples, sample_rate_hz):
    """Overlapping, from the integrated angle as sensor makers' notes do it; one value of the integral fewer."""
    tau0 = 1.0 / sample_rate_hz
    theta = np.cumsum(samples, axis=0) * tau0
    n = len(theta)
    m = np.unique(np.ceil(np.logspace(0, np.log10((n - 1) / 2), 100))).astype(int)
    m = m[2 * m < n]
    variance = [
        np.sum((theta[2 * k:] - 2 * theta[k:-k] + theta[:-2 * k]) ** 2, axis=0) / (2 * (k * tau0) ** 2 * (n - 2 * k))
        for k in m
    ]
    return m * tau0, np.sqrt(variance)
