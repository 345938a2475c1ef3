"""Fair and sharp, in the reduced form that every change must pass; `python -m tests.scoreboard` is the whole of it."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from tests.scoreboard import Case, Verdict, cases, grade_all

_SLOW = ("never-returns",)
"""Each waits for the whole time limit; one of them is graded in `submissions_example`."""


def _first_of_each_mistake() -> list[Case]:
    from tests.corpus.faulty import FAULTY

    first = {fault.mistake: fault.name for fault in reversed(FAULTY) if fault.mistake not in _SLOW}
    return [case for case in cases() if case.part == "faulty" and case.name in set(first.values())]


@pytest.fixture(scope="module")
def verdicts() -> list[Verdict]:
    sound = [case for case in cases() if case.part == "sound"]
    return list(grade_all([*sound, *_first_of_each_mistake()], jobs=2))


def _troubles(verdicts: Sequence[Verdict], part: str, *kinds: str) -> list[str]:
    return [
        f"{v.case.name}: {kind}: {text}"
        for v in verdicts
        if v.case.part == part
        for kind, text in v.troubles
        if not kinds or kind in kinds
    ]


def test_every_sound_submission_gets_all_points_and_no_mistake_named(verdicts: list[Verdict]) -> None:
    assert len([v for v in verdicts if v.case.part == "sound"]) >= 40
    assert _troubles(verdicts, "sound") == []


def test_every_mistake_costs_points_in_its_criterion_and_nowhere_else(verdicts: list[Verdict]) -> None:
    assert len([v for v in verdicts if v.case.part == "faulty"]) >= 80
    assert _troubles(verdicts, "faulty", "missed", "cascade", "too much", "grader failed") == []


def test_no_mistake_is_named_wrong_and_95_percent_are_named(verdicts: list[Verdict]) -> None:
    assert _troubles(verdicts, "faulty", "named wrong") == []
    right, missing = sum(v.named_right for v in verdicts), sum(v.named_not for v in verdicts)
    assert right / (right + missing) >= 0.95, _troubles(verdicts, "faulty", "not named")
