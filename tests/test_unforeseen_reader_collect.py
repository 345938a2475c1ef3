"""Readers and recordings that no list foresaw cost what a marker said before they were judged, and are called by no wrong name."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest

from grader.engine.results import CheckResult, Result
from grader.intake import Submission
from tests.corpus.cases import Case, of
from tests.recordings import Marking

FAULTY, SOUND = (
    [case for case in of(part) if case.criterion in ("sensor_access", "data_collection")]
    for part in ("unforeseen", "unforeseen sound")
)
EVERYWHERE = {  # faults that reach into other criteria: into the plot by the recording's form, into all by a shared class
    "class-with-the-id-as-address",
    "class-in-the-other-order",
    "class-that-clips",
    "one-key-misspelled",
    "keys-in-the-plural",
    "three-long-rows",
    "append-without-an-axis",
    "a-dataclass-in-place-of-a-dictionary",
}


Marked = Callable[[Case], Result]


@pytest.fixture(scope="module")
def marked(player: Marking) -> Marked:
    """Marks a sample once."""
    results: dict[str, Result] = {}

    def mark(sample: Case) -> Result:
        if sample.name not in results:
            content = {name: str(text).encode() for name, text in sample.files.items()}
            only = None if sample.name in EVERYWHERE else sample.criterion
            results[sample.name] = player.mark(Submission("s", "s", content, (), "ready", ""), only=only)
        return results[sample.name]

    return mark


def lost(result: Result) -> list[CheckResult]:
    checks = [check for criterion in result.criteria for check in criterion.checks]
    return [check for check in checks if check.points != check.max_points]


@pytest.mark.parametrize("sample", FAULTY, ids=lambda sample: sample.name)
def test_a_fault_costs_what_the_marker_said_and_has_a_true_name_or_none(sample: Case, marked: Marked) -> None:
    result = marked(sample)
    taken = {check.id: check.max_points - (check.points or 0.0) for check in lost(result)}
    assert taken
    assert {id_: points for id_, points in taken.items() if points > (sample.takes or {}).get(id_, 0.0) + 1e-6} == {}
    assert set(result.misconceptions) <= {sample.fault, *sample.also}
    assert sample.fault in ("", *result.misconceptions)


@pytest.mark.parametrize("sample", FAULTY, ids=lambda sample: sample.name)
def test_every_lost_check_has_a_hint_and_never_the_same_words_twice(sample: Case, marked: Marked) -> None:
    for check in lost(marked(sample)):
        assert check.hint or check.outcome == "skipped", check.message
        vectors = re.findall(r"\[[-+\d.e ]{6,}\]", check.message)
        assert len(vectors) == len(set(vectors)), check.message


@pytest.mark.parametrize("sample", SOUND, ids=lambda sample: sample.name)
def test_sound_work_in_an_unusual_style_loses_nothing(sample: Case, marked: Marked) -> None:
    result = marked(sample)
    assert [(check.id, check.message) for check in lost(result)] == []
    assert result.misconceptions == ()
