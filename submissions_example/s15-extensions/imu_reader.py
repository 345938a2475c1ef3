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


def simulate_and_collect(model, data, duration_seconds=5.0):
    """Push the robot and record its IMU."""
    accel_id = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "torso_accelerometer")
    gyro_id = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "torso_gyroscope")
    n_steps = int(round(duration_seconds / model.opt.timestep))
    time = np.empty(n_steps)
    acceleration = np.empty((n_steps, 3))
    angular_velocity = np.empty((n_steps, 3))

    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5

    for i in range(n_steps):
        mujoco.mj_step(model, data)
        time[i] = data.time
        acceleration[i], angular_velocity[i] = get_imu_readings(model, data, accel_id, gyro_id)

    return {"time": time, "acceleration": acceleration, "angular_velocity": angular_velocity}


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
