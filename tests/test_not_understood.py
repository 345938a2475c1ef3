"""An answer that the judging stumbles over costs its check, not the grader's word: `not_judged` is for faults that any hand-in meets."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from grader.base.errors import GraderError
from grader.course.warnings import remarks
from grader.engine.grader import Marker
from grader.engine.results import Result
from grader.labs.imu import bundles
from grader.labs.imu.student import Student
from grader.people.final_grade import FinalGrade
from tests.corpus.pieces import edit, verbatim
from tests.sandboxes import Opened
from tests.scoreboard import Case, handed_in

SIGNED = Case(
    "faulty", "signed", edit(verbatim(), "filters.py", ("self.alpha * measurement +", "-self.alpha * measurement +"))
)


@pytest.fixture
def marker(opened: Opened) -> Iterator[Marker]:
    with opened(bundles.shipped()) as own:
        yield own


def _filtering(
    marker: Marker, monkeypatch: pytest.MonkeyPatch, case: Case, problem: type[Exception], *, for_all: bool = False
) -> Result:
    """Mark the filtering of a case while the judging of filters fails: for this submission's file, or for all."""
    really = Student.filter

    def stumbling(student: Student, *args: object, **named: object) -> object:
        if for_all or student.files.get("filters.py") == str(case.files["filters.py"]).encode():
            raise problem("a number that nobody has thought of")
        return really(student, *args, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(Student, "filter", stumbling)
    return marker.mark(handed_in(case), only="filtering")


def test_what_sound_code_does_not_meet_is_lost_and_shown_to_a_person(
    marker: Marker, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = _filtering(marker, monkeypatch, SIGNED, ZeroDivisionError)
    assert result.status == "graded"
    assert {check.outcome for check in result.criteria[0].checks} == {"failed"}
    assert "the grader could not read what the code returned" in result.notes[0]
    (told,) = remarks({"a": FinalGrade("a", result)}, (), ())
    assert told == "an answer that the grader could not read (review what the code returns): a"


def test_what_sound_code_meets_too_is_a_fault_of_ours(marker: Marker, monkeypatch: pytest.MonkeyPatch) -> None:
    result = _filtering(marker, monkeypatch, Case("sound", "verbatim", verbatim()), ZeroDivisionError, for_all=True)
    assert result.status == "incomplete"
    assert {check.points for check in result.criteria[0].checks} == {None}


def test_a_box_that_fails_is_a_fault_of_ours(marker: Marker, monkeypatch: pytest.MonkeyPatch) -> None:
    assert _filtering(marker, monkeypatch, SIGNED, GraderError).status == "incomplete"
