from imu_reader import *

class NoisyIMU:
    """
    Wrapper that adds realistic noise to IMU readings.

    Typical noise characteristics:
    - Accelerometer: ~0.01-0.1 m/s² standard deviation
    - Gyroscope: ~0.001-0.01 rad/s standard deviation
    """

    def __init__(self, model, data, accel_id, gyro_id,
                 accel_noise_std=0.05, gyro_noise_std=0.005,
                 accel_bias=None, gyro_bias=None):
        self.model = model
        self.data = data
        self.accel_id = accel_id
        self.gyro_id = gyro_id
        self.accel_noise_std = accel_noise_std
        self.gyro_noise_std = gyro_noise_std

        # Random bias (constant offset)
        self.accel_bias = accel_bias if accel_bias is not None else np.random.normal(0, 0.1, 3)
        self.gyro_bias = gyro_bias if gyro_bias is not None else np.random.normal(0, 0.01, 3)

    def read(self):
        """Get noisy IMU readings."""
        accel, gyro = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)

        # Add Gaussian noise
        accel_noisy = accel + np.random.normal(0, np.sqrt(self.accel_noise_std), 3) + self.accel_bias
        gyro_noisy = gyro + np.random.normal(0, np.sqrt(self.gyro_noise_std), 3) + self.gyro_bias

        return accel_noisy, gyro_noisy

# Create noisy IMU
noisy_imu = NoisyIMU(model, data, accel_id, gyro_id)

# Compare clean vs noisy readings
mujoco.mj_step(model, data)
clean_accel, clean_gyro = get_imu_readings(model, data, accel_id, gyro_id)
noisy_accel, noisy_gyro = noisy_imu.read()

print(f"Clean acceleration: {clean_accel}")
print(f"Noisy acceleration: {noisy_accel}")
print(f"Difference: {noisy_accel - clean_accel}")
