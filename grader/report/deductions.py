"""The section "Deductions" of a report: each fault with its explanation, the checks that failed for it, and what to do next."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from grader.base.text import printable
from grader.engine.faults import FaultRow
from grader.engine.results import CheckResult, LabName, Result
from grader.report import causes, words
from grader.report.causes import Cause, causes_of, part_of


@dataclass(frozen=True)
class DeductedCheck:
    """A check that lost points in a deduction, with the part of its feedback that no earlier check of the deduction has shown.

    `anchor` is the HTML id to which the page's links to the check lead; "" if an earlier deduction has that id.
    """

    anchor: str
    row: words.CheckText
    points: str
    lines: tuple[words.LabelledLine, ...]


@dataclass(frozen=True)
class Deduction:
    """One entry of "Deductions": a fault, its explanation (`why`), the checks that failed for it, and what to do next.

    `waiting` tells number and points of the checks that could not be graded because of the fault; "" if there are none.
    """

    points: str
    title: str
    why: tuple[str, ...]
    checks: tuple[DeductedCheck, ...]
    waiting: str
    next_lines: tuple[words.LabelledLine, ...]


def deductions(result: Result, catalogue: Mapping[str, FaultRow]) -> list[Deduction]:
    """Return the deductions of a result: code that does not run, then all others, each sorted by points lost, most first.

    A last entry, "Not graded", counts checks skipped in criteria where no check failed. `catalogue` has the lab's faults by id.
    """
    checks = [check for criterion in result.criteria for check in criterion.checks]
    found = sorted(causes_of(checks), key=lambda cause: (not cause.does_not_run, -cause.lost))
    waiting = {check for cause in found for check in cause.waiting}
    alone = [check for check in checks if check.outcome == "skipped" and check not in waiting]
    linked: set[str] = set()
    known = [_deduction(cause, result.lab, catalogue, linked) for cause in found]
    return [*known, *([_unreached(alone)] if alone else [])]


def _deduction(cause: Cause, lab: LabName, catalogue: Mapping[str, FaultRow], linked: set[str]) -> Deduction:
    """Return the entry of one fault. `linked` holds the checks that earlier entries show, so that a check has one anchor only."""
    named = [catalogue[each] for each in cause.faults if each in catalogue]
    title = _title(cause, named)
    shown = []
    for check, lines in causes.lines_by_check(cause):
        place = "" if check.id in linked else anchor(check)
        linked.add(check.id)
        row, told = words.row(check, part_of(check), lab), () if _says(title, lines) else tuple(lines)
        shown.append(DeductedCheck(place, row, causes.points_of(check), told))
    return Deduction(
        words.minus(cause.lost),
        title,
        tuple(fault.explanation.strip() for fault in named),
        tuple(shown),
        _count(cause.waiting),
        (*causes.next_lines(cause, lab), causes.again(cause)),
    )


def _title(cause: Cause, named: Sequence[FaultRow]) -> str:
    """Return the title of a deduction: the fault's name, or what this submission returned if the name fits any file."""
    if not named:
        known = [words.fault_in_words(each) for each in cause.faults]
        return _sentence("; ".join(known)) if known else printable(cause.checks[0].title, 300)
    got = {line.text for check in cause.checks for line in words.row(check, "", LabName()).lines if line.label == "Got"}
    if all(fault.group == "any" for fault in named) and len(got) == 1:
        return _sentence(got.pop().partition("\n")[0])
    return _sentence("; ".join(fault.title for fault in named))


def _says(title: str, lines: Iterable[words.LabelledLine]) -> bool:
    """Return whether the title already tells what the submission returned, so that the lines need not."""
    return title in {_sentence(line.text) for line in lines if line.label == "Got"}


def _sentence(text: str) -> str:
    """Capitalize a title unless it begins with an identifier, whose letters have to stay."""
    return text[:1].upper() + text[1:] if text.partition(" ")[0].isalpha() else text


def _unreached(checks: list[CheckResult]) -> Deduction:
    return Deduction(words.minus(words.points_lost(checks)), "Not graded", (), (), _count(checks), ())


def _count(checks: Sequence[CheckResult]) -> str:
    """Return the number and points of checks as ``5 checks, 14 points``; "" without checks."""
    points = words.number(round(words.points_lost(checks), 2))
    return f"{words.counted(len(checks), 'check')}, {points} points" if checks else ""


def anchor(check: CheckResult) -> str:
    """Return the HTML id of a check's row, to which other places of the page link."""
    return check.id.replace(".", "-")
