"""Faults that no list foresaw cost the one check that a careful marker takes, and whoever makes them is told how to go on."""

from __future__ import annotations

import pytest

from grader.intake import Submission
from tests.corpus.unforeseen_habits import HABITS, Habit
from tests.recordings import Marking


@pytest.mark.parametrize("habit", HABITS, ids=lambda habit: habit.name)
def test_a_habit_costs_the_one_check_that_a_marker_takes(habit: Habit, player: Marking) -> None:
    content = {name: text.encode() for name, text in habit.files.items()}
    (criterion,) = player.mark(
        Submission("s", "s", content, (), "ready", ""), only=habit.check.partition(".")[0]
    ).criteria
    lost = {check.id: check for check in criterion.checks if check.points != check.max_points}
    assert set(lost) == {habit.check}, {id_: check.message for id_, check in lost.items()}
    (check,) = lost.values()
    assert check.max_points - (check.points or 0.0) <= habit.most
    assert set(check.misconceptions) <= set(habit.names)
    assert check.hint
