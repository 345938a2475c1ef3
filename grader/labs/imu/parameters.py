"""Faults of a definition that cannot be called as in the lab sheet: other parameters, another method, or globals in their place."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypedDict, TypeVar

from grader.base.text import enumerated
from grader.engine.findings import Deviation, Size
from grader.engine.hypothesis import Reason

Facts = TypeVar("Facts")


class Departure(TypedDict):
    """Texts for a fault's message: the function's or class's `name`, and `departs`, the lab sheet's names that it lacks."""

    name: str
    departs: str


_GLOBALS, _METHOD, _PARAMETERS = FAULTS = ("global-for-parameter", "other-method-name", "other-parameters")
CALL_REASONS: tuple[Reason[Any], ...] = tuple(Reason(fault, 1, fault, lambda _: True) for fault in FAULTS)


def departures(
    name: str, departs_of: Callable[[Facts], Sequence[str]]
) -> Mapping[str, Callable[[Facts], Deviation[Departure] | None]]:
    """Return, by the id of each fault in `FAULTS`, a test for that fault in the student's function or class `name`.

    The test gets a criterion's facts and returns a `Deviation`, or None without the fault. `departs_of` takes from these facts the
    lab sheet's names of parameters and methods that the student's code renames, moves or replaces by globals.
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
