"""One fault in several styles: templates of each function that compute the same in another way, and faults as edits of all of them.

A template has slots, such as ``<address>``, whose sound content is in `SOUND`; a fault gives some of them another content. So each
fault is written in every style, and a grader that is fair says the same of all.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from tests.corpus.pieces import lab

TEMPLATES: Mapping[str, Mapping[str, str]] = {
    "read": {
        "slices": """\
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    <before>
    sensor = accel_sensor_id
    a = <address of accel>
    sensor = gyro_sensor_id
    g = <address of gyro>
    accel, gyro = data.sensordata[a:a + 3].copy(), data.sensordata[g:g + 3].copy()
    return <first>, <second>
""",
        "lists of indices": """\
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    <before>
    found = []
    for sensor, place in ((accel_sensor_id, lambda sensor: <address of accel>), (gyro_sensor_id, lambda sensor: <address of gyro>)):
        found.append(data.sensordata[place(sensor) + np.arange(3)])
    accel, gyro = found
    return <first>, <second>
""",
        "number by number": """\
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    <before>
    accel, gyro = np.zeros(3), np.zeros(3)
    for k in range(3):
        sensor = accel_sensor_id
        accel[k] = data.sensordata[<address of accel> + k]
        sensor = gyro_sensor_id
        gyro[k] = data.sensordata[<address of gyro> + k]
    return (<first>, <second>)
""",
        "a helper and a tuple": """\
def _vector(data, start):
    return np.array(data.sensordata[int(start):int(start) + 3], dtype=float)


def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    <before>
    accel = _vector(data, (lambda sensor: <address of accel>)(accel_sensor_id))
    gyro = _vector(data, (lambda sensor: <address of gyro>)(gyro_sensor_id))
    both = <first>, <second>
    return both
""",
    },
    "collect": {
        "arrays made before": """\
def simulate_and_collect(model, data, duration_seconds=5.0):
    accel_id, gyro_id = model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id
    <set up>
    n = int(round(<duration> / <dt>))
    time, acceleration, angular_velocity = np.zeros(n), np.zeros((n, 3)), np.zeros((n, 3))
    <reset>
    <push>
    for i in range(n):
        <before step>
        <step>
        accel, gyro = get_imu_readings(model, data, accel_id, gyro_id)
        time[i], acceleration[i], angular_velocity[i] = <stamp>, <accel>, <gyro>
    return {"time": time, "acceleration": acceleration, "angular_velocity": angular_velocity}
""",
        "lists": """\
def simulate_and_collect(model, data, duration_seconds=5.0):
    accel_id, gyro_id = model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id
    <set up>
    <reset>
    <push>
    t, a, w = [], [], []
    i = 0
    while i < int(round(<duration> / <dt>)):
        <before step>
        <step>
        accel, gyro = get_imu_readings(model, data, accel_id, gyro_id)
        t.append(<stamp>)
        a.append(np.array(<accel>))
        w.append(np.array(<gyro>))
        i += 1
    return {"time": np.array(t), "acceleration": np.array(a), "angular_velocity": np.array(w)}
""",
        "one table": """\
def simulate_and_collect(model, data, duration_seconds=5.0):
    accel_id, gyro_id = (mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, f"torso_{kind}") for kind in ("accelerometer", "gyroscope"))
    <set up>
    n = int(round(<duration> / <dt>))
    log = np.zeros((n, 7))
    <reset>
    <push>
    for i, row in enumerate(log):
        <before step>
        <step>
        accel, gyro = get_imu_readings(model, data, accel_id, gyro_id)
        row[0], row[1:4], row[4:] = <stamp>, <accel>, <gyro>
    return dict(time=log[:, 0], acceleration=log[:, 1:4], angular_velocity=log[:, 4:])
""",
        "a generator": """\
def _samples(model, data, ids, n):
    for i in range(n):
        <before step>
        <step>
        accel, gyro = get_imu_readings(model, data, *ids)
        yield <stamp>, list(<accel>), list(<gyro>)


def simulate_and_collect(model, data, duration_seconds=5.0):
    ids = model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id
    <set up>
    n = int(round(<duration> / <dt>))
    <reset>
    <push>
    t, a, w = zip(*_samples(model, data, ids, n))
    return {"time": np.array(t), "acceleration": np.array(a), "angular_velocity": np.array(w)}
""",
    },
    "noise": {
        "as on the sheet": """\
class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005, accel_bias=None, gyro_bias=None):
        self.model, self.data, self.accel_id, self.gyro_id = model, data, accel_id, gyro_id
        self.accel_noise_std, self.gyro_noise_std = accel_noise_std, gyro_noise_std
        self.rng = np.random
        self.accel_bias = <accel bias>
        self.gyro_bias = <gyro bias>
        <at first>

    def read(self):
        <at each read>
        accel, gyro = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)
        std, other, bias, others, x, name = self.accel_noise_std, self.gyro_noise_std, self.accel_bias, self.gyro_bias, accel, "accel"
        noisy_accel = <noisy>
        std, other, bias, others, x, name = self.gyro_noise_std, self.accel_noise_std, self.gyro_bias, self.accel_bias, gyro, "gyro"
        noisy_gyro = <noisy>
        return noisy_accel, noisy_gyro
""",
        "a helper for each sensor": """\
class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005, accel_bias=None, gyro_bias=None):
        self.rng = np.random.default_rng()
        self.imu = model, data, accel_id, gyro_id
        self.accel_noise_std, self.gyro_noise_std = accel_noise_std, gyro_noise_std
        self.accel_bias, self.gyro_bias = <accel bias>, <gyro bias>
        <at first>

    def _noisy(self, x, std, other, bias, others, name):
        return <noisy>

    def read(self):
        <at each read>
        accel, gyro = get_imu_readings(*self.imu)
        return (
            self._noisy(accel, self.accel_noise_std, self.gyro_noise_std, self.accel_bias, self.gyro_bias, "accel"),
            self._noisy(gyro, self.gyro_noise_std, self.accel_noise_std, self.gyro_bias, self.accel_bias, "gyro"),
        )
""",
        "dictionaries": """\
class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005, accel_bias=None, gyro_bias=None):
        self.rng = np.random.default_rng()
        self.read_clean = lambda: get_imu_readings(model, data, accel_id, gyro_id)
        self.std = {"accel": accel_noise_std, "gyro": gyro_noise_std}
        self.bias = {"accel": <accel bias>, "gyro": <gyro bias>}
        <at first>

    def read(self):
        <at each read>
        found = {}
        for name, x in zip(("accel", "gyro"), self.read_clean()):
            beside = "gyro" if name == "accel" else "accel"
            std, other, bias, others = self.std[name], self.std[beside], self.bias[name], self.bias[beside]
            found[name] = <noisy>
        return found["accel"], found["gyro"]
""",
        "a dataclass": """\
from dataclasses import dataclass, field
from typing import Any


@dataclass
class NoisyIMU:
    model: Any
    data: Any
    accel_id: int
    gyro_id: int
    accel_noise_std: float = 0.05
    gyro_noise_std: float = 0.005
    accel_bias: Any = None
    gyro_bias: Any = None

    def __post_init__(self):
        self.rng = np.random.default_rng()
        accel_bias, gyro_bias = self.accel_bias, self.gyro_bias
        self.accel_bias = <accel bias>
        self.gyro_bias = <gyro bias>
        <at first>

    def read(self):
        <at each read>
        rows = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)
        stds, biases = (self.accel_noise_std, self.gyro_noise_std), (self.accel_bias, self.gyro_bias)
        kinds = zip(rows, stds, stds[::-1], biases, biases[::-1], ("accel", "gyro"))
        return tuple(<noisy> for x, std, other, bias, others, name in kinds)
""",
    },
    "low_pass": {
        "as on the sheet": """\
class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.alpha, self.value = alpha, <initial>

    def update(self, measurement):
        x, y, alpha = np.array(measurement, dtype=float), self.value, self.alpha
        self.value = <start> if self.value is None else <next>
        return np.array(<output>)
""",
        "an increment and a flag": """\
class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.alpha = alpha
        self.value = <initial>
        self.started = self.value is not None

    def update(self, measurement):
        x, alpha, y = np.asarray(measurement, dtype=float).copy(), self.alpha, self.value
        if not self.started:
            self.started = True
            self.value = <start>
        else:
            self.value = y + ((<next>) - y)
        return (<output>) + 0.0
""",
        "a generator": """\
class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self._steps = self._run(alpha, <initial>)
        next(self._steps)

    def _run(self, alpha, value):
        self.value, result = value, None
        while True:
            x = np.array((yield result), dtype=float)
            y = self.value
            self.value = <start> if y is None else <next>
            result = np.array(<output>)

    def update(self, measurement):
        return self._steps.send(measurement)
""",
        "a list of outputs": """\
class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        first = <initial>
        self.alpha, self.history = alpha, [] if first is None else [first]

    def update(self, measurement):
        x, alpha = np.array(measurement, dtype=float), self.alpha
        y = self.history[-1] if self.history else None
        self.value = <start> if y is None else <next>
        self.history = [self.value]
        return np.copy(<output>)
""",
    },
}
"""By part and style: the code, with slots."""
_DRAWN = "np.random.normal(0, {}, 3) if {} is None else np.asarray({}, dtype=float)"
SOUND: Mapping[str, str] = {
    "before": "pass",
    "address of accel": "model.sensor_adr[sensor]",
    "address of gyro": "model.sensor_adr[sensor]",
    "first": "accel",
    "second": "gyro",
    "set up": "pass",
    "duration": "duration_seconds",
    "dt": "model.opt.timestep",
    "reset": "mujoco.mj_resetData(model, data)",
    "push": "data.qvel[0] = 0.5",
    "before step": "pass",
    "step": "mujoco.mj_step(model, data)",
    "stamp": "data.time",
    "accel": "accel",
    "gyro": "gyro",
    "accel bias": _DRAWN.format(0.1, "accel_bias", "accel_bias"),
    "gyro bias": _DRAWN.format(0.01, "gyro_bias", "gyro_bias"),
    "at first": "pass",
    "at each read": "pass",
    "noisy": "x + self.rng.normal(0, std, 3) + bias",
    "initial": "None if initial_value is None else np.array(initial_value, dtype=float)",
    "start": "x",
    "next": "alpha * x + (1 - alpha) * y",
    "output": "self.value",
}
"""The sound content of each slot."""


@dataclass(frozen=True)
class Fault:
    """A fault of one part: its id in the fault table ("" without a name), and what stands in the slots."""

    part: str
    id: str
    slots: Mapping[str, str]

    @property
    def name(self) -> str:
        return f"{self.part}: {self.id}: {'; '.join(self.slots.values())}"[:100]


def _reader(id_: str, **slots: str) -> Fault:
    return Fault("read", id_, slots)


def _places(id_: str, accel: str, gyro: str = "") -> Fault:
    """A fault of the address; without one for the gyroscope, the same for both sensors."""
    return Fault("read", id_, {"address of accel": accel, "address of gyro": gyro or accel})


def _values(id_: str, change: str) -> Fault:
    """A change of the values of both sensors; ``v`` is a vector."""
    return Fault("read", id_, {"first": f"(lambda v: {change})(accel)", "second": f"(lambda v: {change})(gyro)"})


def _recorder(id_: str, **slots: str) -> Fault:
    return Fault("collect", id_, {name.replace("_", " "): content for name, content in slots.items()})


def _noise(id_: str, **slots: str) -> Fault:
    return Fault("noise", id_, {name.replace("_", " "): content for name, content in slots.items()})


def _filter(id_: str, **slots: str) -> Fault:
    return Fault("low_pass", id_, slots)


FAULTS: tuple[Fault, ...] = (
    _places("sensor-id-as-address", "sensor"),
    _places("sensor-id-as-address", "3 * sensor"),
    _places("off-by-one-address", "model.sensor_adr[sensor] + 1"),
    _places("off-by-one-address", "model.sensor_adr[sensor] - 1"),
    _places("hard-coded-address", "5", "11"),
    _places("same-sensor-twice", "model.sensor_adr[accel_sensor_id]"),
    _reader("swapped-sensors", first="gyro", second="accel"),
    _reader("disturbs-simulation", before="mujoco.mj_step(model, data)"),
    _values("sign-flipped", "-v"),
    _values("wrong-units", "v / 9.81"),
    _values("axes-permuted", "v[::-1].copy()"),
    _values("precision-lost", "np.round(v, 1)"),
    _values("gravity-removed", "v + np.array([0, 0, 9.81])"),
    _values("wrong-length", "v[:2]"),
    _recorder("no-reset", reset="pass"),
    _recorder("no-perturbation", push="pass"),
    _recorder("wrong-perturbation", push="data.qvel[1] = 0.5"),
    _recorder("driven-in-every-step", before_step="data.qvel[0] = 0.5"),
    _recorder("ignores-duration", duration="3.0"),
    _recorder("hard-coded-timestep", dt="0.002"),
    _recorder("samples-skipped", step="mujoco.mj_step(model, data, nstep=2)"),
    _recorder("time-axis-wrong", stamp="float(i)"),
    _recorder("time-axis-wrong", stamp="data.time * 1000"),
    _recorder("channels-swapped", accel="gyro", gyro="accel"),
    _recorder("modifies-model", set_up="model.opt.gravity[2] = -1.62"),
    _recorder("starts-over", before_step="mujoco.mj_resetData(model, data)"),
    _recorder("rows-altered", accel="2 * np.array(accel)"),
    _noise("no-noise", noisy="x + bias"),
    _noise("gyro-not-noisy", noisy='x + bias + (self.rng.normal(0, std, 3) if name == "accel" else 0)'),
    _noise("variance-as-std", noisy="x + self.rng.normal(0, std ** 2, 3) + bias"),
    _noise("std-ignored", noisy="x + self.rng.normal(0, 0.05, 3) + bias"),
    _noise("stds-swapped", noisy="x + self.rng.normal(0, other, 3) + bias"),
    _noise("same-noise-on-axes", noisy="x + self.rng.normal(0, std) + bias"),
    _noise("not-gaussian", noisy="x + self.rng.uniform(-std * 3 ** 0.5, std * 3 ** 0.5, 3) + bias"),
    _noise("noise-not-zero-mean", noisy="x + abs(self.rng.normal(0, std, 3)) + bias"),
    _noise("multiplicative-noise", noisy="x * (1 + self.rng.normal(0, std, 3)) + bias"),
    _noise("frozen-noise", at_first="self.drawn = self.rng.normal(0, 1, 3), self.rng.normal(0, 1, 3)",
           noisy='x + std * self.drawn[name == "gyro"] + bias'),
    _noise("reseeded", at_each_read="self.rng = np.random.default_rng(42)"),
    _noise("no-bias", noisy="x + self.rng.normal(0, std, 3)"),
    _noise("bias-redrawn", noisy='x + self.rng.normal(0, std, 3) + self.rng.normal(0, 0.1 if name == "accel" else 0.01, 3)'),
    _noise("bias-argument-ignored", accel_bias="np.random.normal(0, 0.1, 3)", gyro_bias="np.random.normal(0, 0.01, 3)"),
    _noise("bias-not-random", accel_bias="np.zeros(3) if accel_bias is None else np.asarray(accel_bias, dtype=float)",
           gyro_bias="np.zeros(3) if gyro_bias is None else np.asarray(gyro_bias, dtype=float)"),
    _noise("bias-sign-flipped", noisy="x + self.rng.normal(0, std, 3) - bias"),
    _noise("biases-exchanged", noisy="x + self.rng.normal(0, std, 3) + others"),
    _noise("noise-clipped", noisy="x + np.clip(self.rng.normal(0, std, 3), -std, std) + bias"),
    _filter("alpha-swapped", next="(1 - alpha) * x + alpha * y"),
    _filter("no-filtering", next="x"),
    _filter("zero-initial-state", start="alpha * x"),
    _filter("initial-value-ignored", initial="None"),
    _filter("gain-not-one", next="alpha * x + 0.8 * y"),
    _filter("alpha-ignored", next="0.1 * x + 0.9 * y"),
    _filter("axes-mixed", next="alpha * x + (1 - alpha) * np.mean(y)"),
    _filter("high-pass", output="x - self.value"),
    _filter("output-rounded", output="np.round(self.value, 1)"),
    _filter("output-stuck", next="y"),
    _filter("does-not-filter", start="0.5 * x", next="0.5 * x"),
)  # fmt: skip


def styles_of(fault: Fault) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield each style of a fault's part, with the submission in that style that has the fault."""
    for style, template in TEMPLATES[fault.part].items():
        yield style, lab(**{fault.part: _filled(template, fault.slots)})


def _filled(template: str, slots: Mapping[str, str]) -> str:
    contents = {**SOUND, **slots}
    return re.sub("<([a-z ]+)>", lambda slot: contents[slot[1]], template)
