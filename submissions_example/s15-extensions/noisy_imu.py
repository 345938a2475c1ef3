import mujoco
import numpy as np

from imu_reader import MODEL_PATH, get_imu_readings


class NoisyIMU:
    """Clean IMU + constant bias + white noise."""

    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005,
                 accel_bias=None, gyro_bias=None, rng=None):
        self.model, self.data = model, data
        self.accel_id, self.gyro_id = accel_id, gyro_id
        self.accel_noise_std = accel_noise_std
        self.gyro_noise_std = gyro_noise_std
        self.rng = np.random.default_rng() if rng is None else rng
        if accel_bias is None:
            accel_bias = self.rng.normal(0.0, 0.1, size=3)
        if gyro_bias is None:
            gyro_bias = self.rng.normal(0.0, 0.01, size=3)
        self.accel_bias = np.asarray(accel_bias, dtype=float)
        self.gyro_bias = np.asarray(gyro_bias, dtype=float)

    def read(self):
        accel, gyro = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)
        accel = accel + self.accel_bias + self.rng.normal(0.0, self.accel_noise_std, size=3)
        gyro = gyro + self.gyro_bias + self.rng.normal(0.0, self.gyro_noise_std, size=3)
        return accel, gyro


if __name__ == "__main__":
    model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    data = mujoco.MjData(model)
    imu = NoisyIMU(model, data, model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id)
    mujoco.mj_step(model, data)
    print("noisy reading:", *imu.read())
