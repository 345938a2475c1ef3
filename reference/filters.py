"""Lab 04-01, Step 6: a low-pass filter for noisy readings.

Run as a script it filters a noisy IMU on the standing robot and saves `filtered_imu.png`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

GRAVITY_READING = -9.81  # m/s² on a z axis that points down, standing still


class LowPassFilter:
    """Smooth measurements by an exponential moving average: y[n] = alpha x[n] + (1 − alpha) y[n−1].

    Parameters
    ----------
    alpha : float
        Weight of the newest measurement, in (0, 1]. Smaller is smoother and slower: a step is followed to 63 % after
        about 1 / alpha samples.
    initial_value : array_like, optional
        y before the first measurement. Left out, the first measurement itself is the first output.
    """

    def __init__(self, alpha: float = 0.1, initial_value: ArrayLike | None = None) -> None:
        self.alpha = alpha
        self._value: FloatArray | None = None
        if initial_value is not None:
            self._value = np.array(initial_value, dtype=np.float64)

    def update(self, measurement: ArrayLike) -> FloatArray:
        """Take in one measurement and return the new filtered value, a copy of the same shape."""
        newest: FloatArray = np.array(measurement, dtype=np.float64)
        if self._value is None:
            self._value = newest
        else:
            self._value = self.alpha * newest + (1.0 - self.alpha) * self._value
        return np.array(self._value)


def plot_comparison(raw: FloatArray, filtered: FloatArray) -> None:
    """Draw a raw and a filtered channel, both (n,) in m/s², over each other and save `filtered_imu.png`, as Step 6 asks."""
    import matplotlib.pyplot as plt  # noqa: PLC0415 - only the demonstration draws

    fig, axes = plt.subplots(figsize=(10, 4))
    axes.plot(raw, alpha=0.5, linewidth=1.0, label="Raw z acceleration")
    axes.plot(filtered, linewidth=1.6, label="Filtered z acceleration")
    axes.axhline(GRAVITY_READING, color="k", linestyle="--", alpha=0.3, label="Gravity")
    axes.set(title="Low-pass filtering of noisy IMU data", xlabel="Sample", ylabel="Acceleration (m/s²)")
    axes.legend(loc="upper right")
    axes.grid(True, alpha=0.4)
    fig.tight_layout()
    fig.savefig("filtered_imu.png", dpi=100)
    plt.close(fig)


def main() -> None:
    import mujoco  # noqa: PLC0415 - the filter itself needs no simulator
    from imu_reader import MODEL_PATH, sensor_id  # type: ignore[import-not-found]  # noqa: PLC0415
    from noisy_imu import NoisyIMU  # type: ignore[import-not-found]  # noqa: PLC0415

    model = mujoco.MjModel.from_xml_path(str(MODEL_PATH))
    data = mujoco.MjData(model)
    imu = NoisyIMU(model, data, sensor_id(model, "torso_accelerometer"), sensor_id(model, "torso_gyroscope"))
    smoother = LowPassFilter(alpha=0.1)
    raw, filtered = np.zeros((500, 3)), np.zeros((500, 3))
    for i in range(len(raw)):
        mujoco.mj_step(model, data)
        raw[i], _ = imu.read()
        filtered[i] = smoother.update(raw[i])
    plot_comparison(raw[:, 2], filtered[:, 2])
    print("Standard deviation of z (m/s²): raw", raw[:, 2].std().round(4), "filtered", filtered[50:, 2].std().round(4))


if __name__ == "__main__":
    main()
