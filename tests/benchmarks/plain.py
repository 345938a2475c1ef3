"""Plain pytest, as many courses grade: fifteen simple assertions, a fresh process for each submission.

pytest tests/benchmarks/plain.py, in the submission's folder. Nothing is isolated and no fault is named.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import Any

import matplotlib

matplotlib.use("Agg")

import mujoco
import numpy as np
import pytest

from grader.labs.imu.bundles import shipped

sys.path.insert(0, os.getcwd())
import filters  # type: ignore[import-not-found]
import imu_reader  # type: ignore[import-not-found]
import noisy_imu  # type: ignore[import-not-found]


@pytest.fixture(scope="module")
def run() -> dict[str, Any]:
    """What the student's functions return, by name."""
    model = mujoco.MjModel.from_xml_string(shipped().models["lab"])
    mujoco.MjModel.from_xml_path = staticmethod(lambda _: model)
    ids = [model.sensor(f"torso_{kind}").id for kind in ("accelerometer", "gyroscope")]
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    reading = imu_reader.get_imu_readings(model, data, *ids)
    series = imu_reader.simulate_and_collect(model, mujoco.MjData(model), 3.0)
    mujoco.mj_forward(model, data)
    sensor = noisy_imu.NoisyIMU(model, data, *ids, 0.05, 0.005, np.zeros(3), np.zeros(3))
    noise = np.array([sensor.read() for _ in range(1000)])
    jump, smooth = filters.LowPassFilter(0.1), filters.LowPassFilter(0.1)
    first, second = jump.update(np.zeros(3)), jump.update(np.ones(3))
    smoothed = [smooth.update(row) for row in noise[:, 0]]
    imu_reader.plot_imu_data(series)
    return {
        "reading": reading,
        "keys": set(series),
        "gap_s": 3.0 - len(series["time"]) * model.opt.timestep,
        "step_s": model.opt.timestep,
        **{name: np.asarray(series[name]) for name in ("time", "acceleration", "angular_velocity")},
        "noise": noise,
        "filtered": (first, second),
        "smoothed": smoothed,
    }


CHECKS: dict[str, Callable[[dict[str, Any]], Any]] = {
    "reading has a shape": lambda run: np.shape(run["reading"]) == (2, 3),
    "reading of rest": lambda run: np.allclose(run["reading"][0], [0, 0, -9.81], atol=0.1),
    "gyroscope of rest": lambda run: np.allclose(run["reading"][1], 0, atol=0.1),
    "series has keys": lambda run: {"time", "acceleration", "angular_velocity"} <= run["keys"],
    "series has samples": lambda run: abs(run["gap_s"]) <= 1.5 * run["step_s"],
    "time grows": lambda run: np.all(np.diff(run["time"]) > 0),
    "mean of z": lambda run: abs(run["acceleration"][:, 2].mean() + 9.81) < 0.1,
    "push shows": lambda run: np.ptp(run["angular_velocity"]) > 0.01,
    "size of the noise": lambda run: np.allclose(run["noise"][:, 0].std(axis=0), 0.05, rtol=0.2),
    "size of the gyroscope's noise": lambda run: np.allclose(run["noise"][:, 1].std(axis=0), 0.005, rtol=0.2),
    "noise has no bias": lambda run: np.allclose(run["noise"][:, 1].mean(axis=0), 0, atol=0.01),
    "filter starts at the first value": lambda run: np.allclose(run["filtered"][0], 0),
    "filter follows": lambda run: np.allclose(run["filtered"][1], 0.1),
    "filter smooths": lambda run: np.std(run["smoothed"]) < 5,
    "plot is saved": lambda run: os.path.exists("imu_data.png"),
}


@pytest.mark.parametrize("check", CHECKS)
def test_plain(check, run):
    assert CHECKS[check](run)
