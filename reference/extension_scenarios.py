"""Simulate the correct data (traces) that grade the sheet's extensions: tilt filter, Allan deviation, many IMUs, live plot.

A scenario's first docstring line describes it there. `tilt_start` records no motion: the grader makes readings at rest from it, the
first ones wrong, for a filter to forget. `watched` is two runs for the live plot; an instructor's robot may keep a shorter step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from .allan_variance import allan_deviation
from .complementary_filter import ComplementaryFilter
from .imu_reader import PUSH, sensor_id
from .scene import Recording, Scene, first_line, readings, state_in_the_air
from .worlds import LAB_IMUS

FloatArray = NDArray[np.float64]

# --- tilting --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Wave:
    """A smooth motion of one joint as a sum of sines: amplitudes, frequencies (Hz) and phases (rad), each (k,)."""

    size: FloatArray
    frequency: FloatArray
    phase: FloatArray

    def at(self, time: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the joint's angle or position and two time derivatives, (n,) each, at times (n,) in s, for inverse dynamics."""
        omega = 2.0 * np.pi * self.frequency
        angle = time[:, None] * omega + self.phase
        return (
            np.sin(angle) @ self.size,
            np.cos(angle) @ (self.size * omega),
            np.sin(angle) @ (-self.size * omega**2),
        )


@dataclass(frozen=True)
class Ride:
    """A motion of an IMU on a gimbal that rides on a carriage, and the errors of its sensors.

    Attributes
    ----------
    dt : time between samples (s); n : number of samples
    roll, pitch : amplitude (rad), lowest and highest frequency (Hz)
    shaking : acceleration of the carriage in each direction (m/s²), between 3 and 6 Hz
    bias : size of the gyroscope's offset (rad/s) on each axis
    """

    dt: float
    n: int
    roll: tuple[float, float, float]
    pitch: tuple[float, float, float]
    shaking: float
    bias: float


ACCEL_NOISE, GYRO_NOISE = 0.1, 0.005  # m/s², rad/s
DRIFTING = Ride(0.02, 2000, (0.4, 0.05, 0.2), (0.35, 0.05, 0.2), 0.5, 0.025)
SHAKEN = Ride(0.01, 2000, (0.4, 0.8, 1.2), (0.35, 0.8, 1.2), 5.0, 0.0)
STEEP = Ride(0.02, 2000, (0.2, 0.3, 0.5), (1.1, 0.25, 0.35), 4.0, 0.015)


def _wave(rng: np.random.Generator, amplitude: float, low: float, high: float) -> Wave:
    """Return a random rotation that starts level, so that a slow filter does not begin with an error."""
    shares = np.array([0.75, 0.25])
    return Wave(amplitude * shares, rng.uniform(low, high, 2), rng.choice([0.0, np.pi], 2))


def _shake(rng: np.random.Generator, acceleration: float) -> Wave:
    frequency = rng.uniform(3.0, 6.0, 2)
    return Wave(
        acceleration * np.array([0.7, 0.3]) / (2.0 * np.pi * frequency) ** 2, frequency, rng.uniform(0.0, 6.28, 2)
    )


def _drift_of(rng: np.random.Generator, size: float) -> FloatArray:
    """Return a random gyroscope bias (3,) of about `size` on every axis, with random signs."""
    return np.asarray(size * rng.uniform(0.8, 1.2, 3) * rng.choice([-1.0, 1.0], 3), dtype=np.float64)


def _ridden(scene: Scene, ride: Ride) -> dict[str, Any]:
    """Return noisy sensors and true tilt along a random ride, whose joints are prescribed: inverse dynamics gives the readings."""
    time = np.arange(1, ride.n + 1, dtype=np.float64) * ride.dt
    waves = [_shake(scene.rng, ride.shaking) for _ in range(3)]
    still = Wave(np.zeros(1), np.zeros(1), np.zeros(1))
    turns = [still, _wave(scene.rng, *ride.pitch), _wave(scene.rng, *ride.roll)]
    motion = np.array([wave.at(time) for wave in (*waves, *turns)])  # (6, 3, n): joint, derivative, sample
    readings_of, tilt = _sensed(scene.gimbal, motion)
    bias = _drift_of(scene.rng, ride.bias)
    noise = scene.rng.normal(0.0, 1.0, (ride.n, 6)) * np.repeat([ACCEL_NOISE, GYRO_NOISE], 3)
    noisy = np.round(readings_of[:, :6] + noise + np.concatenate([np.zeros(3), bias]), 5)
    return {"time": time, "acceleration": noisy[:, :3], "angular_velocity": noisy[:, 3:], "tilt": np.round(tilt, 7)}


def _sensed(model: mujoco.MjModel, motion: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return sensor readings (n, 9) and true roll and pitch (n, 2) along a prescribed motion (6, 3, n): joint, derivative, time."""
    data = mujoco.MjData(model)
    samples, tilt = np.zeros((motion.shape[2], model.nsensordata)), np.zeros((motion.shape[2], 2))
    for row in range(motion.shape[2]):
        data.qpos[:], data.qvel[:], data.qacc[:] = motion[:, 0, row], motion[:, 1, row], motion[:, 2, row]
        mujoco.mj_inverse(model, data)
        samples[row] = data.sensordata
        tilt[row] = true_tilt(data.site_xmat[0].reshape(3, 3))
    return samples, tilt


def true_tilt(world_from_site: FloatArray) -> FloatArray:
    """Return roll and pitch (2,) in rad of a frame forward-right-down, from its rotation (3, 3) into the world."""
    up = world_from_site[2]  # the world's z axis in the site's frame: gravity's reaction, at rest
    return np.array([np.arctan2(-up[1], -up[2]), np.arctan2(up[0], np.hypot(up[1], up[2]))])


def _recorded(record: Callable[[Scene], Recording], scene: Scene, ride: Ride) -> Recording:
    arrays = _ridden(scene, ride)
    alone = {"gyro_alone_rms": _rms(arrays, 1.0), "accel_alone_rms": _rms(arrays, 0.0)}
    return Recording(record.__name__, first_line(record), "gimbal", arrays, {"dt": ride.dt, **alone})


def _rms(arrays: dict[str, Any], alpha: float) -> float:
    """Return the error (rad) over the second half that one sensor alone makes (alpha 1: gyroscope, 0: accelerometer).

    A student's filter has to be better than both. The gyroscope starts from the true tilt.
    """
    dt = float(arrays["time"][0])
    single = ComplementaryFilter(dt, alpha)
    single.start(*arrays["tilt"][0])
    estimate = [single.update(*row) for row in zip(arrays["acceleration"], arrays["angular_velocity"], strict=True)]
    error = (np.array(estimate) - arrays["tilt"] + np.pi) % (2.0 * np.pi) - np.pi
    return round(float(np.sqrt(np.mean(error[len(error) // 2 :] ** 2))), 6)


def tilt_drifting(scene: Scene) -> Recording:
    """An IMU that tilts slowly for 40 s; its gyroscope has a bias, so that its integral alone drifts away."""
    return _recorded(tilt_drifting, scene, DRIFTING)


def tilt_shaken(scene: Scene) -> Recording:
    """An IMU that tilts and is shaken by half of gravity: the accelerometer's tilt alone is useless."""
    return _recorded(tilt_shaken, scene, SHAKEN)


def tilt_steep(scene: Scene) -> Recording:
    """An IMU that pitches by more than sixty degrees either way, with a gyroscope bias and some shaking."""
    return _recorded(tilt_steep, scene, STEEP)


def tilt_start(scene: Scene) -> Recording:
    """Held still at two tilts, the second one steep; a shove at the start makes the first reading a wrong one."""
    sign = scene.rng.choice([-1.0, 1.0], 4)
    size = scene.rng.uniform([0.3, 0.3, 0.2, 1.0], [0.5, 0.5, 0.3, 1.2])
    tilt = np.round((sign * size).reshape(2, 2), 4)
    shove = np.round(scene.rng.uniform(3.0, 5.0, (2, 3)) * scene.rng.choice([-1.0, 1.0], (2, 3)), 3)
    return Recording("tilt_start", first_line(tilt_start), None, {"tilt": tilt, "shove": shove}, {"dt": 0.02})


# --- kinds of noise -------------------------------------------------------------------------------------------------

NOISE_SAMPLES = 4000


def allan(scene: Scene) -> Recording:
    """Records of pure kinds of noise, of a mix with a flat region, and of three axes, with their Allan deviations."""
    rng, n = scene.rng, NOISE_SAMPLES
    rate = float(rng.choice([20.0, 25.0, 40.0, 80.0]))
    white = rng.normal(0.0, rng.uniform(0.02, 0.06), n)
    walk = np.cumsum(rng.normal(0.0, rng.uniform(0.001, 0.004), n))
    quantised = np.diff(rng.uniform(-0.5, 0.5, n + 1)) * 0.001 * rate
    ramp = rng.uniform(0.5, 1.5) * rng.choice([-1.0, 1.0]) * 1e-3 * np.arange(n) / rate
    mixed = 0.02 * rng.normal(0.0, 1.0, n) + 0.004 * flicker(rng, n) + np.cumsum(rng.normal(0.0, 4e-5, n))
    axes = rng.normal(0.0, 1.0, (n // 2, 3)) * np.array([0.01, 0.03, 0.1]) + rng.uniform(-0.2, 0.2, 3)
    series = {"white": white, "walk": walk, "quantised": quantised, "drift": ramp, "mixed": mixed, "axes": axes}
    curves = {f"{name}_adev": allan_deviation(samples, rate)[1] for name, samples in series.items()}
    taus = {"taus": allan_deviation(white, rate)[0], "axes_taus": allan_deviation(axes, rate)[0]}
    return Recording("allan", first_line(allan), None, {**series, **curves, **taus}, {"sample_rate_hz": rate})


def flicker(rng: np.random.Generator, n: int) -> FloatArray:
    """Return flicker noise (n,), whose power goes with 1 / frequency and which makes the flat part of an Allan plot."""
    spectrum = np.fft.rfft(rng.normal(0.0, 1.0, 2 * n))
    spectrum[1:] /= np.sqrt(np.arange(1, len(spectrum)))
    spectrum[0] = 0.0
    series = np.fft.irfft(spectrum)[:n]
    return np.asarray(series / series.std(), dtype=np.float64)


# --- many IMUs ------------------------------------------------------------------------------------------------------


def reading_many(scene: Scene) -> Recording:
    """All sensors of a generated model with many IMUs, some of them with a magnetometer, in random states."""
    states = [state_in_the_air(scene.rng, scene.many) for _ in range(4)]
    pairs = [(f"{place}_accelerometer", f"{place}_gyroscope") for place in scene.many_places]
    arrays, scalars = readings(scene.many, states, pairs)
    names = {"places": list(scene.many_places), "compasses": list(scene.many_compasses)}
    return Recording("reading_many", first_line(reading_many), "many_imus", arrays, {**scalars, **names})


def reading_sheet(scene: Scene) -> Recording:
    """All sensors of the lab's own robot, in random states: it has many IMUs, where the instructor's may have one."""
    states = [state_in_the_air(scene.rng, scene.sheet) for _ in range(4)]
    arrays, scalars = readings(scene.sheet, states, LAB_IMUS)
    return Recording("reading_sheet", first_line(reading_sheet), "sheet", arrays, scalars)


# --- a robot to watch -----------------------------------------------------------------------------------------------

WATCHED_S, WATCHED_TIMESTEP = 1.0, 0.004


def watched(scene: Scene) -> Recording:
    """The lab model with a longer time step, pushed and at rest: what every channel of its IMUs shows, step by step."""
    names = [name for imu in scene.imus for name in imu] + ([] if scene.own else ["torso_magnetometer"])
    saved = float(scene.lab.opt.timestep)
    timestep = min(saved, WATCHED_TIMESTEP) if scene.own else WATCHED_TIMESTEP
    scene.lab.opt.timestep = timestep
    try:
        pushed, still = _channels(scene.lab, names, PUSH), _channels(scene.lab, names, 0.0)
    finally:
        scene.lab.opt.timestep = saved
    scalars = {"duration_s": WATCHED_S, "timestep": timestep, "push_mps": PUSH, "sensors": names}
    return Recording("watched", first_line(watched), "lab", {"pushed": pushed, "still": still}, scalars)


def _channels(model: mujoco.MjModel, names: list[str], push: float) -> FloatArray:
    """Return readings (n, 3 × sensors) after each step from reset, with the robot pushed forward by `push` (m/s)."""
    starts = [int(model.sensor_adr[sensor_id(model, name)]) for name in names]
    columns = [start + axis for start in starts for axis in range(3)]
    data = mujoco.MjData(model)
    data.qvel[0] = push
    rows = np.zeros((round(WATCHED_S / model.opt.timestep) + 2, len(columns)))
    for row in rows:
        mujoco.mj_step(model, data)
        row[:] = data.sensordata[columns]
    return rows


EXTENSION_SCENARIOS: tuple[Callable[[Scene], Recording], ...] = (
    tilt_drifting,
    tilt_shaken,
    tilt_steep,
    tilt_start,
    allan,
    reading_many,
    watched,
)
