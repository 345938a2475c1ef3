import mujoco
import numpy as np

from imu_reader import MODEL_PATH, get_imu_readings


class NoisyIMU(object):
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005,
                 accel_bias=None, gyro_bias=None, seed=None):
        self.args = (model, data, accel_id, gyro_id)
        self.std = np.repeat([accel_noise_std, gyro_noise_std], 3)
        self.generator = np.random.Generator(np.random.PCG64(seed))
        drawn = self.generator.uniform(-1, 1, 6) * np.repeat([0.1, 0.01], 3)
        self.bias = drawn.copy()
        if accel_bias is not None:
            self.bias[:3] = accel_bias
        if gyro_bias is not None:
            self.bias[3:] = gyro_bias

    def read(self):
        clean = np.concatenate(get_imu_readings(*self.args))
        noisy = clean + self.bias + self.std * self.generator.standard_normal(6)
        return noisy[:3], noisy[3:]


if __name__ == "__main__":
    model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    data = mujoco.MjData(model)
    imu = NoisyIMU(model, data, model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id)
    mujoco.mj_step(model, data)
    print("noisy reading:", *imu.read())
