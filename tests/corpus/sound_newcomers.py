"""Sound submissions in hands that came late: written against the contract alone, after the checks."""



from __future__ import annotations

from tests.corpus.pieces import (
    COLLECT_LOOKUP,
    COMPARE,
    FILTER_INCREMENT,
    HEAD,
    IDS,
    NOISE_GENERATOR,
    PLOT_LOOP,
    edit,
    lab,
    looping,
    tidy,
    verbatim,
)

_READ = "def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):\n"
_LOOP = '''\
    for i in range(n_steps):
        mujoco.mj_step(model, data)
        time[i] = data.time
        acceleration[i], angular_velocity[i] = get_imu_readings(model, data, accel_id, gyro_id)

    return {"time": time, "acceleration": acceleration, "angular_velocity": angular_velocity}
'''

READ_TAKE = _READ + '''\
    start, size = model.sensor_adr, model.sensor_dim
    return tuple(np.take(data.sensordata, range(start[i], start[i] + size[i])) for i in (accel_sensor_id, gyro_sensor_id))
'''

READ_SPLIT = _READ + '''\
    """All sensors at once, each in an array of its own."""
    parts = np.split(np.array(data.sensordata), np.cumsum(model.sensor_dim)[:-1])
    return parts[accel_sensor_id], parts[gyro_sensor_id]
'''

READ_CACHED_SLICES = '''\
import functools


@functools.lru_cache(maxsize=None)
def _slice(model, sensor_id):
    first = int(model.sensor_adr[sensor_id])
    return slice(first, first + int(model.sensor_dim[sensor_id]))


''' + _READ + '''\
    return data.sensordata[_slice(model, accel_sensor_id)] * 1.0, data.sensordata[_slice(model, gyro_sensor_id)] * 1.0
'''

READ_CHECKS_ITS_ARGUMENTS = '''\
class SensorError(ValueError):
    pass


''' + _READ + '''\
    for kind, i in (("accelerometer", accel_sensor_id), ("gyroscope", gyro_sensor_id)):
        if i is None or i < 0:
            names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, k) for k in range(model.nsensor)]
            raise SensorError(f"no {kind}; the model has {names}")
        if model.sensor_dim[i] != 3:
            raise SensorError(f"{kind} with {model.sensor_dim[i]} numbers")
    if model.sensor_type[accel_sensor_id] != mujoco.mjtSensor.mjSENS_ACCELEROMETER:
        raise SensorError("that is no accelerometer")
    out = np.empty((2, 3))
    for row, i in zip(out, (accel_sensor_id, gyro_sensor_id)):
        row[...] = data.sensordata[model.sensor_adr[i]:][:3]
    return out[0], out[1]
'''

COLLECT_GENERATOR = '''\
def samples(model, data, steps):
    """Step, read, hand over; the caller keeps what it wants."""
''' + IDS + '''\
    for _ in range(steps):
        mujoco.mj_step(model, data)
        yield (data.time, *get_imu_readings(model, data, accel_id, gyro_id))


def simulate_and_collect(model, data, duration_seconds=5.0):
    mujoco.mj_resetData(model, data)
    data.qvel[:1] = 0.5
    steps = round(duration_seconds / model.opt.timestep)
    names = ("time", "acceleration", "angular_velocity")
    return {name: np.asarray(column) for name, column in zip(names, zip(*samples(model, data, steps)))}
'''

COLLECT_STRUCTURED = '''\
ROW = np.dtype([("time", float), ("acceleration", float, 3), ("angular_velocity", float, 3)])


def simulate_and_collect(model, data, duration_seconds=5.0):
''' + IDS + '''\
    mujoco.mj_resetData(model, data)
    data.qvel += 0.5 * np.eye(model.nv)[0]
    table = np.zeros(int(np.rint(duration_seconds / model.opt.timestep)), ROW)
    for row in table:
        mujoco.mj_step(model, data)
        row["time"] = data.time
        row["acceleration"], row["angular_velocity"] = get_imu_readings(model, data, accel_id, gyro_id)
    return {name: table[name] for name in ROW.names}
'''

COLLECT_KEYWORD_IDS = COLLECT_LOOKUP.replace(
    "def simulate_and_collect(model, data, duration_seconds=5.0):", "def simulate_and_collect(model, data, duration_seconds=5.0, *, accel_id=None, gyro_id=None, verbose=False):"
).replace(IDS, '''\
    if accel_id is None:
        accel_id = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "torso_accelerometer")
    if gyro_id is None:
        gyro_id = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "torso_gyroscope")
''')

COLLECT_MORE = COLLECT_LOOKUP.replace(_LOOP, _LOOP.replace(
    '"angular_velocity": angular_velocity}',
    '"angular_velocity": angular_velocity,\n'
    '            "magnitude": np.linalg.norm(acceleration, axis=1), "rate_deg": np.degrees(angular_velocity), "dt": model.opt.timestep}',
))
PLOT_MORE = '''\
def plot_imu_data(imu_data):
    """Uses what simulate_and_collect records besides: the magnitude, and degrees."""
    fig, ax = plt.subplots(3, 1, sharex=True, figsize=(9, 10))
    t = imu_data["time"]
    ax[0].plot(t, imu_data["acceleration"], label=["x", "y", "z"])
    ax[1].plot(t, imu_data["magnitude"], "k", label="magnitude")
    ax[2].plot(t, imu_data["rate_deg"], label=["roll", "pitch", "yaw"])
    for axes, title, unit in zip(ax, ("Acceleration", "Magnitude of the acceleration", "Angular velocity"), ("m/s²", "m/s²", "deg/s")):
        axes.set(title=f"{title}, every {imu_data['dt'] * 1000:.0f} ms", ylabel=f"{title} [{unit}]")
        axes.legend()
    ax[2].set_xlabel("t [s]")
    fig.savefig("imu_data.png")
'''

PLOT_STYLED = '''\
def plot_imu_data(imu_data):
    with plt.style.context(["ggplot"]), plt.rc_context({"font.size": 9, "savefig.format": "png"}):
        fig = plt.figure(figsize=(8, 8), layout="constrained")
        grid = fig.add_gridspec(2, 1, height_ratios=(2, 1))
        upper = fig.add_subplot(grid[0])
        lower = fig.add_subplot(grid[1], sharex=upper)
        for axes, key, name, unit in ((upper, "acceleration", "Specific force", "m/s²"), (lower, "angular_velocity", "Angular rate", "rad/s")):
            for column, colour, letter in zip(np.transpose(imu_data[key]), ("tab:red", "tab:green", "tab:blue"), "xyz"):
                axes.plot(imu_data["time"], column, color=colour)
                axes.annotate(letter, (imu_data["time"][-1], column[-1]), color=colour, xytext=(4, 0), textcoords="offset points")
            axes.set_title(name)
            axes.set_ylabel(f"{name} in {unit}")
        fig.supxlabel("Time in s")
        fig.savefig("imu_data")
        plt.close()
'''

PLOT_DARK_SIX = '''\
plt.style.use("dark_background")


def plot_imu_data(imu_data):
    rows = [("acceleration", "a", "m/s²"), ("angular_velocity", "ω", "rad/s")]
    fig, panels = plt.subplots(3, 2, figsize=(12, 9), sharex="all", squeeze=False)
    for column, (key, symbol, unit) in enumerate(rows):
        for row, letter in enumerate("xyz"):
            axes = panels[row, column]
            axes.plot(imu_data["time"], imu_data[key][:, row], lw=0.8)
            axes.set_ylabel(f"{symbol}_{letter} [{unit}]")
            axes.grid(ls=":")
        panels[0, column].set_title(("Accelerometer", "Gyroscope")[column])
        panels[-1, column].set_xlabel("Time [s]")
    fig.align_ylabels()
    fig.savefig("imu_data.png", bbox_inches="tight", facecolor=fig.get_facecolor())
'''

NOISE_BUFFERED = '''\
class NoisyIMU:
    """Draws the noise a thousand readings at a time."""

    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005, accel_bias=None, gyro_bias=None):
        self._sensors = model, data, accel_id, gyro_id
        self._sigma = np.repeat([accel_noise_std, gyro_noise_std], 3)
        given = [accel_bias, gyro_bias]
        self.accel_bias, self.gyro_bias = (
            np.random.randn(3) * scale if bias is None else np.asarray(bias, float) for bias, scale in zip(given, (0.1, 0.01))
        )
        self._buffer = iter(())

    def _six(self):
        try:
            return next(self._buffer)
        except StopIteration:
            self._buffer = iter(np.random.standard_normal((1000, 6)) * self._sigma)
            return next(self._buffer)

    def read(self):
        reading = np.hstack(get_imu_readings(*self._sensors))
        noisy = reading + self._six() + np.hstack([self.accel_bias, self.gyro_bias])
        return noisy[:3], noisy[3:]
'''

NOISE_COVARIANCE = '''\
class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005, accel_bias=None, gyro_bias=None, seed=None):
        self.read_clean = lambda: get_imu_readings(model, data, accel_id, gyro_id)
        self.rng = np.random.Generator(np.random.Philox(seed))
        self.R = np.diag([accel_noise_std**2] * 3 + [gyro_noise_std**2] * 3)
        self.bias = np.zeros(6)
        self.bias[:3] = self.rng.laplace(0, 0.07, 3) if accel_bias is None else accel_bias
        self.bias[3:] = self.rng.laplace(0, 0.007, 3) if gyro_bias is None else gyro_bias

    def read(self):
        z = np.concatenate(self.read_clean()) + self.rng.multivariate_normal(self.bias, self.R)
        return z[:3], z[3:]
'''

NOISE_GAUSS = '''\
from random import gauss


class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005, accel_bias=None, gyro_bias=None):
        vars(self).update(locals())
        if accel_bias is None:
            self.accel_bias = [gauss(0, 0.1) for _ in range(3)]
        if gyro_bias is None:
            self.gyro_bias = [gauss(0, 0.01) for _ in range(3)]

    def read(self):
        clean = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)
        bias, std = (self.accel_bias, self.gyro_bias), (self.accel_noise_std, self.gyro_noise_std)
        return tuple(np.array([x + b + gauss(0, s) for x, b in zip(c, bs)]) for c, bs, s in zip(clean, bias, std))
'''

FILTER_COROUTINE = '''\
def _smoothing(alpha, state):
    output = None
    while True:
        measurement = yield output
        if state is None:
            state = measurement
        state = [alpha * x + (1 - alpha) * y for x, y in zip(measurement, state)]
        output = np.array(state)


class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self._run = _smoothing(alpha, None if initial_value is None else list(initial_value))
        next(self._run)

    def update(self, measurement):
        return self._run.send(list(measurement))
'''

FILTER_HISTORY = '''\
class LowPassFilter:
    """The weights of the whole past, written out: y = sum of alpha (1 - alpha)^k x[n-k], and the rest for the start."""

    def __init__(self, alpha=0.1, initial_value=None):
        self.alpha = alpha
        self.start = None if initial_value is None else np.array(initial_value, float)
        self.past = []

    def update(self, measurement):
        if self.start is None:
            self.start = np.array(measurement, float)
        self.past.insert(0, np.array(measurement, float))
        weights = (1 - self.alpha) ** np.arange(len(self.past))
        return self.alpha * (weights @ np.array(self.past)) + (1 - self.alpha) ** len(self.past) * self.start
'''

FILTER_SLOTS = '''\
class LowPassFilter:
    __slots__ = ("alpha", "_y", "_fresh")

    def __init__(self, alpha=0.1, initial_value=None):
        if not 0 < alpha <= 1:
            raise ValueError("alpha must be in (0, 1]")
        self.alpha, self._fresh = float(alpha), initial_value is None
        self._y = np.zeros(3) if self._fresh else np.array(initial_value, dtype=np.float64)

    def update(self, measurement):
        if self._fresh:
            self._y[:], self._fresh = measurement, False
        else:
            self._y *= 1 - self.alpha
            self._y += self.alpha * np.asarray(measurement)
        return self._y.copy()

    @property
    def value(self):
        return None if self._fresh else self._y.copy()
'''

OPTIONAL_HELPERS = '''\
import logging
import warnings

import matplotlib.pyplot as plt
import mujoco
import numpy as np

try:
    from tqdm import trange
except ImportError:
    trange = range

np.seterr(all="raise")
warnings.simplefilter("error")
logging.basicConfig(filename="lab.log", level=logging.DEBUG, format="%(asctime)s %(message)s")
log = logging.getLogger(__name__)
MODEL_PATH = "textbook/assets/robot-models/mujoco/humanoid-sensors.xml"
'''

NOTEBOOK_EXPORT = {name: "#!/usr/bin/env python\n# coding: utf-8\n\n# # Lab 04-01\n\n# In[1]:\n\n\n" + text.replace("\n\n\n", "\n\n\n# In[ ]:\n\n\n") for name, text in looping().items()}

MENU = '''\
def main():
    model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    data = mujoco.MjData(model)
    while True:
        choice = input("1 list sensors, 2 record and plot, q quit > ").strip().lower()
        if choice == "1":
            print([model.sensor(i).name for i in range(model.nsensor)])
        elif choice in ("2", ""):
            plot_imu_data(simulate_and_collect(model, data, 3.0))
            break
        else:
            break


if __name__ == "__main__":
    main()
'''

COMPARE_RESIDUAL = COMPARE.replace('''\
    ax.plot(t, np.array(raw)[:, 2], alpha=0.5, label="raw z")
    ax.plot(t, np.array(smooth)[:, 2], label="filtered z")
''', '''\
    raw, smooth = np.array(raw)[:, 2], np.array(smooth)[:, 2]
    ax.plot(t, raw, ".", ms=2, color="0.6")
    ax.plot(t, smooth, "r-")
    ax.plot(t, raw - smooth - 9.81, color="c", lw=0.3, zorder=0)
''').replace('    ax.legend()\n', '    ax.legend(["measured", "after the low-pass", "what was removed (shifted)"], ncol=3)\n')

NEWCOMERS = {
    "taken_by_index": lab(read=READ_TAKE, collect=COLLECT_GENERATOR),
    "split_by_dimensions": lab(read=READ_SPLIT, collect=COLLECT_STRUCTURED),
    "cached_slices": lab(read=READ_CACHED_SLICES, collect=COLLECT_KEYWORD_IDS),
    "checks_its_arguments": lab(read=READ_CHECKS_ITS_ARGUMENTS, low_pass=FILTER_SLOTS),
    "plots_what_else_it_recorded": lab(collect=COLLECT_MORE, plot=PLOT_MORE),
    "ggplot_with_annotations": lab(plot=PLOT_STYLED),
    "dark_with_six_panels": lab(plot=PLOT_DARK_SIX),
    "noise_in_blocks": lab(noise=NOISE_BUFFERED),
    "noise_by_covariance": lab(noise=NOISE_COVARIANCE),
    "noise_number_by_number": lab(noise=NOISE_GAUSS),
    "filter_as_coroutine": lab(low_pass=FILTER_COROUTINE),
    "filter_of_the_whole_past": lab(low_pass=FILTER_HISTORY),
    "raises_on_every_warning": lab(head=OPTIONAL_HELPERS),
    "exported_from_a_notebook": NOTEBOOK_EXPORT,
    "asks_what_to_do": lab(main=MENU),
    "comparison_with_residual": lab(compare=COMPARE_RESIDUAL),
    "methods_bound_to_names": edit(tidy(), "noisy_imu.py", ("import mujoco\n", "import mujoco\nfrom numpy.random import default_rng as make\n"), ("np.random.default_rng()", "make()")),
    "imports_where_it_needs_them": {
        **tidy(),
        "noisy_imu.py": "import numpy as np\n\n\n" + NOISE_GENERATOR.replace("        accel, gyro = get_imu", "        from imu_reader import get_imu_readings\n        accel, gyro = get_imu"),
        "filters.py": "import numpy as np\n\n\n" + FILTER_INCREMENT + "\n\n" + COMPARE.replace('    model = mujoco', "    import matplotlib.pyplot as plt\n    import mujoco\n    from imu_reader import MODEL_PATH\n    from noisy_imu import NoisyIMU\n    model = mujoco"),
    },
    "sheet_with_a_class_of_settings": edit(
        verbatim(), "imu_reader.py",
        ("    dt = model.opt.timestep\n", "    class Settings:\n        push = 0.5\n        dt = model.opt.timestep\n    dt = Settings.dt\n"),
        ("    data.qvel[0] = 0.5  # Forward velocity\n", "    setattr(Settings, 'dof', 0)\n    data.qvel[Settings.dof] = Settings.push\n"),
    ),
    "resets_with_keyframe_free_copy": lab(
        collect=COLLECT_LOOKUP.replace("    mujoco.mj_resetData(model, data)\n    data.qvel[0] = 0.5\n",
                                       "    fresh = mujoco.MjData(model)\n    fresh.qvel[0] = 0.5\n"
                                       "    if hasattr(mujoco, 'mj_copyData'):\n        mujoco.mj_copyData(data, model, fresh)\n"
                                       "    else:  # an older MuJoCo\n        data = fresh\n"),
        plot=PLOT_LOOP.replace('    fig.savefig("imu_data.png", dpi=100)\n', '    for ending in ("pdf", "png"):\n        fig.savefig(f"imu_data.{ending}")\n'),
        head=HEAD + "\nplt.rcParams.update({'figure.autolayout': False, 'axes.spines.top': False})\n",
    ),
}
