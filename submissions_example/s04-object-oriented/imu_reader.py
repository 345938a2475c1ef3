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
