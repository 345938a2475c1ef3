"""Tests that a submission gets the same points at module level and in a notebook; `python -m tests.scoreboard` tests the whole corpus."""

from __future__ import annotations

import pytest

from tests.corpus.cases import of
from tests.layout_variants import VARIANTS, can_be_rearranged
from tests.recordings import Marking
from tests.scoreboard import Case, graded_by, recast

SAMPLE = (
    "state-of-the-class",
    "first-reading-kept",
    "method-under-another-name",
    "bias-drawn-in-read",
    "reset-forgotten",
)


@pytest.mark.parametrize("case", list(recast(SAMPLE)), ids=lambda case: case.name)
def test_what_a_submission_defines_has_the_same_marks_in_every_layout(case: Case, player: Marking) -> None:
    assert graded_by(player, case).troubles == []


def test_nearly_all_of_the_single_faults_can_be_cast() -> None:
    assert sum(can_be_rearranged(fault.files) for fault in of("faulty")) >= 0.9 * len(of("faulty"))
    assert len(VARIANTS) == 2
