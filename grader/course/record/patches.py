"""Unified diffs of one text file: creation, and exact application, so that a patch never lands at another place.

The format is that of ``diff -u``: https://www.gnu.org/software/diffutils/manual/html_node/Detailed-Unified.html
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator, Sequence

from grader.base.errors import RequestError
from grader.base.text import printable

LARGEST = 1_000_000
"""Bytes of a diff or of a patched file. The longest honest program has a twentieth of it."""
_HUNK = re.compile(rb"@@ -(\d{1,9})(?:,(\d{1,9}))? \+\d{1,9}(?:,(\d{1,9}))? @@")
_NO_NEWLINE = b"\\ No newline at end of file\n"


def diff_of(path: str, before: bytes, after: bytes) -> str:
    """Return the unified diff from `before` to `after` of the file `path`; "" if equal. Bad UTF-8 becomes lone surrogates."""
    name = printable(path, 200)
    old, new = ([line.decode("utf-8", "surrogateescape") for line in _lines(each)] for each in (before, after))
    found = difflib.unified_diff(old, new, f"a/{name}", f"b/{name}")
    return "".join(line if line.endswith("\n") else f"{line}\n{_NO_NEWLINE.decode()}" for line in found)


def apply_patch(before: bytes, diff: str, place: str = "patch") -> bytes:
    """Apply a unified diff to a file's bytes and return the new bytes; error messages begin with `place`.

    Raises
    ------
    RequestError
        If the diff is not one of a single file, or a line of it is not exactly where it says.
    """
    data = diff.encode("utf-8", "surrogateescape")
    if max(len(data), len(before)) > LARGEST:
        raise RequestError(f"{place}: more than {LARGEST} bytes")
    lines, after, at = _lines(before), [], 0
    for start, old, new in _hunks(_lines(data), place):
        if start < at or lines[start : start + len(old)] != old:
            raise RequestError(f"{place}: the lines from {start + 1} on do not match the file; make the diff again")
        after += [*lines[at:start], *new]
        at = start + len(old)
    return b"".join([*after, *lines[at:]])


def _lines(content: bytes) -> list[bytes]:
    """Split bytes into lines at each newline only, as ``diff`` does; the newlines stay."""
    *lines, last = content.split(b"\n")
    return [line + b"\n" for line in lines] + ([last] if last else [])


def _hunks(diff: Sequence[bytes], place: str) -> Iterator[tuple[int, list[bytes], list[bytes]]]:
    """Yield each hunk of a diff: its first line in the old file, counted from 0, its old lines, and its new lines."""
    at = next((at for at, line in enumerate(diff) if line.startswith(b"--- ")), len(diff))
    if not diff[at + 1 : at + 2] or not diff[at + 1].startswith(b"+++ "):
        raise RequestError(f"{place}: not a unified diff; make one with `diff -u OLD NEW` or `git diff`")
    at += 2
    while at < len(diff):
        head = _HUNK.match(diff[at])
        if head is None:
            raise RequestError(f"{place}, line {at + 1}: no hunk of a diff of one file begins there")
        counts = [1 if count is None else int(count) for count in head.group(2, 3)]
        old, new, at = _hunk(diff, at + 1, counts, place)
        start = int(head[1]) - (1 if counts[0] else 0)  # an empty hunk stands behind the line that it names
        yield start, old, new


def _hunk(diff: Sequence[bytes], at: int, counts: Sequence[int], place: str) -> tuple[list[bytes], list[bytes], int]:
    """Parse the hunk at line `at`, with `counts` old and new lines; return both, and the index after it; else RequestError."""
    old: list[bytes] = []
    new: list[bytes] = []
    while (len(old), len(new)) != tuple(counts) or diff[at : at + 1] == [_NO_NEWLINE]:
        line = diff[at] if at < len(diff) else b""
        sides = {b" ": (old, new), b"-": (old,), b"+": (new,)}.get(line[:1])
        if line == _NO_NEWLINE and (old or new):
            for side in {b" ": (old, new), b"-": (old,), b"+": (new,)}[diff[at - 1][:1]]:
                side[-1] = side[-1].removesuffix(b"\n")
        elif sides is None or len(old) > counts[0] or len(new) > counts[1]:
            raise RequestError(f"{place}, line {at + 1}: the hunk has other lines than its first line says")
        else:
            for side in sides:
                side.append(line[1:])
        at += 1
    return old, new, at
