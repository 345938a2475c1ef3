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
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import reference
from grader.engine.traces import Scenario
from grader.labs.imu.bundles import shipped
from reference.imu_reader import get_imu_readings, sensor_id, simulate_and_collect
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


@pytest.mark.slow
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


# --- what the sensors must read, worked out by hand, then checked against the motion of the site itself ---

G = 9.81
FloatArray = NDArray[np.float64]
TRUTH = shipped()
BOARD = f"""<mujoco><option gravity="0 0 -{G}"/>
<worldbody><body><geom size="0.1" mass="1"/><site name="imu" %s/></body></worldbody>
<sensor><accelerometer name="accel" site="imu"/><gyro name="gyro" site="imu"/></sensor></mujoco>"""


@pytest.mark.parametrize(
    ("mounting", "expected"),
    [
        ("", [0, 0, G]),
        ('quat="0 1 0 0"', [0, 0, -G]),  # forward-right-down, as the lab's torso
        ('quat="0.7071067811865476 0.7071067811865476 0 0"', [0, G, 0]),  # y turned up
        ('quat="0.7071067811865476 0 -0.7071067811865476 0"', [G, 0, 0]),  # x turned up
    ],
)
def test_a_board_at_rest_reads_the_push_that_holds_it_up_along_the_axis_that_points_up(
    mounting: str, expected: list[float]
) -> None:
    model = mujoco.MjModel.from_xml_string(BOARD % mounting)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    accel, gyro = get_imu_readings(model, data, sensor_id(model, "accel"), sensor_id(model, "gyro"))
    np.testing.assert_allclose(accel, expected, atol=1e-12)
    np.testing.assert_allclose(gyro, 0.0, atol=1e-15)


def test_in_free_fall_all_channels_read_zero() -> None:
    np.testing.assert_allclose(TRUTH["free_fall"].acceleration, 0.0, atol=1e-12)
    np.testing.assert_allclose(TRUTH["free_fall"].angular_velocity, 0.0, atol=1e-12)


def test_a_site_off_the_axis_of_a_constant_spin_reads_the_centripetal_acceleration_inward() -> None:
    spin = TRUTH["constant_spin"]
    omega, radius = spin.scalars["angular_velocity_rad_s"], spin.scalars["radius_m"]
    inward = [-(omega**2) * radius, 0.0, G]  # x points away from the axis
    np.testing.assert_allclose(spin.acceleration, np.tile(inward, (len(spin.time), 1)), atol=1e-9)
    np.testing.assert_allclose(spin.angular_velocity, np.tile([0.0, 0.0, omega], (len(spin.time), 1)), atol=1e-12)


# --- finite differences ---------------------------------------------------------------------------------------------


def pose_after(model: mujoco.MjModel, scenario: Scenario, state: int, h: float) -> tuple[FloatArray, FloatArray]:
    """Positions (p, 3) and attitudes (p, 3, 3) of the IMU sites `h` seconds on, to second order in `h`.

    Only kinematics: the state's position is moved along its velocity and acceleration, forward or back in time.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = scenario.qpos[state]
    mujoco.mj_integratePos(model, data.qpos, scenario.qvel[state] + h / 2 * scenario.qacc[state], h)
    mujoco.mj_kinematics(model, data)
    sites = model.sensor_objid[scenario.pairs[:, 0]]
    return np.array(data.site_xpos[sites]), np.array(data.site_xmat[sites]).reshape(-1, 3, 3)


def felt_by_differences(
    model: mujoco.MjModel, scenario: Scenario, state: int, h: float
) -> tuple[FloatArray, FloatArray]:
    """Specific force and angular rate (p, 3) of every site in its own frame, from three poses `h` apart."""
    (before, turned_back), (now, attitude), (after, turned_on) = (
        pose_after(model, scenario, state, step) for step in (-h, 0.0, h)
    )
    pull = np.array(scenario.scalars["gravity"])
    force = np.einsum("pji,pj->pi", attitude, (after - 2 * now + before) / h**2 - pull)
    turned = Rotation.from_matrix(np.swapaxes(turned_back, 1, 2) @ turned_on)
    return force, turned.as_rotvec() / (2 * h)


def stored(scenario: Scenario, state: int) -> tuple[FloatArray, FloatArray]:
    """The readings in the bundle, (p, 3) each."""
    starts = scenario.sensor_adr[scenario.pairs]
    rows = scenario.sensordata[state][starts[..., None] + np.arange(3)]
    return rows[:, 0], rows[:, 1]


def largest_difference(name: str, h: float) -> FloatArray:
    """Over all states and sites: of the specific force and of the angular rate."""
    scenario, model = TRUTH[name], mujoco.MjModel.from_xml_string(TRUTH.models[TRUTH[name].model or ""])
    worst = np.zeros(2)
    for state in range(len(scenario.qpos)):
        pairs = zip(stored(scenario, state), felt_by_differences(model, scenario, state, h), strict=True)
        worst = np.maximum(worst, [np.abs(read - differenced).max() for read, differenced in pairs])
    return worst


@pytest.mark.parametrize("name", ["reading_lab", "reading_shuffled"])
def test_every_reading_is_the_second_difference_of_its_site_and_the_rate_of_its_attitude(name: str) -> None:
    # The error of the differences falls with the square of the step until round-off, about 1e-16 · 4 m / h², is larger.
    coarse, fine = (largest_difference(name, h) for h in (4e-4, 1e-4))
    assert (fine < [5e-3, 1e-4]).all(), fine
    np.testing.assert_allclose(coarse / fine, 16.0, rtol=0.05)
