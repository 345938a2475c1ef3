"""Faults that no list foresaw cost the one check that a careful marker takes, and whoever makes them is told how to go on."""

from __future__ import annotations

import pytest

from grader.intake import Submission
from tests.corpus.cases import Case, of
from tests.recordings import Marking


@pytest.mark.parametrize("habit", of("habits"), ids=lambda habit: habit.name)
def test_a_habit_costs_the_one_check_that_a_marker_takes(habit: Case, player: Marking) -> None:
    content = {name: str(text).encode() for name, text in habit.files.items()}
    (criterion,) = player.mark(Submission("s", "s", content, (), "ready", ""), only=habit.criterion).criteria
    lost = {check.id: check for check in criterion.checks if check.points != check.max_points}
    assert set(lost) == set(habit.loses), {id_: check.message for id_, check in lost.items()}
    (check,) = lost.values()
    assert check.max_points - (check.points or 0.0) <= habit.most
    assert set(check.misconceptions) <= set(habit.names)
    assert check.hint
