"""Describe an exception of the student's code: type, message, and the place in the student's own file."""

from __future__ import annotations

import linecache
import re
import traceback
from typing import Any, TypeVar

T = TypeVar("T")

_ADDRESS = re.compile(r"0x[0-9a-fA-F]{6,}")
_LONG_INTEGER = re.compile(r"(?<![\d.])\d{10,}(?![\d.])")
_LAST_LINE = 1_000_000_000
_NAME_OF_TYPE = vars(type)["__name__"].__get__
_LONGEST_POINTED_AT = 90  # columns; of a longer line the caret would stand below something else
_OWN_PREFIX = "<submission>/"  # the file name that compiled student code carries


def own_name(path: str) -> str:
    """Return the file name that compiled student code carries: a fixed prefix and the path in the submission."""
    return _OWN_PREFIX + path


def is_own(name: str) -> bool:
    """Return whether a file name is that of a student's code."""
    return name.startswith(_OWN_PREFIX)


def fault_at(path: str, line: int, message: str) -> dict[str, Any]:
    """Return facts in the form of `describe` for a line that is reported although it did not raise."""
    return {"type": "", "message": message, "file": path[:200], "line": line, "text": None, "name": None}


def describe(error: BaseException) -> dict[str, Any]:
    """Return the facts of an exception: what was raised, and the innermost line of the student's code that was running.

    Returns
    -------
    dict
        ``type``, ``message`` (first 400 characters, memory addresses removed so that a regrade reads the same), ``file``,
        ``line``, ``text`` (None where no student frame is on the stack), ``name`` (of a missing module, name or attribute).
    """
    found: dict[str, Any] = {
        "type": type_name(error),
        "message": message_of(error),
        "file": None,
        "line": None,
        "text": None,
    }
    if is_a(error, SyntaxError) and (attribute_of(error, "filename", str) or "").startswith(_OWN_PREFIX):
        found |= {
            "file": attribute_of(error, "filename", str),
            "line": attribute_of(error, "lineno", int),
            "text": _line_with_caret(error),
            "message": (attribute_of(error, "msg", str) or "")[:400],
        }
    else:
        try:
            frames = traceback.extract_tb(error.__traceback__)
        except BaseException:  # a hostile exception may lie about its traceback
            frames = traceback.StackSummary()
        own = [frame for frame in frames if frame.filename.startswith(_OWN_PREFIX)]
        if own:
            found |= {"file": own[-1].filename, "line": own[-1].lineno, "text": own[-1].line}
    if found["file"]:
        found["file"] = str(found["file"])[len(_OWN_PREFIX) :][:200]
    found["text"] = str(found["text"])[:200] if found["text"] else None
    if not isinstance(found["line"], int) or abs(found["line"]) > _LAST_LINE:
        found["line"] = None
    named = is_a(error, ImportError) or is_a(error, NameError) or is_a(error, AttributeError)
    found["name"] = (attribute_of(error, "name", str) or "")[:100] or None if named else None
    return found


def type_name(error: BaseException) -> str:
    """Return the name of an exception's type, even if its metaclass defines `__name__`."""
    return str(_NAME_OF_TYPE(type(error)))[:100]


def is_a(error: BaseException, kind: type[BaseException]) -> bool:
    """Return whether an exception is of a type. `isinstance` would ask its `__class__`, which may be student code."""
    return issubclass(type(error), kind)


def attribute_of(error: BaseException, name: str, kind: type[T]) -> T | None:
    """Return an attribute of an exception; None if it is of another type, or if student code computes it and raises."""
    try:
        value = getattr(error, name, None)
    except BaseException:
        return None
    return value if type(value) is kind else None


def _line_with_caret(error: BaseException) -> str:
    """Return the line with the syntax error, and below it a caret at the column that Python names."""
    filename, lineno = attribute_of(error, "filename", str) or "", attribute_of(error, "lineno", int) or 0
    whole = (attribute_of(error, "text", str) or linecache.getline(filename, lineno)).rstrip()
    line = whole.lstrip()
    column = (attribute_of(error, "offset", int) or 0) - 1 - (len(whole) - len(line))
    return f"{line}\n{' ' * column}^" if 0 <= column <= len(line) <= _LONGEST_POINTED_AT else line


def message_of(error: BaseException) -> str:
    """Return an exception's message with addresses masked, at most 400 characters."""
    try:
        text = str(error)
    except BaseException:  # __str__ is the student's code
        text = ""
    return mask_addresses(text)[:400]


def mask_addresses(text: str) -> str:
    """Mask memory addresses and other long integers, which differ from run to run, so that two runs give equal texts."""
    return _LONG_INTEGER.sub("…", _ADDRESS.sub("0x…", text))
