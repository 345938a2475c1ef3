"""Nothing for nothing: a part that does none of its job keeps a few points for its form at most, and costs no other part any."""

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
