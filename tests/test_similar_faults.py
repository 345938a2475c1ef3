"""Tests of faults with the symptom of a known fault and another cause: name, message and hint are true of each of them."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from grader.engine.results import CheckResult, Result
from tests.corpus.sheet import VERBATIM
from tests.recordings import Marking
from tests.single_faults import Changes, changed, lost_by, marked

READER, NOISY, FILTER = "imu_reader.py", "noisy_imu.py", "filters.py"
UPDATE = """\
        if self.value is None:
            self.value = measurement.copy()
        else:
            self.value = self.alpha * measurement + (1 - self.alpha) * self.value
        return self.value.copy()
"""
ACCEL = "accel_adr = model.sensor_adr[accel_sensor_id]"
GYRO = "gyro_adr = model.sensor_adr[gyro_sensor_id]"
COUNT = "n_steps = int(duration_seconds / dt)"
KEEPS_INPUT = {"self.value = measurement.copy()": "self.value = measurement"}
IN_PLACE = {
    "self.value = self.alpha * measurement + (1 - self.alpha) * self.value": (
        "self.value *= 1 - self.alpha\n            self.value += self.alpha * measurement"
    )
}
GIVES_STATE = {"return self.value.copy()": "return self.value"}


@dataclass(frozen=True)
class Cousin:
    """A changed file of the sheet's solution: what it loses, the faults that are named, and parts of what a student reads."""

    name: str
    path: str
    changes: Changes
    lost: dict[str, float]
    named: tuple[str, ...]
    got: str
    hint: str


def _address(name: str, changes: Changes, named: str, got: str, hint: str) -> Cousin:
    return Cousin(name, READER, changes, {"sensor_access.follows_address": 6.0}, (named,) if named else (), got, hint)


def _count(name: str, count: str, named: tuple[str, ...]) -> Cousin:
    return Cousin(name, READER, {COUNT: count}, {"data_collection.sample_count": 2.0}, named, " samples", BOTH)


def _label(name: str, right: str, wrong: str, got: str, hint: str) -> Cousin:
    return Cousin(
        name,
        READER,
        {right: wrong},
        {"visualization.axis_labels_with_units": 1.0},
        ("no-units",),
        f"“{wrong}” on the y axis, {got}",
        hint,
    )


def _curve(
    name: str, right: str, wrong: str, got: str, hint: str = "Compare key, column, label and unit of each curve"
) -> Cousin:
    changes = {f"imu_data['{right}'][:, 2]": wrong}
    return Cousin(name, READER, changes, {"visualization.curves_match_data": 4.0}, ("wrong-data-plotted",), got, hint)


def _alias(name: str, changes: Changes, *named: str, hint: str) -> Cousin:
    return Cousin(name, FILTER, changes, {"filtering.instances_independent": 1.5}, named, "", hint)


BY_IDS = "Compute both places from the ids that are given, with model.sensor_adr[id]"
NO_ADDRESSES = "The id and 3 * id are not addresses"
BOTH = "int(duration_seconds / model.opt.timestep)"
STEP = "        mujoco.mj_step(model, data)\n"
ALL_OF_FILTERING = {
    "filtering.follows_recursion": 6.0, "filtering.starts_from_first_measurement": 3.0, "filtering.passes_constant": 3.0,
    "filtering.reduces_noise": 3.0, "filtering.preserves_signal": 2.0, "filtering.instances_independent": 3.0,
}  # fmt: skip
COUSINS = [
    # what is looked up in sensordata
    _address(
        "the sizes up to the sensor's own, added up",
        {ACCEL: "accel_adr = int(np.cumsum(model.sensor_dim)[accel_sensor_id])", GYRO: "gyro_adr = int(np.cumsum(model.sensor_dim)[gyro_sensor_id])"},
        "", "accel = ", "start each slice at model.sensor_adr[id]",
    ),
    _address("the id", {ACCEL: "accel_adr = accel_sensor_id", GYRO: "gyro_adr = gyro_sensor_id"}, "sensor-id-as-address", "accel = ", NO_ADDRESSES),
    _address("three times the id", {ACCEL: "accel_adr = 3 * accel_sensor_id", GYRO: "gyro_adr = 3 * gyro_sensor_id"}, "sensor-id-as-address", "accel = ", NO_ADDRESSES),
    _address("the gyroscope's id", {GYRO: "gyro_adr = gyro_sensor_id"}, "sensor-id-as-address", "gyro = ", "3 * id"),
    _address("right behind the accelerometer", {GYRO: "gyro_adr = accel_adr + 3"}, "hard-coded-address", "gyro = ", BY_IDS),
    _address(
        "the torso by name",
        {ACCEL: "accel_adr = model.sensor('torso_accelerometer').adr[0]", GYRO: "gyro_adr = model.sensor('torso_gyroscope').adr[0]"},
        "hard-coded-address", "accel = ", BY_IDS,
    ),
    # how many rows there are
    Cousin("whole seconds", READER, {COUNT: "n_steps = int(duration_seconds)"}, {"data_collection.matches_truth": 6.0}, (), "only the first rows: 1", BOTH),
    _count("always as many", "n_steps = 1500", ("ignores-duration",)),
    _count("a hundred a second", "n_steps = int(duration_seconds * 100)", ("ignores-duration",)),
    _count("half of them", "n_steps = int(duration_seconds / dt) // 2", ()),
    # what labels say
    _label("metres per second", "Acceleration (m/s²)", "Acceleration (m/s)", "which names no unit of acceleration", "Name the right unit in each axis label"),
    _label("radians", "Angular Velocity (rad/s)", "Angular Velocity (rad)", "which names no unit of angular velocity", "rad of an angle"),
    # what curves show
    _curve("the other sensor's key", "angular_velocity", "imu_data['acceleration'][:, 2]", "no curve that shows angular velocity z"),
    _curve("one column twice", "angular_velocity", "imu_data['angular_velocity'][:, 1]", "no curve that shows angular velocity z"),
    _curve(
        "a scaled curve", "acceleration", "2 * imu_data['acceleration'][:, 2]",
        "no curve that shows acceleration z; 1 curve shows other numbers", "Draw the recorded numbers unchanged",
    ),
    # a reading that changes
    Cousin(
        "a view", READER, {"gyro_adr:gyro_adr+3].copy()": "gyro_adr:gyro_adr+3]"}, {"sensor_access.reading_is_a_copy": 3.0}, ("view-not-copy",),
        "after data.sensordata had changed and the function had been called again", "add .copy() to each slice",
    ),
    # how the push is made
    Cousin(
        "a push before every step", READER, {f"{STEP}\n        times": f"        data.qvel[0] = 0.5\n{STEP}        times"},
        {"data_collection.applies_push": 3.0}, ("wrong-perturbation",),
        "qpos, qvel or a force set 599 times while the simulation runs, first before step 2", "once, after the reset and before the loop",
    ),
    # whose array is whose
    _alias("keeps the input", KEEPS_INPUT, "aliased-input", hint="Store measurement.copy() as the first state"),
    _alias(
        "keeps the input and changes it in place", KEEPS_INPUT | IN_PLACE, "mutates-input", "aliased-input",
        hint="Do not change the arrays that you are given. Store measurement.copy()",
    ),
    _alias(
        "keeps the input and returns it", KEEPS_INPUT | GIVES_STATE, "aliased-output", "aliased-input",
        hint="Return self.value.copy(). Then the caller can change the output without changing the filter (Step 6). Store",
    ),
    _alias("all three", KEEPS_INPUT | IN_PLACE | GIVES_STATE, "aliased-output", "mutates-input", "aliased-input", hint="Return self.value.copy()"),
    # the state of another filter, told with its numbers
    Cousin(
        "a state in the class", FILTER, {"self.value": "LowPassFilter.value"}, {"filtering.instances_independent": 3.0}, ("shared-state",),
        " when there is a second filter, too", "Keep the state in self.value and set it in __init__",
    ),
    # nothing written
    Cousin(
        "pass in place of a method's body", FILTER, {UPDATE: "        pass\n"}, ALL_OF_FILTERING, ("wrong-return-type",),
        "None", "it is still to be written, or a return statement is missing",
    ),
]  # fmt: skip


@pytest.mark.parametrize("cousin", COUSINS, ids=lambda cousin: cousin.name)
def test_a_cousin_is_told_what_is_true_of_it(cousin: Cousin, player: Marking) -> None:
    result = marked(player, changed(VERBATIM, cousin.path, cousin.changes))
    assert lost_by(result) == pytest.approx(cousin.lost, abs=1e-9)  # 5 - 2.08 is no decimal in binary
    told = _told(result)
    assert tuple(told.misconceptions) == cousin.named
    assert cousin.got in told.got
    assert cousin.hint in told.hint


def test_a_class_without_its_method_is_still_to_be_written(player: Marking) -> None:
    files = VERBATIM | {FILTER: "class LowPassFilter:\n    pass\n"}
    told = next(check for check in _checks(marked(player, files)) if check.id == "filtering.follows_recursion")
    assert told.misconceptions == ("name-missing",)
    assert told.got == "AttributeError: 'LowPassFilter' object has no attribute 'update'"
    assert told.hint.startswith("It is still to be written, or it has another name: ")


def _checks(result: Result) -> list[CheckResult]:
    return [check for part in result.criteria for check in part.checks]


def _told(result: Result) -> CheckResult:
    return next(check for check in _checks(result) if check.outcome in ("failed", "partial", "error"))
