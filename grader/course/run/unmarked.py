"""Results of submissions that no marker finished grading, so that they appear in the class all the same."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from grader import __version__
from grader.base.text import printable
from grader.course.run.grade_request import GradeRequest
from grader.engine.check_runner import known_checks
from grader.engine.marks import marked
from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, LabName, Result, Status
from grader.engine.rubric import Criterion
from grader.intake import Submission


def unjudged(submission: Submission, request: GradeRequest, reason: str) -> Result:
    """Return the result, with `reason` as a note, of a submission that the grader failed on: no check is judged or has points."""
    note = f"The grader failed on this submission ({printable(reason, 300)}); grade it again"
    row = CheckResult("", "", "not_judged", None, 0.0, fault=printable(reason, 300))
    return _without_marker(submission, request, "incomplete", row, note)


def stopped(submission: Submission, request: GradeRequest, reason: str) -> Result:
    """Return the result, with `reason` as a note, of a submission that exceeded its time or memory limit twice: checks earn 0."""
    note = (
        f"Marking this submission was ended twice ({printable(reason, 300)}), and no check was done by then. "
        "Look at what it does, or ask whoever marks to"
    )
    row = CheckResult("", "", "timeout", 0.0, 0.0, expected="an answer in time", got="none, twice", keeps=0.0)
    return _without_marker(submission, request, "graded", row, note)


def _without_marker(
    submission: Submission, request: GradeRequest, status: Status, row: CheckResult, note: str
) -> Result:
    """Return a result in which every check of the rubric has the outcome of `row`, with `note` as the reason."""
    known = known_checks(request.rubric.lab, request.rubric.own_checks)
    titles = {id_: check.title for id_, check in known.items()}
    found = Result(
        submission.name,
        status,
        criteria=tuple(_alike(criterion, titles, row) for criterion in request.rubric.criteria),
        extensions=tuple(ExtensionResult(each.id, False, each.points) for each in request.rubric.extensions),
        notes=(*submission.notes, note),
        lab=LabName(request.rubric.lab.label, request.rubric.lab.title),
        provenance={
            "grader": __version__,
            "rubric_sha256": request.rubric.sha256,
            "traces_sha256": request.traces.sha256,
            "submission_sha256": submission.sha256,
            **({"hidden": True} if request.traces.name != "public" else {}),
        },
    )
    return marked(found, request.rubric)


def _alike(criterion: Criterion, titles: Mapping[str, str], row: CheckResult) -> CriterionResult:
    rows = (replace(row, id=check.id, title=titles.get(check.id, check.id)) for check in criterion.checks)
    return CriterionResult(criterion.id, criterion.title, criterion.points, tuple(rows))
