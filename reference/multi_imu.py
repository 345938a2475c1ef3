"""Extension: every IMU that a model has, found by the names of its sensors."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Reading = tuple[FloatArray, ...]

MODEL_PATH = Path(__file__).resolve().parent / "models" / "humanoid-sensors.xml"
KINDS = ("_accelerometer", "_gyroscope")
COMPASS = "_magnetometer"


def places(model: mujoco.MjModel) -> list[str]:
    """Return the places that have an IMU, an accelerometer and a gyroscope, in the order of their accelerometers.

    A place is what stands before `_accelerometer` in a sensor's name, such as "torso".
    """
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, i) or "" for i in range(model.nsensor)]
    accelerometer, gyroscope = KINDS
    with_one = [name.removesuffix(accelerometer) for name in names if name.endswith(accelerometer)]
    return [place for place in with_one if place + gyroscope in names]


def read_all_imus(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, Reading]:
    """Read the IMU at every place that has one.

    Returns
    -------
    dict
        Place to a tuple of (3,) ndarrays of float64, each a copy in its site's own frame: acceleration in m/s², angular
        velocity in rad/s and, where the place has a magnetometer, the magnetic field in the model's unit.
    """
    return {place: _reading(model, data, place) for place in places(model)}


def _reading(model: mujoco.MjModel, data: mujoco.MjData, place: str) -> Reading:
    compass = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, place + COMPASS) >= 0
    return tuple(_sensor(model, data, place + kind) for kind in (*KINDS, *((COMPASS,) if compass else ())))


def _sensor(model: mujoco.MjModel, data: mujoco.MjData, name: str) -> FloatArray:
    sensor = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, name)
    start = model.sensor_adr[sensor]
    return np.array(data.sensordata[start : start + model.sensor_dim[sensor]])


def main() -> None:
    model = mujoco.MjModel.from_xml_path(str(MODEL_PATH))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    for place, (acceleration, angular_velocity, *_) in read_all_imus(model, data).items():
        print(f"{place:12} {acceleration.round(3)} m/s² {angular_velocity.round(4)} rad/s")


if __name__ == "__main__":
    main()
