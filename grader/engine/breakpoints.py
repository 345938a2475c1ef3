"""Break points that a submission still holds: the sandbox passes over them, and a note says so."""

from __future__ import annotations

import re
from collections.abc import Iterator

_MOST_BYTES = 400_000
_CALL = re.compile(
    r"#[^\n]*|\"\"\".*?(?:\"\"\"|\Z)|'''.*?(?:'''|\Z)|\"(?:\\.|[^\"\\\n])*\"?|'(?:\\.|[^'\\\n])*'?"
    r"|\b(breakpoint|(?:\w{1,40}\.)?set_trace)[ \t]*\(",
    re.DOTALL,
)
"""Comments and strings are matched so that what stands in them is not."""


def breakpoints(source: bytes) -> Iterator[tuple[str, int]]:
    """What a program calls, and the line: ``pdb.set_trace``, 12. Its text alone is looked at."""
    text = source[:_MOST_BYTES].decode("utf-8", "replace")
    for found in _CALL.finditer(text):
        if found[1]:
            yield found[1], text.count("\n", 0, found.start()) + 1
