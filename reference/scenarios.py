"""Simulate the ground truth of all scenarios, one function each, whose first docstring line describes it in the traces.

The name and the seed of a bundle decide all random numbers. A row of a simulated motion holds what the sensors read right after
`mj_step`, as on the lab sheet, and the simulation's time after that step. (MuJoCo computes sensors before it integrates, so the
readings belong to the state at the step's beginning.)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from . import worlds
from .extension_scenarios import EXTENSION_SCENARIOS, reading_sheet
from .filters import LowPassFilter
from .imu_reader import PUSH, get_imu_readings, sensor_id
from .lab_variants import lab_variant
from .robot import Robot, all_imus, is_steady
from .scene import (
    LAB_PAIR,
    Recording,
    Scene,
    Settings,
    at_state,
    drawn_settings,
    first_line,
    generator,
    paced,
    readings,
    roll,
    state_in_the_air,
)
from .variants import vary

FloatArray = NDArray[np.float64]

PUBLIC_SEED = "4101"
EXTRA_ROWS = 2  # after the last one, so that an answer that is late or one sample too long can still be compared


@dataclass(frozen=True)
class Bundle:
    """The recorded scenarios of one seed, with the MJCF texts of their models by name."""

    models: Mapping[str, str]
    recordings: tuple[Recording, ...]


def simulate(name: str, seed: str, robot: Robot | None = None) -> Bundle:
    """Run every scenario and return the recordings.

    Parameters
    ----------
    name : str
        "public" for the robot and the settings that students may know, any other text for random ones.
    seed : str
        Any text. The same name and seed give the same recordings.
    robot : Robot, optional
        The instructor's own robot, in place of the lab's. The scenario `standing` is then left out, because this robot need not
        rest at reset, and `reading_sheet`, readings of the lab's robot, is added.
    """
    public = name == "public"
    text = worlds.lab() if public else lab_variant(worlds.lab(), generator(name, seed, "lab"))
    sheet = mujoco.MjModel.from_xml_string(text)
    timestep = float(sheet.opt.timestep)
    settings = Settings() if public else drawn_settings(generator(name, seed, "settings"), timestep)
    learnt = worlds.LAB_ADDRESSES | worlds.imu_addresses(sheet)
    world = worlds.shuffled(generator(name, seed, "shuffled"), learnt)
    many = worlds.many_imus(generator(name, seed, "many_imus"), learnt)
    texts = {
        "lab": text,
        "shuffled": world.xml,
        "many_imus": many.xml,
        "gimbal": worlds.GIMBAL,
        "free_fall": worlds.FREE_FALL,
        "constant_spin": worlds.constant_spin(settings.radius),
    }
    if robot is not None:
        # The readings of many places stay in the lab's world; all else is asked about the robot.
        texts |= {"sheet": text, "lab": _own(robot, name, seed), "students": robot.xml}
    compiled = {key: mujoco.MjModel.from_xml_string(text) for key, text in texts.items()}
    lab, imus = compiled["lab"], worlds.LAB_IMUS
    if robot is not None:
        settings, imus = paced(settings, float(lab.opt.timestep)), all_imus(lab, robot.imu)

    def scene(purpose: str) -> Scene:
        return Scene(
            rng=generator(name, seed, purpose),
            settings=settings,
            lab=lab,
            imus=imus,
            sheet=compiled.get("sheet", lab),
            shuffled=compiled["shuffled"],
            shuffled_imus=world.imus,
            spin=compiled["constant_spin"],
            free_fall=compiled["free_fall"],
            gimbal=compiled["gimbal"],
            many=compiled["many_imus"],
            many_places=many.places,
            many_compasses=many.compasses,
        )

    if robot is None:
        return Bundle(texts, tuple(record(scene(record.__name__)) for record in SCENARIOS))
    own = (*(record for record in SCENARIOS if record is not standing), reading_sheet)
    return Bundle(texts, tuple(_retold(record(scene(record.__name__))) for record in own))


def _own(robot: Robot, name: str, seed: str) -> str:
    """Return the MJCF of the instructor's robot or, under a secret, of a random variant whose simulation is stable."""
    if name == "public":
        return robot.xml
    rng = generator(name, seed, "robot")
    for _ in range(_DRAWS):
        xml = vary(robot.xml, rng)
        if is_steady(mujoco.MjModel.from_xml_string(xml)):
            return xml
    raise RuntimeError(f"none of {_DRAWS} variants of {robot.file} is steady")


_DRAWS = 50


def _retold(recording: Recording) -> Recording:
    """Return the recording of an instructor's robot with a description that says "instructor's model" and not "lab model".

    Recordings of other models are unchanged.
    """
    if recording.model != "lab":
        return recording
    said = recording.description
    for article in ("the", "The"):
        said = said.replace(f"{article} lab model", f"{article} instructor's model")
    return replace(recording, description=said)


# --- motions --------------------------------------------------------------------------------------------------------


def standing(scene: Scene) -> Recording:
    """The lab model from reset, untouched: it rests."""
    return Recording(
        "standing", first_line(standing), "lab", roll(scene.lab, mujoco.MjData(scene.lab), 1500, scene.imu)
    )


def tumbling(scene: Scene) -> Recording:
    """The lab model thrown into the air with a random spin: all six channels move, each in its own way."""
    if not scene.own:
        return Recording("tumbling", first_line(tumbling), "lab", _thrown(scene.rng, scene.lab, scene.imu))
    for _ in range(_THROWS):
        arrays = _thrown(scene.rng, scene.lab, scene.imu)
        if _can_be_plotted(arrays):
            return Recording("tumbling", first_line(tumbling), "lab", arrays)
    # A robot that stands on rails, or one that breaks in the air: what is plotted has six curves that can be told apart.
    return Recording("tumbling", first_line(tumbling), "sheet", _thrown(scene.rng, scene.sheet, LAB_PAIR))


_THROWS = 10
_THROWN_STEPS, _THROWN_TIMESTEP = 600, 0.002


def _thrown(rng: np.random.Generator, model: mujoco.MjModel, imu: tuple[str, str]) -> dict[str, FloatArray]:
    qpos, qvel = state_in_the_air(rng, model)
    rise = rng.uniform(4.5, 5.5)
    if model.nv > 2:
        qvel[2] = rise  # up, so that it is still in the air at the end
    saved = float(model.opt.timestep)
    model.opt.timestep = min(saved, _THROWN_TIMESTEP)
    try:
        arrays = roll(model, at_state(model, qpos, qvel), _THROWN_STEPS, imu)
    finally:
        model.opt.timestep = saved
    return {"start_qpos": qpos, "start_qvel": qvel, **arrays}


def _can_be_plotted(arrays: Mapping[str, FloatArray]) -> bool:
    """Return whether the six curves can be told apart in a plot: each axis moves, and no two axes of a sensor coincide."""
    for rows in (arrays["acceleration"], arrays["angular_velocity"]):
        if not np.isfinite(rows).all():
            return False
        height = np.ptp(rows)
        apart = [np.abs(rows[:, i] - rows[:, j]).mean() for i, j in ((0, 1), (0, 2), (1, 2))]
        if height == 0 or np.min(rows.std(axis=0)) < 0.02 * height or min(apart) < 0.05 * height:
            return False
    return True


def free_fall(scene: Scene) -> Recording:
    """A box falls without turning: an accelerometer in free fall reads zero."""
    data = mujoco.MjData(scene.free_fall)
    data.qvel[:3] = scene.rng.uniform(-1.0, 1.0, 3)
    trace = roll(scene.free_fall, data, 200, ("accelerometer", "gyroscope"))
    return Recording("free_fall", first_line(free_fall), "free_fall", trace)


def constant_spin(scene: Scene) -> Recording:
    """A turntable at constant rate, the IMU off its axis: it reads −ω²r outward and gravity's reaction upward."""
    data = mujoco.MjData(scene.spin)
    data.qvel[0] = scene.settings.spin
    trace = roll(scene.spin, data, 500, ("accelerometer", "gyroscope"))
    scalars = {"angular_velocity_rad_s": scene.settings.spin, "radius_m": scene.settings.radius}
    return Recording("constant_spin", first_line(constant_spin), "constant_spin", trace, scalars)


# --- single readings ------------------------------------------------------------------------------------------------


def reading_lab(scene: Scene) -> Recording:
    """All sensors of the lab model in random states in the air, and last standing at rest."""
    states = [state_in_the_air(scene.rng, scene.lab) for _ in range(12)]
    states.append((np.array(scene.lab.qpos0), np.zeros(scene.lab.nv)))
    arrays, scalars = readings(scene.lab, states, scene.imus)
    return Recording("reading_lab", first_line(reading_lab), "lab", arrays, scalars)


def reading_shuffled(scene: Scene) -> Recording:
    """All sensors of a generated model: other names, other order, other mountings."""
    states = [state_in_the_air(scene.rng, scene.shuffled) for _ in range(12)]
    arrays, scalars = readings(scene.shuffled, states, scene.shuffled_imus)
    return Recording("reading_shuffled", first_line(reading_shuffled), "shuffled", arrays, scalars)


# --- the sheet's push -----------------------------------------------------------------------------------------------


def _pushed(scene: Scene, n_steps: int, velocity: float = PUSH) -> dict[str, FloatArray]:
    data = mujoco.MjData(scene.lab)
    data.qvel[0] = velocity
    return roll(scene.lab, data, n_steps, scene.imu)


def _push_scalars(duration: float, timestep: float) -> dict[str, Any]:
    return {
        "duration_s": duration,
        "timestep": timestep,
        "n_steps": round(duration / timestep),
        "push_mps": PUSH,
        "push_dof": 0,
    }


def push(scene: Scene) -> Recording:
    """The sheet's Step 3: from reset, pushed forward with 0.5 m/s; and how it looks without a push."""
    scalars = _push_scalars(scene.settings.push_s, float(scene.lab.opt.timestep))
    arrays = _pushed(scene, scalars["n_steps"] + EXTRA_ROWS)
    still = _pushed(scene, scalars["n_steps"], velocity=0.0)
    arrays |= {f"alt_no_push_{channel}": still[channel] for channel in ("acceleration", "angular_velocity")}
    return Recording("push", first_line(push), "lab", arrays, scalars)


def push_dirty(scene: Scene) -> Recording:
    """The sheet's Step 3 with another time step, on data that another motion has left behind."""
    scalars = _push_scalars(scene.settings.dirty_s, scene.settings.dirty_timestep)
    saved = float(scene.lab.opt.timestep)
    scene.lab.opt.timestep = scalars["timestep"]
    try:
        arrays = _dirty_arrays(scene, scalars["n_steps"])
    finally:
        scene.lab.opt.timestep = saved
    return Recording("push_dirty", first_line(push_dirty), "lab", arrays, scalars)


def _dirty_arrays(scene: Scene, n_steps: int) -> dict[str, Any]:
    left_behind = _data_in_mid_fall(scene)
    qpos, qvel, time = np.array(left_behind.qpos), np.array(left_behind.qvel), float(left_behind.time)
    arrays: dict[str, Any] = {"dirty_qpos": qpos, "dirty_qvel": qvel, "dirty_time": np.array(time)}
    return arrays | _pushed(scene, n_steps + EXTRA_ROWS)


def _data_in_mid_fall(scene: Scene) -> mujoco.MjData:
    """Return data as an earlier run leaves them: the robot lifted, and dropped with a random velocity, in mid-motion.

    A robot without a free joint gets random joint velocities only.
    """
    data = mujoco.MjData(scene.lab)
    held = scene.lab.jnt_type[0] != mujoco.mjtJoint.mjJNT_FREE
    first = 0 if held else 6
    if not held:
        data.qpos[2] += scene.rng.uniform(0.05, 0.1)
        data.qvel[:6] = scene.rng.uniform(0.3, 0.6, 6) * scene.rng.choice([-1.0, 1.0], 6)
    data.qvel[first:] = scene.rng.normal(0.0, 0.5, scene.lab.nv - first)
    for _ in range(60):
        mujoco.mj_step(scene.lab, data)
    return data


# --- noise and filters ----------------------------------------------------------------------------------------------


def filter(scene: Scene) -> Recording:
    """A slow motion with a step in it and white noise on it, and what the sheet's recursion makes of that."""
    n, rng, step = 400, scene.rng, 0.01
    time = np.arange(1, n + 1, dtype=np.float64) * step
    clean_accel = _slow_motion(rng, time, 1.5) + np.array([0.0, 0.0, -9.81])
    clean_gyro = _slow_motion(rng, time, 0.3)
    acceleration = clean_accel + rng.normal(0.0, 0.1, (n, 3))
    angular_velocity = clean_gyro + rng.normal(0.0, 0.02, (n, 3))
    alpha = np.array([0.1, 0.2, scene.settings.alpha])
    initial = acceleration[0] + rng.uniform(2.0, 5.0, 3) * rng.choice([-1.0, 1.0], 3)
    arrays = {
        "time": time,
        "acceleration": acceleration,
        "angular_velocity": angular_velocity,
        "acceleration_clean": clean_accel,
        "angular_velocity_clean": clean_gyro,
        "input": acceleration,
        "alpha": alpha,
        "initial": initial,
        "low_passed": np.array([_filtered(acceleration, a, None) for a in alpha]),
        "low_passed_from_initial": np.array([_filtered(acceleration, a, initial) for a in alpha]),
    }
    return Recording("filter", first_line(filter), None, arrays, {"accel_noise_std": 0.1, "gyro_noise_std": 0.02})


def _slow_motion(rng: np.random.Generator, time: FloatArray, size: float) -> FloatArray:
    """Return a signal (n, 3) that a filter should preserve: each axis a sine below half a hertz, with a step half-way."""
    frequency, phase = rng.uniform(0.2, 0.5, 3), rng.uniform(0.0, 2 * np.pi, 3)
    steps = rng.uniform(0.8, 1.2, 3) * rng.choice([-1.0, 1.0], 3) * size
    wave = size * np.sin(2 * np.pi * time[:, None] * frequency + phase)
    return np.asarray(wave + steps * (time[:, None] > time[len(time) // 2]), dtype=np.float64)


def _filtered(samples: FloatArray, alpha: float, initial: FloatArray | None) -> FloatArray:
    smoother = LowPassFilter(alpha=float(alpha), initial_value=initial)
    return np.array([smoother.update(sample) for sample in samples])


def noise(scene: Scene) -> Recording:
    """Two states in which no channel is small and none is like another, and the noise and bias to add to them."""
    states = [_lively_state(scene) for _ in range(2)]
    readings = [_read(scene, *state) for state in states]
    accel_std, gyro_std = scene.settings.accel_noise_std, scene.settings.gyro_noise_std
    arrays = {
        "qpos": np.array([qpos for qpos, _ in states]),
        "qvel": np.array([qvel for _, qvel in states]),
        "acceleration": np.array([accel for accel, _ in readings]),
        "angular_velocity": np.array([gyro for _, gyro in readings]),
        "accel_bias": accel_std * _distinct(scene.rng),
        "gyro_bias": gyro_std * _distinct(scene.rng),
    }
    return Recording(
        "noise", first_line(noise), "lab", arrays, {"accel_noise_std": accel_std, "gyro_noise_std": gyro_std}
    )


def _read(scene: Scene, qpos: FloatArray, qvel: FloatArray) -> tuple[FloatArray, FloatArray]:
    data = at_state(scene.lab, qpos, qvel)
    return get_imu_readings(scene.lab, data, *(sensor_id(scene.lab, name) for name in scene.imu))


_LIVELY = 0.3
_TRIES = 500
"""States that are tried. Every fourth of the lab's robot is lively; with idle channels none is, and the liveliest counts."""


def _lively_state(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Return a random state (qpos, qvel) in which no sensor channel is near zero or another, so that mix-ups show.

    If no draw is far enough, the best one counts.
    """
    best, most = state_in_the_air(scene.rng, scene.lab), -1.0
    for _ in range(_TRIES):
        state = best if most < 0 else state_in_the_air(scene.rng, scene.lab)
        channels = np.concatenate(_read(scene, *state))
        gaps = np.abs(channels[:, None] - channels)[np.triu_indices(6, 1)]
        least = float(min(np.abs(channels).min(), gaps.min()))
        if least > most:
            best, most = state, least
        if most > _LIVELY:
            break
    return best


def _distinct(rng: np.random.Generator) -> FloatArray:
    """Return a bias (3,) in standard deviations of the noise: 3 to 9, so unlike in size that exchanged axes show."""
    sizes = rng.permutation([3.0, 5.0, 8.0]) + rng.uniform(0.0, 1.0, 3)
    return np.asarray(sizes * rng.choice([-1.0, 1.0], 3), dtype=np.float64)


SCENARIOS: tuple[Callable[[Scene], Recording], ...] = (
    standing,
    tumbling,
    free_fall,
    constant_spin,
    reading_lab,
    reading_shuffled,
    push,
    push_dirty,
    filter,
    noise,
    *EXTENSION_SCENARIOS,
)
