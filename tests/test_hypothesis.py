"""Tests of the choice of a hypothesis: the cheapest that fits is the cause, unless another of the same cost names another cause."""

from __future__ import annotations

import pytest

from grader.engine.hypothesis import Reason, explain


def at_most(cost: int, cause: str, limit: int) -> Reason[int]:
    return Reason("of", cost, cause, lambda seen: seen <= limit)


CHEAP, DEAR = at_most(1, "cheap", 3), at_most(2, "dear", 5)


@pytest.mark.parametrize(
    ("hypotheses", "seen", "cause"),
    [
        ([DEAR, CHEAP], 3, "cheap"),
        ([DEAR, CHEAP], 4, "dear"),
        ([DEAR, CHEAP], 6, None),
        ([CHEAP, at_most(1, "as cheap", 3), DEAR], 3, None),
        ([CHEAP, at_most(1, "as cheap", 2), DEAR], 3, "cheap"),
        ([CHEAP, at_most(1, "cheap", 5)], 3, "cheap"),
        ([], 3, None),
    ],
    ids=["the cheapest", "the next", "none", "two of one cost", "one of two", "cause as the same", "no hypothesis"],
)  # fmt: skip
def test_what_is_told(hypotheses: list[Reason[int]], seen: int, cause: str | None) -> None:
    found = explain(hypotheses, seen)
    assert (found and found.cause) == cause
