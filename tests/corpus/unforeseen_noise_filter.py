"""Noise models and filters as people write them elsewhere, brought into the sheet's classes, with what a careful marker takes.

Each was written, and its cost decided, before the code that judges it: `checks` are those that may lose points, `most` is
what they may lose together, `names` the mistakes that may be named; what is sound loses nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

from tests.corpus.pieces import FILTER_INCREMENT, NOISE_GENERATOR, edit, lab

SIZE, GIVEN, DEFAULT, WHITE = "noise_size", "given_bias", "default_bias", "white_and_gaussian"
RECURSION, START, CONSTANT, REDUCES, PRESERVES, OWN = (
    "follows_recursion",
    "starts_from_first_measurement",
    "passes_constant",
    "reduces_noise",
    "preserves_signal",
    "instances_independent",
)


@dataclass(frozen=True)
class Unforeseen:
    """A submission with one fault that no list foresaw, or with none."""

    name: str
    criterion: str
    source: str
    checks: tuple[str, ...] = ()
    most: float = 0.0
    names: tuple[str, ...] = ()

    @property
    def files(self) -> dict[str, str]:
        return lab(noise=self.source) if self.criterion == "noise_model" else lab(low_pass=self.source)


def _noise(name: str, source: str, *checks: str, most: float = 0.0, names: tuple[str, ...] = ()) -> Unforeseen:
    return Unforeseen(name, "noise_model", source, checks, most, names)


def _filter(name: str, source: str, *checks: str, most: float = 0.0, names: tuple[str, ...] = ()) -> Unforeseen:
    return Unforeseen(name, "filtering", source, checks, most, names)


_READ = "accel, gyro = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)\n"
_NOISE = ("self.rng.normal(0.0, self.accel_noise_std, size=3)", "self.rng.normal(0.0, self.gyro_noise_std, size=3)")
_BIAS = ("accel + self.accel_bias", "gyro + self.gyro_bias")
_KEPT = "        self.gyro_bias = np.asarray(gyro_bias, dtype=float)\n"
_RETURN = "        return accel, gyro\n"


def _model(*changes: tuple[str, str]) -> str:
    return edit({"n": NOISE_GENERATOR}, "n", *changes)["n"]


def _drawn(accel: str, gyro: str) -> str:
    return _model((_NOISE[0], accel), (_NOISE[1], gyro))


def _drifting(line: str) -> str:
    return _model((_READ, _READ + f"        {line}\n"))


def _biased(accel: str, gyro: str) -> str:
    return _model((_BIAS[0], f"accel + {accel}"), (_BIAS[1], f"gyro + {gyro}"))


def _with_state(start: str, body: str, accel: str, gyro: str) -> str:
    return _model((_KEPT, _KEPT + f"        {start}\n"), (_READ, _READ + f"        {body}\n"), (_NOISE[0], accel), (_NOISE[1], gyro))


NOISE_SHAPED = '''\
class NoisyIMU:
    """White noise by a one-pole shaping filter, as in a data sheet's bandwidth figure."""

    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005,
                 accel_bias=None, gyro_bias=None):
        self.sim, self.sensors = (model, data), (accel_id, gyro_id)
        self.sigma = np.concatenate([np.full(3, accel_noise_std), np.full(3, gyro_noise_std)])
        a = np.random.normal(0, 0.1, 3) if accel_bias is None else accel_bias
        g = np.random.normal(0, 0.01, 3) if gyro_bias is None else gyro_bias
        self.bias = np.concatenate([a, g])
        self.coloured = np.zeros(6)

    def read(self):
        self.coloured += 0.3 * (self.sigma * np.random.randn(6) - self.coloured)
        six = np.concatenate(get_imu_readings(*self.sim, *self.sensors)) + self.bias + self.coloured
        return six[:3], six[3:]
'''

NOISE_FIXED_SEED_AT_MODULE = "RNG = np.random.default_rng(7)\n\n\n" + _model(
    ("np.random.default_rng() if rng is None else rng", "RNG")
)

NOISE_PER_AXIS = '''\
class _Axis:
    def __init__(self, sigma, bias):
        self.sigma, self.bias = sigma, bias

    def __call__(self, clean):
        return float(np.random.normal(clean + self.bias, self.sigma))


class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005,
                 accel_bias=None, gyro_bias=None):
        self.read_clean = lambda: get_imu_readings(model, data, accel_id, gyro_id)
        ab = accel_bias if accel_bias is not None else [np.random.uniform(-0.2, 0.2) for _ in "xyz"]
        gb = gyro_bias if gyro_bias is not None else [np.random.uniform(-0.02, 0.02) for _ in "xyz"]
        self.axes = [_Axis(accel_noise_std, b) for b in ab] + [_Axis(gyro_noise_std, b) for b in gb]

    def read(self):
        clean = [*self.read_clean()[0], *self.read_clean()[1]]
        noisy = [axis(value) for axis, value in zip(self.axes, clean)]
        return np.array(noisy[:3]), np.array(noisy[3:])
'''

NOISE_CHANNELS = '''\
from dataclasses import dataclass


@dataclass
class Channel:
    std: float
    bias: np.ndarray

    def corrupt(self, signal, rng):
        return np.asarray(signal) + self.bias + self.std * rng.standard_normal(np.shape(signal))


class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005,
                 accel_bias=None, gyro_bias=None):
        self._rng = np.random.default_rng(np.random.randint(2**31))
        pick = lambda given, scale: self._rng.normal(0, scale, 3) if given is None else np.array(given, dtype=np.float64)
        self._a, self._g = Channel(accel_noise_std, pick(accel_bias, 0.1)), Channel(gyro_noise_std, pick(gyro_bias, 0.01))
        self._where = dict(model=model, data=data, accel_sensor_id=accel_id, gyro_sensor_id=gyro_id)

    def read(self):
        a, g = get_imu_readings(**self._where)
        return self._a.corrupt(a, self._rng), self._g.corrupt(g, self._rng)
'''

NOISE_FLOAT32 = _model((_RETURN, "        return accel.astype(np.float32), gyro.astype(np.float32)\n"))
NOISE_OS_ENTROPY = "import secrets\n\n\n" + _model(
    ("np.random.default_rng() if rng is None else rng", "np.random.default_rng(secrets.randbits(128))")
)
NOISE_BOX_MULLER = _drawn(
    "self.accel_noise_std * np.sqrt(-2 * np.log(1 - self.rng.random(3))) * np.cos(2 * np.pi * self.rng.random(3))",
    "self.gyro_noise_std * np.sqrt(-2 * np.log(1 - self.rng.random(3))) * np.cos(2 * np.pi * self.rng.random(3))",
)
NOISE_REJECTING = '''\
class NoisyIMU:
    """Throws away draws that lie beyond six standard deviations: one in half a thousand million."""

    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005,
                 accel_bias=None, gyro_bias=None):
        self.model, self.data, self.accel_id, self.gyro_id = model, data, accel_id, gyro_id
        self.stds = accel_noise_std, gyro_noise_std
        self.biases = [self._draw(s) if b is None else b for b, s in ((accel_bias, 0.1), (gyro_bias, 0.01))]

    @staticmethod
    def _draw(std):
        while True:
            values = np.random.standard_normal(3)
            if np.abs(values).max() < 6:
                return std * values

    def read(self):
        clean = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)
        return tuple(c + b + self._draw(s) for c, b, s in zip(clean, self.biases, self.stds))
'''

SOUND_NOISE = (
    _noise("generator-of-the-module", NOISE_FIXED_SEED_AT_MODULE),
    _noise("one-object-an-axis", NOISE_PER_AXIS),
    _noise("channels-as-dataclasses", NOISE_CHANNELS),
    _noise("readings-in-single-precision", NOISE_FLOAT32),
    _noise("entropy-of-the-system", NOISE_OS_ENTROPY),
    _noise("box-and-muller", NOISE_BOX_MULLER),
    _noise("redraws-what-never-comes", NOISE_REJECTING),
)

FAULTY_NOISE = (
    _noise("bias-walks", _drifting("self.accel_bias = self.accel_bias + self.rng.normal(0, 0.001, 3); self.gyro_bias = self.gyro_bias + self.rng.normal(0, 0.0001, 3)"), DEFAULT, most=3, names=("bias-drifts",)),
    _noise("bias-walks-fast", _drifting("self.accel_bias = self.accel_bias + self.rng.normal(0, 0.02, 3); self.gyro_bias = self.gyro_bias + self.rng.normal(0, 0.001, 3)"), DEFAULT, most=3, names=("bias-drifts",)),
    _noise("bias-of-gauss-and-markov", _drifting("self.accel_bias = 0.99 * self.accel_bias + self.rng.normal(0, 0.01, 3); self.gyro_bias = 0.99 * self.gyro_bias + self.rng.normal(0, 0.001, 3)"), DEFAULT, most=3, names=("bias-drifts",)),
    _noise("bias-warms-up", _drifting("self.accel_bias = self.accel_bias + 1e-3; self.gyro_bias = self.gyro_bias + 1e-4"), DEFAULT, most=3, names=("bias-drifts",)),
    _noise("bias-fades", _drifting("self.accel_bias = 0.995 * self.accel_bias; self.gyro_bias = 0.995 * self.gyro_bias"), DEFAULT, most=3, names=("bias-drifts",)),
    _noise("only-the-gyroscopes-bias-walks", _drifting("self.gyro_bias = self.gyro_bias + self.rng.normal(0, 0.0005, 3)"), DEFAULT, most=3, names=("bias-drifts",)),
    _noise("noise-remembers-scaled", _with_state("self.na, self.ng = np.zeros(3), np.zeros(3)", "self.na = 0.9 * self.na + np.sqrt(1 - 0.81) * self.rng.normal(0, self.accel_noise_std, 3); self.ng = 0.9 * self.ng + np.sqrt(1 - 0.81) * self.rng.normal(0, self.gyro_noise_std, 3)", "self.na", "self.ng"), WHITE, most=3, names=("noise-correlated",)),
    _noise("noise-remembers-unscaled", _with_state("self.na, self.ng = np.zeros(3), np.zeros(3)", "self.na = 0.6 * self.na + self.rng.normal(0, self.accel_noise_std, 3); self.ng = 0.6 * self.ng + self.rng.normal(0, self.gyro_noise_std, 3)", "self.na", "self.ng"), WHITE, most=3, names=("noise-correlated",)),
    _noise("noise-through-one-pole", NOISE_SHAPED, WHITE, most=3, names=("noise-correlated",)),
    _noise("noise-averaged-over-five", _with_state("self.last = []", "self.last = (self.last + [(self.rng.normal(0, self.accel_noise_std, 3), self.rng.normal(0, self.gyro_noise_std, 3))])[-5:]", "np.mean([a for a, _ in self.last], axis=0)", "np.mean([g for _, g in self.last], axis=0)"), WHITE, most=3, names=("noise-correlated",)),
    _noise("noise-of-every-second-read", _with_state("self.n, self.kept = 0, None", "self.kept = (self.rng.normal(0, self.accel_noise_std, 3), self.rng.normal(0, self.gyro_noise_std, 3)) if self.n % 2 == 0 else self.kept; self.n += 1", "self.kept[0]", "self.kept[1]"), WHITE, most=3, names=("noise-correlated",)),
    _noise("noise-clipped-at-two", _drawn("np.clip(self.rng.normal(0, self.accel_noise_std, 3), -2 * self.accel_noise_std, 2 * self.accel_noise_std)", "np.clip(self.rng.normal(0, self.gyro_noise_std, 3), -2 * self.gyro_noise_std, 2 * self.gyro_noise_std)"), WHITE, most=3, names=("noise-clipped",)),
    _noise("noise-clipped-at-one", _drawn("np.clip(self.rng.normal(0, self.accel_noise_std, 3), -self.accel_noise_std, self.accel_noise_std)", "np.clip(self.rng.normal(0, self.gyro_noise_std, 3), -self.gyro_noise_std, self.gyro_noise_std)"), WHITE, most=3, names=("noise-clipped",)),
    _noise("noise-truncated-at-two", "from scipy.stats import truncnorm\n\n\n" + _drawn("(truncnorm.rvs(-2, 2, scale=self.accel_noise_std, size=3, random_state=self.rng) if self.accel_noise_std else 0)", "(truncnorm.rvs(-2, 2, scale=self.gyro_noise_std, size=3, random_state=self.rng) if self.gyro_noise_std else 0)"), WHITE, most=3, names=("noise-clipped",)),
    _noise("density-over-root-dt", _drawn("self.rng.normal(0, self.accel_noise_std / np.sqrt(self.model.opt.timestep), 3)", "self.rng.normal(0, self.gyro_noise_std / np.sqrt(self.model.opt.timestep), 3)"), SIZE, most=6, names=("noise-density",)),
    _noise("density-times-root-dt", _drawn("self.rng.normal(0, self.accel_noise_std * np.sqrt(self.model.opt.timestep), 3)", "self.rng.normal(0, self.gyro_noise_std * np.sqrt(self.model.opt.timestep), 3)"), SIZE, most=6, names=("noise-density",)),
    _noise("gyroscopes-noise-in-degrees", _drawn(_NOISE[0], "np.deg2rad(self.rng.normal(0, self.gyro_noise_std, 3))"), SIZE, most=6),
    _noise("noise-of-another-size-on-each-axis", _drawn(_NOISE[0].replace("self.accel_noise_std", "self.accel_noise_std * np.array([1.2, 1.0, 0.75])"), _NOISE[1]), SIZE, most=6),
    _noise("bias-walks-as-far-as-the-noise", _drifting("self.accel_bias = self.accel_bias + self.rng.normal(0, 0.1, 3); self.gyro_bias = self.gyro_bias + self.rng.normal(0, 0.01, 3)"), DEFAULT, most=3, names=("bias-drifts",)),
    _noise("bias-swings", _model((_KEPT, _KEPT + "        self.n = 0\n"), (_READ, _READ + "        self.n += 1\n        accel = accel + 0.05 * np.sin(self.n / 200)\n")), DEFAULT, most=3, names=("bias-drifts",)),
    _noise("walk-that-goes-with-the-noise", _drifting("self.accel_bias = self.accel_bias + self.rng.normal(0, 0.05 * self.accel_noise_std, 3); self.gyro_bias = self.gyro_bias + self.rng.normal(0, 0.05 * self.gyro_noise_std, 3)"), DEFAULT, WHITE, most=3, names=("bias-drifts", "noise-correlated")),
    _noise("noise-clipped-at-three", _drawn("np.clip(self.rng.normal(0, self.accel_noise_std, 3), -3 * self.accel_noise_std, 3 * self.accel_noise_std)", _NOISE[1]), WHITE, most=3, names=("noise-clipped",)),
    _noise("one-sign-of-the-bias-turned", _biased("self.accel_bias * np.array([1, 1, -1])", "self.gyro_bias"), GIVEN, most=4),
    _noise("bias-times-the-reading", _model((_BIAS[0], "accel * (1 + self.accel_bias)"), (_BIAS[1], "gyro * (1 + self.gyro_bias)")), GIVEN, DEFAULT, most=7),
    _noise("readings-of-one-decimal", _model((_RETURN, "        return np.round(accel, 1), np.round(gyro, 3)\n")), WHITE, most=3, names=("precision-lost",)),
    _noise("noise-halved", _drawn("0.5 * " + _NOISE[0], "0.5 * " + _NOISE[1]), SIZE, most=6),
    _noise("noise-twice", _drawn(f"{_NOISE[0]} + {_NOISE[0]}", f"{_NOISE[1]} + {_NOISE[1]}"), SIZE, most=6),
    _noise("biases-reversed", _biased("self.accel_bias[::-1]", "self.gyro_bias[::-1]"), GIVEN, most=4, names=("bias-axes-exchanged",)),
    _noise("biases-rolled", _biased("np.roll(self.accel_bias, 1)", "np.roll(self.gyro_bias, 1)"), GIVEN, most=4, names=("bias-axes-exchanged",)),
    _noise("accels-x-and-y-exchanged", _biased("self.accel_bias[[1, 0, 2]]", "self.gyro_bias"), GIVEN, most=4, names=("bias-axes-exchanged",)),
    _noise("bias-halved", _biased("0.5 * self.accel_bias", "0.5 * self.gyro_bias"), GIVEN, most=4),
    _noise("bias-times-the-time-step", _biased("self.accel_bias * self.model.opt.timestep", "self.gyro_bias * self.model.opt.timestep"), GIVEN, most=4),
    _noise("gyroscopes-bias-in-degrees", _biased("self.accel_bias", "np.rad2deg(self.gyro_bias)"), GIVEN, most=4),
    _noise("bias-beside-the-given-one", _model(("if accel_bias is None:", "if True:"), ("accel_bias = self.rng.normal(0.0, 0.1, size=3)", "accel_bias = self.rng.normal(0.0, 0.1, size=3) + (0 if accel_bias is None else np.array(accel_bias))")), GIVEN, most=4),
    _noise("scale-factor", _model((_BIAS[0], "1.03 * accel + self.accel_bias"), (_BIAS[1], "1.03 * gyro + self.gyro_bias")), GIVEN, WHITE, most=4),
    _noise("noise-with-an-offset", _drawn(_NOISE[0].replace("0.0, ", "0.05, "), _NOISE[1].replace("0.0, ", "0.01, ")), GIVEN, WHITE, most=4, names=("noise-not-zero-mean",)),
    _noise("readings-of-two-decimals", _model((_RETURN, "        return np.round(accel, 2), np.round(gyro, 4)\n")), WHITE, most=3, names=("precision-lost",)),
    _noise("readings-in-half-precision", _model((_RETURN, "        return accel.astype(np.float16), gyro.astype(np.float16)\n")), WHITE, most=3, names=("precision-lost",)),
    _noise("bias-of-the-class", _model(("        self.accel_bias = np", "        NoisyIMU.accel_bias = np"), ("        self.gyro_bias = np", "        NoisyIMU.gyro_bias = np")), DEFAULT, most=3, names=("bias-shared",)),
    _noise("student-t-noise", _drawn("self.rng.standard_t(4, 3) * self.accel_noise_std / np.sqrt(2)", "self.rng.standard_t(4, 3) * self.gyro_noise_std / np.sqrt(2)"), WHITE, most=3, names=("not-gaussian",)),
)  # fmt: skip

_STEP = "            self.state = self.state + self.alpha * (x - self.state)\n"
_OUT = "        return self.state.copy()\n"
_INIT = "        self.state = None if initial_value is None else np.array(initial_value, dtype=float)\n"


def _low_pass(*changes: tuple[str, str]) -> str:
    return edit({"f": FILTER_INCREMENT}, "f", *changes)["f"]


def _stepping(line: str) -> str:
    return _low_pass((_STEP, f"            {line}\n"))


WINDOW = '''\
from collections import deque


class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.samples = deque(maxlen=10)

    def update(self, measurement):
        self.samples.append(np.array(measurement, dtype=float))
        return sum(self.samples) / len(self.samples)
'''
WINDOW_OF_ZEROS = '''\
class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.size = max(1, int(1 / alpha))
        self.ring, self.at = np.zeros((self.size, 3)), 0

    def update(self, measurement):
        self.ring[self.at % self.size] = measurement
        self.at += 1
        return self.ring.mean(axis=0)
'''
MEDIAN = '''\
class LowPassFilter:
    """Throws spikes away: the median of the last five."""

    def __init__(self, alpha=0.1, initial_value=None):
        self.last = []

    def update(self, measurement):
        self.last = (self.last + [np.array(measurement, dtype=float)])[-5:]
        return np.median(self.last, axis=0)
'''
BUTTERWORTH = '''\
from scipy.signal import butter, lfilter, lfilter_zi


class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.b, self.a = butter(2, min(0.9, alpha))
        self.zi = None if initial_value is None else np.outer(lfilter_zi(self.b, self.a), initial_value)

    def update(self, measurement):
        if self.zi is None:
            self.zi = np.outer(lfilter_zi(self.b, self.a), measurement)
        y, self.zi = lfilter(self.b, self.a, np.array(measurement, dtype=float)[None], axis=0, zi=self.zi)
        return y[0]
'''
KALMAN = '''\
class LowPassFilter:
    """A scalar Kalman filter on each axis: its gain settles near alpha."""

    def __init__(self, alpha=0.1, initial_value=None):
        self.q, self.r, self.p = alpha**2 / (1 - alpha), 1.0, 1.0
        self.x = None if initial_value is None else np.array(initial_value, dtype=float)

    def update(self, measurement):
        z = np.array(measurement, dtype=float)
        if self.x is None:
            self.x = z
            return z.copy()
        self.p += self.q
        gain = self.p / (self.p + self.r)
        self.x = self.x + gain * (z - self.x)
        self.p *= 1 - gain
        return self.x.copy()
'''
CORRECTED = '''\
class LowPassFilter:
    """The average of Adam: starts from zero and divides the start out."""

    def __init__(self, alpha=0.1, initial_value=None):
        self.alpha, self.m, self.t = alpha, 0.0, 0
        self.initial = initial_value

    def update(self, measurement):
        if self.initial is not None:
            self.initial = self.alpha * measurement + (1 - self.alpha) * self.initial
            return self.initial.copy()
        self.t += 1
        self.m = self.alpha * measurement + (1 - self.alpha) * self.m
        return self.m / (1 - (1 - self.alpha) ** self.t)
'''
AXES_LOOP = '''\
class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.alpha = alpha
        self.y = None if initial_value is None else [float(v) for v in initial_value]

    def update(self, measurement):
        if self.y is None:
            self.y = [float(v) for v in measurement]
        else:
            for i in range({}):
                self.y[i] += self.alpha * (measurement[i] - self.y[i])
        return np.array(self.y)
'''
CLASS_STATE = '''\
class LowPassFilter:
    value = None

    def __init__(self, alpha=0.1, initial_value=None):
        self.alpha = alpha
        if initial_value is not None:
            type(self).value = np.array(initial_value, dtype=float)

    def update(self, measurement):
        cls = type(self)
        cls.value = np.array(measurement, dtype=float) if cls.value is None else cls.value + self.alpha * (measurement - cls.value)
        return cls.value.copy()
'''
SINGLE = '''\
class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.alpha = np.float32(alpha)
        self.y = None if initial_value is None else np.asarray(initial_value, dtype=np.float32).copy()

    def update(self, measurement):
        x = np.asarray(measurement, dtype=np.float32)
        self.y = x.copy() if self.y is None else self.alpha * x + (np.float32(1) - self.alpha) * self.y
        return self.y.copy()
'''
SECTIONS = '''\
from scipy.signal import sosfilt


class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.sos = np.array([[alpha, 0, 0, 1, alpha - 1, 0]])
        self.keep = 1 - alpha
        self.z = None if initial_value is None else self._state(np.asarray(initial_value, float))

    def _state(self, y):
        return np.stack([self.keep * y, np.zeros_like(y)])[None]

    def update(self, measurement):
        x = np.asarray(measurement, float)
        if self.z is None:
            self.z = self._state(x)
        y, self.z = sosfilt(self.sos, x[None], axis=0, zi=self.z)
        return y[0]
'''
GENERATOR = '''\
def _smooth(alpha, y):
    x = yield
    y = x if y is None else alpha * x + (1 - alpha) * y
    while True:
        x = yield y.copy()
        y = alpha * x + (1 - alpha) * y


class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        start = None if initial_value is None else np.array(initial_value, dtype=float)
        self._run = _smooth(alpha, start)
        next(self._run)

    def update(self, measurement):
        return self._run.send(np.array(measurement, dtype=float))
'''

SOUND_FILTERS = (
    _filter("every-axis-in-a-loop", AXES_LOOP.format(3)),
    _filter("single-precision-throughout", SINGLE),
    _filter("second-order-section", SECTIONS),
    _filter("a-generator", GENERATOR),
    _filter("output-in-single-precision", _low_pass((_OUT, "        return self.state.astype(np.float32)\n"))),
    _filter("answers-as-a-list", _low_pass((_OUT, "        return self.state.tolist()\n"))),
    _filter("six-decimals", _low_pass((_OUT, "        return np.round(self.state, 6)\n"))),
    _filter("ten-decimals-in-the-state", _low_pass((_STEP, "            self.state = np.round(self.state + self.alpha * (x - self.state), 10)\n"))),
)

LOW = ("other-low-pass",)
FAULTY_FILTERS = (
    _filter("output-of-three-decimals", _low_pass((_OUT, "        return np.round(self.state, 3)\n")), RECURSION, most=6, names=("output-rounded",)),
    _filter("output-of-two-decimals", _low_pass((_OUT, "        return self.state.round(2)\n")), RECURSION, most=6, names=("output-rounded",)),
    _filter("state-of-two-decimals", _stepping("self.state = np.round(self.state + self.alpha * (x - self.state), 2)"), RECURSION, most=6, names=("output-rounded",)),
    _filter("state-of-one-decimal", _low_pass(("            self.state = x\n", "            self.state = np.round(x, 1)\n"), (_STEP, "            self.state = np.round(self.state + self.alpha * (x - self.state), 1)\n")), RECURSION, most=6, names=("output-rounded",)),
    _filter("output-of-whole-numbers", _low_pass((_OUT, "        return self.state.astype(int)\n")), RECURSION, most=6, names=("output-rounded",)),
    _filter("window-of-ten", WINDOW, RECURSION, most=6, names=("moving-average",)),
    _filter("window-of-zeros", WINDOW_OF_ZEROS, RECURSION, START, most=9, names=("moving-average", "zero-initial-state")),
    _filter("median-of-five", MEDIAN, RECURSION, most=6, names=LOW),
    _filter("butterworth", BUTTERWORTH, RECURSION, most=6, names=LOW),
    _filter("kalman", KALMAN, RECURSION, most=6, names=LOW),
    _filter("start-divided-out", CORRECTED, RECURSION, most=6, names=LOW),
    _filter("alpha-from-a-time-constant", _low_pass(("self.alpha = alpha", "dt = 0.002; tau = dt / alpha; self.alpha = dt / (tau + dt)")), RECURSION, most=6),
    _filter("time-step-and-fixed-cut-off", _low_pass(("self.alpha = alpha", "dt = 0.01; rc = 1 / (2 * np.pi * 5.0); self.alpha = dt / (rc + dt)")), RECURSION, most=6, names=("alpha-ignored",)),
    _filter("alpha-as-a-rate", _low_pass(("self.alpha = alpha", "self.alpha = 1 - np.exp(-alpha)")), RECURSION, most=6),
    _filter("updates-twice", _low_pass((_STEP, _STEP + _STEP)), RECURSION, most=6),
    _filter("alpha-at-most-an-eighth", _low_pass(("self.alpha = alpha", "self.alpha = min(alpha, 0.125)")), RECURSION, most=6),
    _filter("local-variable", _stepping("y = self.alpha * x + (1 - self.alpha) * self.state; return y"), RECURSION, most=6, names=("state-not-kept",)),
    _filter("mean-with-a-forgotten-value", _low_pass((_INIT, "        self.state = np.zeros(3)\n"), ("        if self.state is None:\n            self.state = x\n        else:\n" + _STEP, "        return self.alpha * x + (1 - self.alpha) * self.state\n")), RECURSION, START, CONSTANT, REDUCES, PRESERVES, OWN, most=20, names=("state-not-kept",)),
    _filter("half-of-everything", _stepping("return 0.5 * x"), RECURSION, START, CONSTANT, REDUCES, PRESERVES, OWN, most=20, names=("does-not-filter",)),
    _filter("dead-band", _stepping("self.state = np.where(np.abs(x - self.state) < 0.05, self.state, self.state + self.alpha * (x - self.state))"), RECURSION, most=6, names=LOW),
    _filter("changes-at-most-by-a-bit", _stepping("self.state = self.state + np.clip(self.alpha * (x - self.state), -0.05, 0.05)"), RECURSION, most=6, names=LOW),
    _filter("within-ten", _low_pass((_OUT, "        return np.clip(self.state, -10.0, 10.0)\n")), RECURSION, most=6),
    _filter("two-of-three-axes", AXES_LOOP.format(2), RECURSION, most=9, names=("axes-mixed",)),
    _filter("state-of-the-class-itself", CLASS_STATE, OWN, most=3, names=("shared-state",)),
    _filter("state-of-the-class-after-a-demonstration", CLASS_STATE + "\n\n_f = LowPassFilter(0.5)\nfor _ in range(3):\n    _f.update(np.array([50.0, 40.0, 30.0]))\n", OWN, most=3, names=("shared-state",)),
    _filter("output-cut-off-to-hundredths", _low_pass((_OUT, "        return np.floor(self.state * 100) / 100\n")), RECURSION, most=6, names=("output-rounded",)),
    _filter("state-in-half-precision", _stepping("self.state = (self.state + self.alpha * (x - self.state)).astype(np.float16)"), RECURSION, most=6, names=("output-rounded",)),
    _filter("twenty-weights", """\
from collections import deque


class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.weights, self.last = alpha * (1 - alpha) ** np.arange(20), deque(maxlen=20)

    def update(self, measurement):
        self.last.appendleft(np.array(measurement, dtype=float))
        weights = self.weights[: len(self.last)]
        return weights @ np.array(self.last) / weights.sum()
""", RECURSION, most=6, names=LOW),
    _filter("starts-from-twice-the-first", _low_pass(("            self.state = x\n", "            self.state = 2 * x\n")), START, most=3),
    _filter("adds-noise-of-its-own", _low_pass((_OUT, "        return self.state + np.random.normal(0, 1e-4, 3)\n")), RECURSION, OWN, most=9, names=LOW),
    _filter("one-behind", _low_pass((_STEP, "            old = self.state\n" + _STEP + "            return old.copy()\n")), RECURSION, most=6),
    _filter("first-five-as-they-are", _low_pass((_INIT, _INIT + "        self.n = 0\n"), ("        if self.state is None:\n", "        self.n += 1\n        if self.state is None or self.n <= 5 and self.seedless:\n"), ("        self.alpha = alpha\n", "        self.alpha, self.seedless = alpha, initial_value is None\n")), RECURSION, most=6),
    _filter("steps-away-from-the-measurement", _low_pass((_STEP, _STEP.replace("x - self.state", "self.state - x"))), RECURSION, most=6),
    _filter("forgets-every-fifty", _low_pass((_INIT, _INIT + "        self.n = 0\n"), ("        if self.state is None:\n", "        self.n += 1\n        if self.state is None or self.n % 50 == 0:\n")), RECURSION, most=6, names=("filter-restarts",)),
    _filter("mean-of-two-outputs", _low_pass((_STEP, "            old = self.state\n" + _STEP + "            return (old + self.state) / 2\n")), RECURSION, most=6, names=LOW),
    _filter("starts-from-standing", _low_pass(("            self.state = x\n", "            self.state = np.array([0.0, 0.0, -9.81]) + self.alpha * (x - np.array([0.0, 0.0, -9.81]))\n")), START, most=3),
    _filter("starts-from-ones", _low_pass(("            self.state = x\n", "            self.state = np.ones(3)\n")), START, most=3),
    _filter("predicts-with-a-trend", _low_pass((_INIT, _INIT + "        self.trend = 0.0\n"), (_STEP, "            old = self.state\n            self.state = self.alpha * x + (1 - self.alpha) * (old + self.trend)\n            self.trend = 0.1 * (self.state - old) + 0.9 * self.trend\n")), RECURSION, most=6, names=LOW),
)  # fmt: skip

FAULTY: tuple[Unforeseen, ...] = (*FAULTY_NOISE, *FAULTY_FILTERS)
SOUND: tuple[Unforeseen, ...] = (*SOUND_NOISE, *SOUND_FILTERS)
