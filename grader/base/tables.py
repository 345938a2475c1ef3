"""CSV tables: read in whatever way a spreadsheet saves one, and written so that no spreadsheet takes a cell for a formula."""

from __future__ import annotations

import codecs
import csv
import io
import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass

from grader.base.errors import RequestError
from grader.base.text import csv_cell, decimal


@dataclass(frozen=True)
class Table:
    """The rows of a CSV table, each with the number of its last line, and the delimiter between its cells."""

    rows: list[tuple[int, list[str]]]
    delimiter: str


def read(data: bytes, source: str) -> Table:
    """Read a table with commas, semicolons or tabs, in UTF-8, UTF-16 with a byte order mark, or Windows-1252.

    Raises
    ------
    RequestError
        If it is none of these; the message begins with `source`.
    """
    try:
        text = _text(data)
        head = re.sub('"[^"]*"', "", text.partition("\n")[0])
        delimiter = max(",;\t", key=head.count)
        reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
        return Table([(reader.line_num, cells) for cells in reader], delimiter)
    except (UnicodeDecodeError, csv.Error) as error:
        raise RequestError(f"{source}: is not a CSV file; save it as one, in UTF-8") from error


def titled(
    data: bytes, source: str, needed: Collection[str], columns: Collection[str]
) -> list[tuple[int, dict[str, str]]]:
    """Read a table whose first line names its columns, in any order; return each non-blank row by title, with its line number.

    Raises
    ------
    RequestError
        If it is no table, or lacks a column that is `needed`; the message lists all `columns`.
    """
    (_, titles), *rows = read(data, source).rows or [(1, [])]
    titles = [title.strip().casefold() for title in titles]
    if missing := [name for name in needed if name not in titles]:
        raise RequestError(f"{source}:1: no column {', '.join(missing)}; the columns are {', '.join(columns)}")
    return [(line, dict(zip(titles, cells, strict=False))) for line, cells in rows if any(cells)]


def written(rows: Iterable[Iterable[str]]) -> str:
    """Return the text of a CSV table with these rows, in which no spreadsheet takes a cell for a formula."""
    stream = io.StringIO()
    table = csv.writer(stream, lineterminator="\n")
    table.writerows([text if decimal(text) is not None else csv_cell(text) for text in row] for row in rows)
    return stream.getvalue()


def _text(data: bytes) -> str:
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252")  # Excel, where it is asked for plain CSV
