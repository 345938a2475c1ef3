"""Warnings after a run, one line for each thing that an instructor should review. No score depends on them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from grader.base.text import printable, some
from grader.course.run import missing_packages
from grader.engine.results import AUTOMATIC, Result
from grader.engine.rubric import LatePolicy
from grader.people.final_grade import Adjustment, FinalGrade, automatic_points, maximum_points, summed
from grader.report import words

A_LINE = 20  # names
OUTDATED = 5  # lines
_A_FEW = 5  # names


def remarks(final_grades: Mapping[str, FinalGrade], absent: Sequence[str], unknown: Sequence[str]) -> Iterator[str]:
    """Yield warnings about submissions to review, packages that student code lacks, and mismatches with the roster.

    A submission to review has the same files as another, is empty or unreadable, was repaired automatically, timed out in every
    check, or its code returned something that the grader could not interpret. `absent` are people without a submission, `unknown`
    submissions that match nobody or several people of the roster.
    """
    for ids in equal(final_grades.values()):
        yield from named_lines("the same files were handed in by", ids)
    nothing = [
        s.id for s in final_grades.values() if s.result.status in ("empty", "unreadable") and not s.has_no_submission
    ]
    yield from named_lines("no gradable files (review what was handed in)", nothing)
    odd = [s.id for s in final_grades.values() if not_understood(s.result)]
    yield from named_lines("an answer that the grader could not read (review what the code returns)", odd)
    stopped = [s.id for s in final_grades.values() if timed_out(s.result)]
    yield from named_lines("every check timed out (review what the code does)", stopped)
    yield from missing_packages.lines({s.id: missing_packages.failed(s.result) for s in final_grades.values()})
    applied = [s.id for s in final_grades.values() if any(repair.author == AUTOMATIC for repair in s.result.repairs)]
    yield from named_lines("repaired automatically (review the change)", applied)
    yield from named_lines("in the roster, no submission", absent)
    yield from named_lines("not in the roster, or matched by several people there", unknown)


def of_policy(final_grades: Mapping[str, FinalGrade], policy: LatePolicy | None) -> Iterator[str]:
    """Yield warnings: submissions late by the platform but not by the policy, and people with a due date in it but no submission.

    There is no warning without a late policy.
    """
    if policy is None:
        return
    in_time = [each.id for each in final_grades.values() if each.hand_in.marked_late and each.late is None]
    yield from named_lines("late on the platform, but in time by the roster and the late policy", in_time)
    people = [person for each in final_grades.values() for person in each.hand_in.people]
    known = {text.casefold() for person in people for text in person.called}
    known |= {id_.casefold() for id_ in final_grades}
    yield from named_lines(
        "with a due date in the rubric, but no submission has this name",
        [who for who in policy.due_dates if who.casefold() not in known],
    )


def gone(final_grades: Mapping[str, FinalGrade], found: Collection[str]) -> Iterator[str]:
    """Yield a warning about stored submissions that a download (ids in `found`) lacks, if these are at most half of all.

    A download that lacks more holds resubmissions only, so nobody is missing from it.
    """
    left = [id_ for id_, each in final_grades.items() if id_ not in found and not each.has_no_submission]
    if left and 2 * len(left) <= len(final_grades):
        yield f"on record and in the gradebook, but not in this download: {some(left, _A_FEW, '; ')}"


def replaced(before: Mapping[str, FinalGrade], after: Mapping[str, FinalGrade]) -> Iterator[str]:
    """Yield warnings that name the submissions of which a run graded other files than were stored, with both final grades."""
    changed = [
        f"{id_} ({_final(before[id_])} → {_final(now)})"
        for id_, now in after.items()
        if id_ in before and _digest(before[id_]) != _digest(now)
    ]
    yield from named_lines("other files than on record count now", changed)


def outdated(final_grades: Mapping[str, FinalGrade]) -> Iterator[str]:
    """Yield warnings about overrides whose automatic points have changed since: the first `OUTDATED`, then a count of the rest."""
    lines = [
        _outdated_warning(final_grade, adjustment)
        for final_grade in final_grades.values()
        for adjustment in final_grade.outdated()
    ]
    yield from lines[:OUTDATED]
    if len(lines) > OUTDATED:
        yield f"and {len(lines) - OUTDATED} more overrides whose automatic points have changed; the class page lists them"


def timed_out(result: Result) -> bool:
    outcomes = {check.outcome for criterion in result.criteria for check in criterion.checks}
    return outcomes == {"timeout"}


def _digest(final_grade: FinalGrade) -> object:
    return final_grade.result.provenance.get("submission_sha256")


def _final(final_grade: FinalGrade) -> str:
    return "blank" if final_grade.final is None else words.number(final_grade.final)


def _outdated_warning(final_grade: FinalGrade, adjustment: Adjustment) -> str:
    """Return the warning about an override whose automatic points have changed, with the points then and now."""
    now = automatic_points(final_grade.result, adjustment.criterion)
    then = [points for points in adjustment.automatic.values() if points is not None]
    worth_then = sum(adjustment.out_of.values())
    had = words.fraction(round(sum(then), 2), round(worth_then, 2)) if worth_then else words.number(round(sum(then), 2))
    new = (
        "gone"
        if now is None
        else words.fraction(summed(now), maximum_points(final_grade.result, adjustment.criterion) or 0.0)
    )
    return (
        f"{printable(final_grade.id)}: {adjustment.criterion} was overridden with {words.number(adjustment.points or 0.0)} "
        f"when it had {had}; the automatic points are now {new}. Adjust it again or withdraw it"
    )


def not_understood(result: Result) -> bool:
    return any(check.not_understood for part in result.parts for check in part.checks)


def equal(final_grades: Iterable[FinalGrade]) -> Iterator[list[str]]:
    same: defaultdict[str, list[str]] = defaultdict(list)
    for final_grade in final_grades:
        if final_grade.result.status in ("graded", "incomplete"):
            same[str(final_grade.result.provenance.get("submission_sha256", final_grade.id))].append(final_grade.id)
    yield from (ids for ids in same.values() if len(ids) > 1)


def named_lines(what: str, names: Sequence[str]) -> Iterator[str]:
    """Yield lines ``<what>: a; b`` with up to `A_LINE` names each; nothing for no names. Semicolons, because names hold commas."""
    for start in range(0, len(names), A_LINE):
        yield f"{what}: {'; '.join(printable(name, 80) for name in names[start : start + A_LINE])}"
