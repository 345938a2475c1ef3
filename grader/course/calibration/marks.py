"""Marks that a person gave by hand, as a CSV with a row for each submission and criterion: reading, checking, writing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.base import tables
from grader.base.errors import RequestError
from grader.base.files import read_file
from grader.base.text import csv_cell, decimal, printable

NEEDED = ("id", "criterion", "points")
COLUMNS = (*NEEDED, "low", "high", "comment", "rubric")
_MOST_BYTES = 4_000_000
_LONGEST_COMMENT = 2000

Cell = tuple[str, str]
"""A submission's id and a criterion's id."""


@dataclass(frozen=True)
class Mark:
    """Points that a person gives one criterion by hand, the range from `low` to `high` that they accept too, and a comment."""

    points: float
    low: float
    high: float
    comment: str = ""

    def accepts(self, points: float) -> bool:
        return self.low - 1e-6 <= points <= self.high + 1e-6


@dataclass(frozen=True)
class Marks:
    """The marks that one person gave by hand to a sample of the class, as read from a CSV.

    `marker` names the person. `cells` maps submission id and criterion id to the mark. `ids` are all submissions of the table,
    marked or not. `rubrics` holds the digests of the rubrics shown to the person; empty for a table without them.
    """

    marker: str
    cells: Mapping[Cell, Mark]
    ids: tuple[str, ...] = ()
    rubrics: frozenset[str] = frozenset()


def read_marks(path: Path, find: Callable[[str], str], most: Mapping[Cell, float]) -> Marks:
    """Read one person's marks from a CSV, to compare them with the grades. A row without points is unchecked and gives no mark.

    Parameters
    ----------
    path
        A CSV with the columns id, criterion and points, in any order; low, high, comment and rubric are optional.
    find
        Returns the id of the submission that a name or number in the column `id` means.
    most
        The maximum points of all that can be marked, by submission id and criterion id.

    Raises
    ------
    RequestError
        If the file is no such table, or a row is wrong; the message names the file and the line of the first wrong row.
    """
    source = printable(str(path), 500)
    data = read_file(path, _MOST_BYTES, "give the path of a CSV file with marks")
    table = tables.titled(data, source, NEEDED, COLUMNS)
    rows = [(line, {title: _plain(cell) for title, cell in row.items()}) for line, row in table]
    found: dict[Cell, Mark] = {}
    for line, row in rows:
        word, criterion, points = (row.get(name, "") for name in NEEDED)
        if not points:
            continue
        try:
            cell = find(word), criterion
            criteria = [name for id_, name in most if id_ == cell[0]]
            if not criteria:
                raise RequestError(f"no submission {printable(word)} in this class; give an id, a name or an address")
            if criterion not in criteria:
                raise RequestError(f"no criterion {printable(criterion)}; the criteria are {', '.join(criteria)}")
            if cell in found:
                raise RequestError(f"a second mark for {printable(word)} in {criterion}; remove one of the two rows")
            found[cell] = parse_mark(row, most[cell])
        except RequestError as problem:
            raise RequestError(f"{source}:{line}: {problem}") from problem
    rubrics = frozenset(filter(None, (row.get("rubric") for _, row in rows)))
    return Marks(printable(path.stem, 60), found, tuple(dict.fromkeys(row.get("id", "") for _, row in rows)), rubrics)


def _plain(text: str) -> str:
    """Return a CSV cell without surrounding spaces, and without the apostrophe by which our CSV files disarm formulas."""
    return (text[1:] if text[1:] and csv_cell(text[1:]) == text else text).strip()


def parse_mark(row: Mapping[str, str], most: float) -> Mark:
    """Parse a row's points, low, high and comment, as typed, into a mark; a blank low or high takes the value of points.

    Raises
    ------
    RequestError
        If a field is no number from 0 to `most`, the criterion's maximum, or points lie outside low to high.
    """
    points, low, high = (_number(row, name, most) for name in ("points", "low", "high"))
    if not low <= points <= high:
        raise RequestError(f"points {points:g} lie outside low to high; correct one of the three")
    return Mark(points, low, high, printable(row.get("comment", "").strip(), _LONGEST_COMMENT, newlines=True))


def _number(row: Mapping[str, str], column: str, most: float) -> float:
    text = row.get(column) or row["points"]
    value = decimal(text)
    if value is None or not 0 <= value <= most:
        raise RequestError(f"{column} {printable(text, 40)}: enter a number from 0 to {most:g}, or leave it blank")
    return value


def as_table(cells: Sequence[Cell], marks: Mapping[Cell, Mark], rubric: str) -> str:
    """Return marks as CSV: a row per (submission id, criterion id) in `cells`, blank if unmarked; each has `rubric`, a digest."""
    rows: list[Sequence[str]] = [COLUMNS]
    for cell in cells:
        mark = marks.get(cell)
        given = (f"{mark.points:g}", f"{mark.low:g}", f"{mark.high:g}", mark.comment) if mark else ("",) * 4
        rows.append((*cell, *given, rubric))
    return tables.written(rows)
