"""From what was seen to the mistake that predicts it: one way for every criterion.

A diagnosis is a list of hypotheses. Each says whether it predicts what was seen, and what it asks to be believed; the cheapest
that fits is told, and nothing is where others that ask no more fit as well.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

Seen = TypeVar("Seen")


class Hypothesis(Protocol):
    """One way in which what was seen may have come about."""

    @property
    def told(self) -> Hashable:
        """What it is told as: hypotheses of one cost that are told as the same do not contradict each other."""

    @property
    def cost(self) -> int:
        """How much it asks to be believed."""

    def fits(self, seen: Any, /) -> bool:
        """Return whether it predicts what was seen."""


@dataclass(frozen=True)
class Named(Generic[Seen]):
    """A hypothesis that is no more than its name, which is None for what is known and has none."""

    cost: int
    told: str | None
    predicts: Callable[[Seen], bool]

    def fits(self, seen: Seen, /) -> bool:
        return self.predicts(seen)


@dataclass(frozen=True)
class Reason(Generic[Seen]):
    """A fault as the reason for a deviation of one measured property.

    Attributes
    ----------
    of : the property; told : the id of the fault's row
    holds : whether the fault predicts the facts
    predicts : other properties that deviate through it, where they have no reason of their own
    takes : checks that have nothing to judge where the fault shows in this way, beside those of its row
    """

    of: str
    cost: int
    told: str
    holds: Callable[[Seen], bool]
    predicts: frozenset[str] = frozenset()
    takes: frozenset[str] = frozenset()

    def fits(self, seen: Seen, /) -> bool:
        """Return whether the fault predicts the facts; numbers that it cannot compute with are none that it predicts."""
        try:
            return self.holds(seen)
        except (ArithmeticError, ValueError):  # NumPy's LinAlgError is a ValueError
            return False


Candidate = TypeVar("Candidate", bound=Hypothesis)


def explain(hypotheses: Iterable[Candidate], seen: object) -> Candidate | None:
    """The cheapest that fits; None where none does, or where another of its cost does that is told as something else."""
    return first_that_fits(by_cost(hypotheses), seen)


def by_cost(hypotheses: Iterable[Candidate]) -> tuple[tuple[Candidate, ...], ...]:
    """Those of equal cost together, the cheapest first."""
    return tuple(tuple(equals) for _, equals in itertools.groupby(sorted(hypotheses, key=_cost), key=_cost))


def first_that_fits(levels: Iterable[Iterable[Candidate]], seen: object) -> Candidate | None:
    """`explain` of hypotheses that are sorted already: those of a level are not made before all cheaper ones have failed."""
    for equals in levels:
        if fitting := [each for each in equals if each.fits(seen)]:
            return fitting[0] if len({each.told for each in fitting}) == 1 else None
    return None


def mistakes_of(hypotheses: Iterable[Named[Seen]], seen: Seen) -> list[str]:
    """The name of what explains it, or nothing."""
    found = explain(hypotheses, seen)
    return [found.told] if found is not None and found.told is not None else []


def _cost(hypothesis: Hypothesis) -> int:
    return hypothesis.cost
