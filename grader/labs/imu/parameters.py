"""Faults of a definition that cannot be called as in the lab sheet: other parameters, another method, or globals in their place."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypedDict, TypeVar

from grader.base.text import enumerated
from grader.engine.findings import Deviation, Size
from grader.engine.hypothesis import Reason

Facts = TypeVar("Facts")


class Departure(TypedDict):
    """Texts for a fault's message: `name` of the function or class, and `departs`, the sheet's parameters or method it lacks."""

    name: str
    departs: str


_GLOBALS, _METHOD, _PARAMETERS = FAULTS = ("global-for-parameter", "other-method-name", "other-parameters")
CALL_REASONS: tuple[Reason[Any], ...] = tuple(Reason(fault, 1, fault, lambda _: True) for fault in FAULTS)


def departures(
    name: str, departs_of: Callable[[Facts], Sequence[str]]
) -> Mapping[str, Callable[[Facts], Deviation[Departure] | None]]:
    """Return, for the id of each fault in `FAULTS`, a function that finds it in the calls of the function or class `name`.

    That function gets a criterion's facts, from which `departs_of` takes the lab sheet's names of what had to be called otherwise.
    It returns a `Deviation` that names those of its fault, or None if there are none.
    """

    def measure_of(fault: str) -> Callable[[Facts], Deviation[Departure] | None]:
        def measured(facts: Facts) -> Deviation[Departure] | None:
            return _departure(name, fault, departs_of(facts))

        return measured

    return {fault: measure_of(fault) for fault in FAULTS}


def _departure(name: str, fault: str, departs: Sequence[str]) -> Deviation[Departure] | None:
    by_fault = {
        _GLOBALS: [each for each in departs if each.startswith("global ")],
        _METHOD: [each for each in departs if each.startswith("method ")],
    }
    others = [each for each in departs if each not in by_fault[_METHOD]]
    by_fault[_PARAMETERS] = [] if by_fault[_GLOBALS] else others  # what is read from a global is no parameter
    if not by_fault[fault]:
        return None
    shown = enumerated([each.rpartition(" ")[2] for each in by_fault[fault]])
    return Deviation({"name": name, "departs": shown}, size=Size(f"another call for {shown}"))
