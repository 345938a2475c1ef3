import matplotlib.pyplot as plt
import mujoco
import numpy as np

from imu_reader import MODEL_PATH
from noisy_imu import NoisyIMU


class LowPassFilter:
    """First-order low pass: moves a fraction alpha of the way to each new sample."""

    def __init__(self, alpha=0.1, initial_value=None):
        self.alpha = alpha
        self.state = None if initial_value is None else np.array(initial_value, dtype=float)

    def update(self, measurement):
        x = np.array(measurement, dtype=float)
        if self.state is None:
            self.state = x
        else:
            self.state = self.state + self.alpha * (x - self.state)
        return self.state.copy()


def compare(n=500):
    """Filter a noisy, standing robot and plot it against the raw signal."""
    model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    data = mujoco.MjData(model)
    imu = NoisyIMU(model, data, model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id)
    low_pass = LowPassFilter(alpha=0.1)
    t, raw, smooth = [], [], []
    for _ in range(n):
        mujoco.mj_step(model, data)
        accel, _ = imu.read()
        t.append(data.time)
        raw.append(accel)
        smooth.append(low_pass.update(accel))
    fig, ax = plt.subplots(figsize=(10, 4))
    ax.plot(t, np.array(raw)[:, 2], alpha=0.5, label="raw z")
    ax.plot(t, np.array(smooth)[:, 2], label="filtered z")
    ax.set_xlabel("Time (s)")
    ax.set_ylabel("Acceleration (m/s²)")
    ax.set_title("Raw and filtered acceleration")
    ax.legend()
    fig.savefig("filtered_imu.png", dpi=100)
    plt.close(fig)


if __name__ == "__main__":
    compare()
