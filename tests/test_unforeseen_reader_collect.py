"""Readers and recordings that no list foresaw cost what a marker said before they were judged, and are called by no wrong name."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from grader.engine.results import CheckResult, Result
from grader.intake import Submission
from grader.labs.imu.answers import Collection
from grader.labs.imu.compare import told
from grader.labs.imu.diagnosis import collection
from grader.labs.imu.diagnosis.collection import Story, Worlds
from tests.corpus.unforeseen_reader_collect import FAULTY, SOUND, Sample
from tests.recordings import Marking

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


Marked = Callable[[Sample], Result]


@pytest.fixture(scope="module")
def marked(player: Marking) -> Marked:
    """Marks a sample once."""
    results: dict[str, Result] = {}

    def mark(sample: Sample) -> Result:
        if sample.name not in results:
            content = {name: text.encode() for name, text in sample.files.items()}
            only = None if sample.name in EVERYWHERE else sample.part
            results[sample.name] = player.mark(Submission("s", "s", content, (), "ready", ""), only=only)
        return results[sample.name]

    return mark


def lost(result: Result) -> list[CheckResult]:
    checks = [check for criterion in result.criteria for check in criterion.checks]
    return [check for check in checks if check.points != check.max_points]


@pytest.mark.parametrize("sample", FAULTY, ids=lambda sample: sample.name)
def test_a_fault_costs_what_the_marker_said_and_has_a_true_name_or_none(sample: Sample, marked: Marked) -> None:
    result = marked(sample)
    taken = {check.id: check.max_points - (check.points or 0.0) for check in lost(result)}
    assert taken
    assert {id_: points for id_, points in taken.items() if points > sample.takes.get(id_, 0.0) + 1e-6} == {}
    assert set(result.misconceptions) <= {sample.mistake, *sample.also}
    assert sample.mistake in ("", *result.misconceptions)


@pytest.mark.parametrize("sample", FAULTY, ids=lambda sample: sample.name)
def test_every_lost_check_has_a_hint_and_never_the_same_words_twice(sample: Sample, marked: Marked) -> None:
    for check in lost(marked(sample)):
        assert check.hint or check.outcome == "skipped", check.message
        vectors = re.findall(r"\[[-+\d.e ]{6,}\]", check.message)
        assert len(vectors) == len(set(vectors)), check.message


@pytest.mark.parametrize("sample", SOUND, ids=lambda sample: sample.name)
def test_sound_work_in_an_unusual_style_loses_nothing(sample: Sample, marked: Marked) -> None:
    result = marked(sample)
    assert [(check.id, check.message) for check in lost(result)] == []
    assert result.misconceptions == ()


# --- diagnosis, on arrays alone ------------------------------------------------------------------------------------------

ATOL = 1e-5
RNG = np.random.default_rng(15)
TRUE = RNG.normal(0, 4, (26, 3)), RNG.normal(0, 1, (26, 3))
AXES = np.array([np.linalg.qr(RNG.normal(size=(3, 3)))[0] for _ in range(26)])
AXES *= np.linalg.det(AXES)[:, None, None]
MOUNTED = np.diag([1.0, -1.0, -1.0])


STEPS, DT = 600, 0.002
STAMPS = (np.arange(STEPS) + 1) * DT
WORLD = 9.81 * np.sin(np.outer(STAMPS, [7.0, 11.0, 13.0])), np.cos(np.outer(STAMPS, [5.0, 17.0, 19.0]))
WORLDS = Worlds({"truth": WORLD}, DT, STEPS * DT, STEPS)


def recorded(rows: np.ndarray | slice, change: Callable[[np.ndarray], np.ndarray] = lambda x: x) -> Collection:
    return Collection(STAMPS[rows], change(WORLD[0][rows]), change(WORLD[1][rows]))


@pytest.mark.quick
@pytest.mark.parametrize("stride", [2, 3, 6, 7, 8, 13, 25])
@pytest.mark.parametrize("last", [False, True])
def test_every_stride_of_a_thinned_recording_is_told(stride: int, last: bool) -> None:
    series = recorded(slice(stride - 1 if last else 0, None, stride))
    story = collection.explain(series, WORLDS)
    assert story is not None
    assert story.skip == stride
    assert story.covers(len(series.time), STEPS)  # type: ignore[arg-type]
    assert collection.time_error(series.time, DT, story).max() < 1e-9  # type: ignore[arg-type]


@pytest.mark.quick
def test_rows_at_a_rate_that_does_not_divide_the_steps_are_told_by_their_stamps() -> None:
    rows = np.unique(np.ceil(np.arange(1, 240) * 2.5).astype(int) - 1)
    story = collection.explain(recorded(rows), WORLDS)
    assert story is not None
    assert story.at == tuple(rows)
    assert story.covers(len(rows), STEPS)


@pytest.mark.quick
@pytest.mark.parametrize(
    "change", [np.negative, np.trunc, lambda x: x.round(1), lambda x: 0.9 * x, lambda x: x[:, ::-1] + 2]
)
def test_rows_that_one_treatment_makes_are_the_same_run(change: Callable[[np.ndarray], np.ndarray]) -> None:
    assert collection.explain(recorded(slice(None), change), WORLDS) is None
    assert collection.explain_altered(recorded(slice(None), change), WORLDS) == Story(altered=collection.SENSORS)


@pytest.mark.quick
def test_rows_of_chance_are_no_treatment_of_any_run() -> None:
    series = recorded(slice(None), lambda x: RNG.normal(0, 9.81, x.shape))
    assert collection.explain_altered(series, WORLDS) is None


@pytest.mark.quick
@pytest.mark.parametrize("shorter", collection.SENSORS)
def test_a_sensor_with_fewer_rows_than_the_other_is_told_as_far_as_both_reach(shorter: str) -> None:
    series = recorded(slice(None), np.negative)
    series = replace(series, **{shorter: getattr(series, shorter)[:-3]})
    assert collection.explain_altered(series, WORLDS) == Story(altered=collection.SENSORS)


@pytest.mark.quick
def test_a_vector_has_as_many_digits_as_tell_it_from_the_other_one() -> None:
    near, far = np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 3.00001])
    assert told(near, far) != told(far, near)
    assert told(near, near + 1) == "[1.000 2.000 3.000]"
