import matplotlib.pyplot as plt
import mujoco
import numpy as np

MODEL_PATH = "textbook/assets/robot-models/mujoco/humanoid-sensors.xml"


def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    return data.sensor(accel_sensor_id).data.copy(), data.sensor(gyro_sensor_id).data.copy()


def simulate_and_collect(model, data, duration_seconds=5.0):
    accel_id = model.sensor("torso_accelerometer").id
    gyro_id = model.sensor("torso_gyroscope").id
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    times, accs, gyros = [], [], []
    for _ in range(int(np.ceil(duration_seconds / model.opt.timestep - 1e-9))):
        mujoco.mj_step(model, data)
        acc, gyro = get_imu_readings(model, data, accel_id, gyro_id)
        times.append(data.time)
        accs.append(data.sensor("torso_accelerometer").data)
        gyros.append(data.sensor("torso_gyroscope").data)
    return dict(time=np.array(times), acceleration=np.array(accs), angular_velocity=np.array(gyros))


def plot_imu_data(imu_data):
    plt.figure(figsize=(9, 7))

    plt.subplot(2, 1, 1)
    plt.plot(imu_data["time"], imu_data["acceleration"])
    plt.title("Accelerometer")
    plt.xlabel("time / s")
    plt.ylabel("acceleration / (m/s²)")
    plt.legend(["x", "y", "z"])

    plt.subplot(2, 1, 2)
    plt.plot(imu_data["time"], imu_data["angular_velocity"])
    plt.title("Gyroscope")
    plt.xlabel("time / s")
    plt.ylabel("angular rate / (rad/s)")
    plt.legend(["x", "y", "z"])

    plt.tight_layout()
    plt.savefig("imu_data.png")
    plt.show()


def main():
    model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    data = mujoco.MjData(model)
    for i in range(model.nsensor):
        print(model.sensor(i).name, model.sensor_dim[i])
    plot_imu_data(simulate_and_collect(model, data, duration_seconds=3.0))


if __name__ == "__main__":
    main()
