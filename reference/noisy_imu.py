"""Lab 04-01, Step 5: an IMU with noise and bias.

Each reading is the true one + a constant bias + white Gaussian noise, every axis of either sensor on its own.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

try:
    from .imu_reader import MODEL_PATH, get_imu_readings, sensor_id
except ImportError:  # handed in as loose files, as students do, there is no package around it
    from imu_reader import MODEL_PATH, get_imu_readings, sensor_id  # type: ignore[import-not-found, no-redef]

FloatArray = NDArray[np.float64]

ACCEL_BIAS_STD = 0.1  # m/s²: how much the constant offset differs from one device to the next
GYRO_BIAS_STD = 0.01  # rad/s


class NoisyIMU:
    """Read an IMU of the simulation with the noise and the constant bias of a real device.

    Parameters
    ----------
    model, data
        The simulation; `data` is only read.
    accel_id, gyro_id : int
        Sensor ids.
    accel_noise_std, gyro_noise_std : float
        Standard deviation of the white noise, in m/s² and rad/s.
    accel_bias, gyro_bias : (3,) array_like, optional
        Constant offsets, in m/s² and rad/s. Left out, each `NoisyIMU` draws its own at random.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        accel_id: int,
        gyro_id: int,
        accel_noise_std: float = 0.05,
        gyro_noise_std: float = 0.005,
        accel_bias: ArrayLike | None = None,
        gyro_bias: ArrayLike | None = None,
    ) -> None:
        self.model, self.data = model, data
        self.accel_id, self.gyro_id = accel_id, gyro_id
        self.accel_noise_std, self.gyro_noise_std = accel_noise_std, gyro_noise_std
        self._rng = np.random.default_rng()
        self.accel_bias = self._bias(accel_bias, ACCEL_BIAS_STD)
        self.gyro_bias = self._bias(gyro_bias, GYRO_BIAS_STD)

    def _bias(self, given: ArrayLike | None, std: float) -> FloatArray:
        return self._rng.normal(0.0, std, 3) if given is None else np.array(given, dtype=np.float64)

    def read(self) -> tuple[FloatArray, FloatArray]:
        """Return one noisy reading: acceleration (3,) in m/s² and angular velocity (3,) in rad/s, in the site's frame."""
        acceleration, angular_velocity = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)
        return (
            acceleration + self.accel_bias + self._rng.normal(0.0, self.accel_noise_std, 3),
            angular_velocity + self.gyro_bias + self._rng.normal(0.0, self.gyro_noise_std, 3),
        )


def main() -> None:
    model = mujoco.MjModel.from_xml_path(str(MODEL_PATH))
    data = mujoco.MjData(model)
    accel_id, gyro_id = sensor_id(model, "torso_accelerometer"), sensor_id(model, "torso_gyroscope")
    imu = NoisyIMU(model, data, accel_id, gyro_id)
    mujoco.mj_step(model, data)
    clean, _ = get_imu_readings(model, data, accel_id, gyro_id)
    noisy, _ = imu.read()
    print("Clean acceleration (m/s²):", clean.round(3))
    print("Noisy acceleration (m/s²):", noisy.round(3))
    print("Difference (m/s²):        ", (noisy - clean).round(3))


if __name__ == "__main__":
    main()
