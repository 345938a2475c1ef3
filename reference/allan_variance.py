"""Extension: Allan deviation, which tells kinds of sensor noise apart by how averaging changes them.

On a double logarithmic plot over the averaging time τ each kind has its slope: quantisation −1, white noise −1/2, bias
instability 0, random walk +1/2, drift +1.

References
----------
Riley, W. J. (2008). Handbook of Frequency Stability Analysis. NIST Special Publication 1065. Equations (6) and (7): the Allan
    variance; equation (11): its overlapping estimate from integrated samples.
IEEE Std 952-1997, Annex C: the same for gyroscopes, with the slopes of the kinds of noise.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

PER_DECADE = 12  # averaging times, as closely as a plot needs them


def allan_deviation(samples: ArrayLike, sample_rate_hz: float) -> tuple[FloatArray, FloatArray]:
    """Return the overlapping Allan deviation at averaging times that are spread evenly on a logarithmic axis.

    With the integral x of the samples and τ = m / sample rate, NIST SP 1065, equation (11): σ²(τ) = Σ (x[k + 2m] − 2 x[k + m] +
    x[k])² / (2 τ² · number of terms).

    Parameters
    ----------
    samples : (n,) or (n, 3) array_like
        Readings at a constant rate, n at least 2; each column is treated by itself.
    sample_rate_hz : float
        Readings a second.

    Returns
    -------
    taus_s : (k,) ndarray of float64
        Averaging times in s, from one sample to half the record, increasing.
    adev : (k,) or (k, 3) ndarray of float64
        Allan deviation, in the unit of the samples.

    Raises
    ------
    ValueError
        If there are fewer than two samples, or the rate is not positive.
    """
    values = np.asarray(samples, dtype=np.float64)
    if len(values) < 2 or not sample_rate_hz > 0:
        raise ValueError("an Allan deviation needs two samples or more, and a positive sample rate")
    integral = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)]) / sample_rate_hz
    sizes = cluster_sizes(len(values))
    taus = sizes / sample_rate_hz
    return taus, np.array([_deviation(integral, int(m), tau) for m, tau in zip(sizes, taus, strict=True)])


def cluster_sizes(n: int) -> NDArray[np.int64]:
    """Return the numbers of samples to average, from 1 to n // 2, about `PER_DECADE` for each factor of ten."""
    largest = n // 2
    count = int(np.ceil(PER_DECADE * np.log10(largest))) + 2
    return np.unique(np.geomspace(1, largest, count).round().astype(np.int64))


def _deviation(integral: FloatArray, m: int, tau: float) -> FloatArray:
    second = integral[2 * m :] - 2.0 * integral[m:-m] + integral[: -2 * m]
    return np.asarray(np.sqrt(np.mean(second**2, axis=0) / 2.0) / tau, dtype=np.float64)


def noise_density(taus_s: FloatArray, adev: FloatArray) -> float:
    """Return the density N of white noise in the samples' unit times √s: the deviation at τ = 1 s on a line of slope −1/2.

    For noise that is white with standard deviation σ at the rate f, N = σ / √f. The line is fitted to one axis, `adev` (k,), over
    the shortest decade of averaging times `taus_s` (k,).
    """
    short = taus_s <= 10.0 * taus_s[0]
    return float(np.exp(np.mean(np.log(adev[short]) + 0.5 * np.log(taus_s[short]))))


def plot_allan(taus_s: FloatArray, adev: FloatArray, path: Path) -> None:
    """Draw the deviation of three axes (k, 3) over the averaging time, both logarithmic, and save the picture."""
    import matplotlib.pyplot as plt  # noqa: PLC0415 - only the demonstration draws

    fig, axes = plt.subplots(figsize=(8, 5))
    for column, label in zip(adev.T, "XYZ", strict=True):
        axes.loglog(taus_s, column, label=label)
    axes.set(title="Allan deviation of a noisy IMU", xlabel="Averaging time (s)", ylabel="Allan deviation (m/s²)")
    axes.legend()
    axes.grid(True, which="both", alpha=0.3)
    fig.savefig(path, dpi=100)
    plt.close(fig)


def main() -> None:
    import mujoco  # noqa: PLC0415 - the analysis itself needs no simulator
    from imu_reader import MODEL_PATH, sensor_id  # type: ignore[import-not-found]  # noqa: PLC0415
    from noisy_imu import NoisyIMU  # type: ignore[import-not-found]  # noqa: PLC0415

    model = mujoco.MjModel.from_xml_path(str(MODEL_PATH))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    imu = NoisyIMU(model, data, sensor_id(model, "torso_accelerometer"), sensor_id(model, "torso_gyroscope"))
    rate = 1.0 / model.opt.timestep
    taus, adev = allan_deviation([imu.read()[0] for _ in range(20_000)], rate)
    plot_allan(taus, adev, Path("allan_deviation.png"))
    density = noise_density(taus, adev[:, 0])
    print(
        f"white noise of {density:.5f} m/s²·√s, a standard deviation of {density * rate**0.5:.4f} m/s² at {rate:.0f} Hz"
    )


if __name__ == "__main__":
    main()
