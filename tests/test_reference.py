"""The model solution does what the sheet asks, and can be handed in as it stands."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest
from matplotlib.image import imread

import reference
from grader.engine.traces import Traces
from grader.labs.imu.bundles import shipped
from reference.imu_reader import sensor_id, simulate_and_collect
from reference.worlds import LAB_MODEL

FOLDER = Path(reference.__file__).parent


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


def test_an_unknown_sensor_is_named_and_not_read_as_the_last_one(model: mujoco.MjModel) -> None:
    with pytest.raises(ValueError, match="the model has no sensor named 'torso_acelerometer'"):
        sensor_id(model, "torso_acelerometer")


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


# --- filtering ------------------------------------------------------------------------------------------------------


def test_the_recorded_filter_outputs_are_a_digital_filter_of_order_one(truth: Traces) -> None:
    from scipy.signal import lfilter

    scenario = truth["filter"]
    starts = {"low_passed": scenario.input[0], "low_passed_from_initial": scenario.initial}
    for key, start in starts.items():
        for alpha, recorded in zip(scenario.alpha, scenario[key], strict=True):
            state = (1 - alpha) * start[None, :]
            expected, _ = lfilter([alpha], [1, alpha - 1], scenario.input, axis=0, zi=state)
            np.testing.assert_allclose(recorded, expected, atol=1e-12, err_msg=key)


# --- pictures and hand-in -------------------------------------------------------------------------------------------


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
