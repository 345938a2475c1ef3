"""The model solution does what the sheet asks and can be handed in as it stands; the lab's model is what the sheet promises."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest

import reference
from reference.imu_reader import sensor_id, simulate_and_collect
from reference.scenarios import roll
from reference.scene import LAB_PAIR
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


# --- the lab's model ---


def test_the_robot_is_free_and_has_more_than_twenty_joints_no_controller_and_no_other_file(
    model: mujoco.MjModel,
) -> None:
    kinds = list(model.jnt_type)
    assert kinds[0] == mujoco.mjtJoint.mjJNT_FREE
    assert kinds[1:].count(mujoco.mjtJoint.mjJNT_HINGE) >= 20
    assert model.nu == 0
    assert not re.search(r"\bfile\s*=|<include|<mesh|<texture", LAB_MODEL.read_text(encoding="utf-8"))


@pytest.mark.parametrize("timestep", [0.002, 0.001, 0.004])
def test_standing_reads_gravity_from_the_first_step_on_for_five_seconds(model: mujoco.MjModel, timestep: float) -> None:
    model.opt.timestep = timestep
    trace = roll(model, mujoco.MjData(model), round(5.0 / timestep), LAB_PAIR)
    assert np.abs(trace["acceleration"] - [0.0, 0.0, -9.81]).max() < 1e-3  # promised: 0.1
    assert np.abs(trace["angular_velocity"]).max() < 1e-5


def test_the_push_makes_it_sway_and_it_stays_up(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    push = simulate_and_collect(model, data, duration_seconds=8.0)
    assert np.abs(push["angular_velocity"][:, 1]).max() > 0.3
    assert np.ptp(push["acceleration"][:, 0]) > 1.0
    assert data.qpos[2] == pytest.approx(float(model.qpos0[2]), abs=1e-3)
    assert np.abs(data.qvel).max() < 0.01


def test_the_torso_imu_looks_forward_right_down(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    axes = data.site("torso_imu").xmat.reshape(3, 3).T
    np.testing.assert_allclose(axes, [[1, 0, 0], [0, -1, 0], [0, 0, -1]], atol=1e-12)
