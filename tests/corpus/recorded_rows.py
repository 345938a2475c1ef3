"""What a student can record at home: the public lab model, pushed, at several time steps; and the public readings."""

from __future__ import annotations

import io
from functools import cache

import mujoco
import numpy as np

from grader.labs.imu import bundles
from reference import worlds

_TIMESTEPS = (0.001, 0.00125, 0.002, 0.0025, 0.004)
_SECONDS = 2.5
_EVERY = 5  # a search through every state that is known would take all of the time


@cache
def rows() -> bytes:
    """What a student can record at home: the public lab model, pushed, at several time steps; and the public readings."""
    model = mujoco.MjModel.from_xml_string(worlds.lab())
    reading = bundles.shipped()["reading_lab"]
    kept: dict[str, np.ndarray] = {
        "timesteps": np.array(_TIMESTEPS),
        "lab": np.array(worlds.lab()),
        "read_states": np.hstack([reading["qpos"], 0.1 * reading["qvel"]]),
        "read_sensors": reading["sensordata"],
    }
    for timestep in _TIMESTEPS:
        kept |= _pushed(model, timestep)
    stream = io.BytesIO()
    np.savez_compressed(stream, **kept)
    return stream.getvalue()


def _pushed(model: mujoco.MjModel, timestep: float) -> dict[str, np.ndarray]:
    model.opt.timestep = timestep
    data = mujoco.MjData(model)
    data.qvel[0] = 0.5
    series, states = [], []
    for _ in range(round(_SECONDS / timestep)):
        mujoco.mj_step(model, data)
        series.append(np.array(data.sensordata))
        states.append(np.concatenate([data.qpos, 0.1 * data.qvel]))
    all_sensors = np.array(series)
    both = {f"accel_{timestep:g}": all_sensors[:, 5:8], f"gyro_{timestep:g}": all_sensors[:, 11:14]}
    return both | ({"states": np.array(states[::_EVERY])} if timestep == 0.002 else {})
