"""Sound submissions that lean on what a student's machine has: a viewer's window, a package around the files."""



from __future__ import annotations

from tests.corpus import sheet
from tests.corpus.pieces import COLLECT_APPEND, COMPARE, FILTER_HEAD, FILTER_INCREMENT, HEAD, IDS, edit, lab, tidy

# The window's camera and options are set before the simulation runs in it, as MuJoCo's documentation shows.
VIEWER_SET_UP = HEAD + '''\
import time

import mujoco.viewer


def watch(model, data, seconds=2.0):
    with mujoco.viewer.launch_passive(model, data, show_left_ui=False, show_right_ui=False) as viewer:
        viewer.cam.type = mujoco.mjtCamera.mjCAMERA_TRACKING
        viewer.cam.trackbodyid = model.body("torso").id
        viewer.cam.lookat[:] = data.body("torso").xpos
        viewer.cam.distance, viewer.cam.azimuth, viewer.cam.elevation = 3.0, 90, -15
        mujoco.mjv_initGeom(viewer.user_scn.geoms[0], mujoco.mjtGeom.mjGEOM_SPHERE, [0.02, 0, 0], [0, 0, 1], np.eye(3).ravel(), [1, 0, 0, 1])
        viewer.user_scn.ngeom = 1
        start = time.time()
        while viewer.is_running() and time.time() - start < seconds:
            step_start = time.time()
            mujoco.mj_step(model, data)
            with viewer.lock():
                viewer.opt.flags[mujoco.mjtVisFlag.mjVIS_CONTACTPOINT] = int(data.time % 2)
            viewer.sync()
            time.sleep(max(0.0, model.opt.timestep - (time.time() - step_start)))
'''

COLLECT_WHILE_WATCHING = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    """Record for as long as the window is open."""
''' + IDS + '''\
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    times, accs, gyros = [], [], []
    with mujoco.viewer.launch_passive(model, data) as viewer:
        viewer.opt.flags[mujoco.mjtVisFlag.mjVIS_JOINT] = True
        while viewer.is_running() and data.time < duration_seconds - model.opt.timestep / 2:
            mujoco.mj_step(model, data)
            acc, gyro = get_imu_readings(model, data, accel_id, gyro_id)
            times.append(data.time)
            accs.append(acc)
            gyros.append(gyro)
            viewer.sync()
    return {"time": np.array(times), "acceleration": np.array(accs), "angular_velocity": np.array(gyros)}
'''

# A callback of MuJoCo's notes the times.
COLLECT_BY_CALLBACK = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
''' + IDS + '''\
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    rows, calls = [], []
    mujoco.set_mjcb_control(lambda m, d: calls.append((m.nsensor, d.time)))
    try:
        for _ in range(round(duration_seconds / model.opt.timestep)):
            mujoco.mj_step(model, data)
            rows.append((data.time, *get_imu_readings(model, data, accel_id, gyro_id)))
    finally:
        mujoco.set_mjcb_control(None)
    assert len(calls) >= len(rows)
    time, acceleration, angular_velocity = map(np.array, zip(*rows))
    return {"time": time, "acceleration": acceleration, "angular_velocity": angular_velocity}
'''


def importing(reader: str, noise: str) -> dict[str, str]:
    """A tidy submission that imports the reader's names and the noise model's in other words."""
    changes = (("from imu_reader import", reader), ("from noisy_imu import", noise))
    return {path: _replaced(text, changes) for path, text in tidy().items()}


def _replaced(text: str, changes: tuple[tuple[str, str], ...]) -> str:
    for old, new in changes:
        text = text.replace(old, new)
    return text


def below(folder: str, files: dict[str, str]) -> dict[str, str]:
    return {f"{folder}/{path}": text for path, text in files.items()}


# Run from above as `python -m src.imu_lab.filters`, so every import begins there.
ABSOLUTE_PACKAGE = {
    "pyproject.toml": '[project]\nname = "imu-lab"\nversion = "0.1"\n',
    **below("src/imu_lab", importing("from src.imu_lab.imu_reader import", "from src.imu_lab.noisy_imu import")),
    "src/imu_lab/__init__.py": "",
}

# Modules taken from the package itself, names that its __init__ offers, a helper two folders deep that reaches back up.
DOTTED_PACKAGE = below("imu", {
    **importing("from . import imu_reader\nfrom .imu_reader import", "from . import"),
    "__init__.py": "from .config import SAMPLES\nfrom .noisy_imu import NoisyIMU\n",
    "config.py": "SAMPLES = 500\n",
    "units/__init__.py": "",
    "units/names.py": "from .. import SAMPLES, config\nfrom ..config import SAMPLES as COUNT\n\nassert SAMPLES == COUNT == config.SAMPLES\n",
})
DOTTED_PACKAGE["imu/filters.py"] = "import imu.units.names\n" + DOTTED_PACKAGE["imu/filters.py"].replace("n=500", "n=imu.units.names.COUNT")

# Constants and paths as large programs have them, all of them checked before anything else is defined.
SETTINGS_FIRST = """\
import configparser
from pathlib import Path

PROJECT_ROOT = Path(__file__).resolve().parents[2]
MODEL_PATH = PROJECT_ROOT / "assets" / "models" / "humanoid-sensors.xml"
if not MODEL_PATH.is_file():
    raise FileNotFoundError(f"the lab model is not at {MODEL_PATH}")
MODEL_SIZE = len(MODEL_PATH.read_text(encoding="utf-8"))
MODEL_PATH = str(MODEL_PATH)
SETTINGS = configparser.ConfigParser()
SETTINGS.read("lab.ini")
PUSH = SETTINGS.getfloat("simulation", "push")
"""

# What nbconvert makes of `%matplotlib inline`, `files = !ls` and `%%time`.
EXPORTED = HEAD + """\
get_ipython().run_line_magic('matplotlib', 'inline')
get_ipython().run_line_magic('load_ext', 'autoreload')
files = get_ipython().getoutput('ls')
print(len(files), "files")
get_ipython().run_cell_magic('time', '', 'PUSH = 0.5\\nSECONDS = 3.0\\n')
"""

FILM = """\
from matplotlib.animation import FuncAnimation


def film(imu_data, frames=15):
    fig, ax = plt.subplots()
    ax.set(xlim=(0, imu_data["time"][-1]), ylim=(-12, 0), xlabel="Time (s)", ylabel="Acceleration (m/s²)")
    (line,) = ax.plot([], [])

    def draw(frame):
        line.set_data(imu_data["time"][:frame], imu_data["acceleration"][:frame, 2])
        return (line,)

    steps = range(0, len(imu_data["time"]), len(imu_data["time"]) // frames)
    FuncAnimation(fig, draw, frames=steps, interval=40, blit=True).save("imu.gif", writer="pillow", fps=20)


model = mujoco.MjModel.from_xml_path(MODEL_PATH)
imu_data = simulate_and_collect(model, mujoco.MjData(model), 3.0)
film(imu_data)
plot_imu_data(imu_data)
"""
# The sheet's collector with its global ids, which only `main()` finds out.
IDS_IN_MAIN = """\
def main():
    global accel_id, gyro_id
    model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    accel_id, gyro_id = model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id
    plot_imu_data(simulate_and_collect(model, mujoco.MjData(model), duration_seconds=3.0))


if __name__ == "__main__":
    main()
"""


def ids_in_main(head: str) -> dict[str, str]:
    return lab(head=HEAD + head, collect=sheet.COLLECT, main=IDS_IN_MAIN)

# What is compared is a function of a module; that it is called stands in a program that nobody imports.
RUN_LAB = """\
import mujoco
from imu_reader import MODEL_PATH, plot_imu_data, simulate_and_collect
from plotting import compare

model = mujoco.MjModel.from_xml_path(MODEL_PATH)
plot_imu_data(simulate_and_collect(model, mujoco.MjData(model), 3.0))
compare()
"""
COMPARE_ONLY = COMPARE.split("\n\n\nif __name__")[0]
PLOTTING = {
    "filters.py": f"import numpy as np\n\n\n{FILTER_INCREMENT}",
    "plotting.py": f"{FILTER_HEAD}from filters import LowPassFilter\n\n\n{COMPARE_ONLY}\n",
}
WITH_DUNDER_MAIN = {
    **below("imu", importing("from .imu_reader import", "from .noisy_imu import")),
    "imu/__init__.py": "",
    "imu/__main__.py": "from . import filters\n\nfilters.compare()\n",
}
WITH_DUNDER_MAIN["imu/filters.py"] = WITH_DUNDER_MAIN["imu/filters.py"].split("\n\n\nif __name__")[0]

HABITS_MORE = {
    "viewer_set_up_at_module_level": lab(head=VIEWER_SET_UP, collect=COLLECT_WHILE_WATCHING, main="""\
model = mujoco.MjModel.from_xml_path(MODEL_PATH)
data = mujoco.MjData(model)
watch(model, data)
plot_imu_data(simulate_and_collect(model, data, 3.0))
"""),
    "package_with_absolute_imports": ABSOLUTE_PACKAGE,
    "settings_and_paths_first": {
        **edit(lab(head=HEAD + SETTINGS_FIRST), "imu_reader.py", ("data.qvel[0] = 0.5", "data.qvel[0] = PUSH")),
        "lab.ini": "[simulation]\npush = 0.5\n",
    },
    "exported_with_magics": edit(lab(head=EXPORTED), "imu_reader.py", ("data.qvel[0] = 0.5", "data.qvel[0] = PUSH")),
    "sensors_by_name_as_parameters": edit(
        lab(collect=COLLECT_APPEND), "imu_reader.py",
        ("duration_seconds=5.0):", 'duration_seconds=5.0, *, accel_name="torso_accelerometer", gyro_name="torso_gyroscope"):'),
        ('model.sensor("torso_accelerometer").id', "mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, accel_name)"),
        ('model.sensor("torso_gyroscope").id', "mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, gyro_name)"),
    ),
    "forward_after_every_step": edit(lab(), "imu_reader.py", ("mujoco.mj_step(model, data)\n", "mujoco.mj_step(model, data)\n        mujoco.mj_forward(model, data)\n")),
    "recording_with_attributes": edit(
        lab(head=HEAD + '\n\nclass Recording(dict):\n    __getattr__ = dict.__getitem__\n', collect=COLLECT_APPEND), "imu_reader.py",
        ("return dict(time=", "return Recording(time="), ('t = imu_data["time"]', "t = imu_data.time"),
    ),
    "recording_with_labels": edit(
        lab(collect=COLLECT_APPEND), "imu_reader.py",
        ("return dict(time=", 'return dict(axes=["x", "y", "z"], time='), ('enumerate("xyz")', 'enumerate(imu_data["axes"])'),
    ),
    "deviations_must_be_positive": edit(
        lab(), "noisy_imu.py",
        ("        self.model, self.data = model, data\n", "        if accel_noise_std <= 0 or gyro_noise_std <= 0:\n            raise ValueError('no noise')\n        self.model, self.data = model, data\n"),
    ),
    "film_of_the_recording": lab(main=FILM),
    "bias_as_large_as_the_noise": edit(
        lab(), "noisy_imu.py",
        ("self.rng.normal(0.0, 0.1, size=3)", "self.rng.normal(0.0, self.accel_noise_std, size=3)"),
        ("self.rng.normal(0.0, 0.01, size=3)", "2.0 * self.rng.normal(0.0, self.gyro_noise_std, size=3)"),
    ),
    "accelerometer_bias_as_large_as_the_noise": edit(
        lab(), "noisy_imu.py", ("self.rng.normal(0.0, 0.1, size=3)", "self.rng.normal(0.0, self.accel_noise_std, size=3)"),
    ),
    "ids_that_are_none_until_main": ids_in_main("accel_id = None  # see main()\ngyro_id = None\n"),
    "ids_that_are_minus_one_until_main": ids_in_main("accel_id = gyro_id = -1\n"),
    "collector_by_position_only": edit(lab(), "imu_reader.py", ("duration_seconds=5.0):", "duration_seconds=5.0, /):"),
                                       ("duration_seconds=3.0", "3.0")),
    "program_that_calls_what_draws": {**tidy(), **PLOTTING, "run_lab.py": RUN_LAB},
    "package_that_is_run": WITH_DUNDER_MAIN,
    "callback_of_the_simulation": lab(collect=COLLECT_BY_CALLBACK),
    "package_that_imports_its_modules": DOTTED_PACKAGE,
}
