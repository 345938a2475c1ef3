"""Faults as people make them in programs of their own, each with the one check that a careful marker takes, and how much at most.

They were written, and decided, before the code that judges them was mended. Several follow habits of public code: windows that throw
away the wrong end, biases that are subtracted, recorders that keep to a frame rate, sensors at the place where a robot of one's
own has them.
"""

from __future__ import annotations

from dataclasses import dataclass

from tests.corpus.pieces import COLLECT_APPEND, COLLECT_LOOKUP, FILTER_INCREMENT, NOISE_GENERATOR, READ_NAMED, edit, lab

VALUES, PLACE = "sensor_access.matches_truth", "sensor_access.follows_address"
ROWS, COUNT, TIME = "data_collection.matches_truth", "data_collection.sample_count", "data_collection.time_axis"
RESET, PUSH = "data_collection.starts_from_reset", "data_collection.applies_push"
SIZE, GIVEN, DEFAULT, LAW = (
    f"noise_model.{name}" for name in ("noise_size", "given_bias", "default_bias", "white_and_gaussian")
)
RECURSION, START, OWN = (
    f"filtering.{name}" for name in ("follows_recursion", "starts_from_first_measurement", "instances_independent")
)


@dataclass(frozen=True)
class Habit:
    """A submission with one fault: `check` is lost and nothing else, with `most` points; `names` are those that are true of it."""

    name: str
    check: str
    most: float
    files: dict[str, str]
    names: tuple[str, ...] = ()


def _reader(name: str, check: str, most: float, body: str, names: tuple[str, ...] = ()) -> Habit:
    return Habit(name, check, most, lab(read=edit({"r": READ_NAMED}, "r", (_READ, body))["r"]), names)


def _collector(name: str, check: str, most: float, changes: list[tuple[str, str]], names: tuple[str, ...] = ()) -> Habit:
    return Habit(name, check, most, lab(collect=edit({"c": COLLECT_APPEND}, "c", *changes)["c"]), names)


def _rows(name: str, check: str, most: float, changes: list[tuple[str, str]], names: tuple[str, ...] = ()) -> Habit:
    return Habit(name, check, most, lab(collect=edit({"c": COLLECT_LOOKUP}, "c", *changes)["c"]), names)


def _noise(name: str, check: str, most: float, changes: list[tuple[str, str]], names: tuple[str, ...] = ()) -> Habit:
    return Habit(name, check, most, lab(noise=edit({"n": NOISE_GENERATOR}, "n", *changes)["n"]), names)


def _filter(name: str, check: str, most: float, changes: list[tuple[str, str]], names: tuple[str, ...] = ()) -> Habit:
    return Habit(name, check, most, lab(low_pass=edit({"f": FILTER_INCREMENT}, "f", *changes)["f"]), names)


_READ = "    return data.sensor(accel_sensor_id).data.copy(), data.sensor(gyro_sensor_id).data.copy()\n"
_BOTH = "    a, g = data.sensor(accel_sensor_id).data.copy(), data.sensor(gyro_sensor_id).data.copy()\n"
_STEP = "        mujoco.mj_step(model, data)\n"
_LOOP = "    for _ in range(int(np.ceil(duration_seconds / model.opt.timestep - 1e-9))):\n"
_PUSH = "    data.qvel[0] = 0.5\n"
_LOOKUP_PUSH = "    data.qvel[0] = 0.5\n\n"
_RECORD = "        acceleration[i], angular_velocity[i] = get_imu_readings(model, data, accel_id, gyro_id)\n"
_A, _G = "accel + self.accel_bias", "gyro + self.gyro_bias"
_DRAW_A, _DRAW_G = "self.rng.normal(0.0, self.accel_noise_std, size=3)", "self.rng.normal(0.0, self.gyro_noise_std, size=3)"
_KEPT = "        self.gyro_bias = np.asarray(gyro_bias, dtype=float)\n"
_NOISY = "        return accel, gyro\n"
_UPDATE = "            self.state = self.state + self.alpha * (x - self.state)\n"
_OUT = "        return self.state.copy()\n"
_INIT = "        self.alpha = alpha\n"

READERS = (
    _reader("saturates-at-two-g", VALUES, 6, _BOTH + "    return np.clip(a, -19.6, 19.6), g\n"),
    _reader("dead-band", VALUES, 6, _BOTH + "    return np.where(np.abs(a) < 0.5, 0.0, a), g\n"),
    _reader("calibrated-by-two-percent", VALUES, 6, _BOTH + "    return 1.02 * a, 1.02 * g\n"),
    _reader("bias-of-a-data-sheet-taken-off", VALUES, 6, _BOTH + "    return a - np.array([0.02, -0.01, 0.05]), g\n"),
    _reader("least-significant-bits", VALUES, 6, _BOTH + "    lsb = 9.81 / 2048\n    return np.round(a / lsb) * lsb, g\n", ("precision-lost",)),
    _reader("turned-to-nose-up", VALUES, 6, _BOTH + "    return np.array([a[2], a[1], -a[0]]), np.array([g[2], g[1], -g[0]])\n", ("axes-permuted", "sign-flipped")),
    _reader("first-sensors-of-the-robot", PLACE, 6, "    return data.sensordata[0:3].copy(), data.sensordata[3:6].copy()\n", ("hard-coded-address", "sensor-id-as-address", "off-by-one-address")),
    _reader("magnitude-beside-the-vector-lost", VALUES, 6, _BOTH + "    return a / np.linalg.norm(a), g\n"),
)  # fmt: skip

COLLECTORS = (
    _collector("keeps-to-sixty-frames", COUNT, 2, [(_LOOP, "    for k in range(int(duration_seconds * 60)):\n"), (_STEP, "        while data.time < (k + 1) / 60:\n            mujoco.mj_step(model, data)\n")], ("samples-skipped", "fixed-rate")),
    _rows("a-hundred-steps-to-warm-up", ROWS, 6, [(_LOOKUP_PUSH, _LOOKUP_PUSH + "    for _ in range(100):\n        mujoco.mj_step(model, data)\n")]),
    _rows("pushed-after-a-second", PUSH, 3, [(_LOOKUP_PUSH, "\n"), ("        time[i] = data.time\n", "        if i == 500:\n            data.qvel[0] = 0.5\n        time[i] = data.time\n")], ("wrong-perturbation", "no-perturbation")),
    _rows("smoothed-while-it-is-stored", ROWS, 6, [(_RECORD, _RECORD + "        if i:\n            acceleration[i] = 0.5 * acceleration[i] + 0.5 * acceleration[i - 1]\n")], ("rows-altered",)),
    _rows("gravity-put-back", ROWS, 6, [("    return {", "    acceleration[:, 2] += 9.81\n    return {")], ("rows-altered",)),
    _rows("negated-on-the-way-out", ROWS, 6, [("    return {", "    acceleration, angular_velocity = -acceleration, -angular_velocity\n    return {")], ("rows-altered",)),
    _rows("milliseconds", TIME, 3, [("time[i] = data.time", "time[i] = 1000 * data.time")], ("time-axis-wrong",)),
    _rows("spikes-thrown-out", ROWS, 6, [("    return {", "    acceleration = np.clip(acceleration, np.percentile(acceleration, 5, axis=0), np.percentile(acceleration, 95, axis=0))\n    return {")], ("rows-altered",)),
    _rows("centred-on-zero", ROWS, 6, [("    return {", "    acceleration = acceleration - acceleration.mean(axis=0)\n    return {")], ("rows-altered",)),
)  # fmt: skip

NOISES = (
    _noise("bias-subtracted", GIVEN, 4, [(_A, "accel - self.accel_bias"), (_G, "gyro - self.gyro_bias")], ("bias-sign-flipped",)),
    _noise("bias-forgotten-after-one-read", GIVEN, 4, [(_NOISY, "        self.accel_bias, self.gyro_bias = np.zeros(3), np.zeros(3)\n        return accel, gyro\n")], ("no-bias", "bias-drifts")),
    _noise("quantised-like-a-converter", LAW, 3, [(_NOISY, "        return np.round(accel / 0.01) * 0.01, np.round(gyro / 0.001) * 0.001\n")], ("precision-lost",)),
    _noise("flat-between-plus-and-minus", LAW, 3, [(_DRAW_A, "self.rng.uniform(-1, 1, 3) * self.accel_noise_std"), (_DRAW_G, "self.rng.uniform(-1, 1, 3) * self.gyro_noise_std")], ("not-gaussian",)),
    _noise("flat-of-half-the-width", LAW, 3, [(_DRAW_A, "(self.rng.random(3) - 0.5) * self.accel_noise_std"), (_DRAW_G, "(self.rng.random(3) - 0.5) * self.gyro_noise_std")], ("not-gaussian",)),
    _noise("one-number-for-the-bias-of-all", DEFAULT, 3, [("accel_bias = self.rng.normal(0.0, 0.1, size=3)", "accel_bias = np.full(3, self.rng.normal(0.0, 0.1))"), ("gyro_bias = self.rng.normal(0.0, 0.01, size=3)", "gyro_bias = np.full(3, self.rng.normal(0.0, 0.01))")], ("bias-shared",)),
    _noise("the-same-bias-in-every-robot", DEFAULT, 3, [("accel_bias = self.rng.normal(0.0, 0.1, size=3)", "accel_bias = np.full(3, 0.01)"), ("gyro_bias = self.rng.normal(0.0, 0.01, size=3)", "gyro_bias = np.full(3, 0.01)")], ("bias-not-random", "bias-shared")),
    _noise("tenth-of-the-bias", GIVEN, 4, [(_A, "accel + 0.1 * self.accel_bias"), (_G, "gyro + 0.1 * self.gyro_bias")]),
    _noise("noise-in-the-bias-alone", DEFAULT, 3, [(_A, "accel + self.accel_bias * (1 + 0.1 * self.rng.standard_normal(3))"), (_G, "gyro + self.gyro_bias * (1 + 0.1 * self.rng.standard_normal(3))")], ("bias-redrawn", "bias-drifts")),
)  # fmt: skip

FILTERS = (
    _filter("negated-output", RECURSION, 6, [(_OUT, "        return -self.state\n")], ("gain-not-one",)),
    _filter("constant-added-to-the-output", RECURSION, 6, [(_OUT, "        return self.state + 0.3\n")]),
    _filter("doubled-output", RECURSION, 6, [(_OUT, "        return 2 * self.state\n")], ("gain-not-one",)),
    _filter("median-over-the-axes", RECURSION, 6, [(_OUT, "        return np.full(3, np.median(self.state))\n")], ("axes-mixed",)),
    _filter("noise-of-its-own", RECURSION, 6, [(_OUT, "        return self.state + np.random.normal(0, 0.02, 3)\n")]),
    _filter("alpha-of-a-sample-rate", RECURSION, 6, [(_INIT, "        self.alpha = 1 - np.exp(-2 * np.pi * 5.0 / 500.0)\n")], ("alpha-ignored",)),
    _filter("window-without-an-axis", RECURSION, 6, [(_INIT, "        self.alpha, self.last = alpha, []\n"), (_OUT, "        self.last = (self.last + [x])[-10:]\n        return np.full(3, np.mean(self.last))\n")], ("axes-mixed", "moving-average")),
    _filter("limited-slope", RECURSION, 6, [(_UPDATE, "            self.state = self.state + np.clip(self.alpha * (x - self.state), -0.01, 0.01)\n")], ("other-low-pass",)),
    _filter("believes-half-a-metre-at-most", RECURSION, 6, [(_UPDATE, "            self.state = self.state + self.alpha * np.clip(x - self.state, -0.5, 0.5)\n")], ("other-low-pass",)),
    _filter("predicts-one-ahead", RECURSION, 6, [(_UPDATE, "            last = self.state\n            self.state = self.state + self.alpha * (x - self.state)\n            return 2 * self.state - last\n")], ("other-low-pass",)),
    _filter("alpha-of-half-at-least", RECURSION, 6, [(_INIT, "        self.alpha = max(alpha, 0.5)\n")], ("alpha-ignored",)),
    _filter("starts-again-after-fifty", RECURSION, 6, [(_INIT, "        self.alpha, self.n = alpha, 0\n"), (_UPDATE, _UPDATE + "        self.n += 1\n        if self.n % 50 == 0:\n            self.state = x\n")], ("filter-restarts",)),
)  # fmt: skip

HABITS = (*READERS, *COLLECTORS, *NOISES, *FILTERS)
