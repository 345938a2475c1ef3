"""Diagnosis by hypotheses: find the fault that predicts what was observed, in the same way for each criterion.

A hypothesis has a cost (prior implausibility) and tells whether it predicts the observations. The cheapest that fits is reported.
If several of that cost fit and name different faults, none is reported.
"""

from __future__ import annotations

import itertools
import operator
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

Seen = TypeVar("Seen")


class Hypothesis(Protocol):
    """Protocol of a possible cause, such as a fault, of what was observed of student code; `explain` chooses among several."""

    @property
    def cause(self) -> Hashable:
        """Reported cause, such as a fault's id. Hypotheses of equal cost contradict each other only if their causes differ."""

    @property
    def cost(self) -> int:
        """Cost of the hypothesis (prior implausibility); `explain` prefers the cheapest that fits."""

    def fits(self, seen: Any, /) -> bool:
        """Return whether the hypothesis predicts the observations `seen`."""


@dataclass(frozen=True)
class Reason(Generic[Seen]):
    """A known fault as the possible reason why one measured property deviates; `charging.Judge` tries the reasons of a property.

    Attributes
    ----------
    of : short name of the check, or of another property, in which the fault shows
    cost : prior implausibility; the cheapest reason that fits is chosen
    cause : id of the fault in the fault table
    holds : tells whether the fault predicts the measured record
    beside : whether the fault may hold together with other faults of the property; then it counts if it fits, cheapest or not
    """

    of: str
    cost: int
    cause: str
    holds: Callable[[Seen], bool]
    beside: bool = False

    def fits(self, seen: Seen, /) -> bool:
        """Return whether the fault predicts the measured record; False if computing that raises an arithmetic or value error."""
        try:
            return self.holds(seen)
        except (ArithmeticError, ValueError):  # NumPy's LinAlgError is a ValueError
            return False


Candidate = TypeVar("Candidate", bound=Hypothesis)


def explain(hypotheses: Iterable[Candidate], seen: object) -> Candidate | None:
    """Return the cheapest hypothesis that fits `seen`; None if none fits, or if others of its cost fit and report another cause."""
    return first_that_fits(by_cost(hypotheses), seen)


def by_cost(hypotheses: Iterable[Candidate]) -> tuple[tuple[Candidate, ...], ...]:
    """Group the hypotheses by cost, the cheapest group first, as `first_that_fits` takes them."""
    cost = operator.attrgetter("cost")
    return tuple(tuple(equals) for _, equals in itertools.groupby(sorted(hypotheses, key=cost), key=cost))


def first_that_fits(levels: Iterable[Iterable[Candidate]], seen: object) -> Candidate | None:
    """Return the hypothesis that fits `seen` in the first level where any does; None if none does, or if several differ in cause.

    Each level holds hypotheses of one cost, the cheapest level first. Later levels are not tried.
    """
    for equals in levels:
        if fitting := [each for each in equals if each.fits(seen)]:
            return fitting[0] if len({each.cause for each in fitting}) == 1 else None
    return None
