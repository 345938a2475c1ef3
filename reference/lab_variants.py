"""Random variants of the lab model for hidden traces, new to students: as on the lab sheet they stand, and stay up if pushed."""

from __future__ import annotations

from itertools import permutations

import mujoco
import numpy as np
from numpy.typing import NDArray

from . import balance, worlds
from .imu_reader import PUSH, sensor_id, simulate_and_collect
from .scene import LAB_PAIR, roll
from .variants import Robot, numbers, vary

FloatArray = NDArray[np.float64]

STANDING = (0.0, 0.0, -9.81)  # m/s², as the sheet has it
STANDS_WITHIN = 0.1  # m/s²
STILL_WITHIN = 1e-3  # m/s²
SWAYS = 0.3  # rad/s, in pitch
STAYS_ABOVE = 0.95  # of its height
FARTHEST = 42
"""Largest address of an IMU: generated models have more numbers, so that one learnt here is in range there."""
SETTLED_S = 5.0
"""When the push is over: the sheet's own default duration."""
SHEET_S = 3.0
WINDOWS = (3, 9, 27, 81)
ALIKE = 0.7
"""Least correlation of a filter's output with a running mean of its input, for each of the windows (rows)."""
STILL_S = 0.5
"""For how long it is still by then."""


def lab_variant(xml: str, rng: np.random.Generator) -> str:
    """Draw without limit; return the first variant (MJCF) to move as on the sheet, with new IMU addresses and unlike channels."""
    while True:
        text = at_rest(vary(xml, rng))
        if keeps_the_facts(mujoco.MjModel.from_xml_string(text)):
            return text


def at_rest(xml: str) -> str:
    """Return MJCF with height, pads and springs set so that its initial pose rests; `balance.balanced` is for the lab's file."""
    robot = Robot.of(xml)
    model = robot.model
    balance.settle(model)
    pads = balance.pads(model)
    next(robot.bodies()).set("pos", numbers(model.qpos0[:3]))
    for geom, element in enumerate(robot.parts("geom")):
        if geom in pads:
            element.set("pos", numbers(model.geom_pos[geom]))
    for joint, element in enumerate(robot.parts("joint", "freejoint")):
        if element.tag == "joint":
            element.set("springref", numbers(model.qpos_spring[model.jnt_qposadr[joint]]))
    return robot.text()


def keeps_the_facts(model: mujoco.MjModel) -> bool:
    return _hides_its_sensors(model) and _stands(model) and _sways_and_settles(model) and _channels_differ(model)


def _hides_its_sensors(model: mujoco.MjModel) -> bool:
    """Return whether no address of an IMU is one in the students' model, the sensor's id, or beyond the generated models."""
    addresses = worlds.imu_addresses(model)
    unlike = all(int(model.sensor_adr[i]) != i for i in range(model.nsensor) if int(model.sensor_adr[i]) in addresses)
    return unlike and worlds.LAB_ADDRESSES.isdisjoint(addresses) and max(addresses) <= FARTHEST


def _stands(model: mujoco.MjModel) -> bool:
    """Return whether the robot rests from the first step on and reads as the lab sheet says, within half a second."""
    trace = roll(model, mujoco.MjData(model), round(0.5 / model.opt.timestep), LAB_PAIR)
    still = np.ptp(trace["acceleration"], axis=0).max() < STILL_WITHIN
    return bool(still and not _far_from_standing(trace["acceleration"][0]))


def _sways_and_settles(model: mujoco.MjModel) -> bool:
    data = mujoco.MjData(model)
    data.qvel[0] = PUSH
    accel, gyro = (int(model.sensor_adr[sensor_id(model, name)]) for name in LAB_PAIR)
    lowest, fastest = np.inf, 0.0
    while data.time < SETTLED_S:
        mujoco.mj_step(model, data)
        lowest, fastest = min(lowest, data.qpos[2]), max(fastest, abs(data.sensordata[gyro + 1]))
        if data.time > SETTLED_S - STILL_S and _far_from_standing(data.sensordata[accel : accel + 3]):
            return False
    return bool(lowest > STAYS_ABOVE * model.qpos0[2] and fastest > SWAYS)


def _far_from_standing(acceleration: FloatArray) -> bool:
    return bool(np.abs(acceleration - STANDING).max() > STANDS_WITHIN)


def _channels_differ(model: mujoco.MjModel) -> bool:
    """Return whether, in the lab sheet's three seconds, no channel looks like a smoothed copy of another of the same sensor.

    If one did, a plot of raw data alone would seem to compare raw and filtered data.
    """
    trace = simulate_and_collect(model, mujoco.MjData(model), SHEET_S)
    pairs = [(a, b) for key in ("acceleration", "angular_velocity") for a, b in permutations(trace[key].T, 2)]
    return not any(_seems_smoothed(a, b, window) for a, b in pairs for window in WINDOWS)


def _seems_smoothed(raw: FloatArray, smooth: FloatArray, window: int) -> bool:
    """Return whether `smooth` follows the running mean of `raw` over the second half, at any lag that a filter may have."""
    if np.std(np.diff(smooth)) > 0.85 * np.std(np.diff(raw)):
        return False
    mean = np.convolve(raw, np.ones(window) / window, mode="valid")
    return any(_alike(mean, smooth[window // 2 + lag :]) for lag in range(2 * window + 1))


def _alike(one: FloatArray, other: FloatArray) -> bool:
    n = min(len(one), len(other))
    a, b = one[n // 2 : n], other[n // 2 : n]
    as_large = 0.23 < b.std() / a.std() < 4.3
    near = abs(a.mean() - b.mean()) <= 3.3 * a.std()
    return bool(as_large and near and np.corrcoef(a, b)[0, 1] > ALIKE)
