"""Work that no list foresaw loses what a careful marker said before it was judged, each fault once, with a true name or none."""

from __future__ import annotations

import pytest

from grader.engine.results import Result
from tests.corpus.cases import Case, of
from tests.recordings import Marking
from tests.scoreboard import Verdict, look_at_words, lost
from tests.single_faults import lost_by, marked

_EVERY = 6
"""Of so many plots one is drawn."""
_EVERYWHERE = {
    "class-with-the-id-as-address", "class-in-the-other-order", "class-that-clips", "one-key-misspelled",
    "keys-in-the-plural", "three-long-rows", "append-without-an-axis", "a-dataclass-in-place-of-a-dictionary",
}  # fmt: skip
"""Faults that reach into other criteria: into the plot by the recording's form, into all by a shared class."""


def _chosen(*parts: str) -> list[Case]:
    every = [case for part in parts for case in of(part)]
    plots = [case for case in every if case.criterion == "visualization"]
    return [case for case in every if case.criterion != "visualization"] + plots[::_EVERY]


def _judged(player: Marking, sample: Case) -> Result:
    return marked(player, sample.files, None if sample.name in _EVERYWHERE else sample.criterion)


@pytest.mark.parametrize("sample", _chosen("unforeseen sound"), ids=lambda sample: sample.name)
def test_sound_work_in_a_style_of_its_own_loses_nothing(sample: Case, player: Marking) -> None:
    result = _judged(player, sample)
    assert [(check.id, check.message) for check in lost(result)] == []
    assert result.misconceptions == ()


@pytest.mark.parametrize("sample", _chosen("unforeseen", "habits"), ids=lambda sample: sample.name)
def test_a_fault_loses_what_the_marker_said_and_is_told_why(sample: Case, player: Marking) -> None:
    result = _judged(player, sample)
    found = lost_by(result)
    names, right = set(result.misconceptions), {*sample.names, *sample.also, sample.fault} - {""}
    said = Verdict(sample, result=result)
    look_at_words(said)
    assert said.troubles == []
    assert found
    assert names <= right
    assert sample.fault in ("", *names)
    assert names or not sample.names or sample.part == "habits"  # a habit may have a name
    if sample.takes is not None:
        assert {id_: points for id_, points in found.items() if points > sample.takes.get(id_, 0.0) + 1e-6} == {}
    else:
        assert set(found) <= set(sample.loses)
        assert sum(found.values()) <= sample.most + 1e-9
