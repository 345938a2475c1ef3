"""One submission and its marks: no fault of ours is a zero, and whatever is accepted can be sent and judged."""

from __future__ import annotations

import json
import re

import pytest

from grader.base.errors import GraderError
from grader.course.run.warnings import remarks
from grader.engine import check_runner, rubric
from grader.engine.grader import Marker
from grader.engine.results import Result, to_json
from grader.engine.traces import Traces
from grader.intake.file_budget import MAX_FILES
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.labs.imu.student import Student
from grader.people.final_grade import FinalGrade
from tests.corpus.pieces import edit, tidy, verbatim
from tests.sandboxes import Opened
from tests.single_faults import marked


class UnsayableError(Exception):
    def __str__(self) -> str:
        raise IndexError

    __repr__ = __str__


class ExitingError(Exception):
    def __str__(self) -> str:
        raise SystemExit


@pytest.mark.plain
def test_the_sheets_own_code_has_all_points_in_a_sandbox(marker: Marker) -> None:
    result = marked(marker, verbatim())
    assert (result.status, result.score) == ("graded", 100.0)


@pytest.mark.parametrize(
    ("problem", "says"),
    [
        (ZeroDivisionError("a fault of ours"), "ZeroDivisionError: a fault of ours"),
        (UnsayableError(), "UnsayableError: its message raises IndexError"),
        (ExitingError(), "ExitingError: its message raises SystemExit"),
    ],
)
def test_a_fault_of_the_grader_is_not_judged_and_never_a_zero(
    marker: Marker, monkeypatch: pytest.MonkeyPatch, problem: Exception, says: str
) -> None:
    def broken(*_: object) -> bool:
        raise problem

    monkeypatch.setattr("grader.labs.imu.filtering.measure.Facts.noise_gain", property(broken))
    result = marked(marker, tidy())
    row = next(
        check for criterion in result.criteria for check in criterion.checks if check.id == "filtering.reduces_noise"
    )
    assert (result.status, row.outcome, row.points) == ("incomplete", "not_judged", None)
    assert row.message == f"Not judged, because the grader failed: {says}"
    told = says.replace(":", r" at grader/labs/imu/filtering/checks\.py:\d+ in check_reduces_noise:")
    assert re.fullmatch(told, row.fault)
    assert json.dumps(row.fault) in to_json(result)


def test_a_fault_of_ours_in_feedback_says_where_it_was(marker: Marker, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("grader.engine.feedback.hint_of", lambda *_: 1 // 0)
    result = marked(marker, edit(verbatim(), "filters.py", ("self.alpha *", "2 * self.alpha *")), "filtering")
    faults = {check.fault.partition(":")[0] for check in result.criteria[0].checks if check.outcome == "not_judged"}
    assert faults == {"ZeroDivisionError at grader/engine/feedback.py"}


def test_checks_and_rubric_hold_the_same_ids() -> None:
    listed = [check.id for check in rubric.load(LAB).checks]
    assert sorted(check_runner.known_checks(LAB)) == sorted(listed)


def test_a_call_that_does_not_fit_is_told_as_that_on_hidden_runs(hidden: Traces, opened: Opened) -> None:
    reader = "\ndef get_imu_readings(model, data, a, g, frame):\n    return data.sensordata[:3], data.sensordata[3:6]\n"
    files = tidy()
    files["imu_reader.py"] += reader
    with opened(hidden) as marker:
        result = marked(marker, files)
    told = result.criteria[0].checks[0].message
    assert told.endswith(
        "TypeError in the call itself, before a line of yours ran: compare its parameters with the sheet's"
    )


def test_no_plugin_of_the_machine_takes_part_in_the_marking(request: pytest.FixtureRequest) -> None:
    """hypothesis brings one, which these tests themselves run with."""
    name = "hypothesispytest"
    assert request.config.pluginmanager.has_plugin(name)
    assert not any(item.config.pluginmanager.has_plugin(name) for item in check_runner.session(LAB)._items)


# --- answers that the judging stumbles over: `not_judged` is for faults that any submission meets ------------------------


def _marked_signed(opened: Opened, monkeypatch: pytest.MonkeyPatch, problem: type[Exception]) -> Result:
    """Mark a filter with a wrong sign, for which the judging of filters fails."""
    signed = edit(verbatim(), "filters.py", ("self.alpha * measurement +", "-self.alpha * measurement +"))
    really = Student.filter

    def stumbling(student: Student, *args: object, **named: object) -> object:
        if student.files.get("filters.py") == str(signed["filters.py"]).encode():
            raise problem("a number that nobody has thought of")
        return really(student, *args, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(Student, "filter", stumbling)
    with opened(bundles.shipped()) as marker:
        return marked(marker, signed, "filtering")


def test_what_sound_code_does_not_meet_is_lost_and_shown_to_a_person(
    opened: Opened, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = _marked_signed(opened, monkeypatch, ZeroDivisionError)
    assert result.status == "graded"
    assert {check.outcome for check in result.criteria[0].checks} == {"failed"}
    assert "the grader could not read what the code returned" in result.notes[0]
    faults = [check.fault for check in result.criteria[0].checks]
    assert all(fault.startswith("ZeroDivisionError at grader/") and fault.endswith("thought of") for fault in faults)
    (told,) = remarks({"a": FinalGrade("a", result)}, (), ())
    assert told == "an answer that the grader could not read (review what the code returns): a"


def test_a_sandbox_that_fails_is_a_fault_of_ours(opened: Opened, monkeypatch: pytest.MonkeyPatch) -> None:
    assert _marked_signed(opened, monkeypatch, GraderError).status == "incomplete"


# --- limits fit each other: what is accepted can be sent to a worker, and any answer can be sent back in a question -------

LARGE = edit(
    verbatim(),
    "imu_reader.py",
    ("    return {\n", "    more = {f'more{n}': np.zeros(585_000) for n in range(7)}\n    return {**more,\n"),
)
"""A recording just below the cap of an answer, 32 MiB: 4,095,000 numbers beside its three series."""


@pytest.mark.parametrize("part", ["data_collection", "visualization"])
def test_a_recording_just_below_the_cap_is_judged_in_every_question(marker: Marker, part: str) -> None:
    result = marked(marker, LARGE, part)
    assert result.status == "graded"
    assert {check.outcome for check in result.criteria[0].checks} == {"passed"}


def test_a_recording_above_the_cap_costs_its_own_checks(marker: Marker) -> None:
    larger = {**LARGE, "imu_reader.py": LARGE["imu_reader.py"].replace("range(7)", "range(8)")}
    result = marked(marker, larger)
    assert result.status == "graded"
    assert [criterion.points for criterion in result.criteria] == [20, 0, 20, 20, 20]


def test_a_thousand_programs_and_a_thousand_tables_with_the_longest_names_are_sent(marker: Marker) -> None:
    folder = "/".join(["語" * 80] * 3)
    more = {f"{folder}/{n:04}.py": "x = 1\n" for n in range(MAX_FILES)}
    more |= {f"{folder}/{n:04}.csv": "1,2\n" for n in range(MAX_FILES)}
    result = marked(marker, {**verbatim(), **more}, "filtering")
    assert (result.status, result.criteria[0].points) == ("graded", 20)
