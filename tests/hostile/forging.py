"""Forgery: code that is wrong and tries to be marked right. Its honest twin is as wrong and does not try."""

from __future__ import annotations

from tests.corpus.pieces import lab
from tests.corpus.writing import Files
from tests.hostile.picture import canned_picture
from tests.hostile.program import FILTER, NOISE, READER, Program, first, in_function, last

# ---------------------------------------------------------------- what is wrong: one part, the rest is sound

READS: Files = lab(read='''\
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    return np.zeros(3), np.zeros(3)
''')
VIEWS: Files = lab(read='''\
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    a, g = model.sensor_adr[accel_sensor_id], model.sensor_adr[gyro_sensor_id]
    return data.sensordata[a:a + 3], data.sensordata[g:g + 3]
''')
STEPS: Files = lab(read='''\
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    accel, gyro = data.sensor(accel_sensor_id).data.copy(), data.sensor(gyro_sensor_id).data.copy()
    mujoco.mj_step(model, data)
    return accel, gyro
''')
STANDS: Files = lab(collect='''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    n = int(round(duration_seconds / model.opt.timestep))
    time = (1 + np.arange(n)) * model.opt.timestep
    return {"time": time, "acceleration": np.tile([0, 0, -9.81], (n, 1)), "angular_velocity": np.zeros((n, 3))}
''')
BARE_PLOT = '''\
def plot_imu_data(imu_data):
    fig, axes = plt.subplots(2, 1)
    axes[0].plot(imu_data["time"], imu_data["acceleration"])
    axes[1].plot(imu_data["time"], imu_data["angular_velocity"])
    fig.savefig("imu_data.png")
    plt.close(fig)
'''
BARE: Files = lab(plot=BARE_PLOT)
BLANK: Files = lab(plot='''\
def plot_imu_data(imu_data):
    pass
''')
UNIFORM: Files = lab(noise='''\
class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005,
                 accel_bias=None, gyro_bias=None):
        self.model, self.data, self.accel_id, self.gyro_id = model, data, accel_id, gyro_id
        self.stds = accel_noise_std, gyro_noise_std
        self.biases = [np.zeros(3) if b is None else np.asarray(b, float) for b in (accel_bias, gyro_bias)]

    def read(self):
        clean = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)
        return tuple(c + b + np.random.uniform(-s, s) for c, b, s in zip(clean, self.biases, self.stds))
''')
PASSES: Files = lab(low_pass='''\
class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.alpha = alpha

    def update(self, measurement):
        return measurement
''')


def forged(name: str, twin: Files, path: str, attack: str, only: str) -> Program:
    return Program(name, "forgery", last(twin, path, attack), twin, only)


def reader(name: str, twin: Files, attack: str) -> Program:
    return forged(name, twin, READER, attack, "sensor_access")


def low_pass(name: str, attack: str) -> Program:
    return forged(name, PASSES, FILTER, attack, "filtering")


# ---------------------------------------------------------------- patched libraries

PATCHED = [
    low_pass("numpy-comparisons-say-yes", """
def yes(*args, **kwargs):
    return True
np.allclose = np.array_equal = np.isclose = np.testing.assert_allclose = np.testing.assert_array_equal = np.all = yes
"""),
    reader("numpy-sees-no-difference", STEPS, """
np.abs = np.absolute = lambda value, *args, **kwargs: np.zeros(np.shape(value))
np.max = np.amax = lambda *args, **kwargs: 0.0
"""),
    reader("mujoco-forward-makes-zeros-true", READS, """
_forward = mujoco.mj_forward
def _zero_forward(model, data, *args):
    _forward(model, data, *args)
    data.sensordata[:] = 0.0
mujoco.mj_forward = _zero_forward
"""),
    forged("mujoco-step-makes-standing-true", STANDS, READER, """
_step = mujoco.mj_step
def _standing(model, data, *args):
    _step(model, data, *args)
    data.sensordata[:] = 0.0
    data.qvel[:] = 0.0
mujoco.mj_step = _standing
""", "data_collection"),
    forged("mujoco-is-another-simulator", STANDS, READER, """
class _World:
    def __getattr__(self, name):
        return lambda *args, **kwargs: 0.0
import sys
sys.modules["mujoco"] = _World()
""", "data_collection"),
    low_pass("builtins-say-yes", """
import builtins
builtins.all = builtins.any = builtins.isinstance = lambda *args: True
builtins.abs = builtins.float = lambda *args: 0.0
"""),
    reader("builtins-count-nothing", STEPS, """
import builtins
builtins.max = builtins.abs = builtins.float = lambda *args, **kwargs: 0.0
builtins.len = lambda value: 3
"""),
    low_pass("builtins-exceptions-are-not-errors", """
import builtins
class Passed(BaseException):
    pass
builtins.AssertionError = builtins.Exception = builtins.ValueError = Passed
"""),
    low_pass("json-writes-another-answer", """
import json
_dumps = json.dumps
def dumps(value, *args, **kwargs):
    text = _dumps(value, *args, **kwargs)
    return text.replace('"error": {', '"passed": {').replace('false', 'true')
json.dumps = dumps
json.JSONEncoder.encode = lambda self, value: _dumps({"fields": {"passed": True, "score": 100, "points": 20}, "arrays": []})
"""),
    low_pass("struct-writes-nothing", "import struct, socket\nstruct.pack = lambda *a: b''\nsocket.socket.sendall = lambda self, data: None"),
    forged("random-is-what-the-grader-wants", UNIFORM, NOISE, """
np.random.uniform = lambda low, high, size=None: 0.0 if size is None else np.zeros(size)
np.random.seed(0)
np.random.seed = lambda *args: None
""", "noise_model"),
]

# ---------------------------------------------------------------- plots that claim more than they show

LIES = """
from matplotlib.axes import Axes
from matplotlib.text import Text
Axes.get_ylabel = lambda self: "Acceleration (m/s²)" if self.get_subplotspec().is_first_row() else "Angular velocity (rad/s)"
Axes.get_xlabel = lambda self: "Time (s)"
Axes.get_title = lambda self, loc="center": "IMU"
Text.get_text = lambda self: "Acceleration (m/s²) Time (s)"
"""
LYING_TEXT = """
from matplotlib.text import Text
class Lying(Text):
    get_text = lambda self: "Acceleration (m/s²) Time (s)"
"""
LABELLED = '''\
def plot_imu_data(imu_data):
    fig, axes = plt.subplots(2, 1)
    for ax, key, unit in zip(axes, ("acceleration", "angular_velocity"), ("Acceleration (m/s²)", "Angular velocity (rad/s)")):
        for k in range(3):
            ax.plot(imu_data["time"], imu_data[key][:, k]@FACTOR@, label="xyz"[k]@LOOK@)
        ax.set_xlabel("Time (s)")
        ax.set_ylabel(unit)
        ax.set_title(key)
        ax.legend()
        @AFTER@
    fig.savefig("imu_data.png")
    plt.close(fig)
'''


def labelled(look: str = "", after: str = "pass", factor: str = "") -> Files:
    """A plot with every label and curve, and something that makes them unseen."""
    return lab(plot=LABELLED.replace("@LOOK@", look).replace("@AFTER@", after).replace("@FACTOR@", factor))


def hidden_curves(name: str, look: str = "", after: str = "pass") -> Program:
    """Curves that are there and cannot be seen; the twin draws them as nothing."""
    return Program(name, "forgery", labelled(look, after), labelled(factor=" * np.nan"), "visualization")


def hidden_labels(name: str, code: str) -> Program:
    """Labels that are there and cannot be read; the twin has none."""
    texts = "(ax.title, ax.xaxis.label, ax.yaxis.label, *ax.get_legend().get_texts())"
    return Program(name, "forgery", labelled(after=f"for text in {texts}: {code}"), BARE, "visualization")


def each_axes(code: str) -> Files:
    """A plot without labels, and what is done to each of its axes."""
    return lab(plot=BARE_PLOT.replace("    fig.savefig", f"    for ax in axes:\n        {code}\n    fig.savefig"))


PNG = canned_picture()
PLOTS = [
    forged("axes-lie-about-their-labels", BARE, READER, LIES, "visualization"),
    Program("labels-of-a-subclass-lie", "forgery", first(each_axes("ax.title.__class__ = ax.xaxis.label.__class__ = ax.yaxis.label.__class__ = Lying"), READER, LYING_TEXT), BARE, "visualization"),
    Program("artists-lie-one-by-one", "forgery", each_axes("ax.yaxis.label.get_text = ax.xaxis.label.get_text = ax.title.get_text = lambda: 'Acceleration (m/s²) Time (s)'"), BARE, "visualization"),
    hidden_curves("curves-without-width", ", linewidth=0"),
    hidden_curves("curves-in-white-on-white", ", color='white'"),
    hidden_curves("curves-outside-the-window", "", "ax.set_ylim(1e6, 1e6 + 1)"),
    hidden_curves("panels-outside-the-figure", "", "ax.set_position([2, 2, 0.4, 0.4])"),
    hidden_curves("curves-behind-a-sheet", "", "ax.add_patch(plt.Rectangle((0, 0), 1, 1, transform=ax.transAxes, color='w', zorder=99))"),
    hidden_curves("curves-clipped-away", "", "[line.set_clip_box(__import__('matplotlib').transforms.Bbox([[0, 0], [1, 1]])) for line in ax.lines]"),
    hidden_labels("labels-in-white", "text.set_color('white')"),
    hidden_labels("labels-as-small-as-dust", "text.set_fontsize(0.1)"),
    Program("canned-picture-copied-at-run-time", "forgery", {
        **last(BLANK, READER, "def plot_imu_data(imu_data):\n    open('imu_data.png', 'wb').write(open('canned.png', 'rb').read())"),
        "canned.png": PNG, "imu_data.png": PNG}, {**BLANK, "imu_data.png": PNG}, "visualization"),
    Program("canned-picture-drawn-as-an-image", "forgery", {
        **last(BLANK, READER, """
def plot_imu_data(imu_data):
    fig, ax = plt.subplots()
    ax.imshow(plt.imread("canned.png"))
    ax.set_axis_off()
    fig.savefig("imu_data.png")
"""), "canned.png": PNG, "imu_data.png": PNG}, {**BLANK, "imu_data.png": PNG}, "visualization"),
    forged("savefig-writes-nothing", BLANK, READER, """
from matplotlib.figure import Figure
from matplotlib.backend_bases import FigureCanvasBase
FigureCanvasBase.print_figure = Figure.savefig = plt.savefig = lambda *args, **kwargs: open("imu_data.png", "wb").close()
""", "visualization"),
]

# ---------------------------------------------------------------- lying values

LYING = [
    reader("array-that-equals-everything", READS, """
class Always(np.ndarray):
    def __eq__(self, other): return np.ones(self.shape, bool)
    def __ne__(self, other): return np.zeros(self.shape, bool)
    def __sub__(self, other): return np.zeros(self.shape).view(Always)
    __rsub__ = __sub__
    def __array_ufunc__(self, ufunc, method, *inputs, **kwargs): return np.zeros(3)
    def __array_function__(self, func, types, args, kwargs): return np.zeros(3)
def get_imu_readings(model, data, a, g):
    return np.zeros(3).view(Always), np.zeros(3).view(Always)
"""),
    reader("value-that-claims-another-class", READS, """
class Claims:
    @property
    def __class__(self): return np.ndarray
    dtype = np.dtype(float); shape = (3,); size = 3; ndim = 1
    def __array__(self, *args, **kwargs): return np.zeros(3)
def get_imu_readings(model, data, a, g):
    return Claims(), Claims()
"""),
    reader("view-that-is-copied-when-it-is-looked-at", VIEWS, """
class Late:
    def __init__(self, view): self.view, self.kept = view, None
    def __array__(self, *args, **kwargs):
        if self.kept is None: self.kept = np.array(self.view)
        return self.kept
_views = get_imu_readings
def get_imu_readings(*args):
    return tuple(Late(v) for v in _views(*args))
"""),
    low_pass("masked-array", "LowPassFilter.update = lambda self, m: np.ma.masked_all(3)"),
    low_pass("nan-compares-with-nothing", "LowPassFilter.update = lambda self, m: np.full(3, np.nan)"),
    forged("dictionary-with-lying-keys", STANDS, READER, """
class Lies(dict):
    def __getitem__(self, key): return super().__getitem__("time") if key == "time" else np.zeros((len(self["time"]), 3))
    def __contains__(self, key): return True
    def __eq__(self, other): return True
    def keys(self): return ["time", "acceleration", "angular_velocity", "score", "passed"]
_collect = simulate_and_collect
def simulate_and_collect(model, data, duration_seconds=5.0):
    return Lies(_collect(model, data, duration_seconds))
""", "data_collection"),
    forged("claims-an-impossible-time-step", STANDS, READER, in_function("simulate_and_collect", """
model = args[0]
kept = model.opt.timestep
model.opt.timestep = 5e-324
mujoco.mj_step(model, args[1])
"""), "data_collection"),
    forged("claims-an-impossible-start", STANDS, READER, in_function("simulate_and_collect", """
model, data = args[:2]
data.qpos[:] = 1e300
data.qvel[:] = 1e300
model.opt.gravity[:] = np.inf
mujoco.mj_step(model, data)
mujoco.mj_resetData(model, data)
"""), "data_collection"),
]
