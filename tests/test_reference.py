"""The model solution does what the sheet asks, and can be handed in as it stands."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import mujoco
import pytest

import reference
from reference.imu_reader import sensor_id, simulate_and_collect
from reference.worlds import LAB_MODEL

FOLDER = Path(reference.__file__).parent


@pytest.fixture
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(LAB_MODEL))


def test_an_unknown_sensor_is_named_and_not_read_as_the_last_one(model: mujoco.MjModel) -> None:
    with pytest.raises(ValueError, match="the model has no sensor named 'torso_acelerometer'"):
        sensor_id(model, "torso_acelerometer")


def test_a_duration_that_floats_cannot_divide_loses_no_step(model: mujoco.MjModel) -> None:
    assert int(0.57 / 0.01) == 56  # what it guards against
    model.opt.timestep = 0.01
    assert len(simulate_and_collect(model, mujoco.MjData(model), 0.57)["time"]) == 57


def test_handed_in_as_loose_files_they_run_and_draw_what_the_sheet_asks_for(tmp_path: Path) -> None:
    names = ("imu_reader.py", "noisy_imu.py", "filters.py")
    (tmp_path / "models").mkdir()
    for path in (*(FOLDER / name for name in names), LAB_MODEL):
        shutil.copy(path, tmp_path / ("models" if path == LAB_MODEL else ""))
    done = subprocess.run(
        [sys.executable, "-c", f"import runpy\nfor name in {names}: runpy.run_path(name, run_name='__main__')"],
        cwd=tmp_path, env={**os.environ, "MPLBACKEND": "Agg", "PYTHONIOENCODING": "utf-8"},
        capture_output=True, encoding="utf-8", check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "torso_accelerometer: type=1, dim=3, address=5" in done.stdout
    assert "Difference (m/s²):" in done.stdout
    assert {path.name for path in tmp_path.glob("*.png")} == {"imu_data.png", "filtered_imu.png"}
