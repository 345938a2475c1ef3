from __future__ import annotations

from abc import ABC, abstractmethod

import matplotlib.pyplot as plt
import mujoco
import numpy as np

from imu_reader import MODEL, Vector
from noisy_imu import NoisyIMU


class Filter(ABC):
    @abstractmethod
    def update(self, measurement: Vector) -> Vector:
        """Take one sample in, give one out."""

    def __call__(self, samples: Vector) -> Vector:
        return np.array([self.update(sample) for sample in samples])


class LowPassFilter(Filter):
    """y[n] = alpha x[n] + (1 - alpha) y[n-1]"""

    def __init__(self, alpha: float = 0.1, initial_value: Vector | None = None) -> None:
        self._alpha = alpha
        self._y = None if initial_value is None else np.array(initial_value, dtype=np.float64)

    @property
    def alpha(self) -> float:
        return self._alpha

    def reset(self) -> None:
        self._y = None

    def update(self, measurement: Vector) -> Vector:
        y = measurement if self._y is None else self._alpha * measurement + (1 - self._alpha) * self._y
        self._y = np.array(y)
        return self._y.copy()


def main() -> None:
    model = mujoco.MjModel.from_xml_path(MODEL.as_posix())
    data = mujoco.MjData(model)
    imu = NoisyIMU(model, data, model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id, seed=1)
    raw = np.empty((500, 3))
    for row in raw:
        mujoco.mj_step(model, data)
        row[:] = imu.read().acceleration
    smooth = LowPassFilter(0.1)(raw)
    figure, panel = plt.subplots(figsize=(10, 4))
    panel.plot(raw[:, 2], label="raw", linewidth=0.7)
    panel.plot(smooth[:, 2], label="filtered")
    panel.set(title="z acceleration", xlabel="sample", ylabel="acceleration / (m/s²)")
    panel.legend()
    figure.savefig("filtered_imu.png")


if __name__ == "__main__":
    main()
