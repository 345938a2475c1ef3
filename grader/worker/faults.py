"""Describe an exception of the student's code as plain data: type, message, and the place in the student's own file."""

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
    """Return the file name under which student code is compiled: a prefix that marks it, and its path in the submission."""
    return _OWN_PREFIX + path


def is_own(name: str) -> bool:
    """Return whether a file name, as of a stack frame, is that of student code, so that messages name the student's line."""
    return name.startswith(_OWN_PREFIX)


def fault_at(path: str, line: int, message: str) -> dict[str, Any]:
    """Return a fault at `line` of `path` that raised nothing, such as a merge conflict, as a dict with the keys of `describe`."""
    return {"type": "", "message": message, "file": path[:200], "line": line, "text": None, "name": None}


def describe(error: BaseException) -> dict[str, Any]:
    """Describe an exception as plain data: what was raised, and the innermost line of the student's code that was running.

    Returns
    -------
    dict
        ``type``, ``message`` (at most 400 characters, memory addresses masked so that a regrade reads the same); ``file``, ``line``
        and ``text`` (None without student code on the stack); ``name`` (of a missing module, name or attribute, else None).
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
    """Return the name of an exception's type as `type` stores it, because a student's metaclass may define another `__name__`."""
    return str(_NAME_OF_TYPE(type(error)))[:100]


def is_a(error: BaseException, kind: type[BaseException]) -> bool:
    """Return whether an exception is of a type. `isinstance` would ask its `__class__`, which may be student code."""
    return issubclass(type(error), kind)


def attribute_of(error: BaseException, name: str, kind: type[T]) -> T | None:
    """Return an exception's attribute if its value is exactly of type `kind`; None if it is not, is missing, or cannot be read."""
    try:
        value = getattr(error, name, None)
    except BaseException:
        return None
    return value if type(value) is kind else None


def _line_with_caret(error: BaseException) -> str:
    """Return the line with the syntax error, and below it a caret at the column that Python names; no caret below a long line."""
    filename, lineno = attribute_of(error, "filename", str) or "", attribute_of(error, "lineno", int) or 0
    whole = (attribute_of(error, "text", str) or linecache.getline(filename, lineno)).rstrip()
    line = whole.lstrip()
    column = (attribute_of(error, "offset", int) or 0) - 1 - (len(whole) - len(line))
    return f"{line}\n{' ' * column}^" if 0 <= column <= len(line) <= _LONGEST_POINTED_AT else line


def message_of(error: BaseException) -> str:
    """Return an exception's message, at most 400 characters, with memory addresses masked; "" if the student's `__str__` raises."""
    try:
        text = str(error)
    except BaseException:  # __str__ is the student's code
        text = ""
    return mask_addresses(text)[:400]


def mask_addresses(text: str) -> str:
    """Mask memory addresses and integers of ten digits or more, which differ from run to run, so that two runs give equal texts."""
    return _LONG_INTEGER.sub("…", _ADDRESS.sub("0x…", text))
