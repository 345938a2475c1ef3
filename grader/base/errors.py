"""Exceptions of a run, by whose fault they are: the user's, the grader's, or the student code's.

`RequestError` is the user's fault (exit code 2), `GraderError` is the grader's (exit code 3). `NoAnswer` and its subclasses are the
student code's: a check is lost, and the run goes on.
"""

from __future__ import annotations

import traceback
from pathlib import Path

from grader.base.text import printable

_PACKAGE = Path(__file__).resolve().parents[1]


class RequestError(Exception):
    """Exception: the user asked for something impossible, such as a bad path. The message says what is wrong; exit code 2.

    Attributes
    ----------
    option : name of the wrong or missing command option, without dashes; "" if the problem concerns no single option
    why : the problem in words for a web form, without the option or file that the message names; by default the message
    """

    def __init__(self, message: str, *, option: str = "", why: str = "") -> None:
        super().__init__(message)
        self.option = option
        self.why = why or message


class GraderError(Exception):
    """Exception: the grader itself failed. A check that raises it is neither passed nor failed; elsewhere, the exit code is 3."""


def fault_text(problem: BaseException, *, message: bool = True) -> str:
    """Return an exception as one line to report: ``ZeroDivisionError at grader/engine/marks.py:31 in marked: division by zero``.

    File and line are the innermost ones in this package or in a check that an instructor added; without such a line they are left
    out. `message` False leaves out the exception's message, which may hold hidden data.
    """
    place = ""
    for frame in traceback.extract_tb(problem.__traceback__):
        path = Path(frame.filename)
        is_ours = path.is_relative_to(_PACKAGE)
        if is_ours or path.parent.name.startswith("own_checks_"):
            file = path.relative_to(_PACKAGE.parent).as_posix() if is_ours else path.name
            place = f" at {file}:{frame.lineno} in {frame.name}"
    said = f": {' '.join(message_of(problem).split())}" if message else ""
    return printable(f"{type(problem).__name__}{place}{said}", 400)


def message_of(problem: BaseException) -> str:
    """Return the text of an exception; if its `__str__` raises, as one in an instructor's check may, return a note that says so."""
    try:
        return str(problem)
    except (Exception, SystemExit) as unsayable:
        return f"its message raises {type(unsayable).__name__}"


class NoAnswer(Exception):  # noqa: N818 - it is an outcome, not an error of ours
    """Exception, base of `TimedOut` and others: a request to run student code got no usable answer; the requesting check fails."""


class TimedOut(NoAnswer):
    """Exception: the process that runs student code did not answer within its limit of CPU time or wall time."""

    def __init__(self, message: str, *, cpu_s: float, wall_s: float) -> None:
        super().__init__(message)
        self.cpu_s = cpu_s
        self.wall_s = wall_s


class Crashed(NoAnswer):
    """Exception: the process that runs student code ended, by a signal or an exit, without an answer."""


class Malformed(NoAnswer):
    """Exception: the process that runs student code sent a reply that breaks the protocol, as tampering code may do."""
