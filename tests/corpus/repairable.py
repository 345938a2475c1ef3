"""Programs that do not run, each by one small edit of a sound one: what a person repairs in a minute, and the suggester proposes.

Each row: what is wrong, which sound program it was (the sheet's own code, or a tidy one), the file, and what stands there in place of what.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tests.corpus.pieces import tidy, verbatim
from tests.corpus.writing import Files


@dataclass(frozen=True)
class Repairable:
    """A program with one edit that keeps it, or a part of it, from running."""

    name: str
    files: Files
    path: str

    @property
    def text(self) -> str:
        """The text of the file that does not run."""
        return str(self.files[self.path])


_Row = tuple[str, str, Sequence[tuple[str, str]]]

_PUT_TOGETHER: Sequence[_Row] = [
    ("data's options", 'imu_reader.py', [('dt = model.opt.timestep', 'dt = data.opt.timestep')]),
    ("data's addresses", 'imu_reader.py', [('model.sensor_adr[accel', 'data.sensor_adr[accel')]),
    ("the model's numbers", 'imu_reader.py', [('data.sensordata[accel', 'model.sensordata[accel')]),
    ("the model's velocity", 'imu_reader.py', [('data.qvel[0] = 0.5', 'model.qvel[0] = 0.5')]),
    ("the model's time", 'imu_reader.py', [('times[i] = data.time', 'times[i] = model.time')]),
    ('no return after the loop', 'imu_reader.py', [("    return {\n        'time': times,\n        'acceleration': accelerations,\n        'angular_velocity': angular_velocities\n    }\n", '')]),
    ('an array that nothing makes', 'imu_reader.py', [('    times = np.zeros(n_steps)\n', '')]),
    ('no columns', 'imu_reader.py', [('accelerations = np.zeros((n_steps, 3))', 'accelerations = np.zeros(n_steps)'), ('angular_velocities = np.zeros((n_steps, 3))', 'angular_velocities = np.zeros(n_steps)')]),
    ('columns first', 'imu_reader.py', [('accelerations = np.zeros((n_steps, 3))', 'accelerations = np.zeros((3, n_steps))'), ('angular_velocities = np.zeros((n_steps, 3))', 'angular_velocities = np.zeros((3, n_steps))')]),
    ('lists with places', 'imu_reader.py', [('accelerations = np.zeros((n_steps, 3))', 'accelerations = []'), ('angular_velocities = np.zeros((n_steps, 3))', 'angular_velocities = []')]),
    ('a place by division', 'imu_reader.py', [('accelerations[i] = accel', 'accelerations[data.time / dt - 1] = accel')]),
    ('data before model', 'imu_reader.py', [('mj_resetData(model, data)', 'mj_resetData(data, model)')]),
    ('no model', 'imu_reader.py', [('mj_resetData(model, data)', 'mj_resetData(data)')]),
    ('a time step for the step', 'imu_reader.py', [('        mujoco.mj_step(model, data)', '        mujoco.mj_step(model, data, dt)')]),
    ('a reader that is given data first', 'imu_reader.py', [('        accel, gyro = get_imu_readings(model, data, accel_id, gyro_id)', '        accel, gyro = get_imu_readings(data, model, accel_id, gyro_id)')]),
    ('three names for two readings', 'imu_reader.py', [('        accel, gyro = get_imu_readings(model, data, accel_id, gyro_id)', '        accel, gyro, other = get_imu_readings(model, data, accel_id, gyro_id)')]),
    ('a reader that is given data first by read', 'noisy_imu.py', [('get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)', 'get_imu_readings(self.data, self.model, self.accel_id, self.gyro_id)')]),
    ('a reader that is given no model by read', 'noisy_imu.py', [('get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)', 'get_imu_readings(self.data, self.accel_id, self.gyro_id)')]),
    ('a draw of four', 'noisy_imu.py', [('(0, self.accel_noise_std, 3)', '(0, self.accel_noise_std, 4)')]),
    ('a state that __init__ does not set', 'filters.py', [('        self.value = initial_value\n', '')]),
    ('a state that is a list', 'filters.py', [('self.value = measurement.copy()', 'self.value = list(measurement)')]),
    ('axes and their figure', 'imu_reader.py', [('fig, axes = plt.subplots(2, 1', 'axes, fig = plt.subplots(2, 1')]),
    ('a constructor with another name', 'noisy_imu.py', [('def __init__', 'def __int__')]),
    ('steps before their length', 'imu_reader.py', [('    dt = model.opt.timestep\n    n_steps = int(duration_seconds / dt)\n', '    n_steps = int(duration_seconds / dt)\n    dt = model.opt.timestep\n')]),
    ('a loop from one', 'imu_reader.py', [('    for i in range(n_steps):\n', '    for i in range(1, n_steps + 1):\n')]),
    ("another program's data", 'imu_reader.py', [('times[i] = data.time', 'times[i] = sim.data.time')]),
    ('the longer name of an address', 'imu_reader.py', [('data.sensordata[accel_adr:accel_adr+3]', 'data.sensordata[accel_adr:accel_adr+3]'), ('accel_adr = model.sensor_adr[accel_sensor_id]', 'accel_adr = model.sensor(accel_sensor_id).address[0]')]),
    ('what is asserted of a standing robot', 'imu_reader.py', [('    return acceleration, angular_velocity\n', '    assert abs(acceleration[2] + 9.81) < 0.5, acceleration\n    return acceleration, angular_velocity\n')]),
    ('a module that a variable hides', 'imu_reader.py', [('    dt = model.opt.timestep\n', '    started = time.time()\n    dt = model.opt.timestep\n'), ('import numpy as np\n', 'import numpy as np\nimport time\n'), ('times', 'time')]),
]  # fmt: skip

_PUT_TOGETHER_TIDILY: Sequence[_Row] = [
    ('a constant below the main guard', 'imu_reader.py', [('np.empty((n_steps, 3))', 'np.empty((n_steps, N_AXES))'), ('\n\nif __name__ == "__main__":\n    main()\n', '\n\nif __name__ == "__main__":\n    N_AXES = 3\n    main()\n')]),
    ('a constant of main()', 'imu_reader.py', [('np.empty((n_steps, 3))', 'np.empty((n_steps, N_AXES))'), ('def main():\n', 'def main():\n    global N_AXES\n    N_AXES = 3\n')]),
    ('an import within another function', 'imu_reader.py', [('def plot_imu_data(imu_data):\n', 'def panels(fig):\n    grid = gridspec.GridSpec(2, 1, figure=fig)\n    return fig.add_subplot(grid[0]), fig.add_subplot(grid[1])\n\n\ndef plot_imu_data(imu_data):\n    import matplotlib.gridspec as gridspec\n'), ('fig, (top, bottom) = plt.subplots(2, 1, figsize=(10, 6), sharex=True)', 'fig = plt.figure()\n    top, bottom = panels(fig)')]),
    ('a decorator that is not there', 'imu_reader.py', [('def get_imu_readings', '@functools.lru_cash\ndef get_imu_readings')]),
    ('a name in a class that nothing has', 'filters.py', [('class LowPassFilter:\n', 'class LowPassFilter:\n    ALPHA = DEFAULT\n\n')]),
    ('a base that is not there', 'filters.py', [('class LowPassFilter:', 'class LowPassFilter(BaseFilter):')]),
    ('a decorator that is not imported', 'filters.py', [('class LowPassFilter:', '@dataclass\nclass LowPassFilter:')]),
]  # fmt: skip

_NO_RETURN: Sequence[_Row] = [
    ('the reader', 'imu_reader.py', [('    return acceleration, angular_velocity\n', '')]),
    ('the reader prints', 'imu_reader.py', [('    return acceleration, angular_velocity\n', "    print(f'{acceleration}', acceleration, angular_velocity)\n")]),
    ('the reader, without the word', 'imu_reader.py', [('    return acceleration, angular_velocity\n', '    acceleration, angular_velocity\n')]),
    ('a recording by a name', 'imu_reader.py', [("    return {\n        'time'", "    imu_data = {\n        'time'")]),
    ('a recording without the word', 'imu_reader.py', [("    return {\n        'time'", "    {\n        'time'")]),
    ('read', 'noisy_imu.py', [('        return accel_noisy, gyro_noisy\n', '')]),
    ('read keeps them', 'noisy_imu.py', [('        return accel_noisy, gyro_noisy\n', '        self.last = (accel_noisy, gyro_noisy)\n        self.reads = 1\n')]),
    ('update', 'filters.py', [('        return self.value.copy()\n', '')]),
    ('update, once it has begun', 'filters.py', [('            self.value = measurement.copy()\n', '            self.value = measurement.copy()\n            return measurement\n'), ('        return self.value.copy()\n', '')]),
]  # fmt: skip

_OTHER_METHODS: Sequence[_Row] = [
    ('process', 'filters.py', [('def update', 'def process'), ('.update(', '.process(')]),
    ('a call', 'filters.py', [('def update', 'def __call__'), ('accel_filter.update(', 'accel_filter(')]),
    ('filter, beside others', 'filters.py', [('    def update', '    def reset(self):\n        self.value = None\n\n    def set_alpha(self, alpha):\n        self.alpha = alpha\n\n    def filter'), ('.update(', '.filter(')]),
    ('of a base', 'filters.py', [('class LowPassFilter:', 'class Base:\n    def step(self, x):\n        return self.next(x, 1)\n\n\nclass LowPassFilter(Base):'), ('def update(self, measurement)', 'def next(self, measurement, times)'), ('accel_filter.update(', 'accel_filter.step(')]),
    ('get_readings', 'noisy_imu.py', [('def read(', 'def get_readings('), ('noisy_imu.read()', 'noisy_imu.get_readings()')]),
    ('sample', 'noisy_imu.py', [('def read(', 'def sample('), ('noisy_imu.read()', 'noisy_imu.sample()')]),
]  # fmt: skip

_CALLS_THAT_RAISE: Sequence[_Row] = [
    ('a style that is nowhere', 'imu_reader.py', [('    fig, axes =', "    plt.style.use('my-style')\n    fig, axes =")]),
    ('a heading of no size', 'imu_reader.py', [('    plt.tight_layout()\n', "    plt.suptitle('IMU', fontsize='hugee')\n    plt.tight_layout()\n")]),
    ('a picture of no resolution', 'imu_reader.py', [('dpi=150', "dpi='high'")]),
    ('a legend at no place', 'imu_reader.py', [('axes[1].legend()', "axes[1].legend(loc='top')")]),
    ('a label of no size', 'imu_reader.py', [("(m/s²)')", "(m/s²)', size='hugee')")]),
    ('a curve of no colour', 'imu_reader.py', [("[:, 0], label='X'", "[:, 0], 'grenn', label='X'")]),
    ('a print in the reader', 'imu_reader.py', [('    return acceleration,', "    print(f'{acceleration:.2f}')\n    return acceleration,")]),
    ('a print of the noise', 'noisy_imu.py', [('        return accel_noisy,', "        print('noisy: ' + accel_noisy)\n        return accel_noisy,")]),
]  # fmt: skip

_UNKNOWN_NAMES: Sequence[_Row] = [
    ('a variable', 'filters.py', [('self.alpha * measurement', 'self.alpha * measurment')]),
    ('self of an attribute', 'filters.py', [('(1 - self.alpha)', '(1 - alpha)')]),
    ('self of a method', 'filters.py', [('def update(self, measurement)', 'def update(measurement)')]),
    ('self of __init__', 'filters.py', [('def __init__(self, alpha', 'def __init__(alpha')]),
    ('an attribute', 'filters.py', [('self.alpha = alpha', 'self.aplha = alpha')]),
    ('three attributes that are not kept', 'noisy_imu.py', [('        self.model = model\n', '        model = model\n'), ('        self.data = data\n', '        data = data\n'), ('        self.accel_id = accel_id\n', '        accel_id = accel_id\n')]),
    ('a function of NumPy', 'noisy_imu.py', [('np.random.normal(0, self.gyro_noise_std', 'np.random.norml(0, self.gyro_noise_std')]),
    ('NumPy before its function', 'imu_reader.py', [('    times = np.zeros(n_steps)', '    times = zeros(n_steps)')]),
    ('where no bias is given alone', 'noisy_imu.py', [('np.random.normal(0, 0.01, 3)', 'np.random.norml(0, 0.01, 3)')]),
    ('what is returned', 'noisy_imu.py', [('return accel_noisy, gyro_noisy', 'return accel_noisy, gyro_noisey')]),
    ('a member of the data', 'imu_reader.py', [('data.sensordata[gyro_adr', 'data.sensor_data[gyro_adr')]),
    ('a function of MuJoCo', 'imu_reader.py', [('mujoco.mj_resetData(', 'mujoco.mj_resetdata(')]),
    ('a built-in function', 'imu_reader.py', [('for i in range(n_steps)', 'for i in rang(n_steps)')]),
    ('a key', 'imu_reader.py', [("imu_data['angular_velocity'][:, 2]", "imu_data['angular_velocty'][:, 2]")]),
    ('a key as an attribute', 'imu_reader.py', [("imu_data['acceleration'][:, 0]", 'imu_data.acceleration[:, 0]')]),
    ('a keyword', 'imu_reader.py', [("label='X'", "lable='X'")]),
    ('a function of pyplot of a panel', 'imu_reader.py', [('axes[1].set_xlabel(', 'axes[1].xlabel('), ('axes[0].set_ylabel(', 'axes[0].ylabel(')]),
    ('a function of a panel of pyplot', 'imu_reader.py', [('    plt.tight_layout()\n', "    plt.set_xlabel('Time (s)')\n    plt.tight_layout()\n")]),
    ('two in one line', 'filters.py', [('self.alpha * measurement + (1 - self.alpha)', 'alpha * measurment + (1 - self.alpha)')]),
    ('beside a wrong weight', 'filters.py', [('(1 - self.alpha) * self.value', '(1 + alpha) * self.value')]),
]  # fmt: skip

_ARRAYS: Sequence[_Row] = [
    ('an array that is asked for its truth', 'filters.py', [('if self.value is None', 'if not self.value')]),
    ('an array that is compared with nothing', 'filters.py', [('if self.value is None', 'if self.value == None')]),
    ('a bias, or another', 'noisy_imu.py', [('accel_bias if accel_bias is not None else np', 'accel_bias or np')]),
    ('a size that is an array', 'noisy_imu.py', [('self.accel_noise_std, 3)', 'self.accel_noise_std, size=accel)')]),
]  # fmt: skip

_SYNTAX: Sequence[_Row] = [
    ('a colon after a function', 'filters.py', [('def update(self, measurement):', 'def update(self, measurement)')]),
    ('a colon before a comment', 'imu_reader.py', [('    for i in range(n_steps):', '    for i in range(n_steps)  # n: steps')]),
    ('a colon after a class', 'filters.py', [('class LowPassFilter:', 'class LowPassFilter')]),
    ('a colon after else', 'filters.py', [('        else:\n', '        else\n')]),
    ('a comparison with None', 'filters.py', [('if self.value is None:', 'if self.value = None:')]),
    ('a comparison', 'filters.py', [('if self.value is None:', 'if self.alpha = 1:')]),
    ('a bracket of a call', 'filters.py', [('        return self.value.copy()', '        return self.value.copy(')]),
    ('a bracket of a call that goes on', 'imu_reader.py', [('np.zeros((n_steps, 3))\n    angular', 'np.zeros((n_steps, 3)\n    angular')]),
    ('a bracket before a colon', 'imu_reader.py', [('    for i in range(n_steps):', '    for i in range(n_steps:')]),
    ('a bracket of parameters', 'filters.py', [('def update(self, measurement):', 'def update(self, measurement:')]),
    ('a bracket of several lines', 'imu_reader.py', [("        'angular_velocity': angular_velocities\n    }", "        'angular_velocity': angular_velocities")]),
    ('a bracket too many', 'filters.py', [('        return self.value.copy()', '        return self.value.copy())')]),
    ('a bracket of another kind', 'filters.py', [('        return self.value.copy()', '        return self.value.copy(]')]),
    ('a quote', 'imu_reader.py', [("set_title('Accelerometer Readings')", "set_title('Accelerometer Readings)")]),
    ('quotes of a book', 'imu_reader.py', [("set_title('Accelerometer Readings')", 'set_title(‘Accelerometer Readings’)')]),
    ('a space of a book', 'imu_reader.py', [('    n_steps = int(', '    n_steps =\xa0int(')]),
    ('a comma between values', 'imu_reader.py', [('np.zeros((n_steps, 3))\n    angular', 'np.zeros((n_steps 3))\n    angular')]),
    ('a comma between parameters', 'imu_reader.py', [('(model, data, accel_sensor_id,', '(model, data accel_sensor_id,')]),
    ('a comma between lines', 'imu_reader.py', [("        'time': times,\n        'acc", "        'time': times\n        'acc")]),
    ('a line too far out', 'filters.py', [('        return self.value.copy()', '    return self.value.copy()')]),
    ('a line a space too far in', 'filters.py', [('        return self.value.copy()', '         return self.value.copy()')]),
    ('a line a space too far out', 'filters.py', [('        return self.value.copy()', '       return self.value.copy()')]),
    ('a tabulator', 'filters.py', [('        return self.value.copy()', '\treturn self.value.copy()')]),
    ('a merge that is not finished', 'imu_reader.py', [('    for i in range(n_steps):', '<<<<<<< HEAD\n    for i in range(n_steps):\n=======\n    for i in range(3):\n>>>>>>> theirs')]),
    ('a merge with what was there before', 'imu_reader.py', [('    for i in range(n_steps):', '<<<<<<< HEAD\n    for i in range(n_steps):\n||||||| base\n    for i in (1,):\n=======\n    for i in range(3):\n>>>>>>> theirs')]),
    ('a mark of a merge', 'imu_reader.py', [('    for i in range(n_steps):', '<<<<<<< HEAD\n    for i in range(n_steps):')]),
    ('a block with nothing in it', 'filters.py', [('class LowPassFilter:', 'def helper(x):  # later\n\nclass LowPassFilter:')]),
    ('print as a statement', 'imu_reader.py', [('print(f"Angular velocity: {gyro}")', 'print f"Angular velocity: {gyro}"')]),
    ('else if', 'filters.py', [('        else:\n', '        else if self.alpha:\n')]),
    ('an increment', 'imu_reader.py', [('        times[i] = data.time\n', '        times[i] = data.time\n        i++\n')]),
]  # fmt: skip


def _edited(base: Files, row: _Row, group: str) -> Repairable:
    name, path, changes = row
    text = str(base[path])
    for old, new in changes:
        if old not in text:
            raise ValueError(f"{name}: {path} holds no {old!r}")
        text = text.replace(old, new)
    return Repairable(f"{group}: {name}", {**base, path: text}, path)


_GROUPS: Mapping[str, Sequence[_Row]] = {
    "syntax": _SYNTAX,
    "unknown name": _UNKNOWN_NAMES,
    "no return": _NO_RETURN,
    "array": _ARRAYS,
    "another method": _OTHER_METHODS,
    "call that raises": _CALLS_THAT_RAISE,
    "put together": _PUT_TOGETHER,
}
REPAIRABLE = [
    *(_edited(verbatim(), row, group) for group, rows in _GROUPS.items() for row in rows),
    *(_edited(tidy(), row, "put together") for row in _PUT_TOGETHER_TIDILY),
]
