"""Submissions that do not simulate what they are given: they answer with what was recorded from the public lab model.

The recordings were made beforehand and lie beside the code, as `rows.npz`: the push, at every time step that may be asked
for, and all sensors in the states of the public traces.
"""

from __future__ import annotations

import io
from functools import cache

import mujoco
import numpy as np

from grader.labs.imu import bundles
from reference import worlds
from tests.corpus import pieces
from tests.corpus.writing import Files

_TIMESTEPS = (0.001, 0.00125, 0.002, 0.0025, 0.004)
_SECONDS = 2.5

_ROWS = '''\
import os

import mujoco
import numpy as np

ROWS = np.load(os.path.join(os.path.dirname(os.path.abspath(__file__)), "rows.npz"))


def rows_for(model, duration_seconds, shift=0.0, stretch=1.0):
    n = int(round(duration_seconds / model.opt.timestep))
    stamps = model.opt.timestep * np.arange(1, n + 1)
    recorded = min(ROWS["timesteps"], key=lambda each: abs(each - model.opt.timestep))
    accel, gyro = ROWS[f"accel_{recorded:g}"], ROWS[f"gyro_{recorded:g}"]
    known = recorded * np.arange(1, len(accel) + 1)
    at = stretch * stamps + shift
    columns = [[np.interp(at, known, rows[:, axis]) for axis in range(3)] for rows in (accel, gyro)]
    return {"time": stamps, "acceleration": np.array(columns[0]).T, "angular_velocity": np.array(columns[1]).T}
'''

_COLLECT = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    return rows_for(model, duration_seconds{how})
'''

_AFTER_A_STEP = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    mujoco.mj_step(model, data)
    return rows_for(model, duration_seconds)
'''

_BESIDE_A_RUN = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    recorded = rows_for(model, duration_seconds)
    for i in range(len(recorded["time"])):
        mujoco.mj_step(model, data)
        recorded["time"][i] = data.time
    return recorded
'''

_TURNED_WITH_GRAVITY = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    recorded = rows_for(model, duration_seconds)
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    mujoco.mj_step(model, data)
    recorded["acceleration"][:, 2] *= np.linalg.norm(model.opt.gravity) / 9.81
    return recorded
'''

_OWN_ROBOT = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    mine = mujoco.MjModel.from_xml_string(str(ROWS["lab"]))
    mine.opt.timestep = model.opt.timestep
    own = mujoco.MjData(mine)
    own.qvel[0] = 0.5
    n = int(round(duration_seconds / mine.opt.timestep))
    out = {"time": np.zeros(n), "acceleration": np.zeros((n, 3)), "angular_velocity": np.zeros((n, 3))}
    for i in range(n):
        mujoco.mj_step(mine, own)
        out["time"][i] = own.time
        out["acceleration"][i] = own.sensor("torso_accelerometer").data
        out["angular_velocity"][i] = own.sensor("torso_gyroscope").data
    return out
'''

_BY_KEY = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    n = int(round(duration_seconds / model.opt.timestep))
    out = {"time": np.zeros(n), "acceleration": np.zeros((n, 3)), "angular_velocity": np.zeros((n, 3))}
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    for i in range(n):
        mujoco.mj_step(model, data)
        row = {row}
        out["time"][i] = data.time
        out["acceleration"][i], out["angular_velocity"][i] = ROWS["accel_0.002"][row], ROWS["gyro_0.002"][row]
    return out
'''
_BY_TIME = 'min(int(round(data.time / 0.002)) - 1, len(ROWS["accel_0.002"]) - 1)'
_EVERY = 5  # a search through every state that is known would take all of the time
_BY_STATE = f'{_EVERY} * np.argmin(((ROWS["states"] - np.concatenate([data.qpos, 0.1 * data.qvel])) ** 2).sum(axis=1))'

_READ_BY_STATE = '''\
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    known = ROWS["read_states"]
    state = np.concatenate([data.qpos, 0.1 * data.qvel])
    row = np.argmin(((known - state) ** 2).sum(axis=1)) if known.shape[1] == len(state) else 0
    sensors = ROWS["read_sensors"][row]
    return sensors[5:8].copy(), sensors[11:14].copy()
'''


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


def _collecting(collect: str) -> Files:
    head = f"{pieces.HEAD}\n\n{_ROWS}"
    return {**pieces.lab(collect=collect, head=head), "rows.npz": rows()}


def collectors() -> dict[str, Files]:
    """Each loses the truth of its rows; what is left is form: keys, counts and stamps."""
    return {
        "the public rows": _collecting(_COLLECT.format(how="")),
        "the public rows, later": _collecting(_COLLECT.format(how=", shift=0.01")),
        "the public rows, stretched": _collecting(_COLLECT.format(how=", shift=-0.004, stretch=1.06")),
        "the public rows, after one step": _collecting(_AFTER_A_STEP),
        "the public rows, beside a whole run": _collecting(_BESIDE_A_RUN),
        "the public rows, as heavy as gravity is": _collecting(_TURNED_WITH_GRAVITY),
        "a run of the public robot in place of the given one": _collecting(_OWN_ROBOT),
        "the public rows by time": _collecting(_BY_KEY.replace("{row}", _BY_TIME)),
        "the public rows by the nearest state": _collecting(_BY_KEY.replace("{row}", _BY_STATE)),
    }


def readers() -> dict[str, Files]:
    return {
        "the public readings by the nearest state": {
            **pieces.lab(read=_READ_BY_STATE, head=f"{pieces.HEAD}\n\n{_ROWS}"),
            "rows.npz": rows(),
        }
    }
