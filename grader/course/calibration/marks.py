"""Marks that a person gave by hand: a CSV with a row for each submission and criterion."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.base import tables
from grader.base.errors import RequestError
from grader.base.files import read_file
from grader.base.text import csv_cell, decimal, printable

NEEDED = ("id", "criterion", "points")
COLUMNS = (*NEEDED, "low", "high", "comment", "rubric")
_MOST_BYTES = 4_000_000
_MOST_PROBLEMS = 10
_LONGEST_COMMENT = 2000

Cell = tuple[str, str]
"""A submission's id and a criterion's id."""


@dataclass(frozen=True)
class Mark:
    """Points that a person gives in one criterion, the range that they would accept too, and their sentence."""

    points: float
    low: float
    high: float
    comment: str = ""

    def accepts(self, points: float) -> bool:
        return self.low - 1e-6 <= points <= self.high + 1e-6


@dataclass(frozen=True)
class Marks:
    """The marks that one person gave by hand to a sample of the class.

    `ids` are all submissions of the table, marked or not. `rubrics` holds the short digests of the rubrics that the marking page
    showed; empty for a table without them.
    """

    marker: str
    cells: Mapping[Cell, Mark]
    ids: tuple[str, ...] = ()
    rubrics: frozenset[str] = frozenset()


def read_marks(path: Path, find: Callable[[str], str], most: Mapping[Cell, float]) -> Marks:
    """Read the marks of one person. Rows without points are left out.

    Parameters
    ----------
    path
        A CSV with the columns `NEEDED`, in any order; the others of `COLUMNS` are optional.
    find
        Returns the id of the submission that a cell of the column `id` names.
    most
        The maximum of each cell that can be marked.

    Raises
    ------
    RequestError
        With a line for each wrong row.
    """
    source = printable(str(path), 500)
    try:
        table = tables.reader(read_file(path, _MOST_BYTES, "give the path of a CSV file with marks"))
        titles = [title.strip().casefold() for title in next(table, [])]
        rows = [(dict(zip(titles, map(_plain, cells), strict=False)), table.line_num) for cells in table if any(cells)]
    except (UnicodeDecodeError, csv.Error) as error:
        raise RequestError(f"{source}: is not a CSV file; save it as one, in UTF-8") from error
    if missing := [name for name in NEEDED if name not in titles]:
        raise RequestError(f"{source}:1: no column {', '.join(missing)}; the columns are {', '.join(COLUMNS)}")
    found: dict[Cell, Mark] = {}
    problems = []
    for row, line in rows:
        try:
            found |= _marked_cell(row, find, most, found)
        except RequestError as problem:
            problems.append(f"{source}:{line}: {problem}")
    if problems:
        more = len(problems) - _MOST_PROBLEMS
        raise RequestError(
            "\n".join([*problems[:_MOST_PROBLEMS], *([f"{source}: and {more} more"] if more > 0 else [])])
        )
    rubrics = frozenset(filter(None, (row.get("rubric", "").strip() for row, _ in rows)))
    ids = tuple(dict.fromkeys(row.get("id", "").strip() for row, _ in rows))
    return Marks(printable(path.stem, 60), found, ids, rubrics)


def _plain(text: str) -> str:
    """Return a cell without the apostrophe that keeps a spreadsheet from taking it for a formula."""
    return text[1:] if text[1:] and csv_cell(text[1:]) == text else text


def _marked_cell(
    row: Mapping[str, str], find: Callable[[str], str], most: Mapping[Cell, float], known: Mapping[Cell, Mark]
) -> dict[Cell, Mark]:
    """Return the mark of one row by its cell; nothing if the row has no points."""
    word, criterion, text = (row.get(name, "").strip() for name in NEEDED)
    if not text:
        return {}
    cell = find(word), criterion
    if cell not in most:
        criteria = [name for id_, name in most if id_ == cell[0]]
        if not criteria:
            raise RequestError(f"no submission {printable(word)} in this class; give an id, a name or an address")
        raise RequestError(f"no criterion {printable(criterion)}; the criteria are {', '.join(criteria)}")
    if cell in known:
        raise RequestError(f"a second mark for {printable(word)} in {criterion}; remove one of the two rows")
    mark = mark_of(row, most[cell])
    return {} if mark is None else {cell: mark}


def mark_of(row: Mapping[str, str], most: float) -> Mark | None:
    """Return the mark in the fields points, low, high and comment as typed; None if the points are blank.

    Raises
    ------
    RequestError
        If a field is not a number from low to high, all between 0 and `most`, the points of the criterion.
    """
    text = row.get("points", "").strip()
    if not text:
        return None
    points = _number(text, "points", most)
    low, high = (_number(row.get(name, ""), name, most, points) for name in ("low", "high"))
    if not low <= points <= high:
        raise RequestError(f"points {printable(text, 40)} lie outside low to high; correct one of the three")
    return Mark(points, low, high, printable(row.get("comment", "").strip(), _LONGEST_COMMENT, newlines=True))


def _number(text: str, column: str, most: float, default: float | None = None) -> float:
    if default is not None and not text.strip():
        return default
    value = decimal(text)
    if value is None or not 0 <= value <= most:
        raise RequestError(f"{column} {printable(text, 40)}: enter a number from 0 to {most:g}, or leave it blank")
    return value


def as_rows(cells: Sequence[Cell], marks: Mapping[Cell, Mark], rubric: str) -> Iterator[Sequence[str]]:
    """Yield the rows of a table of marks, titles first, with blank points for each cell that has no mark yet."""
    yield COLUMNS
    for cell in cells:
        mark = marks.get(cell)
        told = (
            ("", "", "", "")
            if mark is None
            else (*map("{:g}".format, (mark.points, mark.low, mark.high)), mark.comment)
        )
        yield *cell, *told, rubric
