"""What the lab sheet promises of its model, and what the grader needs of it."""

from __future__ import annotations

import re

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from reference import balance, worlds
from reference.imu_reader import sensor_id, simulate_and_collect
from reference.scenarios import roll
from reference.scene import LAB_PAIR
from reference.worlds import LAB_MODEL

FloatArray = NDArray[np.float64]
STANDING = [0.0, 0.0, -9.81]


@pytest.fixture
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(LAB_MODEL))


@pytest.fixture(scope="module")
def push() -> dict[str, FloatArray]:
    """The sheet's Step 3, five seconds of it."""
    model = mujoco.MjModel.from_xml_path(str(LAB_MODEL))
    return simulate_and_collect(model, mujoco.MjData(model), duration_seconds=5.0)


def imus(model: mujoco.MjModel) -> list[tuple[int, int]]:
    """Ids of accelerometer and gyroscope, place by place."""
    return [
        (sensor_id(model, f"{place}_accelerometer"), sensor_id(model, f"{place}_gyroscope"))
        for place in worlds.LAB_PLACES
    ]


def test_the_sheet_finds_the_sensors_that_it_expects(model: mujoco.MjModel) -> None:
    for accel, gyro in imus(model):
        assert (model.sensor_type[accel], model.sensor_dim[accel]) == (mujoco.mjtSensor.mjSENS_ACCELEROMETER, 3)
        assert (model.sensor_type[gyro], model.sensor_dim[gyro]) == (mujoco.mjtSensor.mjSENS_GYRO, 3)
    assert len({model.sensor_objid[accel] for accel, _ in imus(model)}) == 4


def test_the_robot_is_free_and_has_more_than_twenty_joints_and_no_controller(model: mujoco.MjModel) -> None:
    kinds = list(model.jnt_type)
    assert kinds[0] == mujoco.mjtJoint.mjJNT_FREE
    assert kinds[1:].count(mujoco.mjtJoint.mjJNT_HINGE) >= 20
    assert model.nu == 0


def test_the_model_needs_no_other_file() -> None:
    assert not re.search(r"\bfile\s*=|<include|<mesh|<texture", LAB_MODEL.read_text(encoding="utf-8"))


def test_for_every_imu_sensor_the_id_is_not_its_address(model: mujoco.MjModel) -> None:
    assert all(model.sensor_adr[sensor] != sensor for pair in imus(model) for sensor in pair)


def test_no_gyroscope_follows_its_accelerometer_directly(model: mujoco.MjModel) -> None:
    assert all(model.sensor_adr[gyro] != model.sensor_adr[accel] + 3 for accel, gyro in imus(model))


def test_the_initial_pose_is_the_equilibrium(model: mujoco.MjModel) -> None:
    assert np.abs(balance.missing_forces(model)).max() < 1e-3  # N or N m, of a weight of 350 N
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert np.abs(data.qacc).max() < 1e-2


@pytest.mark.parametrize("timestep", [0.002, 0.001, 0.0025, 0.004])
def test_standing_reads_gravity_from_the_first_step_on_for_five_seconds(model: mujoco.MjModel, timestep: float) -> None:
    model.opt.timestep = timestep
    trace = roll(model, mujoco.MjData(model), round(5.0 / timestep), LAB_PAIR)
    assert np.abs(trace["acceleration"] - STANDING).max() < 1e-3  # promised: 0.1
    assert np.abs(trace["angular_velocity"]).max() < 1e-5


def test_the_push_makes_it_sway(push: dict[str, FloatArray]) -> None:
    assert np.abs(push["angular_velocity"][:, 1]).max() > 0.3
    assert np.ptp(push["acceleration"][:, 0]) > 1.0


def test_after_the_push_it_stays_up(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    height, up = float(model.qpos0[2]), []
    data.qvel[0] = 0.5
    for _ in range(4000):
        mujoco.mj_step(model, data)
        up.append(data.qpos[2])
    assert min(up) > 0.95 * height
    assert data.qpos[2] == pytest.approx(height, abs=1e-3)
    assert np.abs(data.qvel).max() < 0.01


def test_the_torso_imu_looks_forward_right_down(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    axes = data.site("torso_imu").xmat.reshape(3, 3).T
    np.testing.assert_allclose(axes, [[1, 0, 0], [0, -1, 0], [0, 0, -1]], atol=1e-12)
