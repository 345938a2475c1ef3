"""Pictures that no list foresaw lose what a careful marker said before, each fault once, with a true word."""

from __future__ import annotations

import pytest

from grader.engine.results import CheckResult
from grader.intake import Submission
from tests.corpus.cases import Case, of
from tests.recordings import Marking

CRITERION = "visualization"
FAULTY, SOUND = (
    [case for case in of(part) if case.criterion == CRITERION] for part in ("unforeseen", "unforeseen sound")
)


def lost(player: Marking, sample: Case) -> dict[str, CheckResult]:
    content = {name: str(text).encode() for name, text in sample.files.items()}
    criterion = player.mark(Submission("s", "s", content, (), "ready", ""), only=CRITERION).criteria[0]
    return {check.id: check for check in criterion.checks if check.points != check.max_points}


@pytest.mark.parametrize("sample", SOUND[::6], ids=lambda sample: sample.name)
def test_a_sound_picture_loses_nothing(sample: Case, player: Marking) -> None:
    assert {name: check.message for name, check in lost(player, sample).items()} == {}


@pytest.mark.parametrize("sample", FAULTY[::6], ids=lambda sample: sample.name)
def test_a_picture_that_shows_less_loses_what_the_marker_said(sample: Case, player: Marking) -> None:
    checks = lost(player, sample)
    names = {mistake for check in checks.values() for mistake in check.misconceptions}
    assert checks
    assert set(checks) <= set(sample.loses)
    assert sum(check.max_points - (check.points or 0.0) for check in checks.values()) <= sample.most + 1e-9
    assert names <= set(sample.names)
    assert bool(names) == bool(sample.names)
    assert [name for name, check in checks.items() if not check.hint and check.outcome != "skipped"] == []
