"""The whole corpus, judged from tapes on every change: no box, the same assertions; and tapes are as good as the box."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from grader.engine import rubric, traces
from grader.engine.marking import Marker
from grader.engine.results import to_dict
from grader.labs.imu.lab import LAB
from tests.made_up import without_durations
from tests.scoreboard import Case, Verdict, graded_by, handed_in
from tests.tapes import PlayingBox, StaleError
from tests.tapes.storing import Shelf, shelf, taped

SAMPLE = taped()[::40]


class Player:
    """Marks cases from their tapes."""

    def __init__(self) -> None:
        self._box = PlayingBox(shelf().rung)
        self.marker = Marker(rubric.load(LAB), traces.shipped(), box=self._box)  # type: ignore[arg-type] # speaks as a box does

    def insert(self, case: Case) -> Marker:
        self._box.tape = shelf()[case.id]
        return self.marker


@pytest.fixture(scope="module")
def player() -> Player:
    return Player()


@pytest.fixture(scope="module")
def verdicts(player: Player) -> list[Verdict]:
    return [graded_by(player.insert(case), case) for case in taped()]


def _troubles(verdicts: Sequence[Verdict], parts: Sequence[str], *kinds: str) -> list[str]:
    return [
        f"{v.case.id}: {kind}: {text}"
        for v in verdicts
        if v.case.part in parts
        for kind, text in v.troubles
        if not kinds or kind in kinds
    ]


FAULTY = ("faulty", "lookalikes", "pairs")


@pytest.mark.quick
def test_every_sound_submission_gets_all_points_and_no_mistake_named(verdicts: list[Verdict]) -> None:
    assert len([v for v in verdicts if v.case.part == "sound"]) >= 150
    assert _troubles(verdicts, ("sound",)) == []


@pytest.mark.quick
def test_every_mistake_costs_points_in_its_criterion_and_nowhere_else(verdicts: list[Verdict]) -> None:
    assert len([v for v in verdicts if v.case.part in FAULTY]) >= 350
    assert _troubles(verdicts, FAULTY, "missed", "cascade", "too much", "grader failed") == []


@pytest.mark.quick
def test_no_mistake_is_named_wrong_and_95_percent_are_named(verdicts: list[Verdict]) -> None:
    marked = [v for v in verdicts if v.case.part in FAULTY]
    assert _troubles(marked, FAULTY, "named wrong") == []
    right, missing = sum(v.named_right for v in marked), sum(v.named_not for v in marked)
    assert right / (right + missing) >= 0.95, _troubles(marked, FAULTY, "not named")


@pytest.mark.quick
def test_every_broken_submission_ends_in_a_clear_verdict(verdicts: list[Verdict]) -> None:
    assert len([v for v in verdicts if v.case.part == "broken"]) >= 150
    assert _troubles(verdicts, ("broken",)) == []


@pytest.mark.quick
def test_extensions_lose_what_they_get_wrong_and_nothing_else(verdicts: list[Verdict]) -> None:
    assert len([v for v in verdicts if v.case.part == "extensions"]) >= 50
    assert _troubles(verdicts, ("extensions",)) == []


@pytest.fixture(scope="module")
def box_marker() -> Marker:
    with Marker(rubric.load(LAB), traces.shipped()) as marker:
        yield marker


@pytest.mark.parametrize("case", SAMPLE, ids=lambda case: case.id)
def test_the_verdict_from_the_tape_is_that_of_the_box(case: Case, player: Player, box_marker: Marker) -> None:
    submission = handed_in(case)
    played = to_dict(player.insert(case).mark(submission, only=case.only))
    boxed = to_dict(box_marker.mark(submission, only=case.only))
    assert without_durations(played) == without_durations(boxed)


def test_a_question_that_was_not_asked_when_the_tape_was_recorded_is_refused(player: Player) -> None:
    worker = PlayingBox("full").worker()
    with pytest.raises(StaleError, match="'read' was not asked when the tape was recorded"):
        worker.ask("read", {"model": "another"})


def test_a_tape_of_another_harness_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.tapes.storing.harness_sha256", lambda: "0" * 64)
    with pytest.raises(StaleError, match="the harness has changed"):
        Shelf()
