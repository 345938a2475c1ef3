"""Find breakpoints left in a submission, such as ``pdb.set_trace()``. The sandbox skips them, and a note tells the student."""

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
    """Yield name and line number of each breakpoint call in a program, ``("pdb.set_trace", 12)``, to note it in the report.

    No code is run. Calls in comments and strings, and those beyond the first 400 kB, are left out.
    """
    text = source[:_MOST_BYTES].decode("utf-8", "replace")
    for found in _CALL.finditer(text):
        if found[1]:
            yield found[1], text.count("\n", 0, found.start()) + 1
