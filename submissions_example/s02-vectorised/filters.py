import matplotlib.pyplot as plt
import mujoco
import numpy as np

from imu_reader import MODEL_PATH
from noisy_imu import NoisyIMU


from scipy.signal import lfilter


class LowPassFilter:
    """b = [alpha], a = [1, alpha - 1]; zi carries the state over."""

    def __init__(self, alpha=0.1, initial_value=None):
        self.b, self.a = [alpha], [1.0, alpha - 1.0]
        self.zi = None if initial_value is None else np.atleast_2d((1 - alpha) * np.asarray(initial_value, float))

    def update(self, measurement):
        x = np.atleast_2d(np.asarray(measurement, float))
        if self.zi is None:
            self.zi = -self.a[1] * x
        y, self.zi = lfilter(self.b, self.a, x, axis=0, zi=self.zi)
        return y[0].reshape(np.shape(measurement))


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
