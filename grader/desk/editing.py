"""Submitted text in a form field and back: a browser changes line endings, and the bytes of unchanged lines must stay."""

from __future__ import annotations

import re
from dataclasses import dataclass

LARGEST = 200_000
"""Bytes of a file that is edited in the browser. The longest honest program has a quarter of it."""
_ENDS = re.compile(r"\r\n|\r|\n")
_LOST = re.compile(r"[\x00-\x08\x0b\x0e-\x1f\x7f]")
_BOM = "\ufeff"


@dataclass(frozen=True)
class Editable:
    """A file's text for the repair editor; `why` says why it cannot be edited ("" if it can), `note` warns if it is not UTF-8."""

    text: str = ""
    why: str = ""
    note: str = ""


def editable(path: str, content: bytes) -> Editable:
    """Return a submitted file as text for the repair editor, lines ended by ``\\n``; without text if it cannot be edited."""
    if not path.lower().endswith(".py"):
        return Editable(why="only .py files are edited here; repair others with imugrade repair")
    if len(content) > LARGEST:
        return Editable(why=f"larger than {LARGEST // 1000} kB; repair it with imugrade repair")
    text, note = _decoded(content)
    if _LOST.search(text):
        return Editable(why="contains control characters that a browser drops; repair it with imugrade repair")
    return Editable(_ENDS.sub("\n", text), note=note)


def as_bytes(before: bytes, text: str) -> bytes:
    """Return the bytes of a file from its edited text, so that its diff shows the edit alone.

    Lines above the first change and below the last one are copied from `before`. The others get the file's usual line ending.
    """
    was, _ = _decoded(before)
    old, new = (_ENDS.sub("\n", each).split("\n") for each in (was, text))
    ends = _ENDS.findall(was)
    usual = max(set(ends), key=ends.count, default="\n")
    same = min(len(old), len(new))
    top = next((at for at in range(same) if old[at] != new[at]), same)
    bottom = next((at for at in range(same - top) if old[-1 - at] != new[-1 - at]), same - top)
    kept = [*ends[:top], *[usual] * (len(new) - 1)][: len(new) - 1]
    if bottom > 1:
        kept[1 - bottom :] = ends[1 - bottom :]
    joined = "".join(line + end for line, end in zip(new, [*kept, ""], strict=True))
    return (_BOM * (was.startswith(_BOM) and not joined.startswith(_BOM)) + joined).encode()


def _decoded(content: bytes) -> tuple[str, str]:
    try:
        return content.decode(), ""
    except UnicodeDecodeError:
        note = "This file is not UTF-8. It is shown as Windows-1252 and saved as UTF-8."
        return content.decode("cp1252", "replace"), note
