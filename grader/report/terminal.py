"""One result as a table on the terminal. Texts are set as `Text`, so nothing in them is taken for markup."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from typing import Protocol

from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from grader import words
from grader.results import CriterionResult, ExtensionResult, Result
from grader.text import printable

WIDTH = 100
_STYLE = {"earned": "green", "partly": "yellow", "lost": "red", "blank": "bright_black"}
_LABEL = "bright_black"
_INDENT, _LABEL_WIDTH, _READ_WIDTH = 3, 9, 27


class ClassTotals(Protocol):
    """What is told of a run over a class."""

    results: dict[str, Result]
    resumed: int
    leftovers: tuple[str, ...]

    @property
    def incomplete(self) -> list[str]: ...


class Found(Protocol):
    """What is told of a finding of `doctor`."""

    @property
    def name(self) -> str: ...

    @property
    def good(self) -> bool | None: ...

    @property
    def text(self) -> str: ...


def show(result: Result, console: Console, *, only: str | None = None) -> None:
    """Print a result, or one criterion or extension of it.

    Parameters
    ----------
    result
        What was found.
    console
        Where to; lines are at most 100 columns wide, however wide the terminal is.
    only
        The id of the one criterion or extension to show.
    """
    width = min(console.width, WIDTH)
    for part in _parts(result, only):
        console.print(_part(part, width), width=width)
        console.print()
    console.print(_closing(result, only), width=width)


def _parts(result: Result, only: str | None) -> list[CriterionResult | ExtensionResult]:
    if result.status in ("empty", "unreadable"):
        return []  # thirty rows would all say so
    attempted = [extension for extension in result.extensions if extension.attempted and extension.checks]
    parts: list[CriterionResult | ExtensionResult] = [*result.criteria, *attempted]
    return parts if only is None else [part for part in parts if part.id == only]


def _part(part: CriterionResult | ExtensionResult, width: int) -> RenderableType:
    title = part.title if isinstance(part, CriterionResult) else f"Extension: {part.id.replace('_', ' ')}"
    rows = [words.row(check, part.id) for check in part.checks]
    return Group(_heading(title, _points(part)), *(_row(row, width) for row in rows))


def _points(part: CriterionResult | ExtensionResult) -> str:
    if isinstance(part, CriterionResult):
        return words.criterion_points(part)
    return words.extension_points(part)


def _heading(title: str, points: str) -> Table:
    line = _grid()
    line.add_column(ratio=1)
    line.add_column(justify="right", no_wrap=True)
    line.add_row(Text(printable(title, 300), "bold"), Text(points, "bold"))
    return line


def _row(row: words.Row, width: int) -> RenderableType:
    head = _grid()
    head.add_column(width=13, no_wrap=True)
    head.add_column(ratio=1)
    head.add_column(justify="right", no_wrap=True)
    outcome = Text(f" {row.outcome.sign} {row.outcome.word}", _STYLE[row.outcome.kind])
    head.add_row(outcome, Text(row.title), Text(row.points))
    return Group(head, *(Padding(line, (0, 0, 0, _INDENT)) for line in _lines(row, width - _INDENT)))


def _lines(row: words.Row, width: int) -> list[RenderableType]:
    """Expected, Got, Try, then what to read and what to run again: in one line where it is wide enough for the command."""
    lines: list[RenderableType] = [_line(line) for line in row.lines]
    again = Text.assemble(("Again".ljust(8), _LABEL), row.again)
    if row.read and row.again and _LABEL_WIDTH + 1 + _READ_WIDTH + len(again) <= width:
        return [*lines, _labelled("Read", Text(row.read.ljust(_READ_WIDTH)).append_text(again))]
    return [
        *lines,
        *(_labelled(label, Text(text)) for label, text in (("Read", row.read), ("Again", row.again)) if text),
    ]


def _line(line: words.Line) -> RenderableType:
    return _labelled(line.label, Text(line.text)) if line.label else Text(line.text)


def _labelled(label: str, text: Text) -> Table:
    table = _grid()
    table.add_column(width=_LABEL_WIDTH, no_wrap=True)
    table.add_column(ratio=1)
    table.add_row(Text(label, _LABEL), text)
    return table


def _grid() -> Table:
    return Table.grid(expand=True, padding=(0, 1, 0, 0))


def _closing(result: Result, only: str | None) -> RenderableType:
    """Notes, then the score (of a part there is none), then what stands in the way of one."""
    notes = [Text(f"Note  {note}") for note in words.notes(result)]
    status = [Text(words.STATUS[result.status], "bold")] if words.STATUS[result.status] else []
    total = [_heading("Score", words.total_points(result))] if only is None else []
    extra = [_heading("Extra credit", words.extra_credit(result))] if total and words.extra_credit(result) else []
    return Group(*notes, *status, *total, *extra)


def show_class(outcome: ClassTotals, index: str, console: Console) -> None:
    """The last lines of a run over a class: how many, the mean, who needs attention, where to look."""
    scores = [result.score for result in outcome.results.values() if result.status != "incomplete"]
    fresh = len(outcome.results) - outcome.resumed
    facts = [f"{fresh} graded"] + ([f"{outcome.resumed} on record"] if outcome.resumed else [])
    facts += [f"mean {statistics.fmean(scores):.1f}"] if scores else []
    console.print(Text(" · ".join(facts)), soft_wrap=True)
    for leftover in outcome.leftovers:
        console.print(Text(f"Not placed: {printable(leftover, 300)}"), soft_wrap=True)
    if outcome.incomplete:
        names = ", ".join(printable(id_, words.NAME_LIMIT) for id_ in outcome.incomplete)
        console.print(
            Text(f"Not judged, through a fault of the grader: {names}. Run again: only these are done anew."),
            soft_wrap=True,
        )
    console.print(Text(f"Open {printable(index, 1000)}"), soft_wrap=True)


def show_findings(sections: Sequence[tuple[str, Sequence[Found]]], console: Console) -> None:
    """What `doctor` found, a heading and its lines at a time."""
    for heading, findings in sections:
        console.print(Text(heading, "bold"))
        table = _grid()
        table.add_column(width=3, no_wrap=True)
        table.add_column(width=14, no_wrap=True)
        table.add_column(ratio=1)
        for finding in findings:
            sign = {True: "✓", False: "✗", None: " "}[finding.good]
            table.add_row(Text(f" {sign}"), Text(finding.name), Text(printable(finding.text, 500)))
        console.print(table)
