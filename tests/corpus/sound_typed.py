"""A sound submission of somebody who has worked in industry."""

from __future__ import annotations

# Typed, with protocols and abstract classes: a student who has worked in industry.
TYPED = {
    "imu_reader.py": '''\
"""IMU access for lab 04-01."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, NamedTuple, Protocol, TypedDict

import matplotlib.pyplot as plt
import mujoco
import numpy as np
import numpy.typing as npt

Vector = npt.NDArray[np.float64]
MODEL: Final = Path("textbook") / "assets" / "robot-models" / "mujoco" / "humanoid-sensors.xml"


class Reading(NamedTuple):
    """What one look at the IMU gives."""

    acceleration: Vector
    angular_velocity: Vector


class ImuData(TypedDict):
    time: Vector
    acceleration: Vector
    angular_velocity: Vector


class Imu(Protocol):
    def read(self) -> Reading: ...


@dataclass(frozen=True)
class MujocoImu:
    """A real accelerometer and gyroscope of a model."""

    model: mujoco.MjModel
    data: mujoco.MjData
    accel_id: int
    gyro_id: int
    _slices: tuple[slice, slice] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        starts = (int(self.model.sensor_adr[i]) for i in (self.accel_id, self.gyro_id))
        object.__setattr__(self, "_slices", tuple(slice(start, start + 3) for start in starts))

    @classmethod
    def torso(cls, model: mujoco.MjModel, data: mujoco.MjData) -> MujocoImu:
        return cls(model, data, model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id)

    def read(self) -> Reading:
        return Reading(*(self.data.sensordata[part].copy() for part in self._slices))


def get_imu_readings(model: mujoco.MjModel, data: mujoco.MjData, accel_sensor_id: int, gyro_sensor_id: int) -> Reading:
    """Read both sensors once."""
    return MujocoImu(model, data, accel_sensor_id, gyro_sensor_id).read()


def simulate_and_collect(model: mujoco.MjModel, data: mujoco.MjData, duration_seconds: float = 5.0) -> ImuData:
    """Simulate after a push and record every step."""
    imu: Imu = MujocoImu.torso(model, data)
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    recorder = Recorder(round(duration_seconds / model.opt.timestep))
    while not recorder.full:
        mujoco.mj_step(model, data)
        recorder.add(data.time, imu.read())
    return recorder.result()


class Recorder:
    def __init__(self, capacity: int) -> None:
        self._table = np.empty((capacity, 7))
        self._count = 0

    @property
    def full(self) -> bool:
        return self._count == len(self._table)

    def add(self, time: float, reading: Reading) -> None:
        self._table[self._count] = np.hstack((time, *reading))
        self._count += 1

    def result(self) -> ImuData:
        time, acceleration, angular_velocity = np.split(self._table, (1, 4), axis=1)
        return {"time": time.ravel(), "acceleration": acceleration, "angular_velocity": angular_velocity}


def plot_imu_data(imu_data: ImuData) -> None:
    """Both sensors, one panel each."""
    figure, panels = plt.subplots(2, sharex=True, figsize=(10, 7), layout="tight")
    for panel, key, unit in zip(panels, ("acceleration", "angular_velocity"), ("m/s²", "rad/s")):
        name = key.replace("_", " ")
        for axis, curve in zip("xyz", imu_data[key].T):  # type: ignore[literal-required]
            panel.plot(imu_data["time"], curve, label=axis)
        panel.set(title=name.capitalize(), ylabel=f"{name} / {unit}")
        panel.legend(title="axis")
    panels[-1].set_xlabel("time / s")
    figure.savefig("imu_data.png")


def main() -> None:
    model = mujoco.MjModel.from_xml_path(MODEL.as_posix())
    plot_imu_data(simulate_and_collect(model, mujoco.MjData(model), 3.0))


if __name__ == "__main__":
    main()
''',
    "noisy_imu.py": '''\
from __future__ import annotations

import mujoco
import numpy as np

from imu_reader import MujocoImu, Reading, Vector


class SensorError:
    """A constant offset and white noise."""

    def __init__(self, std: float, bias: Vector | None, bias_std: float, rng: np.random.Generator) -> None:
        self._std = std
        self._rng = rng
        self.bias = rng.normal(0.0, bias_std, 3) if bias is None else np.asarray(bias, dtype=np.float64).copy()

    def __call__(self, clean: Vector) -> Vector:
        return clean + self.bias + self._rng.normal(scale=self._std, size=clean.shape)


class NoisyIMU:
    """An IMU as it comes out of a box."""

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        accel_id: int,
        gyro_id: int,
        accel_noise_std: float = 0.05,
        gyro_noise_std: float = 0.005,
        accel_bias: Vector | None = None,
        gyro_bias: Vector | None = None,
        *,
        seed: int | None = None,
    ) -> None:
        rng = np.random.default_rng(seed)
        self._imu = MujocoImu(model, data, accel_id, gyro_id)
        self._errors = (
            SensorError(accel_noise_std, accel_bias, 0.1, rng),
            SensorError(gyro_noise_std, gyro_bias, 0.01, rng),
        )

    def read(self) -> Reading:
        return Reading(*(error(clean) for error, clean in zip(self._errors, self._imu.read())))
''',
    "filters.py": '''\
from __future__ import annotations

from abc import ABC, abstractmethod

import matplotlib.pyplot as plt
import mujoco
import numpy as np

from imu_reader import MODEL, Vector
from noisy_imu import NoisyIMU


class Filter(ABC):
    @abstractmethod
    def update(self, measurement: Vector) -> Vector:
        """Take one sample in, give one out."""

    def __call__(self, samples: Vector) -> Vector:
        return np.array([self.update(sample) for sample in samples])


class LowPassFilter(Filter):
    """y[n] = alpha x[n] + (1 - alpha) y[n-1]"""

    def __init__(self, alpha: float = 0.1, initial_value: Vector | None = None) -> None:
        self._alpha = alpha
        self._y = None if initial_value is None else np.array(initial_value, dtype=np.float64)

    @property
    def alpha(self) -> float:
        return self._alpha

    def reset(self) -> None:
        self._y = None

    def update(self, measurement: Vector) -> Vector:
        y = measurement if self._y is None else self._alpha * measurement + (1 - self._alpha) * self._y
        self._y = np.array(y)
        return self._y.copy()


def main() -> None:
    model = mujoco.MjModel.from_xml_path(MODEL.as_posix())
    data = mujoco.MjData(model)
    imu = NoisyIMU(model, data, model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id, seed=1)
    raw = np.empty((500, 3))
    for row in raw:
        mujoco.mj_step(model, data)
        row[:] = imu.read().acceleration
    smooth = LowPassFilter(0.1)(raw)
    figure, panel = plt.subplots(figsize=(10, 4))
    panel.plot(raw[:, 2], label="raw", linewidth=0.7)
    panel.plot(smooth[:, 2], label="filtered")
    panel.set(title="z acceleration", xlabel="sample", ylabel="acceleration / (m/s²)")
    panel.legend()
    figure.savefig("filtered_imu.png")


if __name__ == "__main__":
    main()
''',
}
