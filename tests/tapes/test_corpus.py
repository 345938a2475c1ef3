"""The whole corpus, judged from tapes on every change: no box, the same assertions; and tapes are as good as the box."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import pytest

from grader.engine.marking import Marker
from grader.engine.results import to_dict
from grader.labs.imu import bundles
from tests import fault_table
from tests.made_up import without_durations
from tests.scoreboard import MORE_THAN_ONE, ONE_FAULT, Case, handed_in
from tests.tapes import PlayingBox, StaleError
from tests.tapes.losses import disagreements, pinned, pins
from tests.tapes.player import generous, player
from tests.tapes.storing import Shelf, taped

FAULTY = ("faulty", "lookalikes", "pairs")
SAMPLE = taped()[::40]
_MANY = 48
BATCHES = [taped()[first::_MANY] for first in range(_MANY)]
"""Every case once, spread so that each batch takes about as long as another."""


@pytest.mark.quick
@pytest.mark.parametrize("cases", BATCHES, ids=range(len(BATCHES)))
def test_every_case_is_judged_as_the_corpus_says(cases: Sequence[Case]) -> None:
    assert [line for case in cases for line in disagreements(player().verdict(case))] == []


@pytest.mark.quick
def test_the_corpus_is_as_large_as_it_was() -> None:
    parts = Counter(case.part for case in taped())
    assert parts["sound"] >= 150
    assert sum(parts[part] for part in FAULTY) >= 350
    assert parts["broken"] >= 150
    assert parts["extensions"] >= 50


@pytest.mark.quick
def test_losses_are_pinned_of_cases_that_there_are() -> None:
    assert set(pinned()) <= {case.id for case in taped() if pins(case)}


@pytest.mark.quick
def test_single_faults_that_cost_more_than_one_check_are_few_and_have_a_reason() -> None:
    single = [case for case in taped() if case.part in ONE_FAULT]
    several = {case.name for case in single if sum(kept is not None for kept in pinned().get(case.id, {}).values()) > 1}
    assert several == set(MORE_THAN_ONE)
    assert len(several) <= 0.02 * len(single)


@pytest.mark.quick
def test_the_handbooks_table_of_faults_is_that_of_the_corpus() -> None:
    kept = fault_table.FILE.read_text(encoding="utf-8")
    assert kept == fault_table.page(pinned()), "run python -m tests.tapes.losses and commit what it writes"


@pytest.fixture(scope="module")
def box_marker() -> Marker:
    with Marker(generous(), bundles.shipped()) as marker:
        yield marker


@pytest.mark.parametrize("case", SAMPLE, ids=lambda case: case.id)
def test_the_verdict_from_the_tape_is_that_of_the_box(case: Case, box_marker: Marker) -> None:
    submission = handed_in(case)
    played = to_dict(player().insert(case).mark(submission, only=case.only))
    boxed = to_dict(box_marker.mark(submission, only=case.only))
    assert without_durations(played) == without_durations(boxed)


def test_a_question_that_was_not_asked_when_the_tape_was_recorded_is_refused() -> None:
    worker = PlayingBox("full").worker()
    with pytest.raises(StaleError, match="'read' was not asked when the tape was recorded"):
        worker.ask("read", {"model": "another"})


def test_a_tape_of_another_harness_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.tapes.storing.harness_sha256", lambda: "0" * 64)
    with pytest.raises(StaleError, match="the harness has changed"):
        Shelf()
