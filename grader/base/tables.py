"""CSV tables: read in any form that spreadsheets save, and written so that no spreadsheet runs a cell as a formula."""

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
    """A CSV table that was read: each row's line number, for messages, and cells; the delimiter, to write the table back."""

    rows: list[tuple[int, list[str]]]
    delimiter: str


def read(data: bytes, source: str) -> Table:
    """Read a CSV table with commas, semicolons or tabs, in UTF-8, UTF-16 with a byte order mark, or Windows-1252.

    Raises
    ------
    RequestError
        If the data is no such table; the message begins with `source`, the name of the file.
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
    """Return (line number, {title: cell}) for each row of a CSV table whose first line holds the column titles, in any order.

    Titles are stripped and in lower case. All columns are returned; a short row lacks its last titles. Blank rows are left out.

    Raises
    ------
    RequestError
        If the data is no table, or a column in `needed` is missing. The message begins with `source`, the name of the file. If a
        column is missing, it lists `columns`: all that the caller reads, optional ones too. They have no other use.
    """
    (_, titles), *rows = read(data, source).rows or [(1, [])]
    titles = [title.strip().casefold() for title in titles]
    if missing := [name for name in needed if name not in titles]:
        raise RequestError(f"{source}:1: no column {', '.join(missing)}; the columns are {', '.join(columns)}")
    return [(line, dict(zip(titles, cells, strict=False))) for line, cells in rows if any(cells)]


def written(rows: Iterable[Iterable[str]]) -> str:
    """Return rows as the text of a CSV file; text that a spreadsheet would run as a formula gets an apostrophe, numbers do not."""
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
