"""Parts that do nothing: the form is there, the thing itself is not. What each may keep at most is said beside it."""

from __future__ import annotations

from dataclasses import dataclass

from tests.corpus.pieces import verbatim

_HEAD = {
    "imu_reader.py": "import mujoco\nimport numpy as np\nimport matplotlib.pyplot as plt\n",
    "noisy_imu.py": "import numpy as np\nfrom imu_reader import get_imu_readings\n",
    "filters.py": "import numpy as np\n",
}


@dataclass(frozen=True)
class Nothing:
    """A submission, sound but for one part, which does nothing; `most` points are left of that part's criterion."""

    name: str
    criterion: str
    file: str
    source: str
    most: float

    @property
    def files(self) -> dict[str, str]:
        return {**verbatim(), self.file: f"{verbatim()[self.file]}\n\n{_HEAD[self.file]}{self.source}"}


def _reader(name: str, body: str) -> Nothing:
    head = "def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):\n"
    return Nothing(f"reader-{name}", "sensor_access", "imu_reader.py", f"{head}    {body}\n", 4)


def _filter(name: str, body: str) -> Nothing:
    source = (
        "class LowPassFilter:\n"
        "    def __init__(self, alpha=0.1, initial_value=None):\n"
        "        self.alpha, self.value = alpha, initial_value\n"
        "    def update(self, measurement):\n"
        f"        {body}\n"
    )
    return Nothing(f"filter-{name}", "filtering", "filters.py", source, 4)


def _noisy(name: str, body: str) -> Nothing:
    source = (
        "class NoisyIMU:\n"
        "    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005,\n"
        "                 accel_bias=None, gyro_bias=None):\n"
        "        self.model, self.data, self.accel_id, self.gyro_id = model, data, accel_id, gyro_id\n"
        "    def read(self):\n"
        f"        {body}\n"
    )
    return Nothing(f"noise-{name}", "noise_model", "noisy_imu.py", source, 4)


def _collector(name: str, body: str) -> Nothing:
    source = (
        "def simulate_and_collect(model, data, duration_seconds=5.0):\n"
        "    dt = model.opt.timestep\n"
        "    n = int(duration_seconds / dt)\n"
        "    times = (np.arange(n) + 1) * dt\n"
        f"    {body}\n"
        "    return {'time': times, 'acceleration': accelerations, 'angular_velocity': angular_velocities}\n"
    )
    return Nothing(f"collector-{name}", "data_collection", "imu_reader.py", source, 6)


def _plot(name: str, body: str) -> Nothing:
    source = (
        "def plot_imu_data(imu_data):\n"
        "    fig, axes = plt.subplots(2, 1, figsize=(12, 8), sharex=True)\n"
        f"    {body}\n"
        "    axes[0].set_title('Accelerometer'); axes[1].set_title('Gyroscope')\n"
        "    axes[0].set_ylabel('Acceleration (m/s²)'); axes[1].set_ylabel('Angular velocity (rad/s)')\n"
        "    axes[1].set_xlabel('Time (s)')\n"
        "    plt.savefig('imu_data.png', dpi=150)\n"
    )
    return Nothing(f"plot-{name}", "visualization", "imu_reader.py", source, 6)


_STANDING = "np.tile([0.0, 0.0, -9.81], (n, 1))"
NOTHING: tuple[Nothing, ...] = (
    _reader("zero", "return np.zeros(3), np.zeros(3)"),
    _reader("gravity", "return np.array([0.0, 0.0, -9.81]), np.zeros(3)"),
    _reader("random", "return np.random.normal(0, 1, 3), np.random.normal(0, 1, 3)"),
    _reader("random-about-gravity", "return np.array([0, 0, -9.81]) + np.random.normal(0, 0.1, 3), np.random.normal(0, 0.01, 3)"),
    _reader("counter", "get_imu_readings.n = n = getattr(get_imu_readings, 'n', 0.0) + 1; return np.full(3, n), np.full(3, n)"),
    _reader("no-numbers-beside-a-constant", "return np.full(3, np.pi), np.full(3, np.nan)"),
    _filter("identity", "return measurement.copy()"),
    _filter("half", "return 0.5 * measurement"),
    _filter("zero", "return np.zeros(3)"),
    _filter("first", "self.value = measurement.copy() if self.value is None else self.value; return self.value.copy()"),
    _filter("tanh", "return np.tanh(measurement)"),
    _filter("square", "return measurement * measurement"),
    _filter("clip", "return np.clip(measurement, -1, 1)"),
    _filter("rounds", "return np.round(measurement, 3)"),
    _filter("fades", "self.value = measurement.copy() if self.value is None else 0.99 * self.value; return self.value.copy()"),
    _filter("random", "return np.random.normal(0, 1, 3)"),
    _noisy("clean", "return get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)"),
    _noisy("zero", "return np.zeros(3), np.zeros(3)"),
    _noisy("constant", "return np.array([0.0, 0.0, -9.81]), np.zeros(3)"),
    _noisy("counter", "self.n = getattr(self, 'n', 0) + 1; return np.full(3, self.n), np.full(3, self.n)"),
    _noisy("counter-of-the-class", "NoisyIMU.n = getattr(NoisyIMU, 'n', 0) + 1; return np.full(3, NoisyIMU.n), np.full(3, NoisyIMU.n)"),
    _noisy("random", "return np.random.normal(0, 9, 3), np.random.normal(0, 9, 3)"),
    _noisy("constant-offset", "a, g = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id); return a + 0.1, g + 0.1"),
    _collector("zeros", "accelerations, angular_velocities = np.zeros((n, 3)), np.zeros((n, 3))"),
    _collector("one-row-of-zeros", "times, accelerations, angular_velocities = times[:1], np.zeros((1, 3)), np.zeros((1, 3))"),
    _collector("standing", f"accelerations, angular_velocities = {_STANDING}, np.zeros((n, 3))"),
    _collector("random", "accelerations, angular_velocities = np.random.normal(0, 1, (n, 3)), np.random.normal(0, 1, (n, 3))"),
    _plot("axes", "pass"),
    _plot("zeros", "[a.plot(imu_data['time'], 0 * imu_data['acceleration'][:, i], label='XYZ'[i]) for a in axes for i in range(3)]"),
    _plot("noise", "[a.plot(np.random.normal(0, 1, 300), label='XYZ'[i]) for a in axes for i in range(3)]; [a.legend() for a in axes]"),
)  # fmt: skip
