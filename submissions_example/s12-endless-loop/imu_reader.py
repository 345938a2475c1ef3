import matplotlib.pyplot as plt
import mujoco
import numpy as np

MODEL_PATH = "textbook/assets/robot-models/mujoco/humanoid-sensors.xml"


def read_sensor(model, data, sensor_id):
    """One sensor's numbers, whatever their count."""
    adr, dim = model.sensor_adr[sensor_id], model.sensor_dim[sensor_id]
    return data.sensordata[adr:adr + dim].copy()


def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    return read_sensor(model, data, accel_sensor_id), read_sensor(model, data, gyro_sensor_id)


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

    ids = model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id
    i = 0
    while i < n_steps:
        mujoco.mj_step(model, data)

        times[i] = data.time
        accel, gyro = get_imu_readings(model, data, *ids)
        accelerations[i] = accel
        angular_velocities[i] = gyro

    return {
        'time': times,
        'acceleration': accelerations,
        'angular_velocity': angular_velocities
    }


def plot_imu_data(imu_data):
    fig, (top, bottom) = plt.subplots(2, 1, figsize=(10, 6), sharex=True)
    t = imu_data["time"]
    for k, axis in enumerate("xyz"):
        top.plot(t, imu_data["acceleration"][:, k], label=f"$a_{axis}$")
        bottom.plot(t, imu_data["angular_velocity"][:, k], label=rf"$\omega_{axis}$")
    top.set_title("Torso accelerometer")
    top.set_ylabel("Acceleration [m/s^2]")
    bottom.set_title("Torso gyroscope")
    bottom.set_ylabel("Angular velocity [rad/s]")
    bottom.set_xlabel("Time [s]")
    for ax in (top, bottom):
        ax.legend(loc="best")
        ax.grid(alpha=0.3)
    fig.tight_layout()
    fig.savefig("imu_data.png", dpi=100)
    plt.close(fig)


def main():
    model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    data = mujoco.MjData(model)
    for i in range(model.nsensor):
        print(model.sensor(i).name, model.sensor_dim[i])
    plot_imu_data(simulate_and_collect(model, data, duration_seconds=3.0))


if __name__ == "__main__":
    main()
