"""The display of `imugrade check --watch`: the current state, then as much of the last result as the terminal holds."""

from __future__ import annotations

from collections.abc import Callable

from rich.console import Console
from rich.text import Text

from grader.report.terminal import show_line

Lines = Callable[[], list[Text]]


class WatchView:
    """Display of `check --watch`: on a terminal a screen that is redrawn, in a pipe one result after the other.

    Parameters
    ----------
    name
        Name of the watched submission.
    command
        Command that shows the whole result; printed if the terminal is too small for all lines.
    """

    def __init__(self, console: Console, name: str, command: str) -> None:
        self._console, self._name, self._command = console, name, command
        self._lines: Lines = list  # no lines before the first result
        self._status, self._size = "", console.size

    def tell(self, status: str) -> None:
        """Show what `check --watch` does now, such as "checking", above the last result."""
        self._status = status
        if self._console.is_terminal:
            self._paint()
        else:
            show_line(self._heading(), self._console)

    def show(self, lines: Lines, status: str) -> None:
        """Show a result, whose text `lines` returns, below `status`; if the terminal changes its size, `lines` is called again."""
        self._lines = lines
        self.tell(status)
        if not self._console.is_terminal:
            for line in lines():
                show_line(line, self._console)

    def refit(self) -> None:
        """Lay out the last result again if the size of the terminal has changed; `check --watch` calls this while it waits."""
        if self._console.size != self._size:
            self._paint()

    def _paint(self) -> None:
        """Clear the terminal; show the status line and the first lines of the last result."""
        self._size = self._console.size
        with self._console:  # written at once to avoid flicker
            self._console.clear()
            for line in [self._heading(), Text(), *self._top()]:
                show_line(line, self._console)

    def _heading(self) -> Text:
        return Text.assemble((self._name, "bold"), "  ", self._status)

    def _top(self) -> list[Text]:
        """Return as many lines of the last result as the terminal holds; the last of these says how many more there are."""
        lines = self._lines()
        room = max(1, self._size.height - 3)  # heading and blank line above, the cursor's line below
        if len(lines) <= room:
            return lines
        return [*lines[: room - 1], Text(f"… {len(lines) - room + 1} more lines: {self._command}", "bright_black")]
