"""Whole submissions, each in one consistent hand."""



from __future__ import annotations

from tests.corpus.pieces import COMPARE, FILTER_INCREMENT, HEAD, MODEL_PATH, lab, verbatim
from tests.corpus.sound_typed import TYPED

# Everything at module level, prints, questions, an absolute path of the student's own machine, figures shown.
CHATTY = {
    "imu_reader.py": '''\
import os
os.system("")
import mujoco
import numpy as np
import matplotlib
matplotlib.use("TkAgg")
import matplotlib.pyplot as plt

plt.ion()
print("=" * 60)
print("   LAB 04-01   IMU   ")
print("=" * 60)
name = input("Press enter to start ")
PATH = r"/Users/me/Documents/robotics/week 4/humanoid-sensors.xml"
model = mujoco.MjModel.from_xml_path(PATH)
data = mujoco.MjData(model)
for i in range(model.nsensor):
    print(i, mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, i), model.sensor_adr[i], model.sensor_dim[i])
ACC = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "torso_accelerometer")
GYR = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "torso_gyroscope")

def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    a = model.sensor_adr[accel_sensor_id]
    g = model.sensor_adr[gyro_sensor_id]
    acc = np.array([data.sensordata[a], data.sensordata[a+1], data.sensordata[a+2]])
    gyr = np.array([data.sensordata[g], data.sensordata[g+1], data.sensordata[g+2]])
    return acc, gyr

mujoco.mj_step(model, data)
print("first reading", get_imu_readings(model, data, ACC, GYR))

def simulate_and_collect(model, data, duration_seconds=5.0):
    print("simulating", duration_seconds, "s ...")
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    T = []
    A = []
    W = []
    for t in np.arange(0, duration_seconds - 1e-9, model.opt.timestep):
        mujoco.mj_step(model, data)
        a, w = get_imu_readings(model, data, ACC, GYR)
        T.append(t)
        A.append(a)
        W.append(w)
    print("... done", len(T))
    return {"time": np.array(T), "acceleration": np.array(A), "angular_velocity": np.array(W)}

result = simulate_and_collect(model, data, 3)

def plot_imu_data(imu_data):
    plt.figure(figsize=(10, 8))
    plt.subplot(211)
    plt.plot(imu_data["time"], imu_data["acceleration"][:,0], "r")
    plt.plot(imu_data["time"], imu_data["acceleration"][:,1], "g")
    plt.plot(imu_data["time"], imu_data["acceleration"][:,2], "b")
    plt.legend(["ax", "ay", "az"])
    plt.title("accelerometer")
    plt.ylabel("acc (m/s2)")
    plt.xlabel("t (s)")
    plt.subplot(212)
    plt.plot(imu_data["time"], imu_data["angular_velocity"][:,0], "r")
    plt.plot(imu_data["time"], imu_data["angular_velocity"][:,1], "g")
    plt.plot(imu_data["time"], imu_data["angular_velocity"][:,2], "b")
    plt.legend(["wx", "wy", "wz"])
    plt.title("gyro")
    plt.ylabel("gyro (rad/s)")
    plt.xlabel("t (s)")
    plt.savefig("imu_data.png")
    plt.show(block=True)

plot_imu_data(result)
input("look at the plot, then press enter")
''',
    "noisy_imu.py": '''\
import numpy as np
from imu_reader import *

class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005, accel_bias=None, gyro_bias=None):
        self.m = model
        self.d = data
        self.a = accel_id
        self.g = gyro_id
        self.sa = accel_noise_std
        self.sg = gyro_noise_std
        self.ba = accel_bias
        self.bg = gyro_bias
        if self.ba is None:
            self.ba = np.random.uniform(-0.1, 0.1, 3)
        if self.bg is None:
            self.bg = np.random.uniform(-0.01, 0.01, 3)
    def read(self):
        acc, gyr = get_imu_readings(self.m, self.d, self.a, self.g)
        for k in range(3):
            acc[k] += self.ba[k] + np.random.normal(0, self.sa)
            gyr[k] += self.bg[k] + np.random.normal(0, self.sg)
        return acc, gyr

noisy = NoisyIMU(model, data, ACC, GYR)
print(noisy.read())
''',
    "filters.py": '''\
from noisy_imu import *
import matplotlib.pyplot as plt

class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.alpha = alpha
        self.y = initial_value
    def update(self, measurement):
        if self.y is None:
            self.y = measurement + 0
        else:
            self.y = self.alpha * measurement + (1 - self.alpha) * self.y
        return self.y + 0

f = LowPassFilter(0.1)
raw = []
fil = []
mujoco.mj_resetData(model, data)
for i in range(400):
    mujoco.mj_step(model, data)
    a, g = noisy.read()
    raw.append(a[2])
    fil.append(f.update(a)[2])
plt.figure()
plt.plot(raw, label="raw")
plt.plot(fil, label="filtered")
plt.legend()
plt.title("filter")
plt.xlabel("sample")
plt.ylabel("az [m/s^2]")
plt.savefig("filtered_imu.png")
plt.show()
''',
}

# The viewer opens at module level; on a machine without a screen the file stops right there.
VIEWER = lab(
    main=f'''\
model = mujoco.MjModel.from_xml_path("{MODEL_PATH}")
data = mujoco.MjData(model)
plot_imu_data(simulate_and_collect(model, data, 3.0))

import mujoco.viewer

viewer = mujoco.viewer.launch_passive(model, data)
for _ in range(200):
    mujoco.mj_step(model, data)
    viewer.sync()
viewer.close()
'''
)

# The viewer is imported with all else, and opened for who wants to watch.
WATCHING = lab(
    head=HEAD
    + '''\
import mujoco.viewer


def watch(model, data) -> None:
    with mujoco.viewer.launch_passive(model, data) as viewer:
        while viewer.is_running():
            mujoco.mj_step(model, data)
            viewer.sync()
'''
)

# The window of MuJoCo's first Python tutorials, opened for who wants to watch; and a notebook's habit of installing first.
WINDOW = lab(
    head="""\
import os
import subprocess
import sys

subprocess.check_call([sys.executable, "-m", "pip", "install", "-q", "mujoco"])
os.system("pip install -q numpy")
print(subprocess.run(["pip", "install", "matplotlib"], capture_output=True, text=True).stdout.upper())
"""
    + HEAD
    + '''\
import glfw
from mujoco.glfw import glfw as window_library


def watch(model, data) -> None:
    if not glfw.init():
        raise RuntimeError("no window can be opened")
    window = window_library.create_window(640, 480, "IMU", None, None)
    glfw.make_context_current(window)
    width, height = glfw.get_framebuffer_size(window)
    while not glfw.window_should_close(window) and glfw.get_key(window, glfw.KEY_ESCAPE) != glfw.PRESS:
        mujoco.mj_step(model, data)
        glfw.swap_buffers(window)
        glfw.poll_events()
    glfw.terminate()
''',
    main=f"""\
model = mujoco.MjModel.from_xml_path("{MODEL_PATH}")
data = mujoco.MjData(model)
plot_imu_data(simulate_and_collect(model, data, 3.0))
watch(model, data)
""",
)

# Letters of the formulas as names; the decimal numbers of the sheet as constants.
GREEK = lab(
    read='''\
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    α, ω = (data.sensordata[slice(s := model.sensor_adr[i], s + 3)].copy() for i in (accel_sensor_id, gyro_sensor_id))
    return α, ω
''',
    low_pass='''\
class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.α, self.y = alpha, initial_value

    def update(self, measurement):
        α, x = self.α, measurement
        self.y = x if self.y is None else α * x + (1 - α) * self.y
        self.y = self.y.copy()
        return self.y.copy()
''',
)

# Everything subclassed, mixed in and decorated.
DECORATED = lab(
    head=HEAD
    + '''\

import functools
import time


def timed(function):
    @functools.wraps(function)
    def wrapper(*args, **kwargs):
        start = time.perf_counter()
        try:
            return function(*args, **kwargs)
        finally:
            print(f"{function.__name__}: {time.perf_counter() - start:.3f} s")

    return wrapper
''',
    collect='''\
@timed
def simulate_and_collect(model, data, duration_seconds=5.0, **options):
    push = options.pop("push", 0.5)
    ids = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, n) for n in ("torso_accelerometer", "torso_gyroscope")]
    assert min(ids) >= 0, "sensor not found"
    count = int(duration_seconds / model.opt.timestep)
    imu_data = {"time": np.zeros(count), "acceleration": np.zeros((count, 3)), "angular_velocity": np.zeros((count, 3))}
    mujoco.mj_resetData(model, data)
    data.qvel[0] = push
    mujoco.mj_forward(model, data)
    for i in range(count):
        mujoco.mj_step(model, data)
        imu_data["time"][i] = data.time
        imu_data["acceleration"][i], imu_data["angular_velocity"][i] = get_imu_readings(model, data, *ids)
    return imu_data
''',
    low_pass='''\
class Stateful:
    def __init__(self):
        self.__state = None

    @property
    def state(self):
        return None if self.__state is None else self.__state.copy()

    @state.setter
    def state(self, value):
        self.__state = np.array(value, dtype=float)


class LowPassFilter(Stateful):
    __slots__ = ("alpha", "_Stateful__state")

    def __init__(self, alpha=0.1, initial_value=None, **kwargs):
        super().__init__(**kwargs)
        self.alpha = alpha
        if initial_value is not None:
            self.state = initial_value

    def update(self, measurement):
        if self.state is None:
            self.state = measurement
        else:
            self.state = self.state * (1 - self.alpha) + self.alpha * np.asarray(measurement)
        return self.state
''',
)

# Relative and package imports between modules of the hand-in; constants in a module of their own.
HELPERS = {
    "config.py": f'MODEL_PATH = "{MODEL_PATH}"\nSENSORS = {{"accel": "torso_accelerometer", "gyro": "torso_gyroscope"}}\nPUSH = 0.5\n',
    "imu_reader.py": '''\
import matplotlib.pyplot as plt
import mujoco
import numpy as np

import config
from plotting import draw_panels


def find(model, kind):
    return mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, config.SENSORS[kind])


def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    return tuple(np.array(data.sensordata[model.sensor_adr[i]:][:3]) for i in (accel_sensor_id, gyro_sensor_id))


def simulate_and_collect(model, data, duration_seconds=5.0):
    accel, gyro = find(model, "accel"), find(model, "gyro")
    mujoco.mj_resetData(model, data)
    data.qvel[0] = config.PUSH
    n = int(duration_seconds / model.opt.timestep)
    log = np.zeros(n, dtype=[("time", float), ("acceleration", float, 3), ("angular_velocity", float, 3)])
    for entry in log:
        mujoco.mj_step(model, data)
        entry["acceleration"], entry["angular_velocity"] = get_imu_readings(model, data, accel, gyro)
        entry["time"] = data.time
    return {name: log[name] for name in log.dtype.names}


def plot_imu_data(imu_data):
    draw_panels(imu_data, "imu_data.png")


if __name__ == "__main__":
    model = mujoco.MjModel.from_xml_path(config.MODEL_PATH)
    plot_imu_data(simulate_and_collect(model, mujoco.MjData(model), 3.0))
    plt.show()
''',
    "plotting.py": '''\
import matplotlib.pyplot as plt

PANELS = [("acceleration", "Acceleration", "m/s²"), ("angular_velocity", "Angular velocity", "rad/s")]


def draw_panels(imu_data, filename):
    with plt.style.context("ggplot"):
        fig, axes = plt.subplots(len(PANELS), 1, figsize=(10, 8), sharex=True)
        for ax, (key, title, unit) in zip(axes, PANELS):
            for k, label in enumerate(("X", "Y", "Z")):
                ax.plot(imu_data["time"], imu_data[key][..., k], label=label)
            ax.set_title(title)
            ax.set_ylabel(f"{title} ({unit})")
            ax.legend()
        axes[-1].set_xlabel("Time (s)")
        fig.savefig(filename)
''',
    "noisy_imu.py": '''\
import numpy as np

import imu_reader


class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005, accel_bias=None, gyro_bias=None):
        self.read_clean = lambda: imu_reader.get_imu_readings(model, data, accel_id, gyro_id)
        self.stds = accel_noise_std, gyro_noise_std
        self.biases = [np.random.randn(3) * s if b is None else np.array(b) for b, s in ((accel_bias, 0.08), (gyro_bias, 0.008))]

    def read(self):
        return tuple(v + np.random.randn(3) * s + b for v, s, b in zip(self.read_clean(), self.stds, self.biases))
''',
    "filters.py": "import matplotlib.pyplot as plt\nimport mujoco\nimport numpy as np\n\nfrom config import MODEL_PATH\n"
    "from noisy_imu import NoisyIMU\n\n\n" + FILTER_INCREMENT + "\n\n" + COMPARE,
}

PEOPLE = {
    "sheet_verbatim": verbatim(),
    "typed_protocols_and_dataclasses": TYPED,
    "chatty_module_level": CHATTY,
    "viewer_at_module_level": VIEWER,
    "viewer_imported_first": WATCHING,
    "glfw_and_pip_at_the_top": WINDOW,
    "greek_names": GREEK,
    "decorated_and_subclassed": DECORATED,
    "helper_modules": HELPERS,
}
