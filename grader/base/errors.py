"""The ways in which a run can go wrong, and whose fault each of them is.

A request that cannot be met is the caller's (exit code 2), a broken grader is ours (exit code 3). What a student's code
does is never an error of the run: `NoAnswer` and its kinds end in a lost check.
"""

from __future__ import annotations

import traceback
from pathlib import Path

from grader.base.text import printable

_PACKAGE = Path(__file__).resolve().parents[1]


class RequestError(Exception):
    """The request was wrong, such as a bad path or a bad rubric. The message says what is wrong; exit code 2.

    Attributes
    ----------
    option
        The option of the command that is wrong or missing, without its dashes; "" if no single one is.
    why
        The problem in words that fit beside a form's field, too: the message, unless it speaks of options.
    """

    def __init__(self, message: str, *, option: str = "", why: str = "") -> None:
        super().__init__(message)
        self.option = option
        self.why = why or message


class GraderError(Exception):
    """The grader itself failed: never a student's fault, never a zero; exit code 3."""


def fault_text(problem: BaseException, *, message: bool = True) -> str:
    """Return an exception as one line to report: ``ZeroDivisionError at grader/engine/marks.py:31 in marked: division by zero``.

    The place is the innermost line of this package or of an instructor's own check, without the folders of a user.
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
    """Return the message of an exception, or a note that it has none: that of an instructor's own check may raise in `__str__`."""
    try:
        return str(problem)
    except (Exception, SystemExit) as unsayable:
        return f"its message raises {type(unsayable).__name__}"


class NoAnswer(Exception):  # noqa: N818 - it is an outcome, not an error of ours
    """The student's process gave no usable answer to a question."""


class TimedOut(NoAnswer):
    """The student's process did not answer within its CPU time or wall time."""

    def __init__(self, message: str, *, cpu_s: float, wall_s: float) -> None:
        super().__init__(message)
        self.cpu_s = cpu_s
        self.wall_s = wall_s


class Crashed(NoAnswer):
    """The student's process ended, by a signal or an exit, without an answer."""


class Malformed(NoAnswer):
    """Exception: the worker's reply violates the protocol."""
