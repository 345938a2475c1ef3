"""CSV tables: read in whatever way a spreadsheet saves one, and written so that no spreadsheet takes a cell for a formula."""

from __future__ import annotations

import codecs
import csv
import io
import re
from collections.abc import Iterable
from typing import Any

from grader.base.text import csv_cell, decimal


def reader(data: bytes) -> Any:
    """Return a `csv.reader` for a table with commas, semicolons or tabs, in UTF-8, UTF-16 with a byte order mark, or Windows-1252.

    Raises
    ------
    UnicodeDecodeError
        If it is none of these.
    """
    text = _text(data)
    head = re.sub('"[^"]*"', "", text.partition("\n")[0])
    return csv.reader(io.StringIO(text, newline=""), delimiter=max(",;\t", key=head.count))


def written(rows: Iterable[Iterable[str]]) -> str:
    """Return the text of a CSV table with these rows."""
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
