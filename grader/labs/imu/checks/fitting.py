"""Deduct for a definition that cannot be called as the sheet calls it, although everything else about it can be judged."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

from grader.engine.findings import CheckFailed, Ours, Size

_GLOBAL, _NAME = "global ", "name for "


@dataclass(frozen=True)
class _Departure:
    """A definition's difference from the sheet's: expected, got, a short form of it, and the fault's id."""

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


def if_nothing(got: str) -> str:
    """Return the hint for a function that returned None; "" for any other value."""
    return _NOTHING_RETURNED if got.removeprefix("got ").startswith("None") else ""


_NOTHING_RETURNED = Ours("The function returns None: it is still to be written, or a return statement is missing.")


def _departures(name: str, departs: Collection[str]) -> Iterator[_Departure]:
    if read := " and ".join(each.removeprefix(_GLOBAL) for each in departs if each.startswith(_GLOBAL)):
        got = f"it uses a global variable instead of {read}"
        yield _Departure(f"{name} uses its parameter {read}", got, got, "global-for-parameter")
    if any(each.startswith(_NAME) for each in departs):
        got, off = (
            "a function that takes the names of the sensors; it was called with the names",
            "names of sensors instead of ids",
        )
        yield _Departure("the ids of both sensors, as mj_name2id gives them", got, off, "other-parameters")
    if odd := ", ".join(departs):
        expected = "the sheet's parameters, with its names and in its order"
        got, off = f"other parameters for {odd}", f"other parameters for {odd}"
        yield _Departure(expected, got, off, "other-parameters")
