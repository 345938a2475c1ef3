"""Every check has a submission of the corpus that loses it and it alone; `losses.yaml` says which, and the tapes prove it."""

from __future__ import annotations

import pytest

from grader.engine import rubric
from grader.labs.imu.lab import LAB
from tests.tapes.losses import pinned

BESIDE = {
    "filtering.reduces_noise": "filtering.follows_recursion",
    "filtering.preserves_signal": "filtering.follows_recursion",
}
"""Checks that no submission can lose alone: who obeys the sheet's recursion reduces noise and preserves the signal. They pay for
what another filter does right; a submission loses them beside the recursion and nothing else."""


@pytest.mark.quick
@pytest.mark.parametrize("check", [check.id for check in rubric.load(LAB).checks])
def test_a_submission_loses_this_check_and_no_other(check: str) -> None:
    wanted = {check, BESIDE.get(check, check)}
    assert [case for case, lost in pinned().items() if set(lost) == wanted]
