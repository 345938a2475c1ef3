"""Tests of parts that do none of their job: they keep a few points for their form at most, and no other part loses any."""

from __future__ import annotations

import pytest

from tests.corpus.cases import Case, of
from tests.recordings import Marking
from tests.scoreboard import handed_in


@pytest.mark.parametrize("nothing", of("nothing"), ids=lambda nothing: nothing.name)
def test_a_part_that_does_nothing_keeps_a_few_points_for_its_form(nothing: Case, player: Marking) -> None:
    result = player.mark(handed_in(nothing))
    points = {criterion.id: criterion.points for criterion in result.criteria}
    kept = {
        c.id: c.points for each in result.criteria for c in each.checks if each.id == nothing.criterion and c.points
    }
    assert points.pop(nothing.criterion) <= nothing.earns, kept
    assert set(points.values()) == {20.0}, {
        c.id: c.message for each in result.criteria for c in each.checks if c.points != c.max_points
    }
