"""What was recorded from the public lab model earns nothing but form under a secret."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import pytest

from grader.engine import traces
from grader.engine.grader import Marker
from grader.engine.results import Result
from grader.labs.imu import bundles
from grader.labs.imu.lab_copies import STUDENTS_IDS, STUDENTS_TIMESTEP, with_graded_robot
from tests.corpus import pieces
from tests.corpus.cases import Case, of
from tests.sandboxes import Opened
from tests.single_faults import lost_by, marked, thinned

COLLECT = pieces.part("steps", "recorder")
MOST = 8.0  # of 20: keys, counts and stamps, or a shape, a copy and a hand off the simulation
SHEET_PATH = "textbook/assets/robot-models/mujoco/humanoid-sensors.xml"
LOSES = {
    "data_collection": {"sample_count", "matches_truth", "starts_from_reset", "applies_push"},
    "sensor_access": {"matches_truth", "follows_address"},
}


@pytest.fixture(scope="module")
def marker(hidden: traces.Traces, opened: Opened) -> Iterator[Marker]:
    with opened(hidden) as warm:
        yield warm


def lost(result: Result) -> set[str]:
    return {check.partition(".")[2] for check in lost_by(result)}


@pytest.mark.parametrize("case", thinned(of("replays"), 3))
def test_what_was_recorded_earns_its_form_alone(marker: Marker, case: Case) -> None:
    result = marked(marker, case.files, case.criterion)
    assert result.criteria[0].points <= MOST
    assert lost(result) == LOSES[case.criterion]


@pytest.mark.parametrize("treatment", ["np.round(accel, 1)", "accel + [0, 0, 9.81]", "accel / 9.81"])
def test_rows_that_are_altered_are_still_of_a_run_that_was_reset_and_pushed(marker: Marker, treatment: str) -> None:
    altered = COLLECT.replace("accelerations[i] = accel", f"accelerations[i] = {treatment}").replace(
        "angular_velocities[i] = gyro", "angular_velocities[i] = np.round(gyro, 2)"
    )
    files = pieces.edit(pieces.VERBATIM, "imu_reader.py", (COLLECT, altered))
    assert lost(marked(marker, files, "data_collection")) == {"matches_truth"}


@pytest.mark.parametrize("ending", [b"\n", b"\r\n"])
def test_a_handed_in_copy_of_the_lab_model_is_the_robot_that_is_graded_with(marker: Marker, ending: bytes) -> None:
    copy = bundles.shipped().models["lab"].encode().replace(b"\n", ending)
    result = marked(marker, {**pieces.VERBATIM, SHEET_PATH: copy, "model/robot.xml": copy}, "data_collection")
    assert (result.criteria[0].points, lost(result)) == (20.0, set())


def test_a_model_of_the_students_own_stays_as_it_is() -> None:
    ours = bundles.shipped().models["lab"].encode()
    files = {"a.xml": ours, "b.xml": ours.replace(b'mass="4.6"', b'mass="4.7"'), "c.txt": ours}
    meant = with_graded_robot(files, "<mujoco/>")
    assert meant == {**files, "a.xml": b"<mujoco/>"}


def test_the_students_ids_and_time_step_are_those_of_the_lab_model() -> None:
    model = mujoco.MjModel.from_xml_string(bundles.shipped().models["lab"])
    assert tuple(model.sensor(f"torso_{kind}").id for kind in ("accelerometer", "gyroscope")) == STUDENTS_IDS
    assert model.opt.timestep == STUDENTS_TIMESTEP


IDS = 'mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "torso_{}")'


@pytest.mark.parametrize(
    ("fault", "edits", "checks"),
    [
        ("hard-coded-address", {IDS.format("accelerometer"): "2", IDS.format("gyroscope"): "4"}, "matches_truth"),
        (
            "hard-coded-timestep",
            {"dt = model.opt.timestep": "dt = 0.002", "times[i] = data.time": "times[i] = (i + 1) * dt"},
            "sample_count time_axis",
        ),
    ],
)
def test_what_was_learnt_by_heart_from_the_public_model_is_named(
    marker: Marker, fault: str, edits: dict[str, str], checks: str
) -> None:
    result = marked(marker, pieces.edit(pieces.VERBATIM, "imu_reader.py", *edits.items()))
    assert (lost(result), result.misconceptions) == (set(checks.split()), (fault,))


@pytest.mark.parametrize("name", ["verbatim", "tidy", "listy", "looping"])
def test_sound_work_gets_everything_on_another_robot(marker: Marker, name: str) -> None:
    result = marked(marker, pieces.lab_of(name, {}))
    assert (result.score, lost(result)) == (100.0, set())
