"""Lines as a terminal shows them: words behind their label, points at the right edge. In a pipe nothing is filled up or broken."""

from __future__ import annotations

from dataclasses import dataclass

from rich.console import Console
from rich.text import Text

LABEL = "bright_black"
_INDENT, _LABEL_WIDTH, _SIGN_WIDTH, _GAP = 3, 10, 12, 2


@dataclass(frozen=True)
class Setting:
    """How lines are set.

    Attributes
    ----------
    width
        Columns of a line; None for a pipe, where each thing is one line.
    """

    console: Console
    width: int | None

    @property
    def bars(self) -> bool:
        """Whether there is room, and are signs, for a bar."""
        return self.width is not None and self.width >= 60 and self.console.encoding.startswith("utf")

    def head(self, sign: Text, title: str, points: str, style: str = "") -> list[Text]:
        """One check: its sign and outcome, its sentence, its points."""
        first = sign.copy()
        first.append(" " * (max(1, _SIGN_WIDTH - len(first)) if self.width is not None else _GAP))
        return self.hang(first, Text(title, style), points)

    def labelled(self, label: str, text: str) -> list[Text]:
        """A line below a check."""
        return self.hang(Text(" " * _INDENT + label.ljust(_LABEL_WIDTH if label else 0), LABEL), Text(text))

    def hang(self, head: Text, body: Text, tail: str = "") -> list[Text]:
        """`body` behind `head`, as many lines as it takes, and `tail` at the end of the first."""
        indent, room = head.cell_len, self._room(head, tail)
        rows = [row for line in body.split("\n", allow_blank=True) for row in self._wrapped(line, room)] or [Text()]
        lines = [head.copy().append_text(rows[0]), *(Text(" " * indent).append_text(row) for row in rows[1:])]
        if tail:
            lines[0].append(self._gap(lines[0], tail)).append(tail)
        for line in lines:
            line.rstrip()
        return lines

    def _room(self, head: Text, tail: str) -> int | None:
        if self.width is None:
            return None
        return max(10, self.width - head.cell_len - (len(tail) + _GAP if tail else 0))

    def _wrapped(self, line: Text, room: int | None) -> list[Text]:
        return [line] if room is None else list(line.wrap(self.console, room)) or [Text()]

    def _gap(self, line: Text, tail: str) -> str:
        return " " * (_GAP if self.width is None else max(_GAP, self.width - line.cell_len - len(tail)))
