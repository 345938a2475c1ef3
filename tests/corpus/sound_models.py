"""Sound ways to write the noise model and the filter."""



from __future__ import annotations

# ---------------------------------------------------------------- noise

NOISE_SCIPY = '''\
from scipy import stats


class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005,
                 accel_bias=None, gyro_bias=None):
        self._source = lambda: get_imu_readings(model, data, accel_id, gyro_id)
        self._noise = [stats.norm(0, accel_noise_std), stats.norm(0, gyro_noise_std)]
        defaults = (stats.uniform(-0.1, 0.2).rvs(3), stats.uniform(-0.01, 0.02).rvs(3))
        self.accel_bias, self.gyro_bias = (d if b is None else np.array(b) for b, d in zip((accel_bias, gyro_bias), defaults))

    def read(self):
        biases = self.accel_bias, self.gyro_bias
        accel, gyro = (x + b + n.rvs(size=3) for x, b, n in zip(self._source(), biases, self._noise))
        return accel, gyro
'''

NOISE_STANDARD_NORMAL = '''\
class NoisyIMU(object):
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005,
                 accel_bias=None, gyro_bias=None, seed=None):
        self.args = (model, data, accel_id, gyro_id)
        self.std = np.repeat([accel_noise_std, gyro_noise_std], 3)
        self.generator = np.random.Generator(np.random.PCG64(seed))
        drawn = self.generator.uniform(-1, 1, 6) * np.repeat([0.1, 0.01], 3)
        self.bias = drawn.copy()
        if accel_bias is not None:
            self.bias[:3] = accel_bias
        if gyro_bias is not None:
            self.bias[3:] = gyro_bias

    def read(self):
        clean = np.concatenate(get_imu_readings(*self.args))
        noisy = clean + self.bias + self.std * self.generator.standard_normal(6)
        return noisy[:3], noisy[3:]
'''

NOISE_RANDOM_MODULE = '''\
import random


class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005,
                 accel_bias=None, gyro_bias=None):
        self.model, self.data, self.accel_id, self.gyro_id = model, data, accel_id, gyro_id
        self.accel_noise_std, self.gyro_noise_std = accel_noise_std, gyro_noise_std
        self.accel_bias = accel_bias if accel_bias is not None else [random.gauss(0, 0.1) for _ in range(3)]
        self.gyro_bias = gyro_bias if gyro_bias is not None else [random.gauss(0, 0.01) for _ in range(3)]

    @staticmethod
    def _disturb(values, std, bias):
        return np.array([v + random.gauss(0, std) + b for v, b in zip(values, bias)])

    def read(self):
        accel, gyro = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)
        return (self._disturb(accel, self.accel_noise_std, self.accel_bias),
                self._disturb(gyro, self.gyro_noise_std, self.gyro_bias))
'''

NOISE_BLOCKS = '''\
class NoisyIMU:
    """Draws its noise a thousand readings at a time: one call of the generator instead of many."""

    BLOCK = 1000

    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005,
                 accel_bias=None, gyro_bias=None):
        self.model, self.data, self.accel_id, self.gyro_id = model, data, accel_id, gyro_id
        self._cov = np.diag([accel_noise_std ** 2] * 3 + [gyro_noise_std ** 2] * 3)
        self._rng = np.random.RandomState()
        self.accel_bias = self._rng.normal(scale=0.1, size=3) if accel_bias is None else np.array(accel_bias, float)
        self.gyro_bias = self._rng.normal(scale=0.01, size=3) if gyro_bias is None else np.array(gyro_bias, float)
        self._stock = iter(())

    def _noise(self):
        try:
            return next(self._stock)
        except StopIteration:
            self._stock = iter(self._rng.multivariate_normal(np.zeros(6), self._cov, self.BLOCK))
            return next(self._stock)

    def read(self):
        accel, gyro = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)
        noise = self._noise()
        return accel + self.accel_bias + noise[:3], gyro + self.gyro_bias + noise[3:]
'''

# The bias is the mean of the normal law, and it is drawn when it is first needed.
NOISE_LAZY_BIAS = '''\
class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005,
                 accel_bias=None, gyro_bias=None):
        self.model = model
        self.data = data
        self.ids = accel_id, gyro_id
        self.accel_noise_std = accel_noise_std
        self.gyro_noise_std = gyro_noise_std
        self._accel_bias = accel_bias
        self._gyro_bias = gyro_bias

    @property
    def accel_bias(self):
        if self._accel_bias is None:
            self._accel_bias = np.random.laplace(0, 0.05, 3)
        return self._accel_bias

    @property
    def gyro_bias(self):
        if self._gyro_bias is None:
            self._gyro_bias = np.random.triangular(-0.02, 0, 0.02, 3)
        return self._gyro_bias

    def read(self):
        accel, gyro = get_imu_readings(self.model, self.data, *self.ids)
        return (np.random.normal(accel + self.accel_bias, self.accel_noise_std),
                np.random.normal(gyro + self.gyro_bias, self.gyro_noise_std))
'''

# ---------------------------------------------------------------- filters

FILTER_LFILTER = '''\
from scipy.signal import lfilter


class LowPassFilter:
    """b = [alpha], a = [1, alpha - 1]; zi carries the state over."""

    def __init__(self, alpha=0.1, initial_value=None):
        self.b, self.a = [alpha], [1.0, alpha - 1.0]
        self.zi = None if initial_value is None else np.atleast_2d((1 - alpha) * np.asarray(initial_value, float))

    def update(self, measurement):
        x = np.atleast_2d(np.asarray(measurement, float))
        if self.zi is None:
            self.zi = -self.a[1] * x
        y, self.zi = lfilter(self.b, self.a, x, axis=0, zi=self.zi)
        return y[0].reshape(np.shape(measurement))
'''

FILTER_DATACLASS = '''\
from dataclasses import dataclass, field
from typing import Optional


@dataclass
class LowPassFilter:
    alpha: float = 0.1
    initial_value: Optional[np.ndarray] = None
    _previous: Optional[np.ndarray] = field(default=None, init=False, repr=False)

    def __post_init__(self):
        if not 0.0 < self.alpha <= 1.0:
            raise ValueError("alpha must be in (0, 1]")
        if self.initial_value is not None:
            self._previous = np.array(self.initial_value, dtype=float)

    def update(self, measurement):
        if self._previous is None:
            self._previous = np.array(measurement, dtype=float)
        self._previous = self.alpha * np.asarray(measurement) + (1 - self.alpha) * self._previous
        return np.array(self._previous)
'''

FILTER_CLOSURE = '''\
def exponential_average(alpha, y=None):
    """A function that remembers its last output."""
    def step(x):
        nonlocal y
        y = +x if y is None else alpha * x + (1 - alpha) * y
        return +y        # unary plus makes a new array
    return step


class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.update = exponential_average(alpha, initial_value)

    def __call__(self, measurement):
        return self.update(measurement)
'''

FILTER_HISTORY = '''\
class LowPassFilter:
    """Keeps everything that it has put out; the last entry is y[n-1]."""

    def __init__(self, alpha=0.1, initial_value=None):
        self.alpha = float(np.clip(alpha, 0.0, 1.0))
        self.history = [] if initial_value is None else [np.array(initial_value, float)]

    def update(self, measurement):
        before = self.history[-1] if self.history else measurement
        self.history.append(np.average([measurement, before], axis=0, weights=[self.alpha, 1 - self.alpha]))
        return self.history[-1].copy()
'''

FILTER_COROUTINE = '''\
class LowPassFilter:
    """A coroutine does the work: send a sample in, get the average out."""

    def __init__(self, alpha=0.1, initial_value=None):
        self._loop = self._run(alpha, initial_value)
        next(self._loop)

    @staticmethod
    def _run(alpha, y):
        x = yield
        if y is None:
            y = x.copy()
            x = yield y.copy()
        while True:
            y = y * (1 - alpha) + x * alpha
            x = yield y.copy()

    def update(self, measurement):
        return self._loop.send(measurement)
'''

# One number at a time, one small filter an axis, plain lists out.
FILTER_PER_AXIS = '''\
class _Axis:
    def __init__(self, alpha, start):
        self.alpha = alpha
        self.y = start

    def __call__(self, x):
        self.y = x if self.y is None else self.y + self.alpha * (x - self.y)
        return self.y


class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.axes = [_Axis(alpha, None if initial_value is None else initial_value[k]) for k in range(3)]

    def update(self, measurement):
        return [axis(x) for axis, x in zip(self.axes, measurement)]
'''
