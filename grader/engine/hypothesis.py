"""Diagnosis by hypotheses: find the fault that predicts the observations, in the same way for each criterion.

A diagnosis is a list of hypotheses. Each has a cost (prior implausibility) and tells whether it predicts the observations. The
cheapest that fits is reported. If several of the same cost fit and name different faults, none is.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

Seen = TypeVar("Seen")


class Hypothesis(Protocol):
    """Protocol of a possible cause of the observations, from which `explain` chooses."""

    @property
    def cause(self) -> Hashable:
        """The cause that is reported; two hypotheses of equal cost contradict each other only if their causes differ."""

    @property
    def cost(self) -> int:
        """Cost of the hypothesis (prior implausibility); `explain` prefers the cheapest that fits."""

    def fits(self, seen: Any, /) -> bool:
        """Return whether the hypothesis predicts the observations."""


@dataclass(frozen=True)
class Reason(Generic[Seen]):
    """A fault as the reason for a deviation of one measured property.

    Attributes
    ----------
    of : the property in which the fault shows
    cause : the id of the fault's row
    holds : tells whether the fault predicts the facts
    beside : whether it may hold beside other faults of the property; otherwise the cheapest of those that fit counts
    """

    of: str
    cost: int
    cause: str
    holds: Callable[[Seen], bool]
    beside: bool = False

    def fits(self, seen: Seen, /) -> bool:
        """Return whether the fault predicts the facts; False if computing with them raises an arithmetic or value error."""
        try:
            return self.holds(seen)
        except (ArithmeticError, ValueError):  # NumPy's LinAlgError is a ValueError
            return False


Candidate = TypeVar("Candidate", bound=Hypothesis)


def explain(hypotheses: Iterable[Candidate], seen: object) -> Candidate | None:
    """Return the cheapest hypothesis that fits; None if none fits, or if others of its cost fit and report another cause."""
    return first_that_fits(by_cost(hypotheses), seen)


def by_cost(hypotheses: Iterable[Candidate]) -> tuple[tuple[Candidate, ...], ...]:
    """Group the hypotheses by cost, the cheapest first."""
    return tuple(tuple(equals) for _, equals in itertools.groupby(sorted(hypotheses, key=_cost), key=_cost))


def first_that_fits(levels: Iterable[Iterable[Candidate]], seen: object) -> Candidate | None:
    """Do the same as `explain` for hypotheses grouped by cost; to save time, a group is made only after all cheaper ones failed."""
    for equals in levels:
        if fitting := [each for each in equals if each.fits(seen)]:
            return fitting[0] if len({each.cause for each in fitting}) == 1 else None
    return None


def _cost(hypothesis: Hypothesis) -> int:
    return hypothesis.cost
