"""Situations from outside bug reports. Those about time zones, rosters, capitals and Git LFS are in `test_class_dates`,
`test_class_people` and `test_intake`.
"""

from __future__ import annotations

import pytest

from tests.corpus.sheet import VERBATIM
from tests.recordings import Marking
from tests.single_faults import changed, lost_by, marked

READER = "imu_reader.py"
STEP = "        mujoco.mj_step(model, data)\n\n        times[i] = data.time\n"
READ = "        accel, gyro = get_imu_readings(model, data, accel_id, gyro_id)\n"
CURVES = "".join(
    f"    axes[0].plot(imu_data['time'], imu_data['acceleration'][:, {axis}], label='{name}')\n"
    for axis, name in enumerate("XYZ")
)
EACH = """\
    n = len(imu_data['time'])
    for k, (name, colour) in enumerate(zip('XYZ', ['r', 'g', 'b'])):
        for i in range({rows}):
            axes[0].{draw}
"""
ONE_A_CALL = {
    "dots by plot": (
        "0, n, max(1, n // 300)",
        "plot(imu_data['time'][i], imu_data['acceleration'][i, k], '.', color=colour, markersize=3, label=name if i == 0 else '_')",
    ),
    "dots by scatter": (
        "0, n, max(1, n // 200)",
        "scatter(imu_data['time'][i], imu_data['acceleration'][i, k], s=6, color=colour, label=name if i == 0 else None)",
    ),
    "segments": (
        "0, n - 1, 2",
        "plot(imu_data['time'][i:i+3], imu_data['acceleration'][i:i+3, k], '-', color=colour, label=name if i == 0 else None)",
    ),
}


def test_a_reading_between_the_halves_of_a_step_is_told_what_is_true_of_it(player: Marking) -> None:
    """The accelerometer is one step old."""
    between = (
        "        mujoco.mj_step1(model, data)\n"
        + READ
        + "        mujoco.mj_step2(model, data)\n        times[i] = data.time\n"
    )
    result = marked(player, changed(VERBATIM, READER, {STEP + READ: between}))
    assert set(lost_by(result)) == {"data_collection.matches_truth"}
    (told,) = [check for part in result.criteria for check in part.checks if check.outcome != "passed"]
    assert told.got == "every row under 'acceleration' late by one sample"
    assert told.hint.endswith("A reading between mj_step1 and mj_step2 holds old values (Step 3).")


@pytest.mark.parametrize(("rows", "draw"), ONE_A_CALL.values(), ids=ONE_A_CALL)
def test_curves_that_are_drawn_one_point_or_segment_a_call_are_curves(rows: str, draw: str, player: Marking) -> None:
    result = marked(player, changed(VERBATIM, READER, {CURVES: EACH.format(rows=rows, draw=draw)}))
    assert (result.score, lost_by(result), list(result.notes)) == (100.0, {}, [])
