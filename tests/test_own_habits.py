"""A forgotten import or return, a misspelt name, other parameters: each is one fault, whatever would fail for it."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest

from tests.corpus.pieces import tidy, verbatim
from tests.corpus.writing import Files
from tests.recordings import Marking
from tests.slips import Changes, Slip, changed, costs_what_it_is, lost_by, marked

READER, NOISY, FILTER = "imu_reader.py", "noisy_imu.py", "filters.py"


def _renamed(files: Files, old: str, new: str) -> Files:
    return {path: text.replace(old, new) if path.endswith(".py") else text for path, text in files.items()}


NOISE, READ, RECURSION = "noise_model.noise_size", "sensor_access.returns_two_vectors", "filtering.follows_recursion"
RECORD, PLOT = "data_collection.returns_named_arrays", "visualization.saves_image"

OTHER, FORGOT = ("other-parameters",), ("import-missing",)

FILTER_IN_TIME = {
    "alpha=0.1, initial_value=None": "cutoff_hz, dt, initial_value=None",
    "self.alpha = alpha": "self.alpha = dt / (1 / (2 * np.pi * cutoff_hz) + dt)",
}
PARAMETERS: dict[str, tuple[str, Changes, dict[str, float], tuple[str, ...]]] = {
    "standard deviations": (NOISY, {"accel_noise_std": "acc_std", "gyro_noise_std": "gyr_std"}, {NOISE: 3.0}, OTHER),
    "sigma for each": (NOISY, {"accel_noise_std": "sigma_a", "gyro_noise_std": "sigma_g"}, {NOISE: 3.0}, OTHER),
    "standard deviations in the code": (
        NOISY,
        {
            "accel_noise_std=0.05, gyro_noise_std=0.005,": "",
            "= accel_noise_std": "= 0.05",
            "= gyro_noise_std": "= 0.005",
        },
        {NOISE: 6.0},
        ("std-ignored",),
    ),
    "biases": (NOISY, {"accel_bias": "b_acc", "gyro_bias": "b_gyro"}, {NOISE: 3.0}, OTHER),
    "no ids": (
        NOISY,
        {
            "model, data, accel_id, gyro_id,": "model, data,",
            "NoisyIMU(model, data, accel_id, gyro_id)": "NoisyIMU(model, data)",
            "= accel_id": "= model.sensor('torso_accelerometer').id",
            "= gyro_id": "= model.sensor('torso_gyroscope').id",
        },
        {NOISE: 3.0},
        OTHER,
    ),
    "smoothing": (
        FILTER,
        {
            "alpha=0.1, initial_value=None": "smoothing=0.1, start=None",
            "self.alpha = alpha": "self.alpha = smoothing",
            "= initial_value": "= start",
            "LowPassFilter(alpha=0.1)": "LowPassFilter(smoothing=0.1)",
        },
        {RECURSION: 3.0},
        OTHER,
    ),
    "a cutoff": (FILTER, FILTER_IN_TIME | {"LowPassFilter(alpha=0.1)": "LowPassFilter(10.0, 0.002)"}, {RECURSION: 3.0}, OTHER),
    "a cutoff with a default": (
        FILTER,
        FILTER_IN_TIME | {"cutoff_hz, dt,": "cutoff_hz=10.0, dt=0.002,", "LowPassFilter(alpha=0.1)": "LowPassFilter()"},
        {RECURSION: 3.0},
        OTHER,
    ),
    "a sampling rate": (
        FILTER,
        FILTER_IN_TIME
        | {"cutoff_hz, dt,": "fc, sampling_freq,", "dt / (1 / (2 * np.pi * cutoff_hz) + dt)": "1 / (1 + sampling_freq / (2 * np.pi * fc))"}
        | {"LowPassFilter(alpha=0.1)": "LowPassFilter(fc=10.0, sampling_freq=500)"},
        {RECURSION: 3.0},
        OTHER,
    ),
    "a time constant": (
        FILTER,
        FILTER_IN_TIME | {"cutoff_hz, dt,": "tau, dt,", "1 / (2 * np.pi * cutoff_hz)": "tau"}
        | {"LowPassFilter(alpha=0.1)": "LowPassFilter(0.02, 0.002)"},
        {RECURSION: 3.0},
        OTHER,
    ),
    "an alpha, or a cutoff": (
        FILTER,
        {
            "alpha=0.1, initial_value=None": "alpha=0.1, initial_value=None, cutoff_hz=0.0, dt=0.002",
            "self.alpha = alpha": "self.alpha = dt / (1 / (2 * np.pi * cutoff_hz) + dt) if cutoff_hz else alpha",
        },
        {},
        (),
    ),
    "no alpha": (
        FILTER,
        {"alpha=0.1, initial_value": "initial_value", "self.alpha = alpha": "self.alpha = 0.1", "(alpha=0.1)": "()"},
        {RECURSION: 6.0},
        ("alpha-ignored",),
    ),
    "no initial value": (
        FILTER,
        {", initial_value=None": "", "= initial_value": "= None"},
        {"filtering.starts_from_first_measurement": 1.5},
        ("initial-value-ignored",),
    ),
    "standard deviations of biases": (
        NOISY,
        {
            "accel_bias=None, gyro_bias=None": "accel_bias_std=0.1, gyro_bias_std=0.01",
            "accel_bias if accel_bias is not None else np.random.normal(0, 0.1, 3)": "np.random.normal(0, accel_bias_std, 3)",
            "gyro_bias if gyro_bias is not None else np.random.normal(0, 0.01, 3)": "np.random.normal(0, gyro_bias_std, 3)",
        },
        {"noise_model.given_bias": 4.0},
        ("bias-argument-ignored",),
    ),
    "the time between measurements": (
        FILTER,
        {"(self, measurement)": "(self, measurement, dt)", "update(noisy_accel)": "update(noisy_accel, 0.002)"},
        {RECURSION: 3.0},
        OTHER,
    ),
    "the time between measurements, by default": (
        FILTER, {"(self, measurement)": "(self, measurement, dt=0.002)"}, {}, (),
    ),
    "data first": (
        READER,
        {
            "(model, data, accel_sensor_id, gyro_sensor_id)": "(data, model, accel_sensor_id, gyro_sensor_id)",
            "get_imu_readings(model, data, accel_id": "get_imu_readings(data, model, accel_id",
        },
        {READ: 3.0},
        OTHER,
    ),
    "data alone": (
        READER,
        {
            "(model, data, accel_sensor_id, gyro_sensor_id)": "(data, accel_sensor_id, gyro_sensor_id)",
            "get_imu_readings(model, data, accel_id": "get_imu_readings(data, accel_id",
        },
        {READ: 3.0},  # the model that it reads as a global stands for the one that is given
        OTHER,
    ),
    "the duration first": (
        READER,
        {
            "(model, data, duration_seconds=5.0)": "(duration_seconds, model, data)",
            "(model, data, duration_seconds=3.0)": "(3.0, model, data)",
        },
        {RECORD: 3.0},
        OTHER,
    ),
    "the number of steps": (
        READER,
        {
            "(model, data, duration_seconds=5.0)": "(model, data, n_steps)",
            "    n_steps = int(duration_seconds / dt)\n": "",
            "(model, data, duration_seconds=3.0)": "(model, data, 1500)",
        },
        {RECORD: 3.0},
        OTHER,
    ),
    "ids, and a duration of another name": (
        READER,
        {
            "(model, data, duration_seconds=5.0):": "(model, data, accel_id, gyro_id, length=5.0):\n    duration_seconds = length",
            "(model, data, duration_seconds=3.0)": "(model, data, accel_id, gyro_id, 3.0)",
        },
        {},
        (),
    ),
    "a file name": (
        READER,
        {
            "plot_imu_data(imu_data):": "plot_imu_data(imu_data, filename):",
            "\nplot_imu_data(imu_data)": "\nplot_imu_data(imu_data, 'imu_data.png')",
            "savefig('imu_data.png'": "savefig(filename",
        },
        {PLOT: 2.0},
        OTHER,
    ),
    "the series one by one": (
        READER,
        {
            "plot_imu_data(imu_data):": "plot_imu_data(t, accel, gyro):\n"
            "    imu_data = {'time': t, 'acceleration': accel, 'angular_velocity': gyro}",
            "\nplot_imu_data(imu_data)": "\nplot_imu_data(*imu_data.values())",
        },
        {PLOT: 2.0},
        OTHER,
    ),
}  # fmt: skip
FORGOTTEN: dict[str, tuple[str, str, dict[str, float]]] = {
    "numpy": (READER, "import numpy as np\n", {RECORD: 3.0}),
    "mujoco": (READER, "import mujoco\n", {RECORD: 3.0}),
    "pyplot": (READER, "import matplotlib.pyplot as plt\n", {PLOT: 2.0}),
    "the reader and all that comes with it": (NOISY, "from imu_reader import *\n", {NOISE: 3.0}),
    "the noise model and all that comes with it": (FILTER, "from noisy_imu import *\n", {"visualization.comparison_plot": 4.0}),
}  # fmt: skip
MISSPELT = {
    ("LowPassFilter", "LowpassFilter"): RECURSION,
    ("NoisyIMU", "NoisyImu"): NOISE,
    ("get_imu_readings", "get_imu_reading"): READ,
    ("simulate_and_collect", "simulateAndCollect"): RECORD,
}
OTHER_METHODS: dict[str, tuple[str, Changes, str]] = {
    "process": (FILTER, {"def update": "def process", ".update(": ".process("}, RECURSION),
    "a call": (FILTER, {"def update": "def __call__", "accel_filter.update(": "accel_filter("}, RECURSION),
    "filter, beside others": (
        FILTER,
        {
            "    def update": "    def reset(self):\n        self.value = None\n\n    def set_alpha(self, alpha):\n        self.alpha = alpha\n\n"
            "    def filter",
            ".update(": ".filter(",
        },
        RECURSION,
    ),
    "of a base": (
        FILTER,
        {"class LowPassFilter:": "class Base:\n    def step(self, x):\n        return self.next(x, 1)\n\n\nclass LowPassFilter(Base):",
         "def update(self, measurement)": "def next(self, measurement, times)", "accel_filter.update(": "accel_filter.step("},
        RECURSION,
    ),
    "get_readings": (NOISY, {"def read(": "def get_readings(", "noisy_imu.read()": "noisy_imu.get_readings()"}, NOISE),
    "sample": (NOISY, {"def read(": "def sample(", "noisy_imu.read()": "noisy_imu.sample()"}, NOISE),
}  # fmt: skip
"""Methods under other names, where only one can be meant."""
SILENT: dict[str, tuple[str, Changes, str]] = {
    "the reader": (READER, {"    return acceleration, angular_velocity\n": ""}, READ),
    "the reader prints": (READER, {"    return acceleration, angular_velocity\n": "    print(f'{acceleration}', acceleration, angular_velocity)\n"}, READ),
    "the reader, without the word": (READER, {"    return acceleration, angular_velocity\n": "    acceleration, angular_velocity\n"}, READ),
    "a recording by a name": (READER, {"    return {\n        'time'": "    imu_data = {\n        'time'"}, RECORD),
    "a recording without the word": (READER, {"    return {\n        'time'": "    {\n        'time'"}, RECORD),
    "read": (NOISY, {"        return accel_noisy, gyro_noisy\n": ""}, NOISE),
    "read keeps them": (
        NOISY,
        {"        return accel_noisy, gyro_noisy\n": "        self.last = (accel_noisy, gyro_noisy)\n        self.reads = 1\n"},
        NOISE,
    ),
    "update": (FILTER, {"        return self.value.copy()\n": ""}, RECURSION),
    "update, once it has begun": (
        FILTER,
        {
            "            self.value = measurement.copy()\n": (
                "            self.value = measurement.copy()\n            return measurement\n"
            ),
            "        return self.value.copy()\n": "",
        },
        RECURSION,
    ),
}  # fmt: skip
_SENSOR = "mujoco.mjtObj.mjOBJ_SENSOR"
_STORED = (
    "accel, gyro = get_imu_readings(model, data, accel_id, gyro_id)",
    "accelerations[i] = accel",
    "angular_velocities[i] = gyro",
)
EDITED: dict[str, tuple[str, Changes, dict[str, float], tuple[str, ...]]] = {
    "a filter that runs away": (FILTER, {"(1 - self.alpha) *": "(1 + self.alpha) *"}, {RECURSION: 6.0}, ("gain-not-one",)),
    "one sensor in both places": (
        NOISY, {"return accel_noisy, gyro_noisy": "return gyro_noisy, gyro_noisy"}, {"noise_model.given_bias": 4.0}, (),
    ),
    "a slice from the id on": (
        READER,
        {"data.sensordata[accel_adr:accel_adr+3]": "data.sensordata[accel_sensor_id:accel_adr+3]"},
        {"sensor_access.follows_address": 6.0},
        ("sensor-id-as-address",),
    ),
    "dates along the axis": (
        READER,
        {
            "import numpy as np\n": "import numpy as np\nfrom datetime import datetime, timedelta\n",
            "imu_data['time']": "[datetime(2026, 5, 1) + timedelta(seconds=float(t)) for t in imu_data['time']]",
        },
        {},
        (),
    ),
    "a duration along the axis": (
        READER, {"imu_data['time']": "(1e6 * imu_data['time']).astype('timedelta64[us]')", "Time (s)": "Time (us)"}, {}, (),
    ),
    "nanoseconds along the axis": (READER, {"imu_data['time']": "1e9 * imu_data['time']", "Time (s)": "Time (ns)"}, {}, ()),
    "a box plot and bars with names beside the curves": (
        READER,
        {
            "plt.savefig('imu_data.png', dpi=150)": "boxes, bars = fig.add_axes([0.8, 0.7, 0.1, 0.1]), fig.add_axes([0.8, 0.2, 0.1, 0.1])\n"
            "    boxes.boxplot([[1, 2, 3], [2, 3, 4]])\n"
            "    bars.bar(['a', 'b'], [1, 2])\n"
            "    bars.plot(['a', 'b'], [1, 2])\n"
            "    plt.savefig('imu_data.png', dpi=150)"
        },
        {},
        (),
    ),
    "a filter of the program's own measurement": (
        FILTER, {"measurement.copy()": "noisy_accel.copy()", "self.alpha * measurement": "self.alpha * noisy_accel"},
        {RECURSION: 3.0}, ("global-for-parameter",),
    ),
    "a filter of the program's own measurement, to which none is given": (
        FILTER, {"def update(self, measurement)": "def update(self)", "measurement.copy()": "noisy_accel.copy()",
                 "self.alpha * measurement": "self.alpha * noisy_accel", ".update(noisy_accel)": ".update()"},
        {RECURSION: 3.0}, ("global-for-parameter",),
    ),
    "a reader of names": (
        READER, {f"model.sensor_adr[{sensor}_sensor_id]": f"model.sensor_adr[mujoco.mj_name2id(model, {_SENSOR}, {sensor}_sensor_id)]" for sensor in ("accel", "gyro")}
        | {f'mujoco.mj_name2id(model, {_SENSOR}, "torso_{sensor}")': f'"torso_{sensor}"' for sensor in ("accelerometer", "gyroscope")},
        {READ: 3.0}, OTHER,
    ),
    "an array that is asked for its truth": (
        FILTER, {"if self.value is None": "if not self.value"}, {RECURSION: 3.0}, ("array-asked-for-truth",),
    ),
    "an array that is compared with nothing": (
        FILTER, {"if self.value is None": "if self.value == None"}, {RECURSION: 3.0}, ("array-asked-for-truth",),
    ),
    "a bias, or another": (
        NOISY, {"accel_bias if accel_bias is not None else np": "accel_bias or np"}, {NOISE: 3.0}, ("array-asked-for-truth",),
    ),
    "a size that is an array": (NOISY, {"self.accel_noise_std, 3)": "self.accel_noise_std, size=accel)"}, {NOISE: 3.0}, ("raises",)),
    "rows that are stored behind the loop": (
        READER, {f"        {line}": f"    {line}" for line in _STORED}, {"data_collection.matches_truth": 6.0}, ("rows-left-zero",),
    ),
    "rows and stamps that are stored behind the loop": (
        READER, {f"        {line}": f"    {line}" for line in ("times[i] = data.time", *_STORED)},
        {"data_collection.matches_truth": 6.0}, ("rows-left-zero",),
    ),
    "a bias of four numbers where none is given": (
        NOISY, {"normal(0, 0.1, 3)": "normal(0, 0.1, 4)"}, {"noise_model.default_bias": 3.0}, ("raises",),
    ),
}  # fmt: skip


LEGEND, CURVES, LABELS = (
    "visualization.legend_names_curves",
    "visualization.curves_match_data",
    "visualization.axis_labels_with_units",
)
LEFT_OUT: dict[str, tuple[str, Changes, dict[str, float], tuple[str, ...]]] = {
    "a style that is nowhere": (READER, {"    fig, axes =": "    plt.style.use('my-style')\n    fig, axes ="}, {PLOT: 2.0}, ("raises",)),
    "a heading of no size": (
        READER, {"    plt.tight_layout()\n": "    plt.suptitle('IMU', fontsize='hugee')\n    plt.tight_layout()\n"}, {PLOT: 2.0}, ("raises",),
    ),
    "a picture of no resolution": (READER, {"dpi=150": "dpi='high'"}, {PLOT: 2.0}, ("raises",)),
    "a legend at no place": (READER, {"axes[1].legend()": "axes[1].legend(loc='top')"}, {LEGEND: 1.0}, ("no-legend",)),
    "a label of no size": (READER, {"(m/s²)')": "(m/s²)', size='hugee')"}, {LABELS: 1.0}, ("no-axis-labels",)),
    "a curve of no colour": (READER, {"[:, 0], label='X'": "[:, 0], 'grenn', label='X'"}, {CURVES: 5.0 - 4.17}, ("curves-missing",)),
    "a print in the reader": (
        READER, {"    return acceleration,": "    print(f'{acceleration:.2f}')\n    return acceleration,"}, {READ: 3.0}, ("raises",),
    ),
    "a print of the noise": (
        NOISY, {"        return accel_noisy,": "        print('noisy: ' + accel_noisy)\n        return accel_noisy,"}, {NOISE: 3.0}, ("raises",),
    ),
}  # fmt: skip
"""A call for its effect alone that raises: what it lacks is charged, or else that it raises."""
READING = {
    "both readings": ("accel, gyro", "*get_imu_readings(model, data, accel_id, gyro_id)"),
    "the scene": ("model, data", "model, data"),
    "the ids": ("accel_id, gyro_id", "accel_id, gyro_id"),
    "a time step": ("dt", "0.002"),
}
"""What a `read` takes, and what the program gives it."""
UNKNOWN: dict[str, tuple[str, dict[str, str], dict[str, float]]] = {
    "a variable": (FILTER, {"self.alpha * measurement": "self.alpha * measurment"}, {RECURSION: 3.0}),
    "self of an attribute": (FILTER, {"(1 - self.alpha)": "(1 - alpha)"}, {RECURSION: 3.0}),
    "self of a method": (FILTER, {"def update(self, measurement)": "def update(measurement)"}, {RECURSION: 3.0}),
    "self of __init__": (FILTER, {"def __init__(self, alpha": "def __init__(alpha"}, {RECURSION: 3.0}),
    "an attribute": (FILTER, {"self.alpha = alpha": "self.aplha = alpha"}, {RECURSION: 3.0}),
    "three attributes that are not kept": (
        NOISY, {f"        self.{name} = {name}\n": f"        {name} = {name}\n" for name in ("model", "data", "accel_id")},
        {NOISE: 3.0},
    ),
    "a function of NumPy": (NOISY, {"np.random.normal(0, self.gyro_noise_std": "np.random.norml(0, self.gyro_noise_std"}, {NOISE: 3.0}),
    "NumPy before its function": (READER, {"    times = np.zeros(n_steps)": "    times = zeros(n_steps)"}, {RECORD: 3.0}),
    "where no bias is given alone": (NOISY, {"np.random.normal(0, 0.01, 3)": "np.random.norml(0, 0.01, 3)"}, {NOISE: 3.0}),
    "what is returned": (NOISY, {"return accel_noisy, gyro_noisy": "return accel_noisy, gyro_noisey"}, {NOISE: 3.0}),
    "a member of the data": (READER, {"data.sensordata[gyro_adr": "data.sensor_data[gyro_adr"}, {READ: 3.0}),
    "a function of MuJoCo": (READER, {"mujoco.mj_resetData(": "mujoco.mj_resetdata("}, {RECORD: 3.0}),
    "a built-in function": (READER, {"for i in range(n_steps)": "for i in rang(n_steps)"}, {RECORD: 3.0}),
    "a key": (READER, {"imu_data['angular_velocity'][:, 2]": "imu_data['angular_velocty'][:, 2]"}, {PLOT: 2.0}),
    "a key as an attribute": (READER, {"imu_data['acceleration'][:, 0]": "imu_data.acceleration[:, 0]"}, {PLOT: 2.0}),
    "a keyword": (READER, {"label='X'": "lable='X'"}, {PLOT: 2.0}),
    "a function of pyplot of a panel": (READER, {"axes[1].set_xlabel(": "axes[1].xlabel(", "axes[0].set_ylabel(": "axes[0].ylabel("}, {PLOT: 2.0}),
    "a function of a panel of pyplot": (READER, {"    plt.tight_layout()\n": "    plt.set_xlabel('Time (s)')\n    plt.tight_layout()\n"}, {PLOT: 2.0}),
    "two in one line": (FILTER, {"self.alpha * measurement + (1 - self.alpha)": "alpha * measurment + (1 - self.alpha)"}, {RECURSION: 3.0}),
    "beside a wrong weight": (FILTER, {"(1 - self.alpha) * self.value": "(1 + alpha) * self.value"}, {RECURSION: 6.0}),
}  # fmt: skip


def _chained() -> Files:
    """noisy_imu.py writes what it has read when it is run, and filters.py filters that."""
    files = changed(
        tidy(),
        NOISY,
        {
            '    print("noisy reading:", *imu.read())\n': "    raw = []\n    for _ in range(500):\n        mujoco.mj_step(model, data)\n"
            '        raw.append(imu.read()[0])\n    np.save("raw.npy", raw)\n'
        },
    )
    head, _, rest = str(files[FILTER]).partition("    model = mujoco.MjModel")
    drawing = rest.partition("    fig, ax")[2]
    load = (
        '    raw = np.load("raw.npy")\n    low_pass = LowPassFilter(alpha=0.1)\n    t = np.arange(len(raw)) * 0.002\n'
    )
    return files | {FILTER: f"{head}{load}    smooth = [low_pass.update(accel) for accel in raw]\n    fig, ax{drawing}"}


def _slips() -> Iterator[Slip]:
    for name, (path, changes, lost, named) in (PARAMETERS | EDITED | LEFT_OUT).items():
        yield Slip(name, changed(verbatim(), path, changes), lost, named)
    for name, (path, line, lost) in FORGOTTEN.items():
        named = () if "comparison" in str(lost) else FORGOT  # the script stops there: what it would draw is not known
        yield Slip(f"forgotten: {name}", changed(verbatim(), path, {line: ""}), lost, named)
    yield Slip(
        "forgotten: a partner",
        changed(tidy(), FILTER, {"from noisy_imu import NoisyIMU\n": ""}),
        {RECURSION: 3.0},
        FORGOT,
    )
    for name, (path, changes, check) in SILENT.items():
        yield Slip(f"no return: {name}", changed(verbatim(), path, changes), {check: 3.0}, ("return-missing",))
    for name, (path, changes, check) in OTHER_METHODS.items():
        files = changed(verbatim(), path, changes)
        used = {"noisy_imu.read()": changes["noisy_imu.read()"]} if path == NOISY else {}
        yield Slip(f"another method: {name}", changed(files, FILTER, used), {check: 3.0}, ("name-missing",))
    for (name, own), check in MISSPELT.items():
        yield Slip(f"misspelt: {own}", _renamed(verbatim(), name, own), {check: 3.0}, ("name-missing",))
    for name, (takes, reads) in READING.items():
        own = {"def read(self)": f"def read(self, {takes})", "noisy_imu.read()": f"noisy_imu.read({reads})"}
        files = changed(verbatim(), NOISY, own)
        files = changed(files, FILTER, {"noisy_imu.read()": own["noisy_imu.read()"]})
        yield Slip(f"read() is given {name}", files, {NOISE: 3.0}, OTHER)
    for name, (path, changes, lost) in UNKNOWN.items():
        named = ("gain-not-one",) if "weight" in name else ("unknown-name",)
        yield Slip(f"unknown: {name}", changed(verbatim(), path, changes), lost, named)
    yield Slip(
        "curves of one sensor in no panel",
        changed(tidy(), READER, {'top.plot(t, imu_data["acceleration"][:, k], label=f"$a_{axis}$")': "pass"}),
        {"visualization.curves_match_data": 2.5},
        ("curves-missing",),
    )
    flag = {"class LowPassFilter:": "first = True\n\n\nclass LowPassFilter:",
            "        if self.state is None:\n": "        global first\n        if first and self.state is None:\n            first = False\n"}  # fmt: skip
    yield Slip(
        "a flag that all filters share",
        changed(tidy(), FILTER, flag),
        {"filtering.instances_independent": 3.0},
        ("shared-state",),
    )
    across = {
        '        top.plot(t, imu_data["acceleration"][:, k], label=f"$a_{axis}$")\n': "        pass\n",
        '        bottom.plot(t, imu_data["angular_velocity"][:, k], label=rf"$\\omega_{axis}$")\n': '    top.plot(imu_data["acceleration"].T)\n'
        '    bottom.plot(imu_data["angular_velocity"].T)\n',
        'ax.legend(loc="best")': 'ax.legend(["x", "y", "z"])',
    }
    yield Slip(
        "a curve of three points for each reading",
        changed(tidy(), READER, across),
        {"visualization.curves_match_data": 5.0},
        ("wrong-data-plotted",),
    )
    yield Slip("scripts that read what the one before has written", _chained(), {})
    yield Slip(
        "legends of the parts of a figure",
        changed(
            tidy(),
            READER,
            {
                "fig, (top, bottom) = plt.subplots(2, 1, figsize=(10, 6), sharex=True)": "fig = plt.figure(figsize=(10, 6))\n"
                "    parts = fig.subfigures(2, 1)\n    top, bottom = parts[0].subplots(), parts[1].subplots()",
                '    for ax in (top, bottom):\n        ax.legend(loc="best")': "    for part, ax in zip(parts, (top, bottom)):\n        part.legend()",
                'top.set_title("Torso accelerometer")': 'parts[0].text(0.5, 0.95, "Torso")',
                '    bottom.set_title("Torso gyroscope")\n': "",
                "    fig.tight_layout()\n": "",
            },
        ),
        {},
    )
    yield Slip(
        "a division by the difference",
        changed(tidy(), FILTER, {"self.alpha * (x - self.state)": "self.alpha / (x - self.state)"}),
        {RECURSION: 6.0},
    )


def _notebook(*cells: str) -> Files:
    told = [
        {"cell_type": "code", "source": cell, "metadata": {}, "outputs": [], "execution_count": None} for cell in cells
    ]
    return {"lab.ipynb": json.dumps({"cells": told, "metadata": {}, "nbformat": 4, "nbformat_minor": 5})}


SHEET = "\n\n".join(
    "\n".join(line for line in str(verbatim()[name]).splitlines() if not line.startswith("from "))
    for name in (READER, NOISY, FILTER)
)
IMPORTS = "import numpy as np\n", "import matplotlib.pyplot as plt\n"
BARE = SHEET.replace(IMPORTS[0], "").replace(IMPORTS[1], "")


@pytest.mark.parametrize(
    ("cells", "lost"),
    [
        ((*IMPORTS, BARE), {}),
        (("%pylab inline", BARE), {}),
        ((IMPORTS[1], BARE), {RECORD: 3.0}),
        ((IMPORTS[0], BARE), {PLOT: 2.0}),
    ],
    ids=["imports in cells of their own", "pylab", "no numpy", "no pyplot"],
)
def test_the_cells_of_a_notebook_are_one_file(cells: tuple[str, ...], lost: dict[str, float], player: Marking) -> None:
    assert lost_by(marked(player, _notebook(*cells))) == lost


@pytest.mark.parametrize("slip", [*_slips()], ids=lambda slip: slip.name)
def test_it_costs_what_it_is_and_nothing_else(slip: Slip, player: Marking) -> None:
    costs_what_it_is(slip, player)


def test_another_word_for_a_function_is_not_its_name(player: Marking) -> None:
    result = marked(player, _renamed(verbatim(), "get_imu_readings", "read_imu"))
    assert result.misconceptions == ("name-missing",)
    assert [part.points for part in result.criteria] == [0.0, 20.0, 20.0, 20.0, 20.0]


def test_what_was_left_out_of_a_plot_is_noted(player: Marking) -> None:
    path, changes, *_ = LEFT_OUT["a legend at no place"]
    notes = marked(player, changed(verbatim(), path, changes)).notes
    assert ": axes[1].legend(loc='top') was left out of the plot, so that the rest counts: ValueError" in str(notes)


def test_what_was_lent_is_noted(player: Marking) -> None:
    notes = marked(player, changed(verbatim(), READER, {"import numpy as np\n": ""})).notes
    assert "imu_reader.py uses np, not there when it is imported: lent to it, so that the rest counts" in notes


BORROWED_ON_PURPOSE = {
    "by text": 'exec("import numpy as np")\n',
    "another way": "import numpy\nnp = numpy\n",
    "from pylab": "from pylab import *\n",
    "or nothing": "try:\n    import numpy as np\nexcept ImportError:\n    np = None\n",
}


@pytest.mark.parametrize("line", BORROWED_ON_PURPOSE.values(), ids=BORROWED_ON_PURPOSE)
def test_a_name_that_comes_by_another_way_is_not_forgotten(line: str, player: Marking) -> None:
    result = marked(player, changed(verbatim(), READER, {"import numpy as np\n": line}))
    assert (result.score, result.notes) == (100.0, ())


def test_a_return_that_a_later_cell_has_is_not_missing(player: Marking) -> None:
    filters = str(verbatim()[FILTER]).partition("# Test filtering")[0].replace("from noisy_imu import *\n", "")
    silent = filters.replace("        return self.value.copy()\n", "")
    assert silent != filters
    cells = [str(verbatim()[name]).replace("from imu_reader import *\n", "") for name in (READER, NOISY)]
    last = str(verbatim()[FILTER]).replace("from noisy_imu import *\n", "")
    assert lost_by(marked(player, _notebook(*cells, silent, last))) == {}
    assert lost_by(marked(player, _notebook(*cells, last, silent))) == {RECURSION: 3.0}


LOOP = """for i in range(n_samples):
    mujoco.mj_step(model, data)
    noisy_accel, _ = noisy_imu.read()
    raw_data[i] = noisy_accel
    filtered_data[i] = accel_filter.update(noisy_accel)
"""
ALL_AT_ONCE = """
    def __call__(self, rows):
        return np.array([self.update(row) for row in rows])
"""
SERIES = """
    def series(self, n):
        rows = []
        for _ in range(n):
            mujoco.mj_step(self.model, self.data)
            rows.append(self.read()[0])
        return np.array(rows)
"""
OWN_METHODS: dict[str, tuple[Changes, Changes, set[str]]] = {
    "a filter that is called": (
        {LOOP: LOOP.replace("filtered_data[i] = accel_filter.update(noisy_accel)", "") + "filtered_data = accel_filter(raw_data)\n"},
        {"return self.value.copy()\n": f"return self.value.copy()\n{ALL_AT_ONCE}", "(1 - self.alpha)": "(2 - self.alpha)"},
        {"filtering"},
    ),
    "a noisy IMU that reads a series": (
        {LOOP: "raw_data = noisy_imu.series(n_samples)\nfiltered_data = np.array([accel_filter.update(row) for row in raw_data])\n"},
        {"return accel_noisy, gyro_noisy\n": f"return accel_noisy, gyro_noisy\n{SERIES}", "+ self.accel_bias": "+ self.acc_bias"},
        {"noise_model"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", OWN_METHODS.values(), ids=OWN_METHODS)
def test_what_a_class_has_beside_the_sheets_methods_is_there_in_its_place(
    case: tuple[Changes, Changes, set[str]], player: Marking
) -> None:
    script, faulty, criteria = case
    files = changed(verbatim(), FILTER, script)
    for old, new in faulty.items():
        path = next(path for path in (FILTER, NOISY) if old in files[path])
        files = changed(files, path, {old: new})
    assert {check.partition(".")[0] for check in lost_by(marked(player, files))} == criteria


@pytest.mark.parametrize(("name", "own"), MISSPELT)
def test_a_misspelt_name_costs_as_much_in_one_file_and_in_a_notebook(name: str, own: str, player: Marking) -> None:
    """What is asked for is at home there, as the files of the sheet were not handed in."""
    code = SHEET.replace(name, own)
    assert [lost_by(marked(player, files)) for files in ({"lab.py": code}, _notebook(code))] == [
        {MISSPELT[name, own]: 3.0}
    ] * 2
