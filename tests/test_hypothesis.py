"""The cheapest hypothesis that fits is told, and only where no other of its cost is told as something else."""

from __future__ import annotations

import pytest

from grader.engine.hypothesis import Named, explain, mistakes_of


def at_most(cost: int, told: str | None, limit: int) -> Named[int]:
    return Named(cost, told, lambda seen: seen <= limit)


CHEAP, DEAR = at_most(1, "cheap", 3), at_most(2, "dear", 5)


@pytest.mark.parametrize(
    ("hypotheses", "seen", "told"),
    [
        ([DEAR, CHEAP], 3, ["cheap"]),
        ([DEAR, CHEAP], 4, ["dear"]),
        ([DEAR, CHEAP], 6, []),
        ([CHEAP, at_most(1, "as cheap", 3), DEAR], 3, []),
        ([CHEAP, at_most(1, "as cheap", 2), DEAR], 3, ["cheap"]),
        ([CHEAP, at_most(1, "cheap", 5)], 3, ["cheap"]),
        ([at_most(0, None, 3), CHEAP], 3, []),
        ([], 3, []),
    ],
    ids=["the cheapest", "the next", "none", "two of one cost", "one of two", "told as the same", "without a name", "no hypothesis"],
)  # fmt: skip
def test_what_is_told(hypotheses: list[Named[int]], seen: int, told: list[str]) -> None:
    assert mistakes_of(hypotheses, seen) == told


def test_what_costs_more_is_not_tried_once_something_fits() -> None:
    def never(seen: int) -> bool:
        raise AssertionError(seen)

    assert explain([Named(2, "dear", never), CHEAP], 3) is CHEAP
