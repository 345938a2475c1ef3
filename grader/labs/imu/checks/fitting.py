"""Deduct for a definition that cannot be called as the sheet calls it, although everything else about it can be judged."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

from grader.engine.findings import CheckFailed, Size

_GLOBAL, _NAME = "global ", "name for "


@dataclass(frozen=True)
class _Departure:
    """How a definition departs from the sheet's: what was expected, what came, a short form of it, and the mistake's id."""

    expected: str
    got: str
    off: str
    mistake: str


def fits_in(name: str, departs: Collection[str], *, keeps: float = 0.5, belongs_to: str = "") -> None:
    """Deduct for parameters by which a definition could not be called as the sheet calls it.

    Parameters
    ----------
    departs : the sheet's names for those parameters, and for those in whose place it reads a ``global``, or takes a ``name``;
        nothing of the student's
    belongs_to : the check that deducts for the same
    """
    for departure in _departures(name, departs):
        raise CheckFailed(
            departure.expected,
            departure.got,
            off=Size(departure.off),
            mistakes=[departure.mistake],
            keeps=keeps,
            belongs_to=belongs_to,
        )


def _departures(name: str, departs: Collection[str]) -> Iterator[_Departure]:
    if read := " and ".join(each.removeprefix(_GLOBAL) for each in departs if each.startswith(_GLOBAL)):
        got = f"a global in place of {read}"
        yield _Departure(f"the {read} that {name} is given", got, got, "global-for-parameter")
    if any(each.startswith(_NAME) for each in departs):
        got, off = (
            "names: it stops at ids, and was called with the names of the sensors",
            "names of sensors in place of ids",
        )
        yield _Departure("the ids of both sensors, as mj_name2id gives them", got, off, "other-parameters")
    if odd := ", ".join(departs):
        expected = "the sheet's parameters, under its names and in its order"
        got, off = f"others in place of, or beside, these: {odd}", f"those that differ: {odd}"
        yield _Departure(expected, got, off, "other-parameters")
