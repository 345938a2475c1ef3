"""Content shared by all CI formats: the parts of a result, a check's text, and what hidden scenarios withhold."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from grader.base.text import printable
from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, LabName, Outcome, Result
from grader.report import causes, words
from grader.report.causes import Cause

Part = CriterionResult | ExtensionResult

NOTES_LIMIT = 20
_LOST: frozenset[Outcome] = frozenset({"failed", "partial", "error", "timeout", "crashed"})
_HELD_BACK = {
    "failed": "It does not do this in a hidden scenario.",
    "partial": "It does a part of this in a hidden scenario.",
    "error": "Your code raised an exception in a hidden scenario.",
    "timeout": "Your code did not answer within the time limit in a hidden scenario.",
    "crashed": "Your code ended its process in a hidden scenario.",
}


def parts(result: Result) -> Iterator[Part]:
    """Yield the criteria, then the attempted extensions."""
    yield from result.criteria
    yield from (extension for extension in result.extensions if extension.attempted and extension.checks)


def title(part: Part) -> str:
    """Return the title of a part, as ``Sensor access`` or ``Extension: allan variance``."""
    if isinstance(part, CriterionResult):
        return printable(part.title, words.NAME_LIMIT)
    return f"Extension: {part.id.replace('_', ' ')}"


def lines(check: CheckResult, part: Part, lab: LabName) -> list[words.Line]:
    """Return the lines of a check with the labels of a report, in the same order: Expected, Got, Try, Read, Rerun."""
    row = words.row(check, part.id, lab)
    more = (words.Line("Read", row.read), words.Line("Rerun", row.again))
    return [*row.lines, *(line for line in more if line.text)]


def plain(check: CheckResult, part: Part, lab: LabName) -> str:
    """Return the lines of a check as text, with the labels in a column."""
    return "\n".join(_plain_line(line) for line in lines(check, part, lab))


def together(cause: Cause, lab: LabName) -> str:
    """Return the text of the checks of one cause, each sentence once."""
    said = [line for _, lines in causes.lines_by_check(cause) for line in lines]
    again = [causes.again(cause)] if words.tells(cause.checks[0]) else []
    return "\n".join(_plain_line(line) for line in [*said, *causes.next_lines(cause, lab), *again])


def _plain_line(line: words.Line) -> str:
    text = line.text.replace("\n", "\n" + " " * 10)
    return f"{line.label:<10}{text}" if line.label else line.text


def notes(result: Result) -> list[str]:
    """Return the repairs and notes, at most `NOTES_LIMIT`, and the number of further ones."""
    lines = [*words.repairs(result), *words.notes(result)]
    more = [f"… and {len(lines) - NOTES_LIMIT} more"] if len(lines) > NOTES_LIMIT else []
    return lines[:NOTES_LIMIT] + more


def lost(check: CheckResult) -> bool:
    """Return whether the check itself found a reason to lose points."""
    return check.outcome in _LOST


def held_back(result: Result) -> Result:
    """Return a result of hidden scenarios as students may see it: what is wrong and the hint, without data of the scenarios.

    Messages are replaced, because an exception's text comes from code that has seen the input.
    """
    return replace(
        result,
        criteria=tuple(replace(part, checks=_held_back(part)) for part in result.criteria),
        extensions=tuple(replace(part, checks=_held_back(part)) for part in result.extensions),
    )


def _held_back(part: Part) -> tuple[CheckResult, ...]:
    return tuple(c.with_message(_HELD_BACK[c.outcome]) if lost(c) else c for c in part.checks)
