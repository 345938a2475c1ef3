"""Collect what a student's own code printed, by the criterion that was being checked, for `imugrade check --prints`.

The code is called many times, so equal lines are counted instead of repeated.
"""

from __future__ import annotations

from collections import Counter

from rich.text import Text

from grader.base.text import printable
from grader.engine.lab import Lab

_MOST_LINES, _LONGEST = 30, 300


class Prints:
    """Lines that student code printed, by the criterion that was checked, each with how often it was printed."""

    def __init__(self) -> None:
        self._lines: dict[str, Counter[str]] = {}

    def add(self, part: str, text: str) -> None:
        """Add text that was printed while the criterion or bonus task with the id `part` was checked; blank lines are left out."""
        lines = [printable(line, _LONGEST) for line in text.splitlines() if line.strip()]
        self._lines.setdefault(part, Counter()).update(lines)

    def clear(self) -> None:
        """Remove all recorded lines, before the next check of `--watch`."""
        self._lines.clear()

    def lines(self, lab: Lab) -> list[Text]:
        """Return lines to show: under each criterion's title, from `lab`, what was printed, in order; or that nothing was."""
        lines = [Text(), Text("Printed by your code")]
        for part, counted in self._lines.items():
            if counted:
                title = Text(f"While checking: {lab.titles.get(part, 'extensions')}", "bold")
                lines += [Text(), title, *_first(counted)]
        return lines if len(lines) > 2 else [Text(), Text("Your code printed nothing.")]


def _first(counted: Counter[str]) -> list[Text]:
    shown = [f"  {line}{f'  (×{count})' if count > 1 else ''}" for line, count in counted.items()]
    more = len(shown) - _MOST_LINES
    return [Text(line) for line in shown[:_MOST_LINES]] + ([Text(f"  … {more} more lines")] if more > 0 else [])
