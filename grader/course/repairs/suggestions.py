"""Suggested repairs: edits of one place in code that does not run, each validated by grading the edited copy in the sandbox.

Candidates are read from the text of the failing line alone: a name that is nearly another one of the file, a missing ``self.`` or
``np.``, one token too many or too few, an indentation, a missing ``return``. No exception's wording is read. An edit is suggested
only where every edit that makes the file run leads to the same grade.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Protocol

from grader.course.record.patches import diff_of
from grader.course.repairs.candidates import limited
from grader.engine.findings import Where
from grader.engine.lab import Lab
from grader.engine.results import CheckResult, Result
from grader.intake import Submission


class MarkCopy(Protocol):
    """Protocol of a function that grades an edited copy in the sandbox within `cpu_s` CPU seconds; None: the rubric's limit."""

    def __call__(self, submission: Submission, cpu_s: float | None = None) -> Result: ...


MOST = 30
"""Largest number of candidates graded for one submission. Grading correct code takes a third of a second."""
SECONDS = 20.0
"""CPU seconds for all candidates of a submission together, both of the grader and of the student's code."""
_STOPPED = frozenset(("error", "timeout", "crashed"))
_DOES_NOT_PARSE = "does-not-import"


@dataclass(frozen=True)
class Suggestion:
    """A repair that the grader suggests: an edited file, its diff, its result, and how many other edits led to the same grade."""

    file: str
    content: bytes
    diff: str
    result: Result
    alike: int


@dataclass(frozen=True)
class _Place:
    """Where a submission stops: the line `row` of `file`, counted from 0, -1 if unknown; `name` is the function required there."""

    file: str
    row: int
    name: str


@dataclass
class _Left:
    """Budget of candidates and CPU seconds for all places of a submission; it shrinks as candidates are graded."""

    candidates: int = MOST
    cpu_s: float = SECONDS


def suggest(handed_in: Submission, graded: Result, lab: Lab, mark: MarkCopy) -> Suggestion | None:
    """Return an edit at one place where the code stops, so that the file runs and the score rises; None if none is found.

    The place that costs most points is tried first. A place whose working edits earn different scores is passed over.

    Parameters
    ----------
    graded
        The result of the submission as it was handed in.
    mark
        Grades each edited copy in the sandbox.
    """
    left = _Left()
    for place in _places(graded, handed_in, lab):
        found = list(_validated(handed_in, graded, place, mark, left))
        if found and len({each.score for _, each in found}) == 1:
            content, result = found[0]
            diff = diff_of(place.file, handed_in.files[place.file], content)
            return Suggestion(place.file, content, diff, result, len(found) - 1)
    return None


def _validated(
    handed_in: Submission, graded: Result, place: _Place, mark: MarkCopy, left: _Left
) -> Iterator[tuple[bytes, Result]]:
    """Grade candidates for a place within the budget `left`; yield those that earn more and with which the file runs."""
    stopped = {(check.where.file, check.id) for check in _stopping(graded) if check.where}
    made = limited(handed_in.files[place.file], place.row, place.name, left.candidates)
    left.cpu_s -= made.cpu_s
    for content in made.files:
        if left.cpu_s <= 0:
            return
        result = mark(replace(handed_in, files={**handed_in.files, place.file: content}), left.cpu_s)
        left.candidates -= 1
        left.cpu_s -= result.cpu_s
        still = {(check.where.file, check.id) for check in _stopping(result) if check.where}
        if result.score > graded.score and not any(file == place.file for file, _ in still) and still <= stopped:
            yield content, result


def _stopping(result: Result) -> list[CheckResult]:
    """Return the checks that failed because code does not run (it raises, hangs, crashes or does not parse)."""
    checks = (check for part in result.criteria for check in part.checks)
    return [check for check in checks if check.outcome in _STOPPED or _DOES_NOT_PARSE in check.misconceptions]


def _places(result: Result, handed_in: Submission, lab: Lab) -> list[_Place]:
    """Return the places at which a submission stops, the costliest first; empty if all of its code runs."""
    cost: dict[_Place, float] = {}
    for part in result.criteria:
        stopping = [check for check in part.checks if check in _stopping(result) or _returns_nothing(check)]
        for check in stopping[:1]:
            name = lab.name_of(check.id)
            where = check.where or _definition(name, handed_in)
            if where is not None and where.file in handed_in.files:
                place = _Place(where.file, (where.line or 0) - 1, name)
                cost[place] = cost.get(place, 0.0) + part.max_points - part.points
    return sorted(cost, key=lambda place: -cost[place])


def _returns_nothing(check: CheckResult) -> bool:
    return check.outcome == "failed" and "wrong-return-type" in check.misconceptions


def _definition(name: str, handed_in: Submission) -> Where | None:
    """Return the first Python file that defines the function or class `name`, without a line; None if no file does."""
    defines = re.compile(rf"^(?:class|def)[ \t]+{re.escape(name)}\b".encode(), re.MULTILINE)
    files = (path for path, content in handed_in.files.items() if path.endswith(".py") and defines.search(content))
    return next((Where(path) for path in files), None)
