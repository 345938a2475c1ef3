"""How a result is told: the same words, labels and order on the terminal and on the pages.

Nothing in here renders; every text that may stem from a submission comes out `printable`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, LabName, Outcome, Result, Status
from grader.ground.text import printable
from grader.people.standing import Standing

TEXT_LIMIT = 2000
NAME_LIMIT = 120
FOR_THE_INSTRUCTOR = frozenset({"tampering"})  # costs nothing by itself, and is not told to students
_LABEL_WIDTH = len("Expected  ")
_LABELLED = re.compile(r"(Expected|Got) {2,}(.*)", re.DOTALL)


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
        outcome=_WORDS[check.outcome],
        title=printable(check.title or check.id, 300),
        points=fraction(check.points, check.max_points) if check.max_points else "",
        lines=(*_message(check.message), *((Line("Try", _text(check.hint)),) if check.hint and lost else ())),
        read=f"{lab.label}, Step {check.lab_step}" if lost and check.lab_step is not None else "",
        again=f"imugrade check --only {part}" if lost else "",
    )


def tells(check: CheckResult) -> bool:
    """Whether a check tells of something that can be mended; a skipped one points to the check that does."""
    return check.outcome not in ("passed", "skipped", "not_judged")


def number(points: float) -> str:
    """At most two decimals, without idle zeros: 20, 87.5, 13.33."""
    return f"{points:.2f}".rstrip("0").rstrip(".")


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


def _message(message: str) -> tuple[Line, ...]:
    """Labelled lines; a line that is indented goes on with the one above it."""
    lines: list[Line] = []
    for text in _text(message).split("\n"):
        labelled = _LABELLED.fullmatch(text)
        if labelled:
            lines.append(Line(labelled[1], labelled[2]))
        elif lines and text.startswith("  "):
            lines[-1] = Line(lines[-1].label, f"{lines[-1].text}\n{_beside(text)}")
        elif text.strip():
            lines.append(Line("", text.strip()))
    return tuple(lines)


def _beside(text: str) -> str:
    """A line that goes on below a label's words; what it is indented by beyond them is its own, a caret's place perhaps."""
    return text[_LABEL_WIDTH:].rstrip() if text.startswith(" " * _LABEL_WIDTH) else text.strip()
