"""Sound submissions with habits that trip graders up: what students do beside the lab."""



from __future__ import annotations

from tests.corpus.pieces import (
    COLLECT_LOOKUP,
    COMPARE,
    HEAD,
    NOISE_GENERATOR,
    PLOT_LOOP,
    READER_MAIN,
    edit,
    lab,
    listy,
    looping,
    tidy,
)

# ---------------------------------------------------------------- units, written in the ways that people write them

WRITINGS = {
    "per_sec": ("m/sec^2", "rad/sec", "sec"),
    "powers": ("m s^-2", "rad s^-1", "s"),
    "m_s_s": ("m/s/s", "rads/s", "seconds"),
    "mathtext_powers": (r"$\\mathrm{m\\,s^{-2}}$", r"$\\mathrm{rad\\,s^{-1}}$", r"$\\mathrm{s}$"),
    "mathtext_fraction": (r"$\\frac{m}{s^2}$", r"$\\frac{rad}{s}$", "s"),
    "words_and_metres": ("metres per second squared", "radians per second", "seconds"),
    "dots": ("m·s⁻²", "rad·s⁻¹", "s"),
    "mathtext_mixed": ("m/s$^2$", "rad/s", "s"),
}


def units(acceleration: str, rate: str, time: str) -> dict[str, str]:
    plot = edit({"p": PLOT_LOOP}, "p", ("Acceleration [m/s^2]", f"Acceleration ({acceleration})"), ("Angular velocity [rad/s]", f"Angular velocity ({rate})"), ("Time [s]", f"Time ({time})"))["p"]
    return lab(plot=plot.replace("\\\\", "\\").replace('("Acceleration (', '(r"Acceleration (').replace('("Angular velocity (', '(r"Angular velocity (').replace('("Time (', '(r"Time ('))


# ---------------------------------------------------------------- figures with more in them than was asked

PLOT_WITH_MAGNITUDE = '''\
def plot_imu_data(imu_data):
    t, acc, gyr = (np.asarray(imu_data[k]) for k in ("time", "acceleration", "angular_velocity"))
    fig = plt.figure(figsize=(11, 10), constrained_layout=True)
    grid = fig.add_gridspec(3, 1)
    a = fig.add_subplot(grid[0])
    m = fig.add_subplot(grid[1], sharex=a)
    w = fig.add_subplot(grid[2], sharex=a)
    a.plot(t, acc[:, 0], "r", t, acc[:, 1], "g", t, acc[:, 2], "b")
    a.legend(["x", "y", "z"])
    a.axhline(0, color="0.8", zorder=0)
    a.axvspan(0, 0.2, color="orange", alpha=0.2)
    a.set(title="Acceleration", ylabel="Acceleration (m/s²)")
    m.plot(t, np.linalg.norm(acc, axis=1), "k", label="|a|")
    m.fill_between(t, 9.7, 9.9, alpha=0.2, label="gravity ± 0.1")
    m.legend()
    m.set(title="Magnitude of the acceleration", ylabel="|a| (m/s²)")
    w.plot(t, gyr[:, 0], "r", t, gyr[:, 1], "g", t, gyr[:, 2], "b")
    w.legend(["roll rate", "pitch rate", "yaw rate"])
    w.set(title="Angular velocity", ylabel="Angular velocity (rad/s)", xlabel="Time (s)")
    w.annotate("push", xy=(0.05, 0), xytext=(0.4, 0.3), arrowprops={"arrowstyle": "->"})
    for ending in ("png", "pdf", "svg"):
        fig.savefig("imu_data." + ending)
'''

PLOT_SUBFIGURES = '''\
def plot_imu_data(imu_data):
    fig = plt.figure(figsize=(12, 8), layout="constrained")
    left, right = fig.subfigures(1, 2)
    for part, key, title, unit in ((left, "acceleration", "Accelerometer", "m/s²"), (right, "angular_velocity", "Gyroscope", "rad/s")):
        axes = part.subplots(3, 1, sharex=True)
        for ax, values, name in zip(axes, imu_data[key].T, "xyz"):
            ax.plot(imu_data["time"], values, lw=1, label=name)
            ax.legend(loc="upper right")
        part.suptitle(title)
        part.supylabel(f"{key.replace('_', ' ')} ({unit})")
        part.supxlabel("time (s)")
    fig.savefig("imu_data.png")
'''

COMPARE_STACKED = COMPARE.replace(
    '''    fig, ax = plt.subplots(figsize=(10, 4))
    ax.plot(t, np.array(raw)[:, 2], alpha=0.5, label="raw z")
    ax.plot(t, np.array(smooth)[:, 2], label="filtered z")
    ax.set_xlabel("Time (s)")
    ax.set_ylabel("Acceleration (m/s²)")
    ax.set_title("Raw and filtered acceleration")
    ax.legend()
''',
    '''    fig, (above, below) = plt.subplots(2, 1, figsize=(10, 8), sharex=True, sharey=True)
    above.plot(t, np.array(raw)[:, 2])
    above.set_title("Raw z acceleration")
    below.plot(t, np.array(smooth)[:, 2])
    below.set_title("Filtered z acceleration")
    for ax in (above, below):
        ax.set_xlabel("Time (s)")
        ax.set_ylabel("Acceleration (m/s²)")
''',
)

COMPARE_SIX_CURVES = COMPARE.replace('ax.plot(t, np.array(raw)[:, 2], alpha=0.5, label="raw z")', 'ax.plot(t, np.array(raw), alpha=0.4, label=["raw x", "raw y", "raw z"])').replace(
    'ax.plot(t, np.array(smooth)[:, 2], label="filtered z")', 'ax.plot(t, np.array(smooth), label=["filtered x", "filtered y", "filtered z"])'
)

# ---------------------------------------------------------------- generators made wherever they are needed

NOISE_NEW_GENERATORS = NOISE_GENERATOR.replace("self.rng.normal(0.0, self.accel_noise_std", "np.random.default_rng().normal(0.0, self.accel_noise_std").replace(
    "self.rng.normal(0.0, self.gyro_noise_std", "np.random.default_rng().normal(0.0, self.gyro_noise_std"
)
NOISE_SYSTEM = NOISE_GENERATOR.replace("self.rng.normal(0.0, self.accel_noise_std, size=3)", "_normal(self.accel_noise_std)").replace("self.rng.normal(0.0, self.gyro_noise_std, size=3)", "_normal(self.gyro_noise_std)").replace(
    "class NoisyIMU",
    '''import secrets

_SOURCE = secrets.SystemRandom()


def _normal(std):
    """Box and Muller, from the operating system's random numbers."""
    u, v = (np.array([_SOURCE.random() for _ in range(3)]) for _ in range(2))
    return std * np.sqrt(-2 * np.log(1 - u)) * np.cos(2 * np.pi * v)


class NoisyIMU''',
)

NOISE_SEEDED_BY_CLOCK = '''\
import time

np.random.seed(int(time.time()) % 2**32)


class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005, accel_bias=None, gyro_bias=None):
        np.random.seed()
        self.__dict__.update(locals())
        if accel_bias is None:
            self.accel_bias = np.random.randn(3) / 10
        if gyro_bias is None:
            self.gyro_bias = np.random.randn(3) / 100

    def read(self):
        accel, gyro = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)
        accel = np.random.normal(loc=accel, scale=self.accel_noise_std) + self.accel_bias
        gyro = np.random.normal(loc=gyro, scale=self.gyro_noise_std) + self.gyro_bias
        return accel, gyro
'''

READ_BY_NAME_OF_ID = '''\
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    values = []
    for sensor_id in (accel_sensor_id, gyro_sensor_id):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, sensor_id)
        values.append(np.array(data.sensor(name).data))
    return values[0], values[1]
'''

COLLECT_FIRST_SAMPLE_TOO = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    """n + 1 samples: the state at t = 0 as well."""
    accel_id = model.sensor("torso_accelerometer").id
    gyro_id = model.sensor("torso_gyroscope").id
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    mujoco.mj_forward(model, data)
    acc, gyr = get_imu_readings(model, data, accel_id, gyro_id)
    t, a, w = [data.time], [acc], [gyr]
    for _ in range(int(round(duration_seconds / model.opt.timestep))):
        mujoco.mj_step(model, data)
        acc, gyr = get_imu_readings(model, data, accel_id, gyro_id)
        t.append(data.time)
        a.append(acc)
        w.append(gyr)
    return {"time": np.array(t), "acceleration": np.array(a), "angular_velocity": np.array(w)}
'''

SETTINGS = HEAD + '''\

import atexit
import os
import sys
import warnings

warnings.simplefilter("error")
np.seterr(all="raise")
np.set_printoptions(precision=3, suppress=True)
sys.setrecursionlimit(5000)
sys.path.append(os.path.dirname(os.path.abspath(__file__)))
plt.rcParams.update({"font.size": 13, "axes.grid": True, "figure.autolayout": True})
atexit.register(print, "good bye")
'''

BESIDE_THE_FILE = '''\
#!/usr/bin/env python3
import os
from pathlib import Path

import matplotlib.pyplot as plt
import mujoco
import numpy as np

HERE = Path(__file__).resolve().parent
os.chdir(HERE)
MODEL_PATH = str(HERE / "models" / "humanoid-sensors.xml")
'''

ARGUMENTS_AT_IMPORT = HEAD + '''\

import argparse

parser = argparse.ArgumentParser()
parser.add_argument("--seconds", type=float, default=3.0)
args = parser.parse_args()

try:
    from tqdm import tqdm
except ImportError:
    def tqdm(things, **options):
        return things
'''

ENDS_WITH_EXIT = READER_MAIN.replace("    main()\n", "    main()\n    answer = int(input('another run? ') or 0)\n    exit(0)\n")

HABITS = {
    **{f"units_{name}": units(*writing) for name, writing in WRITINGS.items()},
    "extra_panel_and_formats": lab(plot=PLOT_WITH_MAGNITUDE, compare=COMPARE_SIX_CURVES),
    "subfigures": lab(plot=PLOT_SUBFIGURES, compare=COMPARE_STACKED),
    "generators_made_in_read": lab(noise=NOISE_NEW_GENERATORS),
    "random_numbers_of_the_system": lab(noise=NOISE_SYSTEM),
    "seeded_by_the_clock": lab(noise=NOISE_SEEDED_BY_CLOCK),
    "name_of_the_id": lab(read=READ_BY_NAME_OF_ID),
    "first_sample_too": lab(collect=COLLECT_FIRST_SAMPLE_TOO),
    "strict_settings": edit(lab(head=SETTINGS), "imu_reader.py", ("    fig.tight_layout()\n", "")),
    "paths_beside_the_file": edit(lab(head=BESIDE_THE_FILE), "imu_reader.py", ('fig.savefig("imu_data.png", dpi=100)', 'fig.savefig(HERE / "imu_data.png", dpi=100)')),
    "pictures_in_a_folder": edit(
        edit(listy(), "imu_reader.py", ('    plt.savefig("imu_data.png")\n', '    import os\n    os.makedirs("figures", exist_ok=True)\n    plt.savefig("figures/imu_data.png")\n')),
        "filters.py", ('fig.savefig("filtered_imu.png", dpi=100)', 'import pathlib\n    pathlib.Path("figures").mkdir(exist_ok=True)\n    fig.savefig("figures/comparison.png", dpi=100)'),
    ),
    "arguments_parsed_at_import": edit(lab(head=ARGUMENTS_AT_IMPORT), "imu_reader.py", ("for i in range(n_steps):", 'for i in tqdm(range(n_steps), desc="simulating"):')),
    "ends_with_exit": lab(main=ENDS_WITH_EXIT),
    "recorded_in_single_precision": lab(collect=COLLECT_LOOKUP.replace("np.empty((n_steps, 3))", "np.empty((n_steps, 3), dtype=np.float32)")),
    "empty_handed_filter_module_head": {**tidy(), "filters.py": tidy()["filters.py"].replace("from imu_reader import MODEL_PATH\n", "try:\n    from imu_reader import MODEL_PATH\nexcept ImportError:\n    MODEL_PATH = 'humanoid-sensors.xml'\n")},
    "time_from_zero_on_the_axis": edit(looping(), "imu_reader.py", *[(f"axes[{p}].plot(imu_data['time'], imu_data['{k}'][:, {i}]", f"axes[{p}].plot(imu_data['time'] - imu_data['time'][0], imu_data['{k}'][:, {i}]") for p, k in ((0, "acceleration"), (1, "angular_velocity")) for i in range(3)]),
}
