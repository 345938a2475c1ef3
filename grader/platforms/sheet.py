"""Editor of a CSV file that another program wrote and will read again: setting a cell keeps all other cells."""

from __future__ import annotations

import codecs
import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass

from grader.base import tables
from grader.base.errors import RequestError
from grader.base.text import printable


class SheetRow(list[str]):
    """The cells of one row."""

    def value(self, column: int | None) -> str:
        """Return a cell's text; "" for a missing one."""
        return self[column] if column is not None and column < len(self) else ""


@dataclass
class Sheet:
    """Rows of a CSV file, the first one with the titles, and how the file is written: delimiter, line end, byte order mark."""

    rows: list[SheetRow]
    delimiter: str
    end: str
    marked: bool

    @property
    def titles(self) -> list[str]:
        return [title.strip() for title in self.rows[0]]

    def column(self, *titles: str) -> int | None:
        """Return the column with the first of these titles that occurs, regardless of case; None if none does."""
        known = [title.casefold() for title in self.titles]
        return next((known.index(title.casefold()) for title in titles if title.casefold() in known), None)

    def set(self, row: SheetRow, column: int, text: str) -> None:
        row += [""] * (column + 1 - len(row))
        row[column] = text

    def keep(self, columns: Sequence[int]) -> None:
        """Remove all columns of the table except these."""
        for row in self.rows:
            row[:] = [row[i] for i in columns if i < len(row)]

    def data(self) -> bytes:
        stream = io.StringIO()
        csv.writer(stream, delimiter=self.delimiter, lineterminator=self.end).writerows(self.rows)
        return stream.getvalue().encode("utf-8-sig" if self.marked else "utf-8")


def read_sheet(data: bytes, source: str) -> Sheet:
    """Parse the bytes of a CSV file; messages call it `source`.

    Raises
    ------
    RequestError
        If it is no CSV file.
    """
    try:
        table = tables.reader(data)
        rows = [SheetRow(cells) for cells in table]
    except (UnicodeDecodeError, csv.Error) as error:
        raise RequestError(f"{printable(source)}: is not a CSV file; export it again, as UTF-8 CSV") from error
    if not rows:
        raise RequestError(f"{printable(source)}: is empty; give the file that the platform exports")
    end = "\r\n" if b"\r\n" in data else "\n"
    return Sheet(rows, table.dialect.delimiter, end, data.startswith(codecs.BOM_UTF8))
