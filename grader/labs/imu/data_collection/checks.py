"""Checks of `simulate_and_collect`: each compares one measured property with a limit."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from grader.engine.findings import Deviation, Form, Size
from grader.labs.imu.collection import SENSOR_UNITS, SENSORS
from grader.labs.imu.compare import Array, deviation, distinct_texts
from grader.labs.imu.data_collection.diagnosis import Explained
from grader.labs.imu.data_collection.explain import JUDGE, row_fault
from grader.labs.imu.data_collection.measure import FORM, TIME_ATOL

Count = TypedDict("Count", {"steps": int, "duration": float, "timestep": float, "n": int})
Stamps = TypedDict("Stamps", {"apart": float, "stamps": str})
Start = TypedDict("Start", {"changed": str, "rows": int})
Push = TypedDict("Push", {"came": str, "n": int})


class Rows(TypedDict):
    """Values for the message of a check that found wrong rows in a recording: counts, and the row furthest from the truth.

    `n` counts all rows, `filled` the rows up to the last that is not zero, `steps` the time steps. The rows are late or early by
    `late` samples, without a sign: the fault's text says which of the two. The others are text: `changed` says what the code
    changed of the model, `of` names the key of the row's sensor if the other sensor is right (else ""), `wanted` and `came` hold
    the right numbers and the student's of that row.
    """

    n: int
    filled: int
    steps: int
    late: int
    changed: str
    of: str
    wanted: str
    came: str


@JUDGE.check("data_collection.returns_named_arrays", lab_step=3)
def check_returns_named_arrays(found: Explained) -> Deviation[Form] | None:
    """simulate_and_collect returns time (n), acceleration (n, 3) and angular_velocity (n, 3) under these names"""
    came = "; ".join(sentence for _, sentence in found.odd_form)
    return Deviation({"form": FORM, "came": came}) if came else None


@JUDGE.check("data_collection.sample_count", lab_step=3)
def check_sample_count(found: Explained) -> Deviation[Count] | None:
    """One sample for every time step of the duration, whatever the duration and the time step"""
    if (run := found.count_off) is None:
        return None
    numbers: Count = {"steps": run.steps, "duration": run.duration_s, "timestep": run.timestep, "n": run.length}
    return Deviation(numbers, size=Size("another number of samples"))


@JUDGE.check("data_collection.time_axis", lab_step=3)
def check_time_axis(found: Explained) -> Deviation[Stamps] | None:
    """Each sample carries its simulation time in seconds"""
    push = found.facts.push
    if push.series.time is None:
        return _stamped(push.model_timestep, np.zeros(0))
    if (run := found.keeps_timestep) is not None and run.series.time is not None:
        return _stamped(run.timestep, run.series.time, 0.5)
    if found.stamps_off <= TIME_ATOL:
        return None
    near = found.stamps_off <= 1.001 * push.model_timestep  # a step early or late
    return _stamped(push.model_timestep, found.stamps, 0.5 if near else 1.0, worst=int(np.argmax(found.stamp_errors)))


@JUDGE.check("data_collection.matches_truth", lab_step=3)
def check_matches_truth(found: Explained) -> Deviation[Rows] | None:
    """The rows are what the sensors read at each step"""
    if not (fault := row_fault(found)):
        return None
    push = found.facts.push
    but_for_one = fault == "rows-left-zero" and push.series.filled_rows == push.length - 1
    one_sensor = found.push is not None and not found.plain and (found.nearly or bool(found.series.absent))
    return _furthest_row(found, 0.5 if but_for_one or one_sensor else 1.0)


@JUDGE.check("data_collection.starts_from_reset", lab_step=3)
def check_starts_from_reset(found: Explained) -> Deviation[Start] | None:
    """A run starts from the reset state, whatever happened before, and leaves the model as it was"""
    changed, rows = found.model_left_changed, found.rows_left
    if not (changed or rows or found.second_is_empty or found.goes_on):
        return None
    return Deviation({"changed": changed, "rows": rows})


@JUDGE.check("data_collection.applies_push", lab_step=3)
def check_applies_push(found: Explained) -> Deviation[Push] | None:
    """The run starts with the push of the sheet: 0.5 m/s forward"""
    return Deviation({"came": found.another_push, "n": found.facts.push.length}) if found.another_push else None


def _stamped(apart: float, stamps: Array, affected: float = 1.0, worst: int = 0) -> Deviation[Stamps]:
    shown = ", ".join(f"{t:g}" for t in stamps[:3]) + (f" … {stamps[-1]:g} s" if len(stamps) else "none")
    shown += f"; {stamps[worst]:g} s in row {worst}" if worst else ""
    return Deviation({"apart": apart, "stamps": shown}, affected=affected)


def _furthest_row(found: Explained, affected: float) -> Deviation[Rows]:
    """Return a deviation that shows the row in which a wrong sensor differs most from the truth; it costs the share `affected`."""
    which = int(found.is_right(0))
    key, unit, got, true = SENSORS[which], SENSOR_UNITS[which], found.series.sensors[which], found.true_rows[which]
    assert got is not None
    gap = deviation(got, true)
    wanted, came = distinct_texts(true[gap.row], got[gap.row])
    if found.series.unfilled and not got[gap.row].any():
        came = "a row that was never filled (NaN)"
    beside = "; the other sensor is right" if found.is_right(1 - which) else ""
    push = found.facts.push
    numbers: Rows = {
        "n": push.length,
        "filled": push.series.filled_rows,
        "steps": push.model_steps,
        "late": abs(found.push.lag) if found.push is not None else 0,
        "changed": found.model_changed,
        "of": f" under {key!r}" if beside else "",
        "wanted": f"{wanted} {unit} under {key!r} in row {gap.row}",
        "came": f"{came} (RMS difference over all rows {gap.rms:.3g} {unit}{beside})",
    }
    return Deviation(numbers, size=Size("the rows are off", gap.rms, unit), affected=affected)
