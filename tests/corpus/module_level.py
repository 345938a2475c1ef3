"""The sheet's own layout, everything at module level, with one edit each: what a file defines counts, whatever else it does.

Each edit is made in the sheet's steps, and the steps are handed in as three files, as one file and as a notebook. What a fair
marker takes at most is written beside it: the points by criterion, nothing elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from tests.corpus import sheet
from tests.corpus.writing import Files, notebook

STEPS: Mapping[str, str] = {
    "model": sheet.STEP_1,
    "reader": sheet.READER,
    "reading": sheet.STEP_2_DEMO,
    "recorder": sheet.COLLECT,
    "recording": sheet.STEP_3_DEMO,
    "plot": sheet.PLOT,
    "plotting": sheet.STEP_4_DEMO,
    "noise": sheet.NOISY_IMU,
    "noisy": sheet.STEP_5_DEMO,
    "filter": sheet.LOW_PASS,
    "filtering": sheet.STEP_6_DEMO,
}
FILES: Mapping[str, tuple[str, ...]] = {
    "imu_reader.py": ("model", "reader", "reading", "recorder", "recording", "plot", "plotting"),
    "noisy_imu.py": ("noise", "noisy"),
    "filters.py": ("filter", "filtering"),
}
_HEADS = {"imu_reader.py": "", "noisy_imu.py": "from imu_reader import *\n\n", "filters.py": "from noisy_imu import *\n\n"}

Steps = dict[str, str]


@dataclass(frozen=True)
class Edit:
    """One edit of the sheet's code.

    Attributes
    ----------
    name : unique; words joined by hyphens
    steps : the sheet's steps with the edit
    takes : criterion -> the most points that a fair marker takes; elsewhere none
    must : criteria that have to lose something
    """

    name: str
    steps: Steps
    takes: Mapping[str, float] = field(default_factory=dict)
    must: tuple[str, ...] = ()


def three_files(steps: Steps) -> Files:
    return {name: _HEADS[name] + sheet.together(*(steps[part] for part in parts)) for name, parts in FILES.items()}


def one_file(steps: Steps) -> Files:
    return {"lab.py": sheet.together(*steps.values())}


def one_notebook(steps: Steps) -> Files:
    return {"lab.ipynb": notebook(*steps.values())}


LAYOUTS: Mapping[str, Callable[[Steps], Files]] = {
    "three-files": three_files,
    "one-file": one_file,
    "notebook": one_notebook,
}


def changed(**changes: tuple[str, str]) -> Steps:
    """The steps with one passage of some exchanged; each must be there exactly once."""
    for name, (old, _) in changes.items():
        if STEPS[name].count(old) != 1:
            raise ValueError(f"{name} holds {STEPS[name].count(old)} of {old!r}, one is needed")
    return {**STEPS, **{name: STEPS[name].replace(*change) for name, change in changes.items()}}


def above(step: str, code: str) -> Steps:
    """The steps with code above one of them."""
    return {**STEPS, step: f"{code}\n\n{STEPS[step]}"}


def below(step: str, code: str) -> Steps:
    """The steps with code below one of them."""
    return {**STEPS, step: f"{STEPS[step]}\n{code}\n"}


# ---------------------------------------------------------------- in a function that code at module level calls

ENDINGS = {
    "loop": "while True: pass",
    "exit": "import os; os._exit(0)",
    "sys-exit": "import sys; sys.exit(1)",
    "segfault": "import ctypes; ctypes.string_at(0)",
    "abort": "import os; os.abort()",
    "raise": "raise RuntimeError('still to be done')",
}
# The step, a line of it, what its criterion may lose: the comparison of raw and filtered is drawn elsewhere.
BODIES = {
    "reader": ("reader", "    accel_adr = model.sensor_adr[accel_sensor_id]\n", {"sensor_access": 20}),
    "recorder": ("recorder", "    dt = model.opt.timestep\n", {"data_collection": 20}),
    "plot": ("plot", "    fig, axes = plt.subplots(2, 1, figsize=(12, 8), sharex=True)\n", {"visualization": 16}),
    "noise": ("noise", "        accel, gyro = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)\n", {"noise_model": 20}),
    "filter": ("filter", "        if self.value is None:\n", {"filtering": 20}),
}  # fmt: skip


def ended(body: str, ending: str) -> Edit:
    step, line, takes = BODIES[body]
    indent = line[: len(line) - len(line.lstrip())]
    return Edit(f"{ending}-in-{body}", changed(**{step: (line, f"{indent}{ENDINGS[ending]}\n{line}")}), takes, tuple(takes))


IN_FUNCTIONS = [ended(body, ending) for body in BODIES for ending in ENDINGS]

# ---------------------------------------------------------------- at module level itself

LONG = """\
for _ in range(10_000_000):
    mujoco.mj_step(model, data)
"""
SWALLOWING = """\
while True:
    try:
        mujoco.mj_step(model, data)
    except:
        pass
"""
LIVE = "plt.ion()\nwhile True:\n    plt.pause(0.01)\n"
AT_MODULE_LEVEL = [
    Edit("loop-between", above("recorder", "while True: pass")),
    Edit("exit-between", above("recorder", "import os\nos._exit(0)")),
    Edit("sys-exit-between", above("plot", "import sys\nsys.exit()")),
    Edit("quit-between", above("recorder", "quit()")),
    Edit("segfault-between", above("recorder", "import ctypes\nctypes.string_at(0)")),
    Edit("abort-above-the-filter", above("filter", "import os\nos.abort()")),
    Edit("kill-above-the-noise", above("noise", "import os, signal\nos.kill(os.getpid(), signal.SIGKILL)")),
    Edit("raise-between", above("recorder", "raise NotImplementedError")),
    Edit("assert-between", above("plot", "assert accel[2] > 0, 'gravity'")),
    Edit("recursion-between", above("plot", "(lambda f: f(f))(lambda f: f(f))")),
    Edit("misspelled-call", above("recorder", "mujoco.mj_stp(model, data)")),
    Edit("misspelled-name", changed(reading=('{accel}"', '{acel}"'))),
    Edit("long-demo", above("plot", LONG)),
    Edit("long-demo-in-the-noise", above("noise", LONG)),
    Edit("loop-that-swallows", above("filter", SWALLOWING)),
    Edit("loop-in-c", above("recorder", "total = sum(range(10**14))")),
    Edit("waits-for-ever", above("recorder", "import threading\nthreading.Event().wait()")),
    Edit("thread-for-ever", above("recorder", "import threading\ndef watch():\n    while True: pass\nthreading.Thread(target=watch, daemon=True).start()")),
    Edit("live-plot-for-ever", above("plot", LIVE)),
    Edit("missing-csv", above("recorder", "log = np.loadtxt('log.csv', delimiter=',')\nprint(log.mean())")),
    Edit("wrong-model-path", changed(model=("humanoid-sensors.xml", "humanoid.xml")), {"visualization": 4}),
    Edit("input-between", above("recorder", "input('Press Enter to go on')")),
    Edit("undefined-dot", above("plot", "data.show()")),
    Edit("bad-statement-then-another-definition", above("recorder", "1 / 0\n\ndef get_imu_readings(model, data, a, g):\n    return np.zeros(3), np.zeros(3)"), {"sensor_access": 20}, ("sensor_access",)),
]  # fmt: skip

# ---------------------------------------------------------------- packages, stars, debuggers

PACKAGES = [
    Edit("pandas-unused", above("model", "import pandas as pd")),
    Edit("pandas-unused-in-each", {**above("noise", "import pandas as pd"), **{"model": "import pandas as pd\n" + STEPS["model"], "filter": "import pandas as pd\n" + STEPS["filter"]}}),
    Edit("two-imports-in-a-line", changed(model=("import numpy as np\n", "import pandas as pd, numpy as np\n"))),
    Edit("plotly-unused", above("filter", "from plotly.subplots import make_subplots\nimport plotly.graph_objects as go")),
    Edit("seaborn-theme", above("plot", "import seaborn as sns\nsns.set_theme(style='darkgrid')")),
    Edit("tqdm-in-the-demo", changed(model=("import mujoco\n", "from tqdm import tqdm\nimport mujoco\n"), filtering=("in range(n_samples)", "in tqdm(range(n_samples))")), {"visualization": 4}),
    Edit("tqdm-in-the-recorder", changed(model=("import mujoco\n", "from tqdm import tqdm\nimport mujoco\n"), recorder=("in range(n_steps)", "in tqdm(range(n_steps))")), {"data_collection": 20}, ("data_collection",)),
    Edit("tqdm-or-not", changed(model=("import mujoco\n", "try:\n    from tqdm import tqdm\nexcept ImportError:\n    tqdm = iter\nimport mujoco\n"), recorder=("in range(n_steps)", "in tqdm(range(n_steps))"))),
    Edit("cv2-in-the-plot", changed(plot=('    fig, axes', "    import cv2\n    fig, axes")), {"visualization": 16}, ("visualization",)),
    Edit("pandas-as-a-hint", changed(model=("import mujoco\n", "import mujoco\nimport pandas as pd\n"), plot=("(imu_data):", "(imu_data: pd.DataFrame) -> None:"))),
    Edit("hint-of-nothing", changed(reader=("gyro_sensor_id):", "gyro_sensor_id) -> Tuple[np.ndarray, np.ndarray]:"))),
    Edit("numba-on-the-filter", changed(filter=("    def update(", "    @njit\n    def update(")), {"filtering": 20}, ("filtering",)),
    Edit("pylab-star", above("model", "from pylab import *")),
    Edit("mujoco-star", above("model", "from mujoco import *")),
    Edit("pyplot-star", changed(recorder=("import matplotlib.pyplot as plt\n", "import matplotlib.pyplot as plt\nfrom matplotlib.pyplot import *\n"))),
    Edit("numpy-star", above("model", "from numpy import *")),
    Edit("every-star", {**above("model", "from pylab import *\nfrom mujoco import *\nfrom numpy import *"), "filter": "from scipy.signal import *\nfrom scipy.stats import *\n" + STEPS["filter"]}),
    Edit("breakpoint-in-the-reader", changed(reader=("    # Get sensor data addresses\n", "    breakpoint()\n"))),
    Edit("breakpoint-between", above("recorder", "breakpoint()")),
    Edit("pdb-in-the-noise", changed(noise=("        # Add Gaussian noise\n", "        import pdb; pdb.set_trace()\n"))),
    Edit("pdb-in-the-filter", changed(filter=("        if self.value is None:\n", "        from pdb import set_trace\n        set_trace()\n        if self.value is None:\n"))),
    Edit("ipdb-in-the-recorder", changed(recorder=("    # Reset simulation\n", "    import ipdb; ipdb.set_trace()\n"))),
]  # fmt: skip

# ---------------------------------------------------------------- what else decides over names

NAMES = [
    Edit("class-body-raises", changed(filter=("    def __init__", "    DEFAULT = ALPHA\n\n    def __init__")), {"filtering": 20}, ("filtering",)),
    Edit("decorator-raises", changed(noise=("class NoisyIMU", "@dataclas\nclass NoisyIMU")), {"noise_model": 20}, ("noise_model",)),
    Edit("default-raises", changed(plot=("(imu_data):", "(imu_data=DATA):")), {"visualization": 16}, ("visualization",)),
    Edit("ids-are-deleted", below("plotting", "del accel_id, gyro_id"), {"visualization": 4}),
    Edit("model-is-deleted", below("filtering", "del model, data, imu_data")),
    Edit("reader-is-deleted", below("plotting", "del get_imu_readings"), {"visualization": 4}),
    Edit("defined-in-a-try", {**STEPS, "filter": "try:\n    import scipy\n" + "".join(f"    {line}" if line.strip() else line for line in STEPS["filter"].splitlines(True)) + "except ImportError:\n    pass\n"}),
    Edit("defined-in-an-if", {**STEPS, "noise": "if True:\n" + "".join(f"    {line}" if line.strip() else line for line in STEPS["noise"].splitlines(True))}),
    Edit("functions-in-a-loop", above("recorder", "for name in ('accel', 'gyro'):\n    exec(f'def read_{name}(): return {name}_id')")),
    Edit("another-name-for-the-filter", {**changed(filter=("class LowPassFilter", "class Smoother")), "filtering": "LowPassFilter = Smoother\n\n" + STEPS["filtering"]}),
    Edit("demo-below-a-guard", {**STEPS, "filtering": "def main():\n    while True:\n        mujoco.mj_step(model, data)\n\n\nif __name__ == '__main__':\n    main()\n"}, {"visualization": 4}),
    Edit("guard-that-exits", below("recording", "if __name__ == '__main__':\n    import os\n    os._exit(3)")),
]  # fmt: skip

# ---------------------------------------------------------------- the globals of one program in place of what a function is given

_READER, _RECORDER = "get_imu_readings(model, data, ", "simulate_and_collect(model, data, "
_IDS = ("accel_sensor_id, gyro_sensor_id", "accel_id, gyro_id")
_FALLBACK = """\
    m, d = m or model, d or data
    accel_adr = m.sensor_adr[accel_id if accel_sensor_id is None else accel_sensor_id]
    gyro_adr = m.sensor_adr[gyro_id if gyro_sensor_id is None else gyro_sensor_id]

    # Extract readings (each is 3D)
    acceleration = d.sensordata[accel_adr:accel_adr+3].copy()
    angular_velocity = d.sensordata[gyro_adr:gyro_adr+3].copy()
"""


def everywhere(*changes: tuple[str, str]) -> Steps:
    """The steps with these passages exchanged wherever they stand; each must be there."""
    steps = STEPS
    for old, new in changes:
        if not any(old in text for text in steps.values()):
            raise ValueError(f"no step holds {old!r}")
        steps = {name: text.replace(old, new) for name, text in steps.items()}
    return dict(steps)


def _between(step: str, first: str, last: str) -> str:
    text = STEPS[step]
    return text[text.index(first) : text.index(last)]


GLOBALS = [
    Edit("reader-of-the-globals", changed(reader=(_READER, "get_imu_readings(m, d, ")), {"sensor_access": 3}, ("sensor_access",)),
    Edit("reader-of-the-global-data", changed(reader=(_READER, "get_imu_readings(model, d, ")), {"sensor_access": 3}, ("sensor_access",)),
    Edit(
        "reader-without-parameters",
        everywhere(
            (f"{_READER}{_IDS[0]}", "get_imu_readings("), (f"{_READER}{_IDS[1]}", "get_imu_readings("),
            ("get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)", "get_imu_readings()"),
            ("[accel_sensor_id]", "[accel_id]"), ("[gyro_sensor_id]", "[gyro_id]"),
        ),
        {"sensor_access": 6},
        ("sensor_access",),
    ),
    Edit(
        "reader-with-globals-by-default",
        changed(reader=(_between("reader", "    # Get sensor data", "\n    return"), _FALLBACK))
        | {"reader": changed(reader=(_between("reader", "    # Get sensor data", "\n    return"), _FALLBACK))["reader"].replace(f"{_READER}{_IDS[0]}", "get_imu_readings(m=None, d=None, accel_sensor_id=None, gyro_sensor_id=None")},
    ),
    Edit("recorder-of-the-globals", changed(recorder=(_RECORDER, "simulate_and_collect(m, d, ")), {"data_collection": 3}, ("data_collection",)),
    Edit("recorder-of-the-global-data", changed(recorder=(_RECORDER, "simulate_and_collect(model, d, "))),
    Edit("recorder-without-model-and-data", everywhere((_RECORDER, "simulate_and_collect(")), {"data_collection": 3}, ("data_collection",)),
    Edit("noise-on-the-global-data", changed(noise=("(self.model, self.data, self.accel_id, self.gyro_id)", "(model, data, accel_id, gyro_id)"))),
    Edit("noise-on-the-last-reading-printed", changed(noise=("        accel, gyro = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)\n", "")), {"noise_model": 3}, ("noise_model",)),
    Edit("plot-of-the-global", changed(plot=("plot_imu_data(imu_data)", "plot_imu_data(d)")), {"visualization": 2}, ("visualization",)),
    Edit("plot-without-parameters", everywhere(("plot_imu_data(imu_data)", "plot_imu_data()")), {"visualization": 2}, ("visualization",)),
]  # fmt: skip

EDITS: list[Edit] = [*IN_FUNCTIONS, *AT_MODULE_LEVEL, *PACKAGES, *NAMES, *GLOBALS]
