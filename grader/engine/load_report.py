"""What loading a file told: the names that it defines, and the statements at module level that were stepped over.

A statement that ends its process, or has to be ended with it, is known by the place that the process wrote down; the next process
is told not to run it. What such a process says is believed about the submission itself alone, and only before it has seen data.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from grader.base.errors import NoAnswer, TimedOut
from grader.base.text import printable
from grader.engine.findings import Fault, Where
from grader.sandbox.wire import Frame

_OVERRAN = "it had not ended when its time was up"
_ENDED = "it ends the process"
_MOST = 24  # statements of a submission that are found to end their process


@dataclass(frozen=True)
class SteppedOver:
    """A statement at module level that did not end well; what follows it was run.

    Attributes
    ----------
    path : the file, or the notebook and its cell
    number, line : which statement of it, and where it begins
    how : ``raised``; ``hints``: it is a definition, whose type hints raised and were left out; ``less``: so was another part of it;
        ``overran`` its time; ``ended`` the process, or could not be interrupted, and was not run again; ``unread``: it is no Python
    defines : of the names that are asked for, those that it would have defined
    within : of these names, those whose code was running when it was interrupted
    fault : what it raised, or the reason
    """

    path: str
    number: int
    line: int
    how: str
    defines: tuple[str, ...]
    within: frozenset[str]
    fault: Fault

    @classmethod
    def of(cls, facts: Mapping[str, Any]) -> SteppedOver:
        fault = Fault.of(facts)
        assert fault is not None
        defines, within = tuple(facts["defines"]), frozenset(facts["within"])
        return cls(facts["path"], facts["number"], facts["at"], facts["how"], defines, within, fault)

    @property
    def where(self) -> str:
        """``imu_reader.py, line 12``, as it can be shown."""
        return f"{printable(self.path.replace(':cell ', ', cell '), 120)}, line {self.line}"

    @property
    def at(self) -> Where:
        file, cell, _ = self.path.partition(":cell ")
        return Where(printable(file, 120), None if cell else self.line)

    @property
    def why(self) -> str:
        said = printable(self.fault.message, 200)
        return f"{self.fault.type}: {said}" if self.fault.type else said


@dataclass(frozen=True)
class Loaded:
    """What one file told.

    Attributes
    ----------
    names : the required names that it defines
    unreadable : why it is no Python, if it is not
    stepped_over : its statements that did not end well
    supplied : names that the file uses and forgot to import, which it was given
    misspelled : which of these names, or methods of these classes, are spelled differently, and how
    frame : the whole answer, for what else a lab reads in it
    """

    names: frozenset[str]
    unreadable: Fault | None
    stepped_over: tuple[SteppedOver, ...]
    supplied: tuple[str, ...]
    misspelled: tuple[tuple[str, str], ...]
    frame: Frame

    @property
    def is_clean(self) -> bool:
        """Whether it was imported as it is: nothing stepped over, supplied or called by another name."""
        return self.unreadable is None and not (self.stepped_over or self.supplied or self.misspelled)


def loaded_from(frame: Frame, path: str) -> Loaded:
    """The answer to `load`, of which other files' statements are left out."""
    own = tuple(each for each in _stepped_over(frame) if each.path == path or each.path.startswith(f"{path}:"))
    misspelled = tuple((name, other) for name, other in frame.fields["misspelled"])
    names, unreadable = frozenset(frame.fields["names"]), Fault.of(frame.fields["unreadable"])
    return Loaded(names, unreadable, own, tuple(frame.fields["supplied"]), misspelled, frame)


def overran(frame: Frame) -> list[SteppedOver]:
    """The statements, in whichever file, that had to be interrupted."""
    return [each for each in _stepped_over(frame) if each.how == "overran"]


def _stepped_over(frame: Frame) -> list[SteppedOver]:
    return [SteppedOver.of(facts) for facts in frame.fields["stepped_over"]]


def mistake_of(each: SteppedOver) -> str:
    """The mistake that a statement shows which was to define something."""
    if each.fault.type == "ModuleNotFoundError":
        return "missing-package"
    if each.how == "overran" or each.fault.message == _OVERRAN:
        return "never-returns"
    return "kills-its-process" if each.how == "ended" else "does-not-import"


# --- statements that end their process -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Ending:
    """A statement that ended its process, or had to be ended, beside these stand-ins; `within`: what was running, if known."""

    path: str
    number: int
    why: str
    beside: frozenset[str]
    within: frozenset[str] | None = None

    def still(self, beside: Collection[str]) -> bool:
        """Return whether it would do so beside other stand-ins, too: not if they may take the place of what it was about."""
        return self.beside == frozenset(beside) or (self.within is not None and self.within.isdisjoint(beside))


class Endings:
    """What is known of one submission's statements that end their process or overrun."""

    def __init__(self) -> None:
        self._known: list[_Ending] = []
        self._suspects: set[tuple[str, int, frozenset[str]]] = set()

    @property
    def found_out(self) -> int:
        """Grows with what is known."""
        return len(self._suspects) + len(self._known)

    def beside(self, standins: Collection[str]) -> list[tuple[str, int, str]]:
        """File, number and reason of the statements that are not run again beside these stand-ins."""
        return [(each.path, each.number, each.why) for each in self._known if each.still(standins)]

    def learn_place(self, written: str, nothing: NoAnswer, standins: Collection[str]) -> None:
        """A statement that ends its process, twice, or has to be ended with it, once, is not run again."""
        place = _place(written)
        if place is None or len(self._known) >= _MOST:
            return
        suspect = (*place, frozenset(standins))
        if isinstance(nothing, TimedOut) or suspect in self._suspects:
            why = _OVERRAN if isinstance(nothing, TimedOut) else _ENDED
            self._known.append(_Ending(*place, why, frozenset(standins)))
        self._suspects.add(suspect)

    def learn_overrun(self, frame: Frame, standins: Collection[str]) -> None:
        """What has had its time once is not run again."""
        beside = frozenset(standins)
        new = [_Ending(each.path, each.number, _OVERRAN, beside, each.within) for each in overran(frame)]
        self._known = list(dict.fromkeys([*self._known, *new]))[:_MOST]  # a process may claim any number of them


def _place(written: str) -> tuple[str, int] | None:
    """The statement that was running when the process ended, as far as it wrote that down; it may have written anything."""
    try:
        ((path, number),) = json.loads(written)
    except (ValueError, TypeError, RecursionError):
        return None
    return (path, number) if isinstance(path, str) and type(number) is int and len(path) <= 500 else None
