"""Breakpoints left in a submission. The sandbox skips them, and a note says so."""

from __future__ import annotations

import re
from collections.abc import Iterator

_MOST_BYTES = 400_000
_CALL = re.compile(
    r"#[^\n]*|\"\"\".*?(?:\"\"\"|\Z)|'''.*?(?:'''|\Z)|\"(?:\\.|[^\"\\\n])*\"?|'(?:\\.|[^'\\\n])*'?"
    r"|\b(breakpoint|(?:\w{1,40}\.)?set_trace)[ \t]*\(",
    re.DOTALL,
)
"""Matches comments and strings first, so that a breakpoint inside one is not counted."""


def breakpoints(source: bytes) -> Iterator[tuple[str, int]]:
    """Yield each breakpoint call in a program's text with its line number, for a note: ``pdb.set_trace``, 12. No code is run."""
    text = source[:_MOST_BYTES].decode("utf-8", "replace")
    for found in _CALL.finditer(text):
        if found[1]:
            yield found[1], text.count("\n", 0, found.start()) + 1
