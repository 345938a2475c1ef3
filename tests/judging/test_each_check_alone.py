"""Tests that every check has a submission in the corpus that loses this check only; `losses.yaml` names it."""

from __future__ import annotations

import pytest

from grader.engine import rubric
from grader.labs.imu.lab import LAB
from tests.recordings.losses import pinned

RECURSION = "filtering.follows_recursion"
WITH_THE_RECURSION = ("filtering.reduces_noise", "filtering.preserves_signal")
"""Checks that no submission loses alone: who obeys the recursion reduces noise and preserves the signal, and who does not is charged
for the recursion, once. What is no filter at all earns neither."""


@pytest.mark.quick
@pytest.mark.parametrize("check", [check.id for check in rubric.load(LAB).checks if check.id not in WITH_THE_RECURSION])
def test_a_submission_loses_this_check_and_no_other(check: str) -> None:
    found = [case for case, lost in pinned().items() if set(lost) == {check}]
    assert found, f"write a row of the corpus that loses {check} alone, then run python -m tests.regenerate --only ROW"


@pytest.mark.quick
@pytest.mark.parametrize("check", WITH_THE_RECURSION)
def test_what_is_no_filter_earns_neither_of_these(check: str) -> None:
    losing = [lost for lost in pinned().values() if check in lost]
    assert losing
    assert all(lost[check] is None or RECURSION in lost for lost in losing)
