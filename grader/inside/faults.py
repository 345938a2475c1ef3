"""Telling what a student's code raised: type, message, and the place in the student's own file."""

from __future__ import annotations

import re
import traceback
from typing import Any

_ADDRESS = re.compile(r"0x[0-9a-fA-F]{6,}")
_OWN_PREFIX = "<submission>/"  # the file name that compiled student code carries


def own_name(path: str) -> str:
    return _OWN_PREFIX + path


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
            "text": (error.text or "").strip(),
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


def _message(error: BaseException) -> str:
    try:
        text = str(error)
    except BaseException:  # __str__ is the student's code
        text = ""
    return _ADDRESS.sub("0x…", text)[:400]
