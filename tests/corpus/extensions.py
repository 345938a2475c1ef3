"""Extensions in several hands: sound ones, each in another style, and faulty ones with what they lose and why."""

from __future__ import annotations

from dataclasses import dataclass

FILES = {
    "complementary_filter": "complementary_filter.py",
    "allan_variance": "allan_variance.py",
    "multiple_imus": "multi_imu.py",
    "realtime_visualization": "live_plot.py",
}


@dataclass(frozen=True)
class FaultyExtension:
    """An extension with one fault.

    Attributes
    ----------
    name : str
        Unique; words joined by hyphens.
    extension : str
        The id of the extension.
    mistake : str
        The id of the mistake that is named; "" where a fair marker cannot name one.
    loses : tuple of str
        The checks that lose points. A filter of tilt may lose more: its faults show in more than one motion.
    source : str
        The extension's file.
    """

    name: str
    extension: str
    mistake: str
    loses: tuple[str, ...]
    source: str


# --- the complementary filter ---------------------------------------------------------------------------------------

NAIVE = """\
import math


class ComplementaryFilter:
    def __init__(self, dt, alpha=0.98):
        self.dt = dt
        self.alpha = alpha
        self.roll = 0.0
        self.pitch = 0.0

    def update(self, accel, gyro):
        ax, ay, az = accel
        accel_roll = math.atan2(-ay, -az)
        accel_pitch = math.atan2(ax, math.hypot(ay, az))
        self.roll = self.alpha * (self.roll + gyro[0] * self.dt) + (1 - self.alpha) * accel_roll
        self.pitch = self.alpha * (self.pitch + gyro[1] * self.dt) + (1 - self.alpha) * accel_pitch
        return self.roll, self.pitch
"""

ARRAY = """\
import numpy as np


class ComplementaryFilter:
    \"\"\"Starts at the accelerometer's tilt; alpha is turned into the weight of the accelerometer.\"\"\"

    def __init__(self, dt, alpha=0.98):
        self.dt, self.weight, self.angles = dt, 1.0 - alpha, None

    def update(self, accel, gyro):
        tilt = np.array([np.arctan2(-accel[1], -accel[2]), np.arctan2(accel[0], np.sqrt(accel[1] ** 2 + accel[2] ** 2))])
        if self.angles is None:
            self.angles = tilt
        predicted = self.angles + np.asarray(gyro)[:2] * self.dt
        error = (tilt - predicted + np.pi) % (2 * np.pi) - np.pi
        self.angles = predicted + self.weight * error
        return self.angles
"""

EULER_DICT = """\
from math import atan2, cos, hypot, sin, tan


class ComplementaryFilter:
    def __init__(self, dt, alpha=0.98):
        self.dt = dt
        self.tau = alpha * dt / (1 - alpha)
        self.phi = self.theta = 0.0

    def update(self, accel, gyro):
        p, q, r = gyro
        a = self.tau / (self.tau + self.dt)
        phi_dot = p + tan(self.theta) * (q * sin(self.phi) + r * cos(self.phi))
        theta_dot = q * cos(self.phi) - r * sin(self.phi)
        self.phi = a * (self.phi + phi_dot * self.dt) + (1 - a) * atan2(-accel[1], -accel[2])
        self.theta = a * (self.theta + theta_dot * self.dt) + (1 - a) * atan2(accel[0], hypot(accel[1], accel[2]))
        return {"roll": self.phi, "pitch": self.theta}
"""

GRAVITY_VECTOR = """\
import numpy as np


class ComplementaryFilter:
    \"\"\"Keeps the direction of gravity's reaction and turns it with the gyroscope.\"\"\"

    def __init__(self, dt, alpha=0.98):
        self.dt, self.alpha = dt, alpha
        self.up = np.array([0.0, 0.0, -1.0])

    def update(self, accel, gyro):
        accel, gyro = np.asarray(accel, float), np.asarray(gyro, float)
        turned = self.up - np.cross(gyro, self.up) * self.dt
        self.up = self.alpha * turned + (1 - self.alpha) * accel / np.linalg.norm(accel)
        self.up /= np.linalg.norm(self.up)
        x, y, z = self.up
        return [float(np.arctan2(-y, -z)), float(np.arctan2(x, np.hypot(y, z)))]
"""

MAHONY = """\
import numpy as np


class ComplementaryFilter:
    \"\"\"Mahony's filter with a quaternion inside; also estimates the gyroscope's bias.\"\"\"

    def __init__(self, dt, alpha=0.98, kp=1.0, ki=0.05):
        self.dt, self.kp, self.ki = dt, kp, ki
        self.q = np.array([1.0, 0.0, 0.0, 0.0])
        self.bias = np.zeros(3)

    def update(self, accel, gyro, mag=None):
        w, x, y, z = self.q
        up = -np.array([2 * (x * z - w * y), 2 * (w * x + y * z), w * w - x * x - y * y + z * z])
        error = np.cross(accel / np.linalg.norm(accel), up)
        self.bias -= self.ki * error * self.dt
        p, q, r = gyro - self.bias + self.kp * error
        rate = 0.5 * np.array([-x * p - y * q - z * r, w * p + y * r - z * q, w * q - x * r + z * p, w * r + x * q - y * p])
        self.q = self.q + rate * self.dt
        self.q /= np.linalg.norm(self.q)
        w, x, y, z = self.q
        roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
        pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1, 1))
        return roll, pitch
"""

SCIPY = """\
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation


@dataclass
class ComplementaryFilter:
    dt: float
    alpha: float = 0.98
    attitude: Rotation = field(default_factory=Rotation.identity)

    def update(self, gyro, accel):
        self.attitude = self.attitude * Rotation.from_rotvec(np.asarray(gyro) * self.dt)
        measured = self.attitude.apply(accel / np.linalg.norm(accel))
        axis = np.cross(measured, [0.0, 0.0, -1.0])
        self.attitude = Rotation.from_rotvec((1 - self.alpha) * axis) * self.attitude
        _, pitch, roll = self.attitude.as_euler("ZYX")
        return roll, pitch, 0.0
"""

_NAIVE_BLEND = """\
        self.roll = self.alpha * (self.roll + gyro[0] * self.dt) + (1 - self.alpha) * accel_roll
        self.pitch = self.alpha * (self.pitch + gyro[1] * self.dt) + (1 - self.alpha) * accel_pitch
"""
_TILT_IDS = tuple(
    f"complementary_filter.{name}"
    for name in (
        "returns_roll_and_pitch", "settles_at_tilt", "beats_gyroscope_alone", "beats_accelerometer_alone", "holds_when_steep",
    )
)  # fmt: skip
_LEVEL, _SETTLES, _DRIFT, _SHAKE, _STEEP = _TILT_IDS


def naive(*changes: tuple[str, str]) -> str:
    return _edited(NAIVE, *changes)


def _edited(source: str, *changes: tuple[str, str]) -> str:
    for old, new in changes:
        assert old in source, old
        source = source.replace(old, new)
    return source


_ACCEL_ROLL, _ACCEL_PITCH = "math.atan2(-ay, -az)", "math.atan2(ax, math.hypot(ay, az))"

FAULTY_TILT = [
    FaultyExtension(
        "integrates-alone", "complementary_filter", "gyro-only", (_SETTLES, _DRIFT),
        naive((_NAIVE_BLEND, "        self.roll += gyro[0] * self.dt\n        self.pitch += gyro[1] * self.dt\n")),
    ),
    FaultyExtension(
        "tilt-alone", "complementary_filter", "accel-only", (_SHAKE, _STEEP),
        naive((_NAIVE_BLEND, "        self.roll, self.pitch = accel_roll, accel_pitch\n")),
    ),
    FaultyExtension(
        "smoothed-tilt-alone", "complementary_filter", "accel-only", (_SHAKE,),
        naive((" + gyro[0] * self.dt", ""), (" + gyro[1] * self.dt", ""), ("alpha=0.98", "alpha=0.8")),
    ),
    FaultyExtension(
        "weights-the-other-way", "complementary_filter", "weights-swapped", (_SHAKE, _STEEP),
        naive(
            ("= self.alpha * (self", "= (1 - self.alpha) * (self"),
            (" + (1 - self.alpha) * accel", " + self.alpha * accel"),
        ),
    ),
    FaultyExtension(
        "tilt-in-degrees", "complementary_filter", "degrees-not-radians", (_SETTLES, _DRIFT, _SHAKE, _STEEP),
        naive((_ACCEL_ROLL, f"math.degrees({_ACCEL_ROLL})"), (_ACCEL_PITCH, f"math.degrees({_ACCEL_PITCH})")),
    ),
    FaultyExtension(
        "answers-in-degrees", "complementary_filter", "degrees-not-radians", (_SETTLES, _DRIFT, _SHAKE, _STEEP),
        naive(("return self.roll, self.pitch", "return math.degrees(self.roll), math.degrees(self.pitch)")),
    ),
    FaultyExtension(
        "gyro-taken-for-degrees", "complementary_filter", "degrees-not-radians", (_STEEP,),
        naive(("gyro[0] * self.dt", "math.radians(gyro[0]) * self.dt"), ("gyro[1] * self.dt", "math.radians(gyro[1]) * self.dt")),
    ),
    FaultyExtension(
        "z-up-formula", "complementary_filter", "tilt-sign-wrong", (_LEVEL, _SETTLES, _DRIFT, _SHAKE, _STEEP),
        naive((_ACCEL_ROLL, "math.atan2(ay, az)")),
    ),
    FaultyExtension(
        "pitch-negated", "complementary_filter", "tilt-sign-wrong", (_SETTLES, _STEEP),
        naive((_ACCEL_PITCH, "math.atan2(-ax, math.hypot(ay, az))")),
    ),
    FaultyExtension(
        "gyro-axes-exchanged", "complementary_filter", "tilt-sign-wrong", (_SHAKE, _STEEP),
        naive(("gyro[0]", "gyro[9]"), ("gyro[1]", "gyro[0]"), ("gyro[9]", "gyro[1]")),
    ),
    FaultyExtension(
        "returns-nothing", "complementary_filter", "wrong-return-type", (_LEVEL, _SETTLES, _DRIFT, _SHAKE, _STEEP),
        naive(("        return self.roll, self.pitch\n", "")),
    ),
    FaultyExtension(
        "time-step-fixed", "complementary_filter", "", (_STEEP,), naive(("self.dt = dt", "self.dt = 0.01")),
    ),
    FaultyExtension(
        "mounted-a-degree-off", "complementary_filter", "", (_LEVEL,),
        naive(("return self.roll, self.pitch", "return self.roll + math.radians(1.0), self.pitch")),
    ),
    FaultyExtension("sine-taken-for-the-angle", "complementary_filter", "", (_SETTLES,), naive((_ACCEL_PITCH, "ax / 9.81"))),
    FaultyExtension(
        "gyroscope-trusted-while-it-turns", "complementary_filter", "", (_DRIFT,),
        naive((_NAIVE_BLEND, "        weight = 0.9985 if any(gyro) else self.alpha\n" + _NAIVE_BLEND.replace("self.alpha", "weight"))),
    ),
    FaultyExtension(
        "raises-at-once", "complementary_filter", "raises", (_LEVEL, _SETTLES, _DRIFT, _SHAKE, _STEEP),
        naive(("ax, ay, az = accel", "ax, ay = accel")),
    ),
]  # fmt: skip

# --- the Allan deviation --------------------------------------------------------------------------------------------

ALLAN_BLOCKS = """\
import numpy as np


def allan_deviation(samples, sample_rate_hz):
    samples = np.asarray(samples, dtype=float)
    taus, adevs = [], []
    m = 1
    while len(samples) // m >= 3:
        k = len(samples) // m
        means = samples[:k * m].reshape(k, m, *samples.shape[1:]).mean(axis=1)
        taus.append(m / sample_rate_hz)
        adevs.append(np.sqrt(0.5 * np.mean(np.diff(means, axis=0) ** 2, axis=0)))
        m *= 2
    return np.array(taus), np.array(adevs)
"""

ALLAN_PHASE = """\
import numpy as np


def allan_deviation(samples, sample_rate_hz):
    \"\"\"Overlapping, from the integrated angle as sensor makers' notes do it; one value of the integral fewer.\"\"\"
    tau0 = 1.0 / sample_rate_hz
    theta = np.cumsum(samples, axis=0) * tau0
    n = len(theta)
    m = np.unique(np.ceil(np.logspace(0, np.log10((n - 1) / 2), 100))).astype(int)
    m = m[2 * m < n]
    variance = [
        np.sum((theta[2 * k:] - 2 * theta[k:-k] + theta[:-2 * k]) ** 2, axis=0) / (2 * (k * tau0) ** 2 * (n - 2 * k))
        for k in m
    ]
    return m * tau0, np.sqrt(variance)
"""

ALLAN_PYTHON = """\
from math import sqrt


def _one(values, rate):
    taus, out = [], []
    n = len(values)
    for m in (1, 2, 3, 5, 8, 12, 20, 30, 50, 80, 120, 200, 300, 500):
        if n // m < 4:
            break
        means = [sum(values[i:i + m]) / m for i in range(0, n - m + 1, m)]
        squares = [(b - a) ** 2 for a, b in zip(means, means[1:])]
        taus.append(m / rate)
        out.append(sqrt(sum(squares) / (2 * len(squares))))
    return taus, out


def allan_deviation(samples, sample_rate_hz):
    if getattr(samples, "ndim", 1) == 2:
        columns = [_one(list(column), sample_rate_hz) for column in samples.T]
        return columns[0][0], [out for _, out in columns]
    return _one(list(samples), sample_rate_hz)
"""

ALLAN_EVERY_TAU = """\
import numpy as np


def allan_deviation(samples, sample_rate_hz):
    samples = np.asarray(samples, float)
    if samples.ndim == 2:
        curves = [allan_deviation(column, sample_rate_hz) for column in samples.T]
        return curves[0][0], np.stack([adev for _, adev in curves], axis=1)
    x = np.r_[0.0, np.cumsum(samples)]
    ms = np.arange(1, len(samples) // 3)
    adev = [np.sqrt(0.5 * np.mean((x[2 * m:] - 2 * x[m:-m] + x[:-2 * m]) ** 2)) / m for m in ms]
    return ms / sample_rate_hz, np.array(adev)
"""

ALLAN_STRIDED = """\
import numpy as np


def allan_deviation(samples, sample_rate_hz):
    \"\"\"Half overlapping clusters, averaging times as they were asked for; the longest ones left out.\"\"\"
    samples = np.asarray(samples, float)
    longest = len(samples) / sample_rate_hz / 20
    taus = np.logspace(np.log10(1 / sample_rate_hz), np.log10(longest), 25)
    out = []
    for tau in taus:
        m = max(1, int(tau * sample_rate_hz + 1e-6))
        starts = np.arange(0, len(samples) - 2 * m + 1, max(1, m // 2))
        total = np.concatenate([np.zeros_like(samples[:1]), np.cumsum(samples, axis=0)])
        first = (total[starts + m] - total[starts]) / m
        second = (total[starts + 2 * m] - total[starts + m]) / m
        out.append(np.sqrt(np.mean((second - first) ** 2, axis=0) / 2))
    return taus, np.array(out)
"""

_ALLAN_IDS = tuple(
    f"allan_variance.{name}"
    for name in (
        "returns_times_and_deviations", "averaging_times", "matches_definition", "shows_kinds_of_noise", "takes_three_axes",
    )
)  # fmt: skip
_RETURNS, _TIMES, _MATCHES, _KINDS, _AXES = _ALLAN_IDS


def blocks(*changes: tuple[str, str]) -> str:
    return _edited(ALLAN_BLOCKS, *changes)


FAULTY_ALLAN = [
    FaultyExtension(
        "spread-of-averages", "allan_variance", "std-not-allan", (_MATCHES, _KINDS),
        blocks(("np.sqrt(0.5 * np.mean(np.diff(means, axis=0) ** 2, axis=0))", "np.std(means, axis=0)")),
    ),
    FaultyExtension("no-half", "allan_variance", "allan-factor-missing", (_MATCHES,), blocks(("0.5 * ", ""))),
    FaultyExtension(
        "no-half-in-the-phase-form", "allan_variance", "allan-factor-missing", (_MATCHES,),
        _edited(ALLAN_PHASE, ("(2 * (k * tau0)", "((k * tau0)")),
    ),
    FaultyExtension("times-in-samples", "allan_variance", "tau-wrong", (_TIMES,), blocks(("m / sample_rate_hz", "m"))),
    FaultyExtension(
        "times-times-the-rate", "allan_variance", "tau-wrong", (_TIMES,), blocks(("m / sample_rate_hz", "m * sample_rate_hz")),
    ),
    FaultyExtension("variance-returned", "allan_variance", "", (_MATCHES, _KINDS), blocks(("np.sqrt(0.5 * np", "(0.5 * np"))),
    FaultyExtension(
        "trend-taken-off-where-there-is-one", "allan_variance", "", (_KINDS,),
        blocks((
            "    taus, adevs = [], []\n",
            "    t = np.arange(len(samples))\n    if samples.ndim == 1 and abs(np.corrcoef(t, samples)[0, 1]) > 0.99:\n"
            "        samples = samples - np.polyval(np.polyfit(t, samples, 1), t)\n    taus, adevs = [], []\n",
        )),
    ),
    FaultyExtension(
        "one-axis-only", "allan_variance", "", (_AXES,),
        blocks(("samples = np.asarray(samples, dtype=float)", "samples = np.ravel(samples).astype(float)")),
    ),
    FaultyExtension(
        "one-number", "allan_variance", "wrong-return-type", _ALLAN_IDS,
        "import numpy as np\n\n\ndef allan_deviation(samples, sample_rate_hz):\n    return float(np.std(np.diff(samples)) / 2 ** 0.5)\n",
    ),
    FaultyExtension(
        "too-long-times", "allan_variance", "not-finite", (_RETURNS,),
        blocks(("        m *= 2\n", "        m *= 2\n    taus.append(m / sample_rate_hz)\n    adevs.append(adevs[-1] * np.nan)\n")),
    ),
]  # fmt: skip

# --- many IMUs ------------------------------------------------------------------------------------------------------

IMUS_NAMED = """\
import mujoco


def read_all_imus(model, data):
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, i) for i in range(model.nsensor)]
    readings = {}
    for name in names:
        if name and name.endswith("_accelerometer"):
            place = name[:-len("_accelerometer")]
            if place + "_gyroscope" in names:
                accel = data.sensor(name).data.copy()
                gyro = data.sensor(place + "_gyroscope").data.copy()
                readings[place] = (accel, gyro)
    return readings
"""

IMUS_READER = """\
import mujoco

from imu_reader import get_imu_readings


def read_all_imus(model, data):
    ids = {model.sensor(i).name: i for i in range(model.nsensor)}
    places = [n.removesuffix("_gyroscope") for n in ids if n.endswith("_gyroscope")]
    return {
        place: get_imu_readings(model, data, ids[f"{place}_accelerometer"], ids[f"{place}_gyroscope"])
        for place in places
        if f"{place}_accelerometer" in ids
    }
"""

IMUS_DICTS = """\
import re


def read_all_imus(model, data):
    found = {}
    for i in range(model.nsensor):
        match = re.fullmatch(r"(.+)_(accelerometer|gyroscope|magnetometer)", model.sensor(i).name or "")
        if match:
            start, size = model.sensor_adr[i], model.sensor_dim[i]
            found.setdefault(match[1], {})[match[2]] = data.sensordata[start:start + size].tolist()
    return {
        place: {"acceleration": kinds["accelerometer"], "angular_velocity": kinds["gyroscope"]}
        for place, kinds in found.items()
        if {"accelerometer", "gyroscope"} <= kinds.keys()
    }
"""

IMUS_COMPASS = """\
from typing import NamedTuple

import mujoco
import numpy as np


class Imu(NamedTuple):
    acceleration: np.ndarray
    angular_velocity: np.ndarray
    magnetic_field: object = None


def _read(model, data, name):
    i = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, name)
    return None if i < 0 else np.array(data.sensordata[model.sensor_adr[i]:model.sensor_adr[i] + 3])


def read_all_imus(model, data):
    suffix = "_accelerometer"
    places = [model.sensor(i).name.replace(suffix, "") for i in range(model.nsensor) if model.sensor(i).name.endswith(suffix)]
    all_of_them = {p: [_read(model, data, f"{p}_{k}") for k in ("accelerometer", "gyroscope", "magnetometer")] for p in places}
    return {place: Imu(*parts) for place, parts in all_of_them.items() if parts[1] is not None}
"""

_IMU_IDS = tuple(f"multiple_imus.{name}" for name in ("finds_every_place", "matches_truth", "readings_are_copies"))
_PLACES, _TRUE, _COPIES = _IMU_IDS
_READING = """\
                accel = data.sensor(name).data.copy()
                gyro = data.sensor(place + "_gyroscope").data.copy()
"""

FAULTY_IMUS = [
    FaultyExtension(
        "always-the-same-two", "multiple_imus", "same-imu-repeated", (_TRUE,),
        _edited(
            IMUS_NAMED,
            ("data.sensor(name)", "data.sensor(names[2])"),
            ('data.sensor(place + "_gyroscope")', "data.sensor(names[4])"),
        ),
    ),
    FaultyExtension(
        "first-place-for-all", "multiple_imus", "same-imu-repeated", (_TRUE,),
        _edited(
            IMUS_NAMED,
            (_READING, "                first = first or place\n" + _READING.replace("name)", 'first + "_accelerometer")').replace("(place", "(first")),
            ("    readings = {}\n", "    readings, first = {}, None\n"),
        ),
    ),
    FaultyExtension(
        "one-array-for-all", "multiple_imus", "same-imu-repeated", (_TRUE,),
        _edited(
            IMUS_NAMED,
            ("    readings = {}\n", "    readings, both = {}, np.zeros((2, 3))\n"),
            (_READING, "                both[0] = data.sensor(name).data\n                both[1] = data.sensor(place + '_gyroscope').data\n"),
            ("(accel, gyro)", "both"),
            ("import mujoco\n", "import mujoco\nimport numpy as np\n"),
        ),
    ),
    FaultyExtension(
        "a-fixed-list", "multiple_imus", "imu-missing", (_PLACES,),
        _edited(IMUS_NAMED, ("        if name and", '        if name and name.split("_")[0] in ("torso", "head", "left", "right") and')),
    ),
    FaultyExtension(
        "feet-left-out", "multiple_imus", "imu-missing", (_PLACES,),
        _edited(IMUS_NAMED, ("        if name and", '        if name and "foot" not in name and')),
    ),
    FaultyExtension("views", "multiple_imus", "", (_COPIES,), _edited(IMUS_NAMED, (".data.copy()", ".data"))),
    FaultyExtension("gyro-first", "multiple_imus", "", (_TRUE,), _edited(IMUS_NAMED, ("(accel, gyro)", "(gyro, accel)"))),
    FaultyExtension(
        "a-list", "multiple_imus", "wrong-return-type", _IMU_IDS, _edited(IMUS_NAMED, ("return readings", "return list(readings.values())")),
    ),
]  # fmt: skip

# --- a live plot ----------------------------------------------------------------------------------------------------

_HEAD = """\
import matplotlib.pyplot as plt
import mujoco
import numpy as np


def _adr(model, name):
    return model.sensor_adr[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, name)]
"""

LIVE_PAUSE = (
    _HEAD
    + """

def live_plot(model, data, duration_seconds):
    plt.ion()
    fig, ax = plt.subplots()
    lines = [ax.plot([], [], label=axis)[0] for axis in "XYZ"]
    ax.set_xlabel("Time (s)")
    ax.legend()
    adr = _adr(model, "torso_accelerometer")
    times, rows = [], []
    n_steps = int(duration_seconds / model.opt.timestep)
    for i in range(n_steps):
        mujoco.mj_step(model, data)
        times.append(data.time)
        rows.append(data.sensordata[adr:adr + 3].copy())
        if i % 20 == 0:
            for line, values in zip(lines, np.array(rows).T):
                line.set_data(times, values)
            ax.relim()
            ax.autoscale_view()
            plt.pause(0.001)
    plt.ioff()
    plt.show()
"""
)

LIVE_FUNC_ANIMATION = (
    _HEAD
    + """
from matplotlib.animation import FuncAnimation


def live_plot(model, data, duration_seconds):
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    fig, (top, bottom) = plt.subplots(2, 1, sharex=True)
    accel, gyro = _adr(model, "torso_accelerometer"), _adr(model, "torso_gyroscope")
    upper, lower = [top.plot([], [])[0] for _ in range(3)], [bottom.plot([], [])[0] for _ in range(3)]
    t, a, w = [], [], []
    per_frame = 10

    def update(frame):
        for _ in range(per_frame):
            mujoco.mj_step(model, data)
            t.append(data.time)
            a.append(data.sensordata[accel:accel + 3].copy())
            w.append(data.sensordata[gyro:gyro + 3].copy())
        for line, values in zip(upper + lower, np.hstack([a, w]).T):
            line.set_data(t, values)
        top.set_xlim(0, max(t[-1], 0.1))
        return upper + lower

    frames = int(duration_seconds / model.opt.timestep / per_frame)
    animation = FuncAnimation(fig, update, frames=frames, interval=20, repeat=False)
    plt.show()
    return animation
"""
)

LIVE_GENERATOR_BLIT = (
    _HEAD
    + """
from matplotlib import animation


def live_plot(model, data, duration_seconds):
    fig, ax = plt.subplots()
    ax.set_xlim(0, duration_seconds)
    ax.set_ylim(-20, 20)
    line, = ax.plot([], [], lw=2)
    adr = _adr(model, "torso_accelerometer")
    t, z = [], []

    def init():
        line.set_data([], [])
        return line,

    def frames():
        while data.time < duration_seconds:
            for _ in range(5):
                mujoco.mj_step(model, data)
            yield data.time, data.sensordata[adr + 2]

    def update(now):
        t.append(now[0])
        z.append(now[1])
        line.set_data(t, z)
        return line,

    ani = animation.FuncAnimation(fig, update, frames, init_func=init, blit=True, interval=10, cache_frame_data=False)
    plt.show()
"""
)

LIVE_SAVED = (
    _HEAD
    + """
from matplotlib.animation import FuncAnimation, PillowWriter


def live_plot(model, data, duration_seconds=5.0):
    fig, ax = plt.subplots(figsize=(10, 4))
    adr = _adr(model, "torso_gyroscope")
    t, rates = [], []

    def update(frame):
        mujoco.mj_step(model, data, nstep=10)
        t.append(data.time)
        rates.append(data.sensordata[adr:adr + 3].copy())
        ax.clear()
        ax.plot(t, np.array(rates))
        ax.set_title(f"t = {data.time:.2f} s")

    animation = FuncAnimation(fig, update, frames=int(duration_seconds / (10 * model.opt.timestep)), init_func=lambda: None)
    animation.save("live.gif", writer=PillowWriter(fps=25))
    plt.close(fig)
"""
)

LIVE_DEQUE = (
    _HEAD
    + """
from collections import deque


def live_plot(model, data, duration_seconds):
    \"\"\"A window of the last 100 readings, redrawn through the canvas.\"\"\"
    fig, ax = plt.subplots()
    times, ax_values = deque(maxlen=100), deque(maxlen=100)
    line, = ax.plot([], [], "r-")
    adr = _adr(model, "torso_accelerometer")
    plt.show(block=False)
    end = data.time + duration_seconds
    while data.time < end - 1e-9:
        mujoco.mj_step(model, data)
        times.append(data.time)
        ax_values.append(data.sensordata[adr])
        line.set_xdata(times)
        line.set_ydata(ax_values)
        ax.set_xlim(times[0], times[-1] + 0.01)
        fig.canvas.draw_idle()
        fig.canvas.flush_events()
    plt.close(fig)
"""
)

LIVE_REPLOT = (
    _HEAD
    + """
import time


def live_plot(model, data, duration_seconds):
    adr = _adr(model, "torso_accelerometer")
    history = []
    began = time.time()
    for step in range(round(duration_seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
        history.append([data.time, *data.sensordata[adr:adr + 3]])
        if step % 10:
            continue
        table = np.array(history)
        plt.clf()
        for column, name in enumerate("xyz", start=1):
            plt.plot(table[:, 0] * 1000, table[:, column], label=name)
        plt.xlabel("time (ms)")
        plt.legend()
        plt.tight_layout()
        plt.draw()
        plt.pause(0.01)
        ahead = data.time - (time.time() - began)
        if ahead > 0:
            time.sleep(ahead)
"""
)

LIVE_MANUAL_BLIT = (
    _HEAD
    + """

def live_plot(model, data, duration_seconds):
    fig, ax = plt.subplots()
    n = int(round(duration_seconds / model.opt.timestep))
    ax.set_xlim(0, n)
    ax.set_ylim(-15, 15)
    line, = ax.plot([], [], animated=True)
    plt.show(block=False)
    fig.canvas.draw()
    background = fig.canvas.copy_from_bbox(ax.bbox)
    adr = _adr(model, "torso_accelerometer")
    z = []
    for i in range(n):
        mujoco.mj_step(model, data)
        z.append(data.sensordata[adr + 2])
        if i % 5 == 4:
            fig.canvas.restore_region(background)
            line.set_data(range(len(z)), z)
            ax.draw_artist(line)
            fig.canvas.blit(ax.bbox)
            fig.canvas.flush_events()
"""
)

LIVE_SCOPE = (
    _HEAD
    + """
from mujoco import mj_step


def live_plot(model, data, duration_seconds):
    \"\"\"Like an oscilloscope: a buffer of fixed length that is shifted to the left; driven by a timer.\"\"\"
    fig, ax = plt.subplots()
    buffer = np.zeros((60, 3))
    lines = ax.plot(buffer)
    adr = _adr(model, "torso_gyroscope")

    def tick():
        for _ in range(3):
            mj_step(model, data)
        buffer[:-1] = buffer[1:]
        buffer[-1] = data.sensordata[adr:adr + 3]
        for line, column in zip(lines, buffer.T):
            line.set_ydata(column.copy())
        ax.relim()
        ax.autoscale_view()
        fig.canvas.draw_idle()
        if data.time >= duration_seconds:
            timer.stop()
            plt.close(fig)

    timer = fig.canvas.new_timer(interval=10)
    timer.add_callback(tick)
    timer.start()
    plt.show()
"""
)

LIVE_NOISY = (
    _HEAD
    + """
from noisy_imu import NoisyIMU


def live_plot(model, data, duration_seconds):
    imu = NoisyIMU(model, data, model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id)
    fig, axes = plt.subplots(2, 1)
    points = []
    for i in range(int(duration_seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
        points.append(np.concatenate([[data.time], *imu.read()]))
        if i % 25 == 0:
            p = np.array(points)
            for ax, columns in zip(axes, (p[:, 1:4], p[:, 4:])):
                ax.cla()
                ax.plot(p[:, 0], columns)
            fig.canvas.draw()
            plt.pause(0.02)
    plt.show()
"""
)

_LIVE_IDS = tuple(f"realtime_visualization.{name}" for name in ("returns", "grows_while_stepping", "shows_true_data"))
_BACK, _GROWS, _SHOWS = _LIVE_IDS

_ONCE = (
    _HEAD
    + """

def live_plot(model, data, duration_seconds):
    adr = _adr(model, "torso_accelerometer")
    times, rows = [], []
    for _ in range(int(duration_seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
        times.append(data.time)
        rows.append(data.sensordata[adr:adr + 3].copy())
    plt.plot(times, rows)
    plt.xlabel("Time (s)")
    plt.show()
"""
)

FAULTY_LIVE = [
    FaultyExtension("drawn-once", "realtime_visualization", "plot-not-live", (_GROWS,), _ONCE),
    FaultyExtension(
        "saved-once", "realtime_visualization", "plot-not-live", (_GROWS,),
        _edited(_ONCE, ("plt.show()", 'plt.savefig("live.png")')),
    ),
    FaultyExtension(
        "replayed", "realtime_visualization", "", (_GROWS,),
        _edited(
            _ONCE,
            ("    plt.plot(times, rows)\n", "    line, = plt.plot([], [])\n    for k in range(0, len(times), 10):\n"
             "        line.set_data(times[:k], [row[2] for row in rows[:k]])\n        plt.pause(0.01)\n"),
        ),
    ),
    FaultyExtension(
        "another-channel-by-mistake", "realtime_visualization", "", (_SHOWS,),
        _edited(LIVE_PAUSE, ("adr:adr + 3].copy()", "adr:adr + 3] * np.array([0.0, 2.0, -1.0]) + 3.0")),
    ),
    FaultyExtension(
        "stops-early", "realtime_visualization", "", (_BACK,),
        _edited(LIVE_PAUSE, ("duration_seconds / model.opt.timestep", "0.6 * duration_seconds / model.opt.timestep")),
    ),
    FaultyExtension(
        "raises-half-way", "realtime_visualization", "raises", _LIVE_IDS,
        _edited(LIVE_PAUSE, ("        times.append(data.time)\n", "        times.append(data.time)\n        assert i < 50\n")),
    ),
    FaultyExtension(
        "never-comes-back", "realtime_visualization", "never-returns", _LIVE_IDS,
        _edited(LIVE_DEQUE, ("while data.time < end - 1e-9:", "while True:"), ("        mujoco.mj_step(model, data)\n", "")),
    ),
]  # fmt: skip

SOUND_EXTENSIONS: dict[str, dict[str, str]] = {
    "complementary_filter": {
        "naive": NAIVE, "array": ARRAY, "euler-dict": EULER_DICT, "gravity-vector": GRAVITY_VECTOR, "mahony": MAHONY, "scipy": SCIPY,
        "alpha-first": _edited(NAIVE, ("self, dt, alpha=0.98", "self, alpha=0.98, dt=0.01")),
        "dt-each-time": _edited(
            NAIVE, ("self, dt, alpha=0.98", "self, alpha"), ("        self.dt = dt\n", ""),
            ("(self, accel, gyro)", "(self, gyro, accel, dt)"), ("* self.dt", "* dt"),
        ),
    },
    "allan_variance": {
        "blocks": ALLAN_BLOCKS, "phase": ALLAN_PHASE, "python": ALLAN_PYTHON, "every-tau": ALLAN_EVERY_TAU, "strided": ALLAN_STRIDED,
    },
    "multiple_imus": {"named": IMUS_NAMED, "reader": IMUS_READER, "dicts": IMUS_DICTS, "compass": IMUS_COMPASS,
                      "data-first": _edited(IMUS_NAMED, ("read_all_imus(model, data)", "read_all_imus(data, model)"))},
    "realtime_visualization": {
        "pause": LIVE_PAUSE, "func-animation": LIVE_FUNC_ANIMATION, "generator-blit": LIVE_GENERATOR_BLIT, "saved": LIVE_SAVED,
        "deque": LIVE_DEQUE, "replot": LIVE_REPLOT, "manual-blit": LIVE_MANUAL_BLIT, "scope": LIVE_SCOPE, "noisy": LIVE_NOISY,
        "switches-backend": _edited(LIVE_PAUSE, ("    plt.ion()\n", '    plt.switch_backend("TkAgg")\n    plt.ion()\n')),
    },
}  # fmt: skip

FAULTY_EXTENSIONS: list[FaultyExtension] = [*FAULTY_TILT, *FAULTY_ALLAN, *FAULTY_IMUS, *FAULTY_LIVE]
