"""Readers and recordings as people write them, marked by hand before anything judged them; no list of mistakes led the pen.

Each sample has one fault, or none. `takes` is what a fair marker takes at most, check by check; every other check of the
five criteria stays whole. Where a name is given, it is the only one that is true.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from tests.corpus.pieces import COLLECT_APPEND, COLLECT_LOOKUP, PLOT_LOOP, edit, lab, verbatim


@dataclass(frozen=True)
class Sample:
    """A submission that was marked by hand.

    Attributes
    ----------
    takes : check -> points that a fair marker takes at most; empty where the work is sound
    mistake : what the report has to call it; "" where no name is needed, and none is true but those in `also`
    part : the criterion that the fault is in
    reason : what the marker says where it does not go without saying
    """

    name: str
    part: str
    files: Mapping[str, str]
    takes: Mapping[str, float] = field(default_factory=dict)
    mistake: str = ""
    also: tuple[str, ...] = ()
    reason: str = ""


_DEF = "def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):\n"
_VALUES = """\
    a, g = model.sensor_adr[accel_sensor_id], model.sensor_adr[gyro_sensor_id]
    acc, gyr = data.sensordata[a:a + 3].copy(), data.sensordata[g:g + 3].copy()
"""


def _lines(body: str) -> str:
    return "".join(f"    {line}\n" if line else "\n" for line in body.strip("\n").split("\n"))


def _reader(body: str, before: str = "") -> dict[str, str]:
    """A reader with this body, after the right values were read into `acc` and `gyr`."""
    return lab(read=f"{before}\n\n{_DEF}{_VALUES}{_lines(body)}")


def _reader_whole(source: str, collect: str = COLLECT_LOOKUP) -> dict[str, str]:
    return lab(read=source, collect=collect)


def _collect(*changes: tuple[str, str], plot: str = PLOT_LOOP, before: str = "") -> dict[str, str]:
    return lab(collect=before + edit({"c": COLLECT_LOOKUP}, "c", *changes)["c"], plot=plot)


def _appending(*changes: tuple[str, str], before: str = "") -> dict[str, str]:
    return lab(collect=before + edit({"c": COLLECT_APPEND}, "c", *changes)["c"])


# A class that the recording shares with get_imu_readings; $ADDRESS is where a sensor is said to begin.
_CLASS = '''\
class Imu:
    """Accelerometer and gyroscope of one place."""

    def __init__(self, model, data, accel_id, gyro_id):
        self.model, self.data = model, data
        self.accel_at, self.gyro_at = (self._place(i) for i in (accel_id, gyro_id))
        self.last = None

    def _place(self, sensor):
        return $ADDRESS

    def read(self):
        accel = self.data.sensordata[self.accel_at:self.accel_at + 3].copy()
        gyro = self.data.sensordata[self.gyro_at:self.gyro_at + 3].copy()
        return $VALUES


def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    return Imu(model, data, accel_sensor_id, gyro_sensor_id).read()
'''
_COLLECT_CLASS = COLLECT_LOOKUP.replace(
    "    for i in range(n_steps):\n", "    imu = Imu(model, data, accel_id, gyro_id)\n    for i in range(n_steps):\n"
).replace("get_imu_readings(model, data, accel_id, gyro_id)", "imu.read()")


def _sharing(address: str = "self.model.sensor_adr[sensor]", values: str = "accel, gyro") -> dict[str, str]:
    source = _CLASS.replace("$ADDRESS", address).replace("$VALUES", values)
    return _reader_whole(source, _COLLECT_CLASS)


# ---------------------------------------------------------------- the reader

_VALUE = {"sensor_access.matches_truth": 6.0}
_PLACE = {"sensor_access.follows_address": 6.0}
_CALM = {"sensor_access.leaves_simulation_alone": 2.0}


def _wrong(name: str, files: Mapping[str, str], takes: Mapping[str, float], mistake: str = "", *also: str, reason: str = "") -> Sample:
    return Sample(name, next(iter(takes)).split(".")[0], files, takes, mistake, also, reason)


FAULTY_READERS = (
    _wrong("class-with-the-id-as-address", _sharing("sensor"), _PLACE, "sensor-id-as-address",
           reason="the recording uses the same class: its own part is right"),
    _wrong("class-one-place-late", _sharing("self.model.sensor_adr[sensor] + 1"), _PLACE, "off-by-one-address"),
    _wrong("class-that-takes-three-numbers-a-sensor", _sharing("3 * sensor"), _PLACE, "sensor-id-as-address"),
    _wrong("class-in-the-other-order", _sharing(values="gyro, accel"), _PLACE, "swapped-sensors"),
    _wrong("class-that-negates", _sharing(values="-accel, -gyro"), _VALUE, "sign-flipped"),
    _wrong("class-that-clips", _sharing(values="np.clip(accel, -8.0, 8.0), np.clip(gyro, -0.2, 0.2)"), _VALUE),
    _wrong("clipped-to-one-g-and-two-radians", _reader("return np.clip(acc, -9.81, 9.81), np.clip(gyr, -2.0, 2.0)"), _VALUE,
           reason="a range of the chip's that the sheet does not have"),
    _wrong("accelerometer-saturates", _reader("acc = np.minimum(np.maximum(acc, -5), 5)\nreturn acc, gyr"), _VALUE),
    _wrong("averaged-with-the-one-before", _reader(
        "global LAST\nnow = np.concatenate([acc, gyr])\nout = now if LAST is None else 0.5 * (LAST + now)\nLAST = now\nreturn out[:3], out[3:]",
        "LAST = None\n"), _VALUE),
    _wrong("mean-of-the-last-five", _reader(
        "WINDOW.append(np.concatenate([acc, gyr]))\nmean = np.mean(WINDOW, axis=0)\nreturn mean[:3], mean[3:]",
        "from collections import deque\n\nWINDOW = deque(maxlen=5)\n"), _VALUE),
    _wrong("smoothed-exponentially", _reader(
        "old = STATE.get('v')\nnew = np.hstack([acc, gyr])\nSTATE['v'] = new if old is None else 0.7 * new + 0.3 * old\n"
        "return STATE['v'][:3].copy(), STATE['v'][3:].copy()", "STATE = {}\n"), _VALUE),
    _wrong("first-reading-kept", _reader(
        "if not hasattr(get_imu_readings, 'kept'):\n    get_imu_readings.kept = (acc, gyr)\nreturn tuple(v.copy() for v in get_imu_readings.kept)"),
        {"sensor_access.matches_truth": 6.0, "sensor_access.follows_address": 6.0, "sensor_access.reading_is_a_copy": 3.0,
         "sensor_access.leaves_simulation_alone": 2.0},
        "cached-reading", reason="one reading for ever follows nothing: its form alone is left"),
    _wrong("read-anew-every-second-call", _reader(
        "MEMORY['n'] = MEMORY.get('n', 0) + 1\nif MEMORY['n'] % 2 or 'v' not in MEMORY:\n    MEMORY['v'] = acc, gyr\nreturn MEMORY['v'][0].copy(), MEMORY['v'][1].copy()",
        "MEMORY = {}\n"), _VALUE),
    _wrong("turned-by-the-bodys-matrix", _reader(
        "body = model.body('torso').id if 'torso' in [model.body(i).name for i in range(model.nbody)] else 1\n"
        "turn = data.xmat[body].reshape(3, 3)\nreturn turn @ acc, turn @ gyr"), _VALUE),
    _wrong("turned-into-the-body", _reader(
        "site = model.sensor_objid[accel_sensor_id]\nturn = data.xmat[model.site_bodyid[site]].reshape(3, 3).T\nreturn turn @ acc, turn @ gyr"),
        _VALUE),
    _wrong("turned-by-the-bodys-quaternion", _reader(
        "body = model.site_bodyid[model.sensor_objid[accel_sensor_id]]\nout = np.zeros((2, 3))\n"
        "mujoco.mju_rotVecQuat(out[0], acc, data.xquat[body])\nmujoco.mju_rotVecQuat(out[1], gyr, data.xquat[body])\nreturn out[0].copy(), out[1].copy()"),
        _VALUE),
    _wrong("accelerometer-turned-by-the-body", _reader(
        "body = model.site_bodyid[model.sensor_objid[accel_sensor_id]]\nreturn data.xmat[body].reshape(3, 3) @ acc, gyr"), _VALUE),
    _wrong("noise-added-while-reading", _reader("return acc + np.random.normal(0, 0.05, 3), gyr + np.random.normal(0, 0.005, 3)"), _VALUE),
    _wrong("noise-of-an-own-generator", _reader(
        "return acc + RNG.normal(0, 0.05, 3), gyr + RNG.normal(0, 0.005, 3)", "RNG = np.random.default_rng()\n"), _VALUE),
    _wrong("offset-drawn-once", _reader("return acc + OFFSET, gyr", "OFFSET = np.random.uniform(-0.2, 0.2, 3)\n"), _VALUE),
    _wrong("zeroed-at-the-first-call", _reader(
        "ZERO.setdefault('a', acc.copy())\nZERO.setdefault('g', gyr.copy())\nreturn acc - ZERO['a'], gyr - ZERO['g']", "ZERO = {}\n"), _VALUE, "", "gravity-removed"),
    _wrong("small-rates-are-nothing", _reader("gyr[np.abs(gyr) < 0.1] = 0.0\nreturn acc, gyr"), _VALUE),
    _wrong("counts-of-a-chip", _reader(
        "lsb_a, lsb_g = 9.81 / 2048, np.radians(1 / 16.4)\nreturn np.round(acc / lsb_a) * lsb_a, np.round(gyr / lsb_g) * lsb_g"), _VALUE, "", "precision-lost"),
    _wrong("gravity-always-up", _reader("if acc[2] < 0:\n    acc = -acc\nreturn acc, gyr"), _VALUE, "", "sign-flipped"),
    _wrong("east-north-up", _reader("return np.array([acc[1], acc[0], -acc[2]]), np.array([gyr[1], gyr[0], -gyr[2]])"), _VALUE, "", "axes-permuted", "sign-flipped"),
    _wrong("only-magnitudes", _reader("return np.sqrt(acc ** 2), np.sqrt(gyr ** 2)"), _VALUE, "", "sign-flipped"),
    _wrong("squared-by-mistake", _reader("return acc, gyr ** 2"), _VALUE),
    _wrong("forward-inside", _reader_whole(_DEF + "    mujoco.mj_forward(model, data)\n" + _VALUES + "    return acc, gyr\n"), _CALM, "disturbs-simulation",
           reason="the sensors then belong to another state than the step's, for whoever reads them next"),
    _wrong("reset-inside", _reader_whole(_DEF + "    mujoco.mj_resetData(model, data)\n    mujoco.mj_forward(model, data)\n" + _VALUES + "    return acc, gyr\n"),
           {**_VALUE, **_CALM}, "disturbs-simulation", reason="the numbers are of another state, and the run is gone"),
    _wrong("clock-moved-while-reading", _reader("data.time += model.opt.timestep\nreturn acc, gyr"), _CALM, "disturbs-simulation"),
    _wrong("places-remembered-by-id", _reader_whole(
        "import functools\n\nMODEL = []\n\n\n@functools.lru_cache(maxsize=None)\ndef place(sensor):\n    return int(MODEL[0].sensor_adr[sensor])\n\n\n" + _DEF
        + "    if not MODEL:\n        MODEL.append(model)\n    a, g = place(accel_sensor_id), place(gyro_sensor_id)\n"
        + "    return data.sensordata[a:a + 3].copy(), data.sensordata[g:g + 3].copy()\n"), _PLACE, "", "hard-coded-address", "sensor-id-as-address"),
)  # fmt: skip


# ---------------------------------------------------------------- the recording

_ROWS = {"data_collection.matches_truth": 6.0}
_SOME_ROWS = {"data_collection.matches_truth": 3.0}
_COUNT = {"data_collection.sample_count": 2.0}
_STAMPS = {"data_collection.time_axis": 3.0}
_RESET = {"data_collection.starts_from_reset": 3.0}
_PUSHED = {"data_collection.applies_push": 3.0}
_NAMES = {"data_collection.returns_named_arrays": 3.0}

_STORE = "        acceleration[i], angular_velocity[i] = get_imu_readings(model, data, accel_id, gyro_id)\n"
_PUSH, _STEP = "    data.qvel[0] = 0.5\n", "        mujoco.mj_step(model, data)\n"
_COUNTED = "int(round(duration_seconds / model.opt.timestep))"
_RETURN = '    return {"time": time, "acceleration": acceleration, "angular_velocity": angular_velocity}\n'
_KINDS = ("sign-flipped", "wrong-units", "precision-lost", "axes-permuted", "gravity-removed")
_RATE = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    """Sample like a real IMU does."""
    acc_id, gyr_id = model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id
    period = 1.0 / $HZ
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    log, next_sample = [], period
    while data.time < duration_seconds - 1e-9:
        mujoco.mj_step(model, data)
        if data.time >= next_sample - 1e-9:
            a, w = get_imu_readings(model, data, acc_id, gyr_id)
            log.append((data.time, a, w))
            next_sample += period
    t, a, w = zip(*log)
    return {"time": np.array(t), "acceleration": np.array(a), "angular_velocity": np.array(w)}
'''


def _altered(lines: str) -> dict[str, str]:
    """The rows, changed after the reader gave them."""
    return _collect((_STORE, _STORE + "".join(f"        {line}\n" for line in lines.split("\n"))))


def _late(steps: str, what: str = "data.qvel[0] = 0.5") -> dict[str, str]:
    return _collect((_PUSH, ""), (_STEP, f"        if {steps}:\n            {what}\n{_STEP}"))


_FAULTY_ROWS = (
    _wrong("rows-negated", _altered("acceleration[i] *= -1\nangular_velocity[i] *= -1"), _ROWS, "rows-altered", *_KINDS),
    _wrong("accelerations-negated", _altered("acceleration[i] = -acceleration[i]"), _ROWS, "rows-altered", *_KINDS),
    _wrong("rows-in-g-and-degrees", _altered("acceleration[i] /= 9.81\nangular_velocity[i] = np.degrees(angular_velocity[i])"), _ROWS, "rows-altered", *_KINDS),
    _wrong("rows-in-two-decimals", _collect((_RETURN, "    acceleration, angular_velocity = acceleration.round(2), angular_velocity.round(2)\n" + _RETURN)), _ROWS, "rows-altered", *_KINDS),
    _wrong("rows-of-integers", _collect(("    acceleration = np.empty((n_steps, 3))", "    acceleration = np.empty((n_steps, 3), dtype=int)"), ("angular_velocity = np.empty((n_steps, 3))", "angular_velocity = np.empty((n_steps, 3), dtype=int)")), _ROWS, "rows-altered", *_KINDS),
    _wrong("rows-scaled", _altered("acceleration[i] *= 0.9\nangular_velocity[i] *= 1.1"), _ROWS, "rows-altered", *_KINDS),
    _wrong("rows-without-gravity-in-degrees", _altered("acceleration[i, 2] += 9.81\nangular_velocity[i] *= 180 / np.pi"), _ROWS, "rows-altered", *_KINDS),
    _wrong("rows-smoothed-afterwards", _collect((_RETURN, "    for rows in (acceleration, angular_velocity):\n        for k in range(3):\n            rows[:, k] = np.convolve(rows[:, k], np.ones(9) / 9, mode='same')\n" + _RETURN)), _ROWS),
    _wrong("rows-with-noise", _altered("acceleration[i] += np.random.normal(0, 0.05, 3)\nangular_velocity[i] += np.random.normal(0, 0.005, 3)"), _ROWS),
    _wrong("rows-mixed-with-the-row-before", _altered("if i > 0:\n    acceleration[i] = 0.2 * acceleration[i] + 0.8 * acceleration[i - 1]"), _ROWS),
    _wrong("rows-with-axes-in-another-order", _altered("acceleration[i] = acceleration[i][[1, 0, 2]]\nangular_velocity[i] = angular_velocity[i][[1, 0, 2]]"), _ROWS, "rows-altered", *_KINDS),
    _wrong("rows-clipped", _collect((_RETURN, "    acceleration = np.clip(acceleration, -9.85, 9.85)\n    angular_velocity = np.clip(angular_velocity, -0.05, 0.05)\n" + _RETURN)), _ROWS),
    _wrong("one-reading-for-all-rows", _collect(
        ("    for i in range(n_steps):\n", "    mujoco.mj_forward(model, data)\n    acc, gyr = get_imu_readings(model, data, accel_id, gyro_id)\n    for i in range(n_steps):\n"),
        (_STORE, "        acceleration[i], angular_velocity[i] = acc, gyr\n")), _ROWS),
    _wrong("first-row-left-empty", _collect(
        ("for i in range(n_steps):", "for i in range(1, n_steps):"), ("time = np.empty(n_steps)", "time = np.zeros(n_steps)"),
        ("    acceleration = np.empty((n_steps, 3))", "    acceleration = np.zeros((n_steps, 3))"), ("angular_velocity = np.empty((n_steps, 3))", "angular_velocity = np.zeros((n_steps, 3))")),
        _SOME_ROWS, "first-row-empty", reason="one row of a thousand"),
    _wrong("first-row-empty-in-the-sheet", edit(verbatim(), "imu_reader.py", ("for i in range(n_steps):", "for i in range(1, n_steps):")), _SOME_ROWS, "first-row-empty", "rows-left-zero"),
    _wrong("push-drawn-at-random", _collect((_PUSH, "    data.qvel[0] = np.random.uniform(0.2, 0.8)\n")), _PUSHED, "random-push"),
    _wrong("push-and-a-random-jitter", _collect((_PUSH, "    data.qvel[0] = 0.5\n    data.qvel[:3] += np.random.normal(0, 0.02, 3)\n")), _PUSHED, "random-push"),
    _wrong("a-hundred-hertz", lab(collect=_RATE.replace("$HZ", "100")), _COUNT, "fixed-rate", reason="what is stored is right, and too seldom"),
    _wrong("fifty-hertz", lab(collect=_RATE.replace("$HZ", "50")), _COUNT, "fixed-rate"),
    _wrong("every-third-step", _appending(("        acc, gyro = get", "        if _ % 3:\n            continue\n        acc, gyro = get")), _COUNT, "samples-skipped"),
    _wrong("every-seventh-row-returned", _collect((_RETURN, '    return {"time": time[::7], "acceleration": acceleration[::7], "angular_velocity": angular_velocity[::7]}\n')), _COUNT, "samples-skipped"),
    _wrong("eight-steps-at-once", _collect((_COUNTED, "int(duration_seconds / model.opt.timestep) // 8"), ("mj_step(model, data)", "mj_step(model, data, nstep=8)")), _COUNT, "samples-skipped"),
    _wrong("frame-skip-of-25", _collect((_COUNTED, "int(duration_seconds / (25 * model.opt.timestep))"), (_STEP, "        for _ in range(25):\n    " + _STEP)), _COUNT, "samples-skipped"),
    _wrong("two-steps-a-row-twice-as-long", _collect((_STEP, _STEP + _STEP)), _ROWS, "samples-skipped"),
    _wrong("pushed-after-a-tenth-of-a-second", _late("abs(data.time - 0.1) < 1e-9"), _PUSHED, "wrong-perturbation", "no-perturbation"),
    _wrong("pushed-at-step-50", _late("i == 50", "data.qvel[0] += 0.5"), _PUSHED, "wrong-perturbation", "no-perturbation"),
    _wrong("pushed-for-the-first-fifty-steps", _late("i < 50"), _PUSHED, "wrong-perturbation"),
    _wrong("pushed-by-a-force-for-a-while", _collect((_PUSH, ""), (_STEP, "        data.xfrc_applied[1, 0] = 100.0 if i < 20 else 0.0\n" + _STEP)), _PUSHED, "wrong-perturbation", "no-perturbation"),
    _wrong("pushed-again-every-second", _collect((_STEP, "        if i % 500 == 0:\n            data.qvel[0] = 0.5\n" + _STEP)), _PUSHED, "wrong-perturbation"),
    _wrong("one-key-misspelled", _collect(('"angular_velocity": angular_velocity}', '"angular_velocty": angular_velocity}')), _NAMES, "wrong-keys",
           reason="the plot uses the sheet's names and is right"),
    _wrong("keys-in-the-plural", _collect((_RETURN, '    return {"times": time, "accelerations": acceleration, "angular_velocities": angular_velocity}\n')), _NAMES, "wrong-keys"),
    _wrong("three-long-rows", _collect(('"acceleration": acceleration, "angular_velocity": angular_velocity}', '"acceleration": acceleration.T, "angular_velocity": angular_velocity.T}')), _NAMES, "arrays-transposed",
           reason="the plot expects what the sheet says, and is right"),
    _wrong("append-without-an-axis", _collect(
        (_STORE, "        a, w = get_imu_readings(model, data, accel_id, gyro_id)\n        acceleration = np.append(acceleration, a)\n        angular_velocity = np.append(angular_velocity, w)\n"),
        ("    acceleration = np.empty((n_steps, 3))", "    acceleration = np.array([])"), ("angular_velocity = np.empty((n_steps, 3))", "angular_velocity = np.array([])")),
        _NAMES, "wrong-return-type", reason="all the numbers, in order, without their shape"),
    _wrong("a-dataclass-in-place-of-a-dictionary", lab(
        collect="from dataclasses import dataclass\n\n\n@dataclass\nclass Recording:\n    time: np.ndarray\n    acceleration: np.ndarray\n    angular_velocity: np.ndarray\n\n\n"
        + COLLECT_LOOKUP.replace(_RETURN, "    return Recording(time, acceleration, angular_velocity)\n"),
        plot=PLOT_LOOP.replace('imu_data["time"]', "imu_data.time").replace('imu_data["acceleration"]', "imu_data.acceleration").replace('imu_data["angular_velocity"]', "imu_data.angular_velocity")),
        _NAMES, "wrong-return-type"),
    _wrong("stamps-in-milliseconds", _appending(("times.append(data.time)", "times.append(1e3 * data.time)")), _STAMPS, "time-axis-wrong"),
    _wrong("stamps-by-linspace", _collect(('"time": time,', '"time": np.linspace(0.0, duration_seconds, n_steps),')), _STAMPS, "time-axis-wrong"),
    _wrong("stamps-in-one-place", _appending(("times.append(data.time)", "times.append(round(data.time, 1))")), _STAMPS, "time-axis-wrong"),
    _wrong("no-reset-of-velocities", _collect(("    mujoco.mj_resetData(model, data)\n", "    data.qpos[:] = model.qpos0\n    data.time = 0.0\n")), _RESET, "no-reset"),
    _wrong("negated-and-never-reset", _collect(("    mujoco.mj_resetData(model, data)\n", "    data.time = 0.0\n"), (_STORE, _STORE + "        acceleration[i] *= -1\n        angular_velocity[i] *= -1\n")),
           {**_ROWS, **_RESET}, "no-reset", "rows-altered", *_KINDS, reason="two faults, a check each"),
    _wrong("negated-and-pushed-the-other-way", _collect((_PUSH, "    data.qvel[0] = -0.5\n"), (_STORE, _STORE + "        acceleration[i] *= -1\n        angular_velocity[i] *= -1\n")),
           {**_ROWS, **_PUSHED}, "wrong-perturbation", "rows-altered", *_KINDS, reason="two faults, a check each"),
)  # fmt: skip
FAULTY_RECORDINGS = _FAULTY_ROWS


# ---------------------------------------------------------------- sound

_SOUND_READ = {
    "a-callable-object": "class Reader:\n    def __call__(self, model, data, accel_sensor_id, gyro_sensor_id):\n        return tuple(np.array(data.sensor(int(i)).data) for i in (accel_sensor_id, gyro_sensor_id))\n\n\nget_imu_readings = Reader()\n",
    "a-lambda": "get_imu_readings = lambda model, data, acc, gyr: [data.sensordata[model.sensor_adr[i]:][:3].tolist() for i in (acc, gyr)]\n",
    "a-named-tuple": "from collections import namedtuple\n\nReading = namedtuple('Reading', 'acceleration angular_velocity')\n\n\n" + _DEF + _VALUES + "    return Reading(acc, gyr)\n",
    "offsets-summed-up": _DEF + "    starts = [0]\n    for dim in model.sensor_dim:\n        starts.append(starts[-1] + int(dim))\n    return tuple(np.array(data.sensordata[starts[i]:starts[i + 1]]) for i in (accel_sensor_id, gyro_sensor_id))\n",
    "split-into-sensors": _DEF + "    parts = np.split(data.sensordata.copy(), np.cumsum(model.sensor_dim)[:-1])\n    return parts[accel_sensor_id], parts[gyro_sensor_id]\n",
    "single-precision": _DEF + _VALUES + "    return acc.astype(np.float32), gyr.astype(np.float32)\n",
    "remembered-within-a-step": "CACHE = {}\n\n\n" + _DEF + "    key = (id(model), data.time, data.sensordata.tobytes(), accel_sensor_id, gyro_sensor_id)\n    if key not in CACHE:\n        CACHE.clear()\n        CACHE[key] = tuple(data.sensor(i).data.copy() for i in (accel_sensor_id, gyro_sensor_id))\n    acc, gyr = CACHE[key]\n    return acc.copy(), gyr.copy()\n",
    "bytes-and-back": _DEF + _VALUES + "    return np.frombuffer(acc.tobytes()), np.frombuffer(gyr.tobytes())\n",
    "clipped-far-away": _DEF + _VALUES + "    return np.clip(acc, -16 * 9.81, 16 * 9.81), np.clip(gyr, -35, 35)\n",
}  # fmt: skip
_GROW = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    acc_id, gyr_id = model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id
    t, a, w = np.empty(0), np.empty((0, 3)), np.empty((0, 3))
    mujoco.mj_resetData(model, data)
    data.qvel[model.jnt_dofadr[0]] += 0.5
    while data.time < duration_seconds - model.opt.timestep / 2:
        mujoco.mj_step(model, data)
        acc, gyr = get_imu_readings(model, data, acc_id, gyr_id)
        t, a, w = np.append(t, data.time), np.append(a, [acc], axis=0), np.append(w, [gyr], axis=0)
    return {"time": t, "acceleration": a, "angular_velocity": w}
'''
_ROWS_OF = '''\
def rows_of(model, data, n):
    ids = [model.sensor(f"torso_{kind}").id for kind in ("accelerometer", "gyroscope")]
    for _ in range(n):
        mujoco.mj_step(model, data)
        yield (data.time, *np.concatenate(get_imu_readings(model, data, *ids)))


def simulate_and_collect(model, data, duration_seconds=5.0):
    mujoco.mj_resetData(model, data)
    data.qvel[:3] = 0.5, 0, 0
    table = np.fromiter((value for row in rows_of(model, data, round(duration_seconds / model.opt.timestep)) for value in row), float)
    table = table.reshape(-1, 7)
    return {"time": table[:, 0], "acceleration": table[:, 1:4], "angular_velocity": table[:, 4:]}
'''
_LISTS = COLLECT_APPEND.replace(
    "time=np.array(times), acceleration=np.array(accs), angular_velocity=np.array(gyros)",
    "time=times, acceleration=[list(map(float, a)) for a in accs], angular_velocity=[list(map(float, g)) for g in gyros]",
)
_AS_ARRAY = PLOT_LOOP.replace('    t = imu_data["time"]\n', '    imu_data = {key: np.asarray(value) for key, value in imu_data.items()}\n    t = imu_data["time"]\n')
_RECARRAY = COLLECT_LOOKUP.replace("    time = np.empty(n_steps)\n    acceleration = np.empty((n_steps, 3))\n    angular_velocity = np.empty((n_steps, 3))\n",
    "    log = np.zeros(n_steps, dtype=[('t', 'f8'), ('a', 'f8', 3), ('w', 'f8', 3)])\n    time, acceleration, angular_velocity = log['t'], log['a'], log['w']\n")  # fmt: skip
SOUND = (
    *(Sample(f"read-by-{name}", "sensor_access", _reader_whole(source)) for name, source in _SOUND_READ.items()),
    Sample("class-for-both", "sensor_access", _sharing()),
    Sample("recorded-by-np-append", "data_collection", lab(collect=_GROW)),
    Sample("recorded-by-a-generator", "data_collection", lab(collect=_ROWS_OF)),
    Sample("recorded-in-lists", "data_collection", lab(collect=_LISTS, plot=_AS_ARRAY)),
    Sample("recorded-in-a-structured-array", "data_collection", lab(collect=_RECARRAY)),
    Sample("recorded-in-single-precision", "data_collection", lab(collect=COLLECT_LOOKUP.replace("np.empty((n_steps, 3))", "np.empty((n_steps, 3), np.float32)").replace("np.empty(n_steps)", "np.empty(n_steps, dtype='f4')"))),
    Sample("stamps-from-the-count", "data_collection", lab(collect=COLLECT_LOOKUP.replace("time[i] = data.time", "time[i] = (i + 1) * model.opt.timestep"))),
    Sample("reset-by-hand", "data_collection", lab(collect=COLLECT_LOOKUP.replace("    mujoco.mj_resetData(model, data)\n", "    data.qpos[:] = model.qpos0\n    data.qvel[:] = 0\n    data.time = 0\n    data.qacc_warmstart[:] = 0\n    mujoco.mj_forward(model, data)\n"))),
)  # fmt: skip
FAULTY = (*FAULTY_READERS, *FAULTY_RECORDINGS)
