"""Common parts of all scenarios: random generator, settings, compiled models, and the recording of a motion."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from .imu_reader import get_imu_readings, sensor_id

FloatArray = NDArray[np.float64]

LAB_PAIR = ("torso_accelerometer", "torso_gyroscope")
SPRING_TORQUE = 10.0  # N m, at most, in a random state: a throw, not an explosion


@dataclass(frozen=True)
class Recording:
    """Correct arrays and scalars of a scenario, to judge code by; `model` names its model in `Bundle.models`, None without one."""

    name: str
    description: str
    model: str | None
    arrays: Mapping[str, Any]
    scalars: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Settings:
    """Durations, rates and noise of the scenarios: by default those of the public traces; hidden ones have `drawn_settings`."""

    push_s: float = 1.2
    dirty_s: float = 0.6
    dirty_timestep: float = 0.004
    spin: float = 4.0  # rad/s
    radius: float = 0.3  # m
    alpha: float = 0.35
    accel_noise_std: float = 0.08  # m/s²
    gyro_noise_std: float = 0.004  # rad/s


@dataclass(frozen=True)
class Scene:
    """Material of a scenario: its own random generator, the settings and the compiled models.

    `sheet` is the robot of the lab sheet, `lab` the one that grading uses: the same, or the instructor's own. For hidden traces
    both are random variants. `imus` names the accelerometer and gyroscope of each IMU of `lab`, the graded IMU first.
    """

    rng: np.random.Generator
    settings: Settings
    lab: mujoco.MjModel
    imus: tuple[tuple[str, str], ...]
    sheet: mujoco.MjModel
    shuffled: mujoco.MjModel
    shuffled_imus: tuple[tuple[str, str], ...]
    spin: mujoco.MjModel
    free_fall: mujoco.MjModel
    gimbal: mujoco.MjModel
    many: mujoco.MjModel
    many_places: tuple[str, ...]
    many_compasses: tuple[str, ...]

    @property
    def imu(self) -> tuple[str, str]:
        """Names of the accelerometer and the gyroscope of the IMU that is graded."""
        return self.imus[0]

    @property
    def own(self) -> bool:
        """Return whether the robot is the instructor's, of which the lab sheet's statements need not be true."""
        return self.lab is not self.sheet


def generator(name: str, seed: str, purpose: str) -> np.random.Generator:
    """Return a random generator seeded by these three texts: with its own `purpose`, a new scenario changes no other's numbers."""
    digest = hashlib.sha256("\0".join(("imugrade", name, seed, purpose)).encode()).digest()
    return np.random.default_rng(np.frombuffer(digest, dtype="<u4").astype(np.uint64))


def first_line(record: Callable[[Scene], Recording]) -> str:
    """Return the first docstring line of `record`, a scenario's function: it describes the scenario in the traces."""
    return (record.__doc__ or "").strip().splitlines()[0]


def drawn_settings(rng: np.random.Generator, usual_timestep: float) -> Settings:
    """Return random durations, rates and noise for hidden traces, which students never see.

    `dirty_timestep`, for a run that reuses MjData, differs from the robot's `usual_timestep`, so that code with a fixed step fails.
    """
    timestep = float(rng.choice([each for each in (0.001, 0.0025, 0.004) if each != usual_timestep]))
    return Settings(
        push_s=round(0.01 * int(rng.integers(100, 151)), 2),
        dirty_s=round(0.02 * int(rng.integers(20, 41)), 2),
        dirty_timestep=timestep,
        spin=round(float(rng.uniform(2.0, 6.0)), 3),
        radius=round(float(rng.uniform(0.15, 0.45)), 3),
        alpha=round(float(rng.uniform(0.25, 0.6)), 3),
        accel_noise_std=round(float(rng.uniform(0.03, 0.1)), 4),
        gyro_noise_std=round(float(rng.uniform(0.002, 0.01)), 5),
    )


def paced(settings: Settings, timestep: float) -> Settings:
    """Return the settings for an instructor's robot: durations rounded to whole steps, at least 150 and at most 2,000 of them.

    A step of `push_s` lasts `timestep`. A step of `dirty_s`, for the run that reuses MjData, lasts the new `dirty_timestep`, which
    is made shorter than `timestep`: a longer one might not be stable.
    """
    n_steps = min(max(round(settings.push_s / timestep), _FEWEST_STEPS), _MOST_STEPS)
    other = round(timestep * min(settings.dirty_timestep / 0.005, 0.8), 9)
    dirty_steps = min(max(round(settings.dirty_s / other), _FEWEST_STEPS), _MOST_STEPS)
    return replace(
        settings,
        push_s=round(n_steps * timestep, 9),
        dirty_s=round(dirty_steps * other, 9),
        dirty_timestep=other,
    )


_FEWEST_STEPS, _MOST_STEPS = 150, 2000


def roll(model: mujoco.MjModel, data: mujoco.MjData, n_steps: int, pair: tuple[str, str]) -> dict[str, FloatArray]:
    """Simulate on from the state in `data`; return the IMU `pair`'s `time` (n,), `acceleration` and `angular_velocity` (n, 3)."""
    accel, gyro = (sensor_id(model, name) for name in pair)
    time, acceleration, angular_velocity = np.zeros(n_steps), np.zeros((n_steps, 3)), np.zeros((n_steps, 3))
    for i in range(n_steps):
        mujoco.mj_step(model, data)
        time[i] = data.time
        acceleration[i], angular_velocity[i] = get_imu_readings(model, data, accel, gyro)
    return {"time": time, "acceleration": acceleration, "angular_velocity": angular_velocity}


def at_state(model: mujoco.MjModel, qpos: FloatArray, qvel: FloatArray, time: float = 0.0) -> mujoco.MjData:
    """Return new data in this state, after `mj_forward` has computed sensors and all else that follows from it."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.time = qpos, qvel, time
    mujoco.mj_forward(model, data)
    return data


def state_in_the_air(rng: np.random.Generator, model: mujoco.MjModel) -> tuple[FloatArray, FloatArray]:
    """Return a random state `qpos` (nq,), `qvel` (nv,) of a robot clear of the floor, so that no contact disturbs its sensors."""
    qpos, qvel = np.array(model.qpos0), rng.normal(0.0, 0.4, model.nv)
    for joint in range(model.njnt):
        place, dof = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
        if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
            attitude = rng.normal(size=4)
            qpos[place : place + 3] += (*rng.uniform(-0.5, 0.5, 2), rng.uniform(2.5, 3.5))
            qpos[place + 3 : place + 7] = attitude / np.linalg.norm(attitude)
            qvel[dof + 3 : dof + 6] = rng.uniform(1.0, 3.0, 3) * rng.choice([-1.0, 1.0], 3)
        elif model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_BALL:
            turn = rng.uniform(-0.15, 0.15, 3)  # half the angle that a hinge is turned by at most
            qpos[place : place + 4] = np.array([1.0, *turn]) / np.linalg.norm([1.0, *turn])
        else:
            qpos[place] = rng.uniform(-1.0, 1.0) * min(0.3, SPRING_TORQUE / max(model.jnt_stiffness[joint], 1e-9))
            if model.jnt_limited[joint]:
                qpos[place] = np.clip(qpos[place], *model.jnt_range[joint])
    return qpos, qvel


def readings(
    model: mujoco.MjModel,
    states: Sequence[tuple[FloatArray, FloatArray]],
    pairs: Sequence[tuple[str, str]],
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return arrays (sensor values, sites' and bodies' motion in k `states`) and scalars (sensor names, gravity), both by name.

    `states` are pairs (qpos, qvel); `pairs` name the accelerometer and gyroscope of each IMU whose site and body are recorded.
    """
    ids = np.array([[sensor_id(model, sensor) for sensor in pair] for pair in pairs], dtype=np.int64)
    sites = model.sensor_objid[ids[:, 0]]
    bodies = model.site_bodyid[sites]
    moments = [at_state(model, qpos, qvel) for qpos, qvel in states]
    arrays = {
        "qpos": np.array([qpos for qpos, _ in states]),
        "qvel": np.array([qvel for _, qvel in states]),
        "qacc": np.array([data.qacc for data in moments]),
        "sensordata": np.array([data.sensordata for data in moments]),
        "site_xmat": np.array([data.site_xmat[sites].reshape(-1, 3, 3) for data in moments]),
        "body_xmat": np.array([data.xmat[bodies].reshape(-1, 3, 3) for data in moments]),
        "cvel": np.array([data.cvel[bodies] for data in moments]),
        "cacc": np.array([data.cacc[bodies] for data in moments]),
        "pairs": ids,
        "sensor_adr": model.sensor_adr.astype(np.int64),
        "sensor_dim": model.sensor_dim.astype(np.int64),
        "sensor_type": model.sensor_type.astype(np.int64),
    }
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, i) for i in range(model.nsensor)]
    return arrays, {"sensor_names": names, "gravity": model.opt.gravity.tolist()}
