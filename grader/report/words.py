"""How a result is told: the same words, labels and order on the terminal and on the pages.

Nothing in here renders; every text that may stem from a submission comes out `printable`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING

from grader.ground.text import printable

if TYPE_CHECKING:  # `imugrade explain` needs a word of these, and no result
    from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, LabName, Outcome, Result, Status
    from grader.people.standing import Standing

TEXT_LIMIT = 2000
NAME_LIMIT = 120
FOR_THE_INSTRUCTOR = frozenset({"tampering"})  # costs nothing by itself, and is not told to students


@dataclass(frozen=True)
class Word:
    """An outcome in a word and a sign; `kind` is one of the four ways of colouring it: never the colour alone."""

    word: str
    sign: str
    kind: str


_WORDS: dict[Outcome, Word] = {
    "passed": Word("earned", "✓", "earned"),
    "partial": Word("partly", "◐", "partly"),
    "failed": Word("lost", "✗", "lost"),
    "error": Word("raised", "✗", "lost"),
    "timeout": Word("timed out", "✗", "lost"),
    "crashed": Word("crashed", "✗", "lost"),
    "skipped": Word("skipped", "–", "blank"),
    "not_judged": Word("not judged", "?", "blank"),
}

STATUS: dict[Status, str] = {
    "graded": "",
    "incomplete": "Part of this could not be judged, through a fault of the grader. Those points are open, not lost.",
    "empty": "Nothing that the lab asks for was found in this submission.",
    "unreadable": "This submission could not be opened.",
}


@dataclass(frozen=True)
class Line:
    """One labelled line below a check: Expected, Got, Try, Read or Again; without a label, a plain sentence."""

    label: str
    text: str


@dataclass(frozen=True)
class Row:
    """One check, ready to be set."""

    outcome: Word
    title: str
    points: str
    lines: tuple[Line, ...]
    read: str
    again: str


def row(check: CheckResult, part: str, lab: LabName) -> Row:
    """Set one check of the criterion or extension `part` of a lab."""
    lost = tells(check)
    return Row(
        outcome=_WORDS[_outcome(check)],
        title=printable(check.title or check.id, 300),
        points=fraction(check.points, check.max_points) if check.max_points else "",
        lines=(*_lines(check), *((Line("Try", _text(check.hint)),) if check.hint and lost else ())),
        read=f"{lab.label}, Step {check.lab_step}" if lost and check.lab_step is not None else "",
        again=f"imugrade check --only {part}" if lost else "",
    )


def _outcome(check: CheckResult) -> Outcome:
    """A lost check that a price of the rubric leaves some points is partly earned: the word and the number agree."""
    some = check.points is not None and 0.0 < check.points < check.max_points
    return "partial" if some and check.outcome == "failed" else check.outcome


def tells(check: CheckResult) -> bool:
    """Whether a check tells of something that can be mended; a skipped one points to the check that does."""
    return check.outcome not in ("passed", "skipped", "not_judged")


def number(points: float) -> str:
    """At most two decimals, without idle zeros: 20, 87.5, 13.33."""
    return f"{points:.2f}".rstrip("0").rstrip(".")


def minus(points: float) -> str:
    """``−9.5``, with a real minus."""
    return f"−{number(round(points, 2))}"


def points_lost(checks: Iterable[CheckResult]) -> float:
    """What checks have cost; what was not judged has cost nothing."""
    return sum(check.max_points - check.points for check in checks if check.points is not None)


def fraction(points: float | None, of: float) -> str:
    """``14 / 20``; points that are not known are a dash."""
    return f"{'–' if points is None else number(points)} / {number(of)}"


def criterion_points(criterion: CriterionResult) -> str:
    return fraction(None if unjudged(criterion) else criterion.points, criterion.max_points)


def extension_points(extension: ExtensionResult) -> str:
    """``4 of 5 shown`` where an extension earns nothing, its points where it is extra credit."""
    if extension.max_points:
        return fraction(extension.points, extension.max_points)
    shown = sum(check.outcome == "passed" for check in extension.checks)
    return f"{shown} of {len(extension.checks)} shown"


def extra_credit(result: Result) -> str:
    """``10 / 10``; empty where extensions earn nothing."""
    return "" if result.extra_credit_cap is None else fraction(result.extra_credit, result.extra_credit_cap)


def total_points(result: Result) -> str:
    open_ = result.status == "incomplete" or any(map(unjudged, result.criteria))
    return fraction(None if open_ else result.score, result.max_score)


def unjudged(criterion: CriterionResult) -> bool:
    """Whether a check of it could not be judged: its points are then unknown."""
    return any(check.points is None for check in criterion.checks)


def name(result: Result) -> str:
    return printable(result.submission, NAME_LIMIT) or "(no name)"


def person(standing: Standing) -> str:
    """Who handed in, or what was handed in where nobody is known."""
    return printable(standing.name, NAME_LIMIT) or "(no name)"


def late(standing: Standing) -> str:
    """``2 d 3 h``; empty where it is not late."""
    if standing.late is None:
        return ""
    if standing.late.seconds is None:
        return "late"
    hours = -(-standing.late.seconds // 3600)
    days = f"{hours // 24} d {hours % 24} h" if hours >= 24 else f"{hours} h"
    return f"{days}, after the cut-off" if standing.late.refused else days


def instant(stamp: str) -> str:
    """``2026-11-20 20:00 UTC``, from ISO 8601; what is none is left as it is."""
    try:
        return f"{datetime.fromisoformat(stamp):%Y-%m-%d %H:%M %Z}".strip()
    except ValueError:
        return printable(stamp, 40)


def notes(result: Result) -> list[str]:
    return [_text(note) for note in result.notes]


def mistakes(result: Result) -> list[str]:
    """The known mistakes that a student is told of, in words."""
    return [misconception(id_) for id_ in result.misconceptions if id_ not in FOR_THE_INSTRUCTOR]


def misconception(id_: str) -> str:
    """``sensor-id-as-address`` in words."""
    return printable(id_, 80).replace("-", " ")


def _text(text: str) -> str:
    return printable(text, TEXT_LIMIT, newlines=True)


def _lines(check: CheckResult) -> tuple[Line, ...]:
    said = (("", check.said), ("Expected", check.expected), ("Got", check.got))
    return tuple(Line(label, _text(text)) for label, text in said if text)
