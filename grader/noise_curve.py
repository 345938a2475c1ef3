"""What the submission's own noise model is, by its Allan deviation: a curve for the report, which decides nothing."""

from __future__ import annotations

import numpy as np

from .compare import Array
from .conversation import Missing
from .diagnosis.allan import overlapping
from .errors import NoAnswer
from .results import NoiseCurve
from .student import Student
from .traces import Traces

_READS = 2000
_TIMES = 24


def noise_curve(student: Student, truth: Traces) -> NoiseCurve | None:
    """Allan deviation of readings of the student's `NoisyIMU` at rest in one state; None where it cannot be read.

    Differences of neighbouring averages are all that counts, so that neither the state nor the bias shows in the curve.
    """
    scenario = truth["noise"]
    stds = float(scenario.scalars["accel_noise_std"]), float(scenario.scalars["gyro_noise_std"])
    accel, gyro = (int(i) for i in truth["reading_lab"]["pairs"][0])
    try:
        run = student.noise(
            "allan", qpos=scenario["qpos"][:1], qvel=scenario["qvel"][:1], ids=(accel, gyro), reads=_READS, stds=stds,
            biases=(scenario["accel_bias"], scenario["gyro_bias"]),
        )  # fmt: skip
    except (Missing, NoAnswer):
        return None
    if run.fault is not None or not (np.isfinite(run.accel).all() and np.isfinite(run.gyro).all()):
        return None
    dt = float(truth["push"].scalars["timestep"])
    sizes = np.unique(np.geomspace(1, _READS // 10, _TIMES).round().astype(int))
    return NoiseCurve(
        taus_s=tuple(_short(m * dt) for m in sizes),
        acceleration=tuple(_mean_deviation(run.accel[0], int(m)) for m in sizes),
        angular_velocity=tuple(_mean_deviation(run.gyro[0], int(m)) for m in sizes),
        asked_for=stds,
    )


def _mean_deviation(samples: Array, m: int) -> float:
    """Root mean square over the three axes of (n, 3) samples."""
    return _short(float(np.sqrt(np.mean([overlapping(column, m) ** 2 for column in samples.T]))))


def _short(value: float) -> float:
    return float(f"{value:.6g}")
