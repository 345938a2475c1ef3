import matplotlib.pyplot as plt
import mujoco
import numpy as np


def _adr(model, name):
    return model.sensor_adr[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, name)]

from matplotlib.animation import FuncAnimation


def live_plot(model, data, duration_seconds):
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    fig, (top, bottom) = plt.subplots(2, 1, sharex=True)
    accel, gyro = _adr(model, "torso_accelerometer"), _adr(model, "torso_gyroscope")
    upper, lower = [top.plot([], [])[0] for _ in range(3)], [bottom.plot([], [])[0] for _ in range(3)]
    t, a, w = [], [], []
    per_frame = 10

    def update(frame):
        for _ in range(per_frame):
            mujoco.mj_step(model, data)
            t.append(data.time)
            a.append(data.sensordata[accel:accel + 3].copy())
            w.append(data.sensordata[gyro:gyro + 3].copy())
        for line, values in zip(upper + lower, np.hstack([a, w]).T):
            line.set_data(t, values)
        top.set_xlim(0, max(t[-1], 0.1))
        return upper + lower

    frames = int(duration_seconds / model.opt.timestep / per_frame)
    animation = FuncAnimation(fig, update, frames=frames, interval=20, repeat=False)
    plt.show()
    return animation
