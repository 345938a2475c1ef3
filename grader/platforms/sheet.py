"""Editor of a CSV file that another program wrote and will read again: setting a cell keeps all other bytes."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from grader.base.errors import RequestError
from grader.base.text import printable

BOM = b"\xef\xbb\xbf"
_QUOTED = r'"(?:[^"]|"")*"'


@dataclass
class SheetRow:
    """One row of a CSV file as raw cells with its line ending, so that unchanged cells are written back byte by byte."""

    cells: list[str]
    end: str

    def value(self, column: int | None) -> str:
        """Return a cell's text; "" if the row has no such cell, or the column is None."""
        if column is None or column >= len(self.cells):
            return ""
        raw = self.cells[column]
        return raw[1:-1].replace('""', '"') if raw.startswith('"') else raw


@dataclass
class CsvSheet:
    """A CSV file in memory, of which cells are set and all others written back unchanged; the first row holds the titles.

    `marked` says that the file starts with a byte order mark.
    """

    delimiter: str
    rows: list[SheetRow] = field(default_factory=list)
    marked: bool = False

    @property
    def titles(self) -> list[str]:
        return [self.rows[0].value(i).strip() for i in range(len(self.rows[0].cells))]

    def column(self, *titles: str) -> int | None:
        """Return the index of the column with the first of these titles that occurs, regardless of case; None if none does."""
        known = [title.casefold() for title in self.titles]
        return next((known.index(title.casefold()) for title in titles if title.casefold() in known), None)

    def set(self, row: SheetRow, column: int, text: str) -> None:
        """Set a cell, in quotes only if its text needs them; a row that is too short gets empty cells."""
        row.cells += [""] * (column + 1 - len(row.cells))
        needs = any(sign in text for sign in (self.delimiter, '"', "\n", "\r", " "))
        row.cells[column] = '"{}"'.format(text.replace('"', '""')) if needs else text

    def keep(self, columns: list[int]) -> None:
        """Remove all columns except those with these indices, as a platform that imports the file would change the others, too."""
        for row in self.rows:
            row.cells = [row.cells[i] for i in columns if i < len(row.cells)]

    def data(self) -> bytes:
        text = "".join(self.delimiter.join(row.cells) + row.end for row in self.rows)
        return (BOM if self.marked else b"") + text.encode()


def read_sheet(data: bytes, source: str) -> CsvSheet:
    """Parse a CSV file in UTF-8 with commas, semicolons or tabs; `source` is its name in messages.

    Raise RequestError if the file is no CSV file in UTF-8.
    """
    try:
        text = data.removeprefix(BOM).decode()
    except UnicodeDecodeError as error:
        raise RequestError(f"{source}: is not UTF-8; export it again as UTF-8 CSV") from error
    head = re.sub(_QUOTED, "", text.partition("\n")[0])
    sheet = CsvSheet(max(",;\t", key=head.count), marked=data.startswith(BOM))
    cell = re.compile(
        rf'({_QUOTED}|[^"{sheet.delimiter}\r\n][^{sheet.delimiter}\r\n]*|)({sheet.delimiter}|\r\n|\n|\r|\Z)'
    )
    cells: list[str] = []
    at = 0
    while at < len(text):
        found = cell.match(text, at)
        if found is None:
            raise RequestError(f"{source}:{text.count(chr(10), 0, at) + 1}: is not CSV here; export the file again")
        cells.append(found[1])
        at = found.end()
        if found[2] != sheet.delimiter:
            sheet.rows.append(SheetRow(cells, found[2]))
            cells = []
        elif at == len(text):
            cells.append("")
    if cells:
        sheet.rows.append(SheetRow(cells, ""))
    if not sheet.rows:
        raise RequestError(f"{printable(source)}: is empty; give the file that the platform exports")
    return sheet
