"""The parts of a submission in several hands, and how they are put together into the sheet's three files."""

from __future__ import annotations

from tests.corpus import sheet

MODEL_PATH = "textbook/assets/robot-models/mujoco/humanoid-sensors.xml"

HEAD = """\
import matplotlib.pyplot as plt
import mujoco
import numpy as np

MODEL_PATH = "textbook/assets/robot-models/mujoco/humanoid-sensors.xml"
"""

# ---------------------------------------------------------------- Step 2: reading

READ_DIM = '''\
def read_sensor(model, data, sensor_id):
    """One sensor's numbers, whatever their count."""
    adr, dim = model.sensor_adr[sensor_id], model.sensor_dim[sensor_id]
    return data.sensordata[adr:adr + dim].copy()


def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    return read_sensor(model, data, accel_sensor_id), read_sensor(model, data, gyro_sensor_id)
'''

READ_NAMED = '''\
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    return data.sensor(accel_sensor_id).data.copy(), data.sensor(gyro_sensor_id).data.copy()
'''

READ_FANCY = '''\
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    start = model.sensor_adr[[accel_sensor_id, gyro_sensor_id]]
    both = data.sensordata[start[:, None] + np.arange(3)]   # fancy indexing copies
    return both[0], both[1]
'''

READ_LISTS = '''\
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    a = model.sensor_adr[accel_sensor_id]
    g = model.sensor_adr[gyro_sensor_id]
    acceleration = [float(data.sensordata[a + k]) for k in range(3)]
    angular_velocity = [float(data.sensordata[g + k]) for k in range(3)]
    return acceleration, angular_velocity
'''

# ---------------------------------------------------------------- Step 3: collecting

IDS = """\
    accel_id = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "torso_accelerometer")
    gyro_id = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "torso_gyroscope")
"""

COLLECT_LOOKUP = (
    '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    """Push the robot and record its IMU."""
'''
    + IDS
    + '''\
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
'''
)

COLLECT_APPEND = '''\
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
        accs.append(acc)
        gyros.append(gyro)
    return dict(time=np.array(times), acceleration=np.array(accs), angular_velocity=np.array(gyros))
'''

COLLECT_WHILE = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    accel_id = model.sensor("torso_accelerometer").id
    gyro_id = model.sensor("torso_gyroscope").id
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    rows = []
    while data.time < duration_seconds:
        mujoco.mj_step(model, data)
        acc, gyro = get_imu_readings(model, data, accel_id, gyro_id)
        rows.append(np.concatenate([[data.time], acc, gyro]))
    table = np.vstack(rows)
    return {"time": table[:, 0], "acceleration": table[:, 1:4], "angular_velocity": table[:, 4:]}
'''

COLLECT_FORWARD_FIRST = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    """Looks at the state, then moves on: sample i belongs to time i*dt."""
    accel_id = model.sensor("torso_accelerometer").id
    gyro_id = model.sensor("torso_gyroscope").id
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    n = int(duration_seconds / model.opt.timestep + 0.5)
    out = {"time": np.zeros(n), "acceleration": np.zeros((n, 3)), "angular_velocity": np.zeros((n, 3))}
    for k in range(n):
        mujoco.mj_forward(model, data)
        out["time"][k] = data.time
        out["acceleration"][k], out["angular_velocity"][k] = get_imu_readings(model, data, accel_id, gyro_id)
        mujoco.mj_step(model, data)
    return out
'''

# ---------------------------------------------------------------- Step 4: plotting

PLOT_LOOP = '''\
def plot_imu_data(imu_data):
    fig, (top, bottom) = plt.subplots(2, 1, figsize=(10, 6), sharex=True)
    t = imu_data["time"]
    for k, axis in enumerate("xyz"):
        top.plot(t, imu_data["acceleration"][:, k], label=f"$a_{axis}$")
        bottom.plot(t, imu_data["angular_velocity"][:, k], label=rf"$\\omega_{axis}$")
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
'''

PLOT_PYPLOT = '''\
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
'''

# ---------------------------------------------------------------- Step 5: noise

NOISE_GENERATOR = '''\
class NoisyIMU:
    """Clean IMU + constant bias + white noise."""

    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005,
                 accel_bias=None, gyro_bias=None, rng=None):
        self.model, self.data = model, data
        self.accel_id, self.gyro_id = accel_id, gyro_id
        self.accel_noise_std = accel_noise_std
        self.gyro_noise_std = gyro_noise_std
        self.rng = np.random.default_rng() if rng is None else rng
        if accel_bias is None:
            accel_bias = self.rng.normal(0.0, 0.1, size=3)
        if gyro_bias is None:
            gyro_bias = self.rng.normal(0.0, 0.01, size=3)
        self.accel_bias = np.asarray(accel_bias, dtype=float)
        self.gyro_bias = np.asarray(gyro_bias, dtype=float)

    def read(self):
        accel, gyro = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)
        accel = accel + self.accel_bias + self.rng.normal(0.0, self.accel_noise_std, size=3)
        gyro = gyro + self.gyro_bias + self.rng.normal(0.0, self.gyro_noise_std, size=3)
        return accel, gyro
'''

# ---------------------------------------------------------------- Step 6: filtering

FILTER_INCREMENT = '''\
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
'''

# ---------------------------------------------------------------- demonstrations

READER_MAIN = '''\
def main():
    model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    data = mujoco.MjData(model)
    for i in range(model.nsensor):
        print(model.sensor(i).name, model.sensor_dim[i])
    plot_imu_data(simulate_and_collect(model, data, duration_seconds=3.0))


if __name__ == "__main__":
    main()
'''

NOISE_MAIN = '''\
if __name__ == "__main__":
    model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    data = mujoco.MjData(model)
    imu = NoisyIMU(model, data, model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id)
    mujoco.mj_step(model, data)
    print("noisy reading:", *imu.read())
'''

COMPARE = '''\
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
'''

NOISE_HEAD = "import mujoco\nimport numpy as np\n\nfrom imu_reader import MODEL_PATH, get_imu_readings\n"
FILTER_HEAD = (
    "import matplotlib.pyplot as plt\nimport mujoco\nimport numpy as np\n\n"
    "from imu_reader import MODEL_PATH\nfrom noisy_imu import NoisyIMU\n"
)


def reader_file(
    read: str = READ_DIM, collect: str = COLLECT_LOOKUP, plot: str = PLOT_LOOP, main: str = READER_MAIN, head: str = HEAD
) -> str:
    return "\n\n".join((head, read, collect, plot, main))


def noise_file(noise: str = NOISE_GENERATOR, main: str = NOISE_MAIN, head: str = NOISE_HEAD) -> str:
    return "\n\n".join((head, noise, main))


def filter_file(low_pass: str = FILTER_INCREMENT, compare: str = COMPARE, head: str = FILTER_HEAD) -> str:
    return "\n\n".join((head, low_pass, compare))


def lab(
    *,
    read: str = READ_DIM,
    collect: str = COLLECT_LOOKUP,
    plot: str = PLOT_LOOP,
    noise: str = NOISE_GENERATOR,
    low_pass: str = FILTER_INCREMENT,
    compare: str = COMPARE,
    head: str = HEAD,
    main: str = READER_MAIN,
) -> dict[str, str]:
    """The sheet's three files from parts; what is not given is sound."""
    return {
        "imu_reader.py": reader_file(read, collect, plot, main, head),
        "noisy_imu.py": noise_file(noise),
        "filters.py": filter_file(low_pass, compare),
    }


def tidy() -> dict[str, str]:
    """Functions, a generator, main guards: nothing runs at import."""
    return lab()


def listy() -> dict[str, str]:
    """Lists that grow, sensors by `data.sensor`, pyplot's state machine."""
    return lab(read=READ_NAMED, collect=COLLECT_APPEND, plot=PLOT_PYPLOT, noise=sheet.NOISY_IMU)


def looping() -> dict[str, str]:
    """A while loop over the simulated time, fancy indexing, the sheet's plot and filter."""
    return lab(read=READ_FANCY, collect=COLLECT_WHILE, plot=sheet.PLOT, low_pass=sheet.LOW_PASS)


def verbatim() -> dict[str, str]:
    """The sheet's own code in three files."""
    return dict(sheet.VERBATIM)


def edit(files: dict[str, str], path: str, *changes: tuple[str, str]) -> dict[str, str]:
    """A copy with passages of one file exchanged; each must be there exactly once.

    Raises
    ------
    ValueError
        If a passage is missing or not unique: the sample would then not have the fault that it claims.
    """
    text = files[path]
    places = []
    for old, new in changes:
        if text.count(old) != 1:
            raise ValueError(f"{path} holds {text.count(old)} of {old!r}, one is needed")
        places.append((text.index(old), old, new))
    pieces, end = [], 0
    for start, old, new in sorted(places):
        if start < end:
            raise ValueError(f"{old!r} overlaps another passage")
        pieces += [text[end:start], new]
        end = start + len(old)
    return {**files, path: "".join([*pieces, text[end:]])}
