"""Report of loading a student's file: the names that it defines, and the module-level statements that failed and were skipped.

A statement may end the process that loads the file, or run too long. So the process notes each statement (file and number) before
it runs, and the next process for this submission skips one that failed so. Student code can forge a note, to reveal hidden numbers
by what is skipped. So the notes of a process are ignored once it was asked anything that may give it data.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from grader.base.errors import NoAnswer, TimedOut
from grader.base.text import printable
from grader.engine.findings import StudentError, Where
from grader.sandbox.wire import Frame

_OVERRAN = "it had not ended when its time was up"
_ENDED = "it ends the process"
_NO_FILE = {
    "FileNotFoundError": re.compile(r"No such file or directory: '([^']+)'|^(\S+) not found"),
    "ValueError": re.compile(r"Error opening file '([^']+)'"),
}
"""Patterns that find the name of a file that does not exist in a message of Python or of a library, by the type of exception."""
_MOST = 24  # most statements to record per submission as ending their process


@dataclass(frozen=True)
class SteppedOver:
    """A module-level statement of a student's file that failed; the statements after it were run all the same.

    Attributes
    ----------
    path : the file, or the notebook and its cell
    number, line : number of the statement in the file, and the line on which it begins
    how : ``raised``: it raised; ``hints``: a definition that was run without its type hints, which raised; ``less``: a definition
        that was run without another part that raised; ``overran``: it exceeded its time; ``ended``: it ended the process or could
        not be interrupted, and was not run again; ``unread``: it is not valid Python
    defines : the required names that it would have defined
    within : the required names whose code was running when it was interrupted
    error : the exception that the statement raised; if it raised none, `error.message` says why it failed
    """

    path: str
    number: int
    line: int
    how: str
    defines: tuple[str, ...]
    within: frozenset[str]
    error: StudentError

    @classmethod
    def of(cls, facts: Mapping[str, Any]) -> SteppedOver:
        error = StudentError.of(facts)
        assert error is not None
        defines, within = tuple(facts["defines"]), frozenset(facts["within"])
        return cls(facts["path"], facts["number"], facts["at"], facts["how"], defines, within, error)

    @property
    def where(self) -> str:
        """The place as printable text for a message: ``imu_reader.py, line 12``."""
        return f"{printable(self.path.replace(':cell ', ', cell '), 120)}, line {self.line}"

    @property
    def at(self) -> Where:
        file, cell, _ = self.path.partition(":cell ")
        return Where(printable(file, 120), None if cell else self.line)

    @property
    def why(self) -> str:
        said = printable(self.error.message, 200) + not_handed_in(self.error)
        return f"{self.error.type}: {said}" if self.error.type else said


@dataclass(frozen=True)
class Loaded:
    """Report of the sandbox on loading one file of a submission.

    Attributes
    ----------
    names : the required names that the file defines
    unreadable : the syntax error if the file is not valid Python, else None
    stepped_over : the statements that failed
    supplied : names that the file uses but did not import, and that the grader supplied
    misspelled : pairs of a required name, or a method of a required class, and the student's spelling of it
    frame : the whole reply of the sandbox, for a lab that reads more from it
    """

    names: frozenset[str]
    unreadable: StudentError | None
    stepped_over: tuple[SteppedOver, ...]
    supplied: tuple[str, ...]
    misspelled: tuple[tuple[str, str], ...]
    frame: Frame

    @property
    def is_clean(self) -> bool:
        """True if the file was loaded as it is: valid Python, no statement failed, no name supplied or misspelled."""
        return self.unreadable is None and not (self.stepped_over or self.supplied or self.misspelled)


def loaded_from(frame: Frame, path: str) -> Loaded:
    """Return the report on `path` from the sandbox's reply to `load`; failed statements of files that it imports are left out."""
    own = tuple(each for each in _stepped_over(frame) if each.path == path or each.path.startswith(f"{path}:"))
    misspelled = tuple((name, other) for name, other in frame.fields["misspelled"])
    names, unreadable = frozenset(frame.fields["names"]), StudentError.of(frame.fields["unreadable"])
    return Loaded(names, unreadable, own, tuple(frame.fields["supplied"]), misspelled, frame)


def overran(frame: Frame) -> list[SteppedOver]:
    """Return the statements, in any file, that a reply of the sandbox reports as interrupted because they exceeded their time."""
    return [each for each in _stepped_over(frame) if each.how == "overran"]


def _stepped_over(frame: Frame) -> list[SteppedOver]:
    return [SteppedOver.of(facts) for facts in frame.fields["stepped_over"]]


def not_handed_in(error: StudentError) -> str:
    """Return " (hand in FILE, too)" for an error message, if student code reads a file that does not exist; "" otherwise."""
    known = _NO_FILE.get(error.type)
    name = known.search(error.message) if known else None
    return f" (hand in {printable(name[name.lastindex or 0], 80)}, too)" if name else ""


def fault_of_statement(each: SteppedOver) -> str:
    """Return the id of the fault that explains why a failed statement did not define a required name."""
    if each.error.type == "ModuleNotFoundError":
        return "missing-package"
    if each.how == "overran" or each.error.message == _OVERRAN:
        return "never-returns"
    return "kills-its-process" if each.how == "ended" else "does-not-import"


# --- statements that end their process -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class _DeadlyStatement:
    """A module-level statement that ended the process that ran it, or exceeded its time.

    `beside` holds the names that correct code (stand-ins) replaced in that process; `within` the required names whose code was
    running in the statement, None if unknown.
    """

    path: str
    number: int
    why: str
    beside: frozenset[str]
    within: frozenset[str] | None = None

    def applies(self, beside: Collection[str]) -> bool:
        """Return whether to skip the statement in a process in which correct code (stand-ins) replaces the names `beside`.

        That is right if the same names were replaced when it failed, or if the code of none of them was running then.
        """
        return self.beside == frozenset(beside) or (self.within is not None and self.within.isdisjoint(beside))


class DeadlyStatements:
    """Statements of one submission that ended a process or exceeded their time, recorded so that the next process skips them."""

    def __init__(self) -> None:
        self._known: list[_DeadlyStatement] = []
        self._suspects: set[tuple[str, int, frozenset[str]]] = set()

    @property
    def count(self) -> int:
        """Number of statements to skip, or suspected after a crash; if it grew during a question, a new process may answer it."""
        return len(self._suspects) + len(self._known)

    def to_skip(self, standins: Collection[str]) -> list[tuple[str, int, str]]:
        """Return (path, number, reason in words) of each statement to skip in a process where correct code replaces `standins`."""
        return [(each.path, each.number, each.why) for each in self._known if each.applies(standins)]

    def learn_place(self, written: str, nothing: NoAnswer, standins: Collection[str]) -> None:
        """Record the statement in which a process ended, to skip it after one timeout or two crashes: a single crash may be chance.

        Parameters
        ----------
        written : the place (file and number of the statement, as JSON) that the process wrote down last; any other text is ignored
        nothing : why the process did not answer
        standins : the names that correct code replaced in that process; the statement is skipped only where these are replaced
        """
        place = _statement_place(written)
        if place is None or len(self._known) >= _MOST:
            return
        suspect = (*place, frozenset(standins))
        if isinstance(nothing, TimedOut) or suspect in self._suspects:
            why = _OVERRAN if isinstance(nothing, TimedOut) else _ENDED
            self._known.append(_DeadlyStatement(*place, why, frozenset(standins)))
        self._suspects.add(suspect)

    def learn_overrun(self, frame: Frame, standins: Collection[str]) -> None:
        """Record the statements that a reply reports as interrupted at their time limit, so that new processes skip them.

        `standins` are the names that correct code replaced in the process that replied. A new process skips the statement if the
        same names are replaced there, or if no name replaced there had code running when the statement was interrupted.
        """
        beside = frozenset(standins)
        new = [_DeadlyStatement(each.path, each.number, _OVERRAN, beside, each.within) for each in overran(frame)]
        self._known = list(dict.fromkeys([*self._known, *new]))[:_MOST]  # a process may report any number of them


def _statement_place(written: str) -> tuple[str, int] | None:
    """Return file and number of the statement whose place a process wrote down last; None if the text is no such place."""
    try:
        ((path, number),) = json.loads(written)
    except (ValueError, TypeError, RecursionError):
        return None
    return (path, number) if isinstance(path, str) and type(number) is int and len(path) <= 500 else None
