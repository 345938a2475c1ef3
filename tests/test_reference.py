"""The model solution does what the sheet asks, and can be handed in as it stands."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import mujoco
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from numpy.typing import NDArray

import reference
from grader.engine.traces import Traces
from grader.labs.imu.bundles import shipped
from reference.filters import LowPassFilter, plot_comparison
from reference.imu_reader import get_imu_readings, list_sensors, plot_imu_data, sensor_id, simulate_and_collect
from reference.noisy_imu import NoisyIMU
from reference.worlds import LAB_MODEL

FOLDER = Path(reference.__file__).parent
FloatArray = NDArray[np.float64]


@pytest.fixture(scope="module")
def truth() -> Traces:
    return shipped()


@pytest.fixture
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(LAB_MODEL))


@pytest.fixture
def handed_in(tmp_path: Path) -> Path:
    """The sheet's three files alone, as a student's folder."""
    for name in ("imu_reader.py", "noisy_imu.py", "filters.py"):
        shutil.copy(FOLDER / name, tmp_path / name)
    (tmp_path / "models").mkdir()
    shutil.copy(LAB_MODEL, tmp_path / "models" / "humanoid-sensors.xml")
    return tmp_path


def run(folder: Path, *arguments: str) -> str:
    environment = {**os.environ, "MPLBACKEND": "Agg", "PYTHONIOENCODING": "utf-8"}
    command = [sys.executable, *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, encoding="utf-8", check=False, env=environment)
    assert done.returncode == 0, done.stderr
    return done.stdout


# --- reading --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["reading_lab", "reading_shuffled"])
def test_the_reader_returns_what_the_simulator_computed_for_the_ids_it_was_given(truth: Traces, name: str) -> None:
    scenario = truth[name]
    model = mujoco.MjModel.from_xml_string(truth.models[scenario.model or ""])
    data = mujoco.MjData(model)
    for row in scenario.sensordata:
        data.sensordata[:] = row
        for accel, gyro in scenario.pairs:
            got = get_imu_readings(model, data, accel, gyro)
            expected = (row[scenario.sensor_adr[i] : scenario.sensor_adr[i] + 3] for i in (accel, gyro))
            for reading, want in zip(got, expected, strict=True):
                np.testing.assert_array_equal(reading, want)


def test_a_reading_stays_when_the_simulation_steps_on(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    accel, gyro = get_imu_readings(model, data, 2, 4)
    data.sensordata[:] = 7.0
    assert accel[2] == pytest.approx(-9.81, abs=0.1)
    assert np.abs(gyro).max() < 0.1


def test_an_unknown_sensor_is_named_and_not_read_as_the_last_one(model: mujoco.MjModel) -> None:
    with pytest.raises(ValueError, match="the model has no sensor named 'torso_acelerometer'"):
        sensor_id(model, "torso_acelerometer")


def test_the_list_has_one_line_a_sensor_in_the_order_of_the_model(model: mujoco.MjModel) -> None:
    lines = list_sensors(model)
    assert len(lines) == model.nsensor
    assert lines[2] == "torso_accelerometer: type=1, dim=3, address=5"


# --- collecting -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["push", "push_dirty"])
def test_collecting_gives_the_recorded_truth_whatever_was_in_the_data(truth: Traces, name: str) -> None:
    scenario = truth[name]
    model = mujoco.MjModel.from_xml_string(truth.models["lab"])
    model.opt.timestep = scenario.scalars["timestep"]
    data = mujoco.MjData(model)
    if "dirty_qpos" in scenario:
        data.qpos[:], data.qvel[:], data.time = scenario.dirty_qpos, scenario.dirty_qvel, float(scenario.dirty_time)
    got = simulate_and_collect(model, data, duration_seconds=scenario.scalars["duration_s"])
    n = scenario.scalars["n_steps"]
    assert {key: value.shape for key, value in got.items()} == {
        "time": (n,), "acceleration": (n, 3), "angular_velocity": (n, 3)
    }  # fmt: skip
    for key, value in got.items():
        np.testing.assert_allclose(value, scenario[key][:n], atol=1e-5, err_msg=key)


def test_a_duration_that_floats_cannot_divide_loses_no_step(model: mujoco.MjModel) -> None:
    assert int(0.57 / 0.01) == 56  # what it guards against
    model.opt.timestep = 0.01
    assert len(simulate_and_collect(model, mujoco.MjData(model), 0.57)["time"]) == 57


# --- noise ----------------------------------------------------------------------------------------------------------


def noisy_samples(model: mujoco.MjModel, n: int, **arguments: float | list[float]) -> tuple[FloatArray, FloatArray]:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    imu = NoisyIMU(model, data, 2, 4, **arguments)  # type: ignore[arg-type]
    readings = [imu.read() for _ in range(n)]
    clean = get_imu_readings(model, data, 2, 4)
    return tuple(np.array([reading[i] for reading in readings]) - clean[i] for i in range(2))  # type: ignore[return-value]


def test_the_noise_has_the_asked_size_on_every_axis_and_the_bias_is_added(model: mujoco.MjModel) -> None:
    n = 2000
    bias = {"accel_bias": [1.0, -2.0, 0.5], "gyro_bias": [0.1, 0.2, -0.3]}
    for samples, std, offset in zip(
        noisy_samples(model, n, accel_noise_std=0.2, gyro_noise_std=0.03, **bias),
        (0.2, 0.03),
        bias.values(),
        strict=True,
    ):
        # Six standard errors: std/√n of the mean, std/√2n of the standard deviation; missed by chance once in 1e8.
        np.testing.assert_allclose(samples.mean(axis=0), offset, atol=6 * std / np.sqrt(n))
        np.testing.assert_allclose(samples.std(axis=0), std, atol=6 * std / np.sqrt(2 * n))
        assert np.abs(np.corrcoef(samples.T)[np.triu_indices(3, 1)]).max() < 6 / np.sqrt(n)
        assert np.abs(np.corrcoef(samples[:-1, 0], samples[1:, 0])[0, 1]) < 6 / np.sqrt(n)


def test_without_noise_the_given_bias_is_all_there_is_even_if_it_is_zero(model: mujoco.MjModel) -> None:
    accel, gyro = noisy_samples(
        model, 3, accel_noise_std=0.0, gyro_noise_std=0.0, accel_bias=[0.0, 0.0, 0.0], gyro_bias=[0.0, 0.01, 0.0]
    )
    np.testing.assert_array_equal(accel, 0.0)
    np.testing.assert_allclose(gyro, np.tile([0.0, 0.01, 0.0], (3, 1)), atol=1e-15)


def test_every_device_has_its_own_bias_of_the_size_on_the_sheet(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    devices = [NoisyIMU(model, data, 2, 4) for _ in range(300)]
    accel, gyro = np.array([d.accel_bias for d in devices]), np.array([d.gyro_bias for d in devices])
    # 900 normal numbers each: six standard errors of a standard deviation are 6/√1800 = 14 %.
    assert accel.std() == pytest.approx(0.1, rel=0.15)
    assert gyro.std() == pytest.approx(0.01, rel=0.15)


def test_reading_noise_leaves_the_simulation_alone(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    before = np.array(data.sensordata)
    NoisyIMU(model, data, 2, 4).read()
    np.testing.assert_array_equal(data.sensordata, before)


def test_changing_the_array_that_was_given_as_bias_changes_nothing(model: mujoco.MjModel) -> None:
    bias = np.ones(3)
    imu = NoisyIMU(model, mujoco.MjData(model), 2, 4, accel_bias=bias)
    bias[:] = 5.0
    np.testing.assert_array_equal(imu.accel_bias, 1.0)


# --- filtering ------------------------------------------------------------------------------------------------------


def test_the_filter_is_the_recursion_worked_by_hand() -> None:
    smoother = LowPassFilter(alpha=0.25)
    assert [float(smoother.update(np.array(x))) for x in (4.0, 8.0, 0.0)] == [4.0, 5.0, 3.75]


def test_the_filter_starts_from_a_given_initial_value() -> None:
    smoother = LowPassFilter(alpha=0.25, initial_value=np.array([0.0, 8.0]))
    np.testing.assert_array_equal(smoother.update(np.array([4.0, 4.0])), [1.0, 7.0])


def test_the_recorded_filter_outputs_are_a_digital_filter_of_order_one(truth: Traces) -> None:
    from scipy.signal import lfilter

    scenario = truth["filter"]
    starts = {"low_passed": scenario.input[0], "low_passed_from_initial": scenario.initial}
    for key, start in starts.items():
        for alpha, recorded in zip(scenario.alpha, scenario[key], strict=True):
            state = (1 - alpha) * start[None, :]
            expected, _ = lfilter([alpha], [1, alpha - 1], scenario.input, axis=0, zi=state)
            np.testing.assert_allclose(recorded, expected, atol=1e-12, err_msg=key)


def test_the_filter_reduces_noise_and_keeps_the_signal(truth: Traces) -> None:
    scenario = truth["filter"]
    smoother = LowPassFilter(alpha=0.2)
    filtered = np.array([smoother.update(sample) for sample in scenario.acceleration])
    noise = scenario.acceleration - scenario.acceleration_clean
    clean = LowPassFilter(alpha=0.2)
    left = filtered - np.array([clean.update(sample) for sample in scenario.acceleration_clean])
    assert (left[20:].std(axis=0) < 0.5 * noise.std(axis=0)).all()  # in theory √(α/(2−α)) = 1/3 of it
    assert np.abs(filtered - scenario.acceleration_clean)[150:190].mean() < 0.2


def test_what_the_caller_does_to_input_or_output_does_not_reach_the_filter() -> None:
    smoother = LowPassFilter(alpha=0.5)
    measurement = np.array([2.0, 2.0])
    first = smoother.update(measurement)
    measurement[:], first[:] = 100.0, -100.0
    np.testing.assert_array_equal(smoother.update(np.array([4.0, 4.0])), [3.0, 3.0])


# --- pictures and hand-in -------------------------------------------------------------------------------------------


def test_the_plot_is_saved_and_labelled(truth: Traces, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    kept: list[Figure] = []
    monkeypatch.setattr(plt, "close", lambda what: kept.append(what) if isinstance(what, Figure) else None)
    plot_imu_data({key: truth["push"][key] for key in ("time", "acceleration", "angular_velocity")})
    plot_comparison(truth["filter"].input[:, 2], truth["filter"].low_passed[0, :, 2])
    monkeypatch.undo()
    upper, lower, comparison = (axes for figure in kept for axes in figure.axes)
    for figure in kept:
        plt.close(figure)
    assert [axes.get_ylabel() for axes in (upper, lower)] == ["Acceleration (m/s²)", "Angular velocity (rad/s)"]
    assert [axes.get_xlabel() for axes in (upper, lower, comparison)] == ["Time (s)", "Time (s)", "Sample"]
    assert [text.get_text() for text in upper.get_legend().get_texts()] == ["X", "Y", "Z", "Gravity"]
    np.testing.assert_array_equal(lower.get_lines()[2].get_ydata(), truth["push"].angular_velocity[:, 2])
    for name in ("imu_data.png", "filtered_imu.png"):
        assert imread(tmp_path / name).std() > 0.01


def test_handed_in_as_loose_files_they_run_and_draw_what_the_sheet_asks_for(handed_in: Path) -> None:
    names = ("imu_reader.py", "noisy_imu.py", "filters.py")
    printed = run(handed_in, "-c", f"import runpy\nfor name in {names}: runpy.run_path(name, run_name='__main__')")
    assert "torso_accelerometer: type=1, dim=3, address=5" in printed
    assert "Difference (m/s²):" in printed
    assert {path.name for path in handed_in.glob("*.png")} == {"imu_data.png", "filtered_imu.png"}


def test_the_pictures_that_come_with_it_are_there_and_small() -> None:
    for name in ("imu_data.png", "filtered_imu.png"):
        assert imread(FOLDER / name).std() > 0.01
        assert (FOLDER / name).stat().st_size < 80_000
