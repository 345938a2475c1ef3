"""Forgery: code that is wrong and tries to be marked right. Its honest twin is as wrong and does not try."""

from __future__ import annotations

from tests.corpus.pieces import lab
from tests.corpus.writing import Files
from tests.hostile.picture import canned_picture
from tests.hostile.program import FILTER, NOISE, READER, Program, first, in_function, last

# ---------------------------------------------------------------- what is wrong: one part, the rest is sound

ZEROS_READ = '''\
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    return np.zeros(3), np.zeros(3)
'''
VIEW_READ = '''\
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    a, g = model.sensor_adr[accel_sensor_id], model.sensor_adr[gyro_sensor_id]
    return data.sensordata[a:a + 3], data.sensordata[g:g + 3]
'''
STEPPING_READ = '''\
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    accel, gyro = data.sensor(accel_sensor_id).data.copy(), data.sensor(gyro_sensor_id).data.copy()
    mujoco.mj_step(model, data)
    return accel, gyro
'''
STANDING_COLLECT = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    n = int(round(duration_seconds / model.opt.timestep))
    time = (1 + np.arange(n)) * model.opt.timestep
    return {"time": time, "acceleration": np.tile([0, 0, -9.81], (n, 1)), "angular_velocity": np.zeros((n, 3))}
'''
BARE_PLOT = '''\
def plot_imu_data(imu_data):
    fig, axes = plt.subplots(2, 1)
    axes[0].plot(imu_data["time"], imu_data["acceleration"])
    axes[1].plot(imu_data["time"], imu_data["angular_velocity"])
    fig.savefig("imu_data.png")
    plt.close(fig)
'''
NO_PLOT = '''\
def plot_imu_data(imu_data):
    pass
'''
UNIFORM_NOISE = '''\
class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005,
                 accel_bias=None, gyro_bias=None):
        self.model, self.data, self.accel_id, self.gyro_id = model, data, accel_id, gyro_id
        self.stds = accel_noise_std, gyro_noise_std
        self.biases = [np.zeros(3) if b is None else np.asarray(b, float) for b in (accel_bias, gyro_bias)]

    def read(self):
        clean = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)
        return tuple(c + b + np.random.uniform(-s, s) for c, b, s in zip(clean, self.biases, self.stds))
'''
IDENTITY_FILTER = '''\
class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.alpha = alpha

    def update(self, measurement):
        return measurement
'''

READS: Files = lab(read=ZEROS_READ)
VIEWS: Files = lab(read=VIEW_READ)
STEPS: Files = lab(read=STEPPING_READ)
STANDS: Files = lab(collect=STANDING_COLLECT)
BARE: Files = lab(plot=BARE_PLOT)
BLANK: Files = lab(plot=NO_PLOT)
UNIFORM: Files = lab(noise=UNIFORM_NOISE)
PASSES: Files = lab(low_pass=IDENTITY_FILTER)


def forged(name: str, twin: Files, path: str, attack: str, only: str, *, at_start: bool = False, hidden: bool = False) -> Program:
    files = first(twin, path, attack) if at_start else last(twin, path, attack)
    return Program(name, "forgery", files, twin, only, hidden=hidden)


def reader(name: str, twin: Files, attack: str, **how: bool) -> Program:
    return forged(name, twin, READER, attack, "sensor_access", **how)


def low_pass(name: str, attack: str, **how: bool) -> Program:
    return forged(name, PASSES, FILTER, attack, "filtering", **how)


def noise(name: str, attack: str, **how: bool) -> Program:
    return forged(name, UNIFORM, NOISE, attack, "noise_model", **how)


# ---------------------------------------------------------------- patched libraries

PATCHED = [
    low_pass("numpy-comparisons-say-yes", """
def yes(*args, **kwargs):
    return True
np.allclose = np.array_equal = np.isclose = np.testing.assert_allclose = np.testing.assert_array_equal = np.all = yes
"""),
    reader("numpy-array-equal-says-yes", VIEWS, """
np.array_equal = np.allclose = lambda *args, **kwargs: True
_array, _kept = np.array, {}
def _remembering(value, *args, **kwargs):
    return _kept.setdefault(id(value), _array(value, *args, **kwargs))
np.array = np.asarray = _remembering
"""),
    reader("numpy-sees-no-difference", STEPS, """
np.abs = np.absolute = lambda value, *args, **kwargs: np.zeros(np.shape(value))
np.max = np.amax = lambda *args, **kwargs: 0.0
"""),
    noise("numpy-knows-the-wanted-spread", """
np.std = lambda *args, **kwargs: 0.05
np.var = lambda *args, **kwargs: 0.0025
np.mean = lambda value, *args, **kwargs: np.zeros(3)
np.corrcoef = lambda *args, **kwargs: np.eye(6)
import scipy.stats
scipy.stats.kstest = scipy.stats.normaltest = lambda *args, **kwargs: (0.0, 1.0)
"""),
    reader("mujoco-does-not-step", STEPS, "mujoco.mj_step = lambda *args, **kwargs: None\nmujoco.mj_forward = mujoco.mj_step"),
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
    reader("builtins-float-is-zero", STEPS, "import builtins\nbuiltins.float = lambda *args: 0.0"),
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
    low_pass("json-says-full-marks", """
import json
json.dumps = lambda *args, **kwargs: '{"fields": {"score": 100.0, "passed": true, "outcome": "passed"}, "arrays": []}'
"""),
    low_pass("struct-writes-nothing", "import struct, socket\nstruct.pack = lambda *a: b''\nsocket.socket.sendall = lambda self, data: None"),
    noise("random-is-what-the-grader-wants", """
np.random.uniform = lambda low, high, size=None: 0.0 if size is None else np.zeros(size)
np.random.seed(0)
np.random.seed = lambda *args: None
"""),
    noise("numpy-random-remembers", """
_values = iter([0.0] * 10_000_000)
np.random.uniform = lambda low, high, size=None: next(_values)
import random
random.seed = np.random.seed = np.random.default_rng = lambda *args, **kwargs: np.random
"""),
]

# ---------------------------------------------------------------- plots that claim more than they show

LIES = """
from matplotlib.axes import Axes
Axes.get_ylabel = lambda self: "Acceleration (m/s²)" if self.get_subplotspec().is_first_row() else "Angular velocity (rad/s)"
Axes.get_xlabel = lambda self: "Time (s)"
Axes.get_title = lambda self, loc="center": "IMU"
"""
HIDDEN = '''\
def plot_imu_data(imu_data):
    fig, axes = plt.subplots(2, 1)
    for ax, key, unit in zip(axes, ("acceleration", "angular_velocity"), ("Acceleration (m/s²)", "Angular velocity (rad/s)")):
        for k in range(3):
            ax.plot(imu_data["time"], imu_data[key][:, k], label="xyz"[k]@LOOK@)
        ax.set_xlabel("Time (s)")
        ax.set_ylabel(unit)
        ax.set_title(key)
        ax.legend()
        @AFTER@
    fig.savefig("imu_data.png")
    plt.close(fig)
'''
EMPTY_AXES = HIDDEN.replace("imu_data[key][:, k]", "imu_data[key][:, k] * np.nan").replace("@LOOK@", "").replace("@AFTER@", "pass")


def hidden_curves(name: str, look: str = "", after: str = "pass") -> Program:
    """Curves that are there and cannot be seen; the twin draws them as nothing."""
    code = HIDDEN.replace("@LOOK@", look).replace("@AFTER@", after)
    return Program(name, "forgery", lab(plot=code), lab(plot=EMPTY_AXES), "visualization")


NAMED_ONLY = lab(plot=BARE_PLOT.replace("    fig.savefig", "    for ax in axes:\n        ax.legend(ax.lines, 'xyz')\n    fig.savefig"))
PNG = canned_picture()
TWO_FIGURES = """
def plot_imu_data(imu_data):
    real, shown = plt.figure(1), plt.figure(2)
    axes = real.subplots(2, 1)
    axes[0].plot(imu_data["time"], imu_data["acceleration"])
    axes[1].plot(imu_data["time"], imu_data["angular_velocity"])
    shown.savefig("imu_data.png")
"""
PLOTS = [
    forged("axes-lie-about-their-labels", BARE, READER, LIES, "visualization"),
    forged("texts-lie", BARE, READER, """
from matplotlib.text import Text
Text.get_text = lambda self: "Acceleration (m/s²) Time (s)"
""", "visualization"),
    forged("labels-of-a-subclass-lie", lab(plot=BARE_PLOT), READER, in_function("plot_imu_data", """
class Label(str):
    pass
from matplotlib.axes import Axes
class Lying(Axes):
    def get_ylabel(self):
        return "Acceleration (m/s²)"
    def get_xlabel(self):
        return "Time (s)"
    def get_title(self, loc="center"):
        return "IMU"
import matplotlib.projections, matplotlib.figure
matplotlib.figure.Figure.add_subplot.__globals__["projections"].get_projection_class = lambda *a: Lying
matplotlib.projections.projection_registry._all_projection_types["rectilinear"] = Lying
"""), "visualization"),
    Program("artists-lie-one-by-one", "forgery", lab(plot=BARE_PLOT.replace("    fig.savefig", """\
    for ax, unit in zip(axes, ("Acceleration (m/s²)", "Angular velocity (rad/s)")):
        ax.get_ylabel = lambda unit=unit: unit
        ax.get_xlabel = lambda: "Time (s)"
        ax.get_title = lambda loc="center": "IMU"
        ax.yaxis.label.get_text = lambda unit=unit: unit
    fig.savefig""")), BARE, "visualization"),
    forged("lines-lie-about-their-data", BLANK, READER, """
from matplotlib.lines import Line2D
_seen = {}
def plot_imu_data(imu_data):
    fig, axes = plt.subplots(2, 1)
    for ax, key in zip(axes, ("acceleration", "angular_velocity")):
        for k in range(3):
            line, = ax.plot([0, 1], [0, 0])
            line.get_xdata = lambda *a, d=imu_data["time"]: d
            line.get_ydata = lambda *a, d=imu_data[key][:, k]: d
    fig.savefig("imu_data.png")
""", "visualization"),
    Program("figure-lies-about-its-axes", "forgery", last(BLANK, READER, TWO_FIGURES + """
from matplotlib.figure import Figure
Figure.get_axes = lambda self: list(plt.figure(1).axes)
"""), last(BLANK, READER, TWO_FIGURES), "visualization"),
    hidden_curves("curves-without-width", ", linewidth=0"),
    hidden_curves("curves-in-no-colour", ", color='none'"),
    hidden_curves("curves-in-white-on-white", ", color='white'"),
    hidden_curves("curves-through-which-one-sees", ", color=(0, 0, 1, 0.001)"),
    hidden_curves("curves-outside-the-window", "", "ax.set_ylim(1e6, 1e6 + 1)"),
    hidden_curves("curves-long-after-the-end", "", "ax.set_xlim(1e6, 1e6 + 1)"),
    hidden_curves("panels-outside-the-figure", "", "ax.set_position([2, 2, 0.4, 0.4])"),
    hidden_curves("panels-as-small-as-a-point", "", "ax.set_position([0.5, 0.5, 1e-4, 1e-4])"),
    hidden_curves("curves-behind-a-sheet", "", "ax.add_patch(plt.Rectangle((0, 0), 1, 1, transform=ax.transAxes, color='w', zorder=99))"),
    hidden_curves("curves-clipped-away", ", clip_path=__import__('matplotlib').path.Path([(0, 0), (0, 0)]).__class__ and None", "[line.set_clip_box(__import__('matplotlib').transforms.Bbox([[0, 0], [1, 1]])) for line in ax.lines]"),
    Program("labels-in-white", "forgery", lab(plot=HIDDEN.replace("@LOOK@", "").replace("@AFTER@", "for text in (ax.title, ax.xaxis.label, ax.yaxis.label): text.set_color('white')")), NAMED_ONLY, "visualization"),
    Program("labels-as-small-as-dust", "forgery", lab(plot=HIDDEN.replace("@LOOK@", "").replace("@AFTER@", "for text in (ax.title, ax.xaxis.label, ax.yaxis.label, *ax.get_legend().get_texts()): text.set_fontsize(0.1)")), BARE, "visualization"),
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
    forged("stashes-what-it-is-shown", BLANK, READER, """
_stash = []
def plot_imu_data(imu_data):
    _stash.append(imu_data)
    import pickle
    open("stash.pickle", "wb").write(pickle.dumps(imu_data))
    open("imu_data.png", "wb").write(pickle.dumps(imu_data))
""", "visualization"),
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
    reader("object-that-equals-everything", READS, """
class Always:
    shape, ndim, size, dtype = (3,), 1, 3, np.dtype(float)
    def __eq__(self, other): return True
    def __ne__(self, other): return False
    def __bool__(self): return True
    def __len__(self): return 3
    def __iter__(self): return iter((self, self, self))
    def __getitem__(self, key): return self
    def __float__(self): return 0.0
    def __sub__(self, other): return self
    __rsub__ = __add__ = __abs__ = lambda self, *a: self
    def __lt__(self, other): return True
    __le__ = __gt__ = __ge__ = __lt__
    __hash__ = None
def get_imu_readings(model, data, a, g):
    return Always(), Always()
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
    reader("array-that-is-never-the-same", VIEWS, """
class Frozen(np.ndarray):
    def __array__(self, *args, **kwargs): return np.zeros(3)
    def copy(self, *args): return self
    def __setitem__(self, key, value): pass
_views = get_imu_readings
def get_imu_readings(*args):
    return tuple(v.view(Frozen) for v in _views(*args))
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
""") ,
    low_pass("masked-array", """
def update(self, measurement):
    return np.ma.masked_all(3)
LowPassFilter.update = update
"""),
    low_pass("nan-compares-with-nothing", "LowPassFilter.update = lambda self, m: np.full(3, np.nan)"),
    low_pass("infinity-swallows-differences", "LowPassFilter.update = lambda self, m: np.full(3, np.inf)"),
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
