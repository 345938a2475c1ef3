from __future__ import annotations

import mujoco
import numpy as np

from imu_reader import MujocoImu, Reading, Vector


class SensorError:
    """A constant offset and white noise."""

    def __init__(self, std: float, bias: Vector | None, bias_std: float, rng: np.random.Generator) -> None:
        self._std = std
        self._rng = rng
        self.bias = rng.normal(0.0, bias_std, 3) if bias is None else np.asarray(bias, dtype=np.float64).copy()

    def __call__(self, clean: Vector) -> Vector:
        return clean + self.bias + self._rng.normal(scale=self._std, size=clean.shape)


class NoisyIMU:
    """An IMU as it comes out of a box."""

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        accel_id: int,
        gyro_id: int,
        accel_noise_std: float = 0.05,
        gyro_noise_std: float = 0.005,
        accel_bias: Vector | None = None,
        gyro_bias: Vector | None = None,
        *,
        seed: int | None = None,
    ) -> None:
        rng = np.random.default_rng(seed)
        self._imu = MujocoImu(model, data, accel_id, gyro_id)
        self._errors = (
            SensorError(accel_noise_std, accel_bias, 0.1, rng),
            SensorError(gyro_noise_std, gyro_bias, 0.01, rng),
        )

    def read(self) -> Reading:
        return Reading(*(error(clean) for error, clean in zip(self._errors, self._imu.read())))
