"""What the lab sheet promises of its model, and what the grader needs of it."""

from __future__ import annotations

import re

import mujoco
import numpy as np
import pytest

from reference.imu_reader import simulate_and_collect
from reference.scenarios import roll
from reference.scene import LAB_PAIR
from reference.worlds import LAB_MODEL

STANDING = [0.0, 0.0, -9.81]


@pytest.fixture
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(LAB_MODEL))


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
    assert np.abs(trace["acceleration"] - STANDING).max() < 1e-3  # promised: 0.1
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
