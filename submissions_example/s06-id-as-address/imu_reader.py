import mujoco
import numpy as np

# Load the model
model = mujoco.MjModel.from_xml_path("textbook/assets/robot-models/mujoco/humanoid-sensors.xml")
data = mujoco.MjData(model)

# List all sensors
print("Available sensors:")
for i in range(model.nsensor):
    name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, i)
    sensor_type = model.sensor_type[i]
    dim = model.sensor_dim[i]
    print(f"  {name}: type={sensor_type}, dim={dim}")

def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    """
    Extract accelerometer and gyroscope readings from sensor data.

    Args:
        model: MuJoCo model
        data: MuJoCo data
        accel_sensor_id: Sensor ID for accelerometer
        gyro_sensor_id: Sensor ID for gyroscope

    Returns:
        Tuple of (acceleration [3], angular_velocity [3])
    """
    # Get sensor data addresses
    accel_adr = model.sensor_adr[accel_sensor_id]
    gyro_adr = model.sensor_adr[gyro_sensor_id]

    # Extract readings (each is 3D)
    acceleration = data.sensordata[accel_sensor_id:accel_sensor_id+3].copy()
    angular_velocity = data.sensordata[gyro_sensor_id:gyro_sensor_id+3].copy()

    return acceleration, angular_velocity

# Get sensor IDs
accel_id = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "torso_accelerometer")
gyro_id = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "torso_gyroscope")

# Step simulation and read sensors
mujoco.mj_step(model, data)
accel, gyro = get_imu_readings(model, data, accel_id, gyro_id)
print(f"Acceleration: {accel}")
print(f"Angular velocity: {gyro}")

import matplotlib.pyplot as plt

def simulate_and_collect(model, data, duration_seconds=5.0):
    """
    Run simulation and collect IMU data.

    Returns:
        Dictionary with time, acceleration, and angular velocity arrays
    """
    dt = model.opt.timestep
    n_steps = int(duration_seconds / dt)

    # Pre-allocate arrays
    times = np.zeros(n_steps)
    accelerations = np.zeros((n_steps, 3))
    angular_velocities = np.zeros((n_steps, 3))

    # Reset simulation
    mujoco.mj_resetData(model, data)

    # Apply initial perturbation (push the robot)
    data.qvel[0] = 0.5  # Forward velocity

    for i in range(n_steps):
        mujoco.mj_step(model, data)

        times[i] = data.time
        accel, gyro = get_imu_readings(model, data, accel_id, gyro_id)
        accelerations[i] = accel
        angular_velocities[i] = gyro

    return {
        'time': times,
        'acceleration': accelerations,
        'angular_velocity': angular_velocities
    }

# Collect data
imu_data = simulate_and_collect(model, data, duration_seconds=3.0)

def plot_imu_data(imu_data):
    """Plot accelerometer and gyroscope data."""
    fig, axes = plt.subplots(2, 1, figsize=(12, 8), sharex=True)

    # Accelerometer plot
    axes[0].plot(imu_data['time'], imu_data['acceleration'][:, 0], label='X')
    axes[0].plot(imu_data['time'], imu_data['acceleration'][:, 1], label='Y')
    axes[0].plot(imu_data['time'], imu_data['acceleration'][:, 2], label='Z')
    axes[0].set_ylabel('Acceleration (m/s²)')
    axes[0].set_title('Accelerometer Readings')
    axes[0].legend()
    axes[0].grid(True)
    axes[0].axhline(y=-9.81, color='k', linestyle='--', alpha=0.3, label='Gravity')

    # Gyroscope plot
    axes[1].plot(imu_data['time'], imu_data['angular_velocity'][:, 0], label='Roll rate')
    axes[1].plot(imu_data['time'], imu_data['angular_velocity'][:, 1], label='Pitch rate')
    axes[1].plot(imu_data['time'], imu_data['angular_velocity'][:, 2], label='Yaw rate')
    axes[1].set_xlabel('Time (s)')
    axes[1].set_ylabel('Angular Velocity (rad/s)')
    axes[1].set_title('Gyroscope Readings')
    axes[1].legend()
    axes[1].grid(True)

    plt.tight_layout()
    plt.savefig('imu_data.png', dpi=150)
    plt.show()

plot_imu_data(imu_data)
