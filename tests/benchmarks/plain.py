"""Plain pytest, as many courses grade: fifteen simple assertions, a fresh process for each submission.

pytest tests/benchmarks/plain.py, in the submission's folder. Nothing is isolated and no mistake is named.
"""

from __future__ import annotations

import os
import sys

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
def model():
    lab = mujoco.MjModel.from_xml_string(shipped().models["lab"])
    mujoco.MjModel.from_xml_path = staticmethod(lambda _: lab)
    return lab


@pytest.fixture(scope="module")
def ids(model):
    return [model.sensor(f"torso_{kind}").id for kind in ("accelerometer", "gyroscope")]


@pytest.fixture(scope="module")
def series(model):
    return imu_reader.simulate_and_collect(model, mujoco.MjData(model), 3.0)


@pytest.fixture(scope="module")
def noise(model, ids):
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    sensor = noisy_imu.NoisyIMU(model, data, *ids, 0.05, 0.005, np.zeros(3), np.zeros(3))
    return np.array([sensor.read() for _ in range(1000)])


@pytest.fixture(scope="module")
def reading(model, ids):
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    return imu_reader.get_imu_readings(model, data, *ids)


def test_reading_has_shape(reading):
    assert np.shape(reading) == (2, 3)


def test_reading_of_rest(reading):
    assert np.allclose(reading[0], [0, 0, -9.81], atol=0.1)


def test_gyro_of_rest(reading):
    assert np.allclose(reading[1], 0, atol=0.1)


def test_series_has_keys(series):
    assert {"time", "acceleration", "angular_velocity"} <= set(series)


def test_series_has_samples(series, model):
    assert abs(len(series["time"]) - 3.0 / model.opt.timestep) <= 1


def test_time_grows(series):
    assert np.all(np.diff(series["time"]) > 0)


def test_mean_of_z(series):
    assert abs(np.mean(np.asarray(series["acceleration"])[:, 2]) + 9.81) < 0.1


def test_push_shows(series):
    assert np.ptp(np.asarray(series["angular_velocity"])) > 0.01


def test_noise_size(noise):
    assert np.allclose(noise[:, 0].std(axis=0), 0.05, rtol=0.2)


def test_gyro_noise_size(noise):
    assert np.allclose(noise[:, 1].std(axis=0), 0.005, rtol=0.2)


def test_noise_has_no_bias(noise):
    assert np.allclose(noise[:, 1].mean(axis=0), 0, atol=0.01)


def test_filter_starts_at_first():
    assert np.allclose(filters.LowPassFilter(0.1).update(np.ones(3)), 1)


def test_filter_follows():
    low_pass = filters.LowPassFilter(0.1)
    low_pass.update(np.zeros(3))
    assert np.allclose(low_pass.update(np.ones(3)), 0.1)


def test_filter_smooths(noise):
    low_pass = filters.LowPassFilter(0.1)
    assert np.std([low_pass.update(row) for row in noise[:, 0]]) < 5


def test_plot_is_saved(series):
    imu_reader.plot_imu_data(series)
    assert os.path.exists("imu_data.png")
