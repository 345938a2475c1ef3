"""Fixture: one judge of attacks for all tests, on the best isolation level of this machine."""

from __future__ import annotations

import sys
from collections.abc import Iterator

import pytest

from grader.sandbox.isolation_levels import NO_ISOLATION
from tests.hostile.judging import AttackJudge


@pytest.fixture(scope="package")
def attack_judge() -> Iterator[AttackJudge]:
    if not sys.platform.startswith("linux"):
        pytest.skip("looks for leftovers in /proc")
    with AttackJudge(None) as attack_judge:
        if attack_judge.isolation_level == NO_ISOLATION.name:
            pytest.skip("nothing isolates here")
        yield attack_judge
