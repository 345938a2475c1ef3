"""Telling what a student's code raised: type, message, and the place in the student's own file."""

from __future__ import annotations

import linecache
import re
import traceback
from typing import Any

_ADDRESS = re.compile(r"0x[0-9a-fA-F]{6,}")
_LONGEST_POINTED_AT = 90  # columns; of a longer line the caret would stand below something else
_OWN_PREFIX = "<submission>/"  # the file name that compiled student code carries


def own_name(path: str) -> str:
    return _OWN_PREFIX + path


def path_of(own: str) -> str:
    """The submission's path of a file name that `own_name` made."""
    return own.removeprefix(_OWN_PREFIX)


def is_own(name: str) -> bool:
    """Whether a file name is of a student's code."""
    return name.startswith(_OWN_PREFIX)


def told_at(path: str, line: int, message: str) -> dict[str, Any]:
    """Facts as `describe` has them, of a line that raised nothing."""
    return {"type": "", "message": message, "file": path[:200], "line": line, "text": None, "name": None}


def describe(error: BaseException) -> dict[str, Any]:
    """Facts of an exception: what was raised and the innermost line of the student's that was running.

    Returns
    -------
    dict
        ``type``, ``message`` (first 400 characters, memory addresses removed so that a regrade reads the same), ``file``,
        ``line``, ``text`` (None where no student frame is on the stack), ``name`` (of a missing module or name).
    """
    found: dict[str, Any] = {
        "type": type(error).__name__[:100],
        "message": _message(error),
        "file": None,
        "line": None,
        "text": None,
    }
    if isinstance(error, SyntaxError) and (error.filename or "").startswith(_OWN_PREFIX):
        found |= {
            "file": error.filename,
            "line": error.lineno,
            "text": _pointed_at(error),
            "message": str(error.msg)[:400],
        }
    else:
        try:
            frames = traceback.extract_tb(error.__traceback__)
        except Exception:  # a hostile exception may lie about its traceback
            frames = traceback.StackSummary()
        own = [frame for frame in frames if frame.filename.startswith(_OWN_PREFIX)]
        if own:
            found |= {"file": own[-1].filename, "line": own[-1].lineno, "text": own[-1].line}
    if found["file"]:
        found["file"] = str(found["file"])[len(_OWN_PREFIX) :][:200]
    for key in ("text", "line"):
        found[key] = str(found[key])[:200] if key == "text" and found[key] else found[key]
    found["name"] = str(error.name)[:100] if isinstance(error, ImportError | NameError) and error.name else None
    return found


def _pointed_at(error: SyntaxError) -> str:
    """The line that is no Python, and a caret below the place where Python gave up, if it says so."""
    whole = (error.text or linecache.getline(error.filename or "", error.lineno or 0)).rstrip()
    line = whole.lstrip()
    column = (error.offset or 0) - 1 - (len(whole) - len(line))
    return f"{line}\n{' ' * column}^" if 0 <= column <= len(line) <= _LONGEST_POINTED_AT else line


def _message(error: BaseException) -> str:
    try:
        text = str(error)
    except BaseException:  # __str__ is the student's code
        text = ""
    return _ADDRESS.sub("0x…", text)[:400]
