"""Lay out lines of a terminal: text after a label, points at the right edge. Lines in a pipe are neither padded nor wrapped."""

from __future__ import annotations

from dataclasses import dataclass

from rich.console import Console
from rich.text import Text

LABEL = "bright_black"
_INDENT, _LABEL_WIDTH, _SIGN_WIDTH, _GAP = 3, 10, 12, 2


@dataclass(frozen=True)
class Setting:
    """How lines are laid out on one console, which is a terminal or a pipe; all output of a result goes through it.

    Attributes
    ----------
    width
        Columns of a line; None for a pipe, where lines are not wrapped.
    """

    console: Console
    width: int | None

    @property
    def bars(self) -> bool:
        """Return whether to show a criterion's points as a bar: the console is a terminal, wide enough and able to print it."""
        return self.width is not None and self.width >= 60 and self.console.encoding.startswith("utf")

    def head(self, sign: Text, title: str, points: str, style: str = "") -> list[Text]:
        """Return the first lines of a check: the sign of its outcome, its title (in `style`), and its points at the right end."""
        first = sign.copy()
        first.append(" " * (max(1, _SIGN_WIDTH - len(first)) if self.width is not None else _GAP))
        return self.hang(first, Text(title, style), points)

    def labelled(self, label: str, text: str) -> list[Text]:
        """Return the lines of a text below a check, behind a label such as "Got"; "" is no label."""
        return self.hang(Text(" " * _INDENT + label.ljust(_LABEL_WIDTH if label else 0), LABEL), Text(text))

    def hang(self, head: Text, body: Text, tail: str = "") -> list[Text]:
        """Return `head`, then `body` wrapped below its own beginning, and `tail` at the right end of the first line."""
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
