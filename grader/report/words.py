"""Words, labels and number formats of a result, shared by the terminal, the pages and the CI formats.

Functions here return texts and print nothing. In texts that may come from a submission, `printable` escapes control
characters and cuts what is too long.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING

from grader.base.text import printable

if TYPE_CHECKING:  # `imugrade explain` needs a word of these, and no result
    from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, LabName, Outcome, Result, Status
    from grader.people.final_grade import FinalGrade, HandIn, Person

TEXT_LIMIT = 2000
NAME_LIMIT = 120
GUIDE = "guide.html"
"""Name of the students' guide, which the kit writes into the starter files."""
FOR_THE_INSTRUCTOR = frozenset({"tampering"})
"""Faults that deduct nothing and are shown to the instructor only."""


@dataclass(frozen=True)
class Word:
    """How the outcome of a check is shown: its word, a sign that works without colour, and its kind, one of four CSS classes."""

    word: str
    sign: str
    kind: str


_WORDS: dict[Outcome, Word] = {
    "passed": Word("passed", "✓", "passed"),
    "partial": Word("partial", "◐", "partial"),
    "failed": Word("failed", "✗", "failed"),
    "error": Word("raised", "✗", "failed"),
    "timeout": Word("timed out", "✗", "failed"),
    "crashed": Word("crashed", "✗", "failed"),
    "skipped": Word("skipped", "–", "blank"),
    "not_judged": Word("not judged", "?", "blank"),
}

STATUS: dict[Status, str] = {
    "graded": "",
    "incomplete": "The grader failed on a part of this submission. Those points are open; they are not lost.",
    "empty": "This submission contains nothing that the lab asks for.",
    "unreadable": "This submission could not be opened.",
}


@dataclass(frozen=True)
class LabelledLine:
    """One labelled line below a check, such as Expected, Got, Try, Read or Rerun. A line without a label is a plain sentence."""

    label: str
    text: str


_HELP = LabelledLine("Help", f"open {GUIDE}, in your starter files")


@dataclass(frozen=True)
class CheckText:
    """One check as text; `read` is a lab step to read, `again` a command that grades the criterion again; "" if there is none."""

    outcome: Word
    title: str
    points: str
    lines: tuple[LabelledLine, ...]
    read: str
    again: str


def row(check: CheckResult, part: str, lab: LabName) -> CheckText:
    """Format a check: outcome, points, feedback, the step of `lab` to read, the command to grade its criterion (`part`) again."""
    lost = tells(check)
    return CheckText(
        outcome=_WORDS[_outcome(check)],
        title=printable(check.title or check.id, 300),
        points=fraction(check.points, check.max_points) if check.max_points else "",
        lines=(*_lines(check), *((LabelledLine("Try", _text(check.hint)),) if check.hint and lost else ())),
        read=f"{lab.label}, Step {check.lab_step}" if lost and check.lab_step is not None else "",
        again=f"imugrade check --only {part}" if lost else "",
    )


def _outcome(check: CheckResult) -> Outcome:
    """Return `partial` for a failed check that keeps points through a deduction of the rubric, else the check's own outcome."""
    some = check.points is not None and 0.0 < check.points < check.max_points
    return "partial" if some and check.outcome == "failed" else check.outcome


def tells(check: CheckResult) -> bool:
    """Return whether a check has feedback of its own: not if it passed, was not judged, or was skipped for another check."""
    return check.outcome not in ("passed", "skipped", "not_judged")


def help_lines(result: Result) -> list[LabelledLine]:
    """Return the line that names the students' guide; [] if nothing was lost: no check failed or was skipped."""
    outcomes = {check.outcome for part in result.parts for check in part.checks}
    return [_HELP] if result.status in ("empty", "unreadable") or outcomes - {"passed", "not_judged"} else []


def number(points: float) -> str:
    """Format points with at most two decimals and no trailing zeros: 20, 87.5, 13.33."""
    return f"{points:.2f}".rstrip("0").rstrip(".")


def counted_points(points: float) -> str:
    """Format points with their noun: ``1 point``, ``2.5 points``."""
    return f"{number(round(points, 2))} point{'' if round(points, 2) == 1 else 's'}"


def minus(points: float) -> str:
    """Format 9.5 deducted points as ``−9.5``, with a minus sign instead of a hyphen."""
    return f"−{number(round(points, 2))}"


def points_lost(checks: Iterable[CheckResult]) -> float:
    """Return the points that checks deducted together. A check that was not judged deducts nothing."""
    return sum(check.max_points - check.points for check in checks if check.points is not None)


def fraction(points: float | None, of: float) -> str:
    """Format points as ``14 / 20``; unknown points are a dash."""
    return f"{'–' if points is None else number(points)} / {number(of)}"


def criterion_points(criterion: CriterionResult) -> str:
    return fraction(None if unjudged(criterion) else criterion.points, criterion.max_points)


def extension_points(extension: ExtensionResult) -> str:
    """Format an extension as ``4 of 5 passed``, or as points where the rubric makes it extra credit."""
    if extension.max_points:
        return fraction(extension.points, extension.max_points)
    passed = sum(check.outcome == "passed" for check in extension.checks)
    return f"{passed} of {len(extension.checks)} passed"


def extra_credit(result: Result) -> str:
    """Format the extra credit of a result as ``10 / 10``; "" if the rubric gives extensions no points."""
    return "" if result.extra_credit_cap is None else fraction(result.extra_credit, result.extra_credit_cap)


def total_points(result: Result) -> str:
    open_ = result.status == "incomplete" or any(map(unjudged, result.criteria))
    return fraction(None if open_ else result.score, result.max_score)


def unjudged(criterion: CriterionResult) -> bool:
    """Return whether a check of the criterion was not judged, so that its points are unknown."""
    return any(check.points is None for check in criterion.checks)


def name(result: Result) -> str:
    return printable(result.submission, NAME_LIMIT) or "(no name)"


def person(final_grade: FinalGrade) -> str:
    """Return the names of the people who submitted, or the submission's name if no platform names them; "(no name)" if blank."""
    return printable(final_grade.name, NAME_LIMIT) or "(no name)"


def distinct(final_grade: FinalGrade) -> str:
    """Return the names of a submission's people, with the submission's id if another person of the class has the same name."""
    name = person(final_grade)
    return f"{name} ({printable(final_grade.id, 80)})" if final_grade.namesake and name != final_grade.id else name


NO_SUBMISSION = "no submission"
"""Status of a person of the roster who has not submitted."""


def status(final_grade: FinalGrade) -> str:
    """Return "graded", "incomplete" (a part not judged), "empty", "unreadable", or "no submission" (only overrides give points)."""
    return NO_SUBMISSION if final_grade.has_no_submission else final_grade.result.status


def submissions(final_grades: Iterable[FinalGrade]) -> str:
    """Count the submissions, and people graded without one, as ``57 submissions, 1 without a submission, graded by hand``."""
    without = Counter(each.has_no_submission for each in final_grades)
    by_hand = f", {without[True]} without a submission, graded by hand" if without[True] else ""
    return f"{counted(without[False], 'submission')}{by_hand}"


def absentees(absent: Sequence[Person], hand_ins: Iterable[HandIn]) -> list[str]:
    """Return the names of the people in `absent`, with an identifier if others there or in `hand_ins` have the same name."""
    listed = [person.name for person in absent]
    names = Counter(name.casefold() for name in [*listed, *(p.name for each in hand_ins for p in each.people)])
    known = [person.number for person in absent]
    return [
        f"{name} ({id_})" if id_ and id_ != name and names[name.casefold()] > 1 else name
        for name, id_ in zip(listed, known, strict=True)
    ]


def late(final_grade: FinalGrade) -> str:
    """Format how late a submission is: ``2 d 3 h``, or ``…, after the cut-off``; "late" if unknown how late, "" if not late."""
    if final_grade.late is None:
        return ""
    if final_grade.late.seconds is None:
        return "late"
    hours = -(-final_grade.late.seconds // 3600)
    days = f"{hours // 24} d {hours % 24} h" if hours >= 24 else f"{hours} h"
    return f"{days}, after the cut-off" if final_grade.late.refused else days


def instant(stamp: str) -> str:
    """Format an ISO 8601 time as ``2026-11-20 20:00 UTC``; return any other text made printable."""
    try:
        return f"{datetime.fromisoformat(stamp):%Y-%m-%d %H:%M %Z}".strip()
    except ValueError:
        return printable(stamp, 40)


def notes(result: Result) -> list[str]:
    return [_text(note) for note in result.notes]


def repairs(result: Result) -> list[str]:
    """Return a line on each repair, for a report: ``filters.py was repaired by Eve (−5 points): a colon was missing``."""
    return [
        f"{printable(each.file, 200)} was repaired by {printable(each.author, 80)} ({minus(each.deduction)} points): "
        f"{printable(each.comment, 300)}"
        for each in result.repairs
    ]


def faults(result: Result) -> list[str]:
    """Return the faults of a result, each as words (see `fault_in_words`), without those that only the instructor may see."""
    return [fault_in_words(id_) for id_ in result.misconceptions if id_ not in FOR_THE_INSTRUCTOR]


def fault_in_words(id_: str) -> str:
    """Return a fault id such as ``sensor-id-as-address`` as words: ``sensor id as address``."""
    return printable(id_, 80).replace("-", " ")


def _text(text: str) -> str:
    return printable(text, TEXT_LIMIT, newlines=True)


def _lines(check: CheckResult) -> tuple[LabelledLine, ...]:
    said = (("", check.said), ("Expected", check.expected), ("Got", check.got))
    return tuple(LabelledLine(label, _text(text)) for label, text in said if text)


def counted(count: int, what: str) -> str:
    """Return a number with its noun, which gets an "s" unless the number is 1: ``1 check``, ``0 checks``."""
    return f"{count} {what}{'' if count == 1 else 's'}"
