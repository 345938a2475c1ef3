"""A table that a person saved from a spreadsheet, in whatever way theirs saves one."""

from __future__ import annotations

import codecs
import csv
import io
from typing import Any


def reader(data: bytes) -> Any:
    """Return a `csv.reader` for a table with commas, semicolons or tabs, in UTF-8, UTF-16 with a byte order mark, or Windows-1252.

    Raises
    ------
    UnicodeDecodeError
        If it is none of these.
    """
    text = _text(data)
    head = text.partition("\n")[0]
    return csv.reader(io.StringIO(text, newline=""), delimiter=max(",;\t", key=head.count))


def _text(data: bytes) -> str:
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252")  # Excel, where it is asked for plain CSV
