"""What goes wrong when a program is put together: other arguments, another object's member, arrays of another form, lines elsewhere.

A marker mends each in ten seconds. It is one fault, whatever would fail for it.
"""

from __future__ import annotations

import pytest

from tests.corpus.pieces import tidy, verbatim
from tests.corpus.writing import Files
from tests.recordings import Marking
from tests.slips import Changes, Slip, changed, costs_what_it_is

READER, NOISY, FILTER = "imu_reader.py", "noisy_imu.py", "filters.py"
RECORD, READ = {"data_collection.returns_named_arrays": 3.0}, {"sensor_access.returns_two_vectors": 3.0}
NOISE, RECURSION = {"noise_model.noise_size": 3.0}, {"filtering.follows_recursion": 3.0}
PLOT = {"visualization.saves_image": 2.0}
UNKNOWN, RAISES, MISSING, BROKEN = ("unknown-name",), ("raises",), ("import-missing",), ("does-not-import",)
HEAD = "import matplotlib.pyplot as plt\nimport mujoco\nimport numpy as np\n"
ROWS, RATES = "accelerations = np.zeros((n_steps, 3))", "angular_velocities = np.zeros((n_steps, 3))"
CALL, OWN = (
    "get_imu_readings(model, data, accel_id, gyro_id)",
    "get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)",
)
RETURN = """    return {
        'time': times,
        'acceleration': accelerations,
        'angular_velocity': angular_velocities
    }
"""
GUARD = '\n\nif __name__ == "__main__":\n'
SCRIPT = (
    "    model = mujoco.MjModel.from_xml_path(MODEL_PATH)\n    data = mujoco.MjData(model)\n"
    "    plot_imu_data(simulate_and_collect(model, data, 3.0))\n"
)
PANELS = """def panels(fig):
    grid = gridspec.GridSpec(2, 1, figure=fig)
    return fig.add_subplot(grid[0]), fig.add_subplot(grid[1])


def plot_imu_data(imu_data):
    import matplotlib.gridspec as gridspec
"""

AT_MODULE_LEVEL: dict[str, tuple[str, Changes, dict[str, float], tuple[str, ...]]] = {
    "data's options": (READER, {"dt = model.opt.timestep": "dt = data.opt.timestep"}, RECORD, UNKNOWN),
    "data's addresses": (READER, {"model.sensor_adr[accel": "data.sensor_adr[accel"}, READ, UNKNOWN),
    "the model's numbers": (READER, {"data.sensordata[accel": "model.sensordata[accel"}, READ, UNKNOWN),
    "the model's velocity": (READER, {"data.qvel[0] = 0.5": "model.qvel[0] = 0.5"}, RECORD, UNKNOWN),
    "the model's time": (READER, {"times[i] = data.time": "times[i] = model.time"}, RECORD, UNKNOWN),
    "no return after the loop": (READER, {RETURN: ""}, RECORD, ("return-missing",)),
    "an array that nothing makes": (READER, {"    times = np.zeros(n_steps)\n": ""}, RECORD, RAISES),
    "no columns": (READER, {ROWS: "accelerations = np.zeros(n_steps)", RATES: "angular_velocities = np.zeros(n_steps)"}, RECORD, RAISES),
    "columns first": (READER, {ROWS: "accelerations = np.zeros((3, n_steps))", RATES: "angular_velocities = np.zeros((3, n_steps))"}, RECORD, RAISES),
    "lists with places": (READER, {ROWS: "accelerations = []", RATES: "angular_velocities = []"}, RECORD, RAISES),
    "a place by division": (READER, {"accelerations[i] = accel": "accelerations[data.time / dt - 1] = accel"}, RECORD, RAISES),
    "data before model": (READER, {"mj_resetData(model, data)": "mj_resetData(data, model)"}, RECORD, RAISES),
    "no model": (READER, {"mj_resetData(model, data)": "mj_resetData(data)"}, RECORD, RAISES),
    "a time step for the step": (READER, {"        mujoco.mj_step(model, data)": "        mujoco.mj_step(model, data, dt)"}, RECORD, RAISES),
    "a reader that is given data first": (READER, {f"        accel, gyro = {CALL}": f"        accel, gyro = {CALL.replace('model, data', 'data, model')}"}, RECORD, RAISES),
    "three names for two readings": (READER, {f"        accel, gyro = {CALL}": f"        accel, gyro, other = {CALL}"}, RECORD, RAISES),
    "a reader that is given data first by read": (NOISY, {OWN: OWN.replace("self.model, self.data", "self.data, self.model")}, NOISE, RAISES),
    "a reader that is given no model by read": (NOISY, {OWN: OWN.replace("self.model, ", "")}, NOISE, RAISES),
    "a draw of four": (NOISY, {"(0, self.accel_noise_std, 3)": "(0, self.accel_noise_std, 4)"}, NOISE, RAISES),
    "a state that __init__ does not set": (FILTER, {"        self.value = initial_value\n": ""}, RECURSION, UNKNOWN),
    "a state that is a list": (FILTER, {"self.value = measurement.copy()": "self.value = list(measurement)"}, RECURSION, RAISES),
    "axes and their figure": (READER, {"fig, axes = plt.subplots(2, 1": "axes, fig = plt.subplots(2, 1"}, PLOT, RAISES),
    "a library that a last line overwrites": (NOISY, {"print(f\"Clean acceleration": "np = 2\nprint(f\"Clean acceleration"}, NOISE, MISSING),
    "an instance in the place of its class": (FILTER, {"accel_filter = LowPassFilter(alpha=0.1)": "LowPassFilter = accel_filter = LowPassFilter(alpha=0.1)", "gyro_filter = LowPassFilter(alpha=0.1)\n": ""}, RECURSION, MISSING),
    "a constructor with another name": (NOISY, {"def __init__": "def __int__"}, NOISE, ("name-missing",)),
    "a merge that is not finished": (READER, {"        times[i] = data.time\n": "<<<<<<< HEAD\n        times[i] = data.time\n=======\n        times[i] = (i + 1) * dt\n>>>>>>> theirs\n"}, RECORD, BROKEN),
    "steps before their length": (READER, {"    dt = model.opt.timestep\n    n_steps = int(duration_seconds / dt)\n": "    n_steps = int(duration_seconds / dt)\n    dt = model.opt.timestep\n"}, RECORD, RAISES),
    "a loop from one": (READER, {"    for i in range(n_steps):\n": "    for i in range(1, n_steps + 1):\n"}, RECORD, RAISES),
    "another program's data": (READER, {"times[i] = data.time": "times[i] = sim.data.time"}, RECORD, UNKNOWN),
    "the longer name of an address": (READER, {"data.sensordata[accel_adr:accel_adr+3]": "data.sensordata[accel_adr:accel_adr+3]", "accel_adr = model.sensor_adr[accel_sensor_id]": "accel_adr = model.sensor(accel_sensor_id).address[0]"}, READ, UNKNOWN),
    "what is asserted of a standing robot": (READER, {"    return acceleration, angular_velocity\n": "    assert abs(acceleration[2] + 9.81) < 0.5, acceleration\n    return acceleration, angular_velocity\n"}, READ, RAISES),
    "a module that a variable hides": (READER, {"    dt = model.opt.timestep\n": "    started = time.time()\n    dt = model.opt.timestep\n", "import numpy as np\n": "import numpy as np\nimport time\n", "times": "time"}, RECORD, UNKNOWN),
    "a file that has another name by now": (NOISY, {"from imu_reader import *": "from imu_reader import np, mujoco, model, data, accel_id, gyro_id\nfrom imu import get_imu_readings"}, NOISE, MISSING),
}  # fmt: skip

TIDY: dict[str, tuple[str, Changes, dict[str, float], tuple[str, ...]]] = {
    "imports below the main guard": (READER, {HEAD: "", GUARD + "    main()\n": GUARD + "    " + HEAD.replace("\n", "\n    ") + "main()\n"}, RECORD, MISSING),
    "a constant below the main guard": (READER, {"np.empty((n_steps, 3))": "np.empty((n_steps, N_AXES))", GUARD + "    main()\n": GUARD + "    N_AXES = 3\n    main()\n"}, RECORD, MISSING),
    "a constant of main()": (READER, {"np.empty((n_steps, 3))": "np.empty((n_steps, N_AXES))", "def main():\n": "def main():\n    global N_AXES\n    N_AXES = 3\n"}, RECORD, MISSING),
    "an import within another function": (
        READER,
        {"def plot_imu_data(imu_data):\n": PANELS, "fig, (top, bottom) = plt.subplots(2, 1, figsize=(10, 6), sharex=True)": "fig = plt.figure()\n    top, bottom = panels(fig)"},
        PLOT, MISSING,
    ),
    "a decorator that is not there": (READER, {"def get_imu_readings": "@functools.lru_cash\ndef get_imu_readings"}, READ, ("does-not-import",)),
    "a name in a class that nothing has": (FILTER, {"class LowPassFilter:\n": "class LowPassFilter:\n    ALPHA = DEFAULT\n\n"}, RECURSION, BROKEN),
    "a base that is not there": (FILTER, {"class LowPassFilter:": "class LowPassFilter(BaseFilter):"}, RECURSION, BROKEN),
    "a decorator that is not imported": (FILTER, {"class LowPassFilter:": "@dataclass\nclass LowPassFilter:"}, RECURSION, MISSING),
}  # fmt: skip


def _slips(files: Files, cases: dict[str, tuple[str, Changes, dict[str, float], tuple[str, ...]]]) -> list[Slip]:
    return [Slip(name, changed(files, path, to), lost, named) for name, (path, to, lost, named) in cases.items()]


SLIPS = [*_slips(verbatim(), AT_MODULE_LEVEL), *_slips(tidy(), TIDY)]


@pytest.mark.parametrize("slip", SLIPS, ids=lambda slip: slip.name)
def test_it_costs_what_it_is_and_nothing_else(slip: Slip, player: Marking) -> None:
    costs_what_it_is(slip, player)
