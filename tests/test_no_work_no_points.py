"""Tests of parts that do none of their job: they keep a few points for their form at most, and no other part loses any."""

from __future__ import annotations

import pytest

from tests.corpus.cases import Case, of
from tests.recordings import Marking
from tests.scoreboard import graded_by


@pytest.mark.parametrize("nothing", of("nothing"), ids=lambda nothing: nothing.name)
def test_a_part_that_does_nothing_keeps_a_few_points_for_its_form(nothing: Case, player: Marking) -> None:
    assert graded_by(player, nothing).troubles == []
