"""What is known of a recording by its rows alone, and what is asked again of its run: series of a few rows that are made by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from grader.labs.imu import recordings
from grader.labs.imu.answers import KEYS, Array, Collection
from tests.judging.made import truth

pytestmark = pytest.mark.quick
_ALIKE, _MOVING = np.ones((4, 3)), np.arange(12.0).reshape(4, 3)
_NONE = np.full((4, 3), np.nan)


@pytest.mark.parametrize(
    ("accel", "gyro", "complete"),
    [(_ALIKE, _ALIKE, True), (_ALIKE, None, False), (None, _ALIKE, False), (None, None, False)],
)
def test_a_recording_is_complete_with_both_sensors(accel: Array | None, gyro: Array | None, complete: bool) -> None:
    assert recordings.complete(Collection(None, accel, gyro)) is complete


@pytest.mark.parametrize(
    ("series", "rows"),
    [
        (Collection(np.zeros(5), np.zeros((3, 3)), np.zeros((4, 3))), 3),
        (Collection(np.zeros(5), None, np.zeros((4, 3))), 4),
        (Collection(np.zeros(5), None, None), 5),
        (Collection(None, None, None), 0),
    ],
)
def test_a_recording_is_as_long_as_its_accelerations_or_what_else_there_is(series: Collection, rows: int) -> None:
    assert recordings.length(series) == rows


@pytest.mark.parametrize(
    ("series", "alike"),
    [
        (Collection(None, _ALIKE, 2 * _ALIKE), True),
        (Collection(None, _ALIKE[:2], _ALIKE[:2]), True),
        (Collection(None, _ALIKE[:1], _ALIKE[:1]), False),
        (Collection(None, _ALIKE * [1, 2, 3], _ALIKE), True),
        (Collection(None, _MOVING, _ALIKE), False),
        (Collection(None, _ALIKE, _MOVING), False),
        (Collection(None, _ALIKE, _NONE, absent=KEYS[2]), True),
        (Collection(None, _NONE, _ALIKE, absent=KEYS[1]), True),
        (Collection(None, _MOVING, _NONE, absent=KEYS[2]), False),
        (Collection(None, None, None), False),
    ],
)
def test_rows_are_all_alike_where_those_of_each_sensor_that_is_there_are(series: Collection, alike: bool) -> None:
    assert recordings.all_alike(series) is alike


@pytest.mark.parametrize(
    ("own", "leaning", "follows"),
    [
        (_ALIKE, _ALIKE, False),
        (_ALIKE, _ALIKE + 0.11, False),
        (_ALIKE, _ALIKE + 0.13, True),
        (_ALIKE, _ALIKE - 0.13, True),
        (None, _ALIKE, False),
        (_ALIKE, None, False),
        (_ALIKE, _ALIKE[:0], False),
    ],
)
def test_one_row_follows_where_it_is_another_one_under_gravity_that_leans(
    own: Array | None, leaning: Array | None, follows: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recordings, "pushed", lambda *_: Collection(None, own, own))
    monkeypatch.setattr(recordings, "_leaning", lambda *_: Collection(None, leaning, leaning))
    student: Any = None
    assert recordings.one_row_follows(student, truth()) is follows


class Replaying:
    """A sandbox that says which runs it was asked for again; nine sensor values a row."""

    def __init__(self) -> None:
        self.asked: list[int] = []

    def replay(self, _first: Any, rows: int) -> Array:
        self.asked.append(rows)
        return np.tile(np.arange(9.0), (rows, 1))


@pytest.mark.parametrize(("rows", "asked"), [(4, 4), (4000, 3000)])
def test_a_run_is_held_against_the_accelerations_of_ours_and_never_without_an_end(rows: int, asked: int) -> None:
    student: Any = Replaying()
    traces: Any = {"reading_lab": {"sensor_adr": np.array([3, 0]), "pairs": np.array([[0, 1]])}}
    accel = np.ones((rows, 3))
    beside = recordings._beside_ours(student, traces, Collection(None, accel, accel, first_step={"steps": np.ones(1)}))
    assert beside is not None
    theirs, ours = beside
    assert theirs is accel
    assert student.asked == [asked]
    assert np.array_equal(ours, np.tile([3.0, 4.0, 5.0], (asked, 1)))


def test_a_run_without_a_step_or_a_row_is_not_held_against_ours() -> None:
    student: Any = Replaying()
    step = {"steps": np.ones(1)}
    for series in (
        Collection(None, _ALIKE, _ALIKE),
        Collection(None, None, _ALIKE, first_step=step),
        Collection(None, _ALIKE[:0], _ALIKE[:0], first_step=step),
    ):
        assert recordings._beside_ours(student, truth(), series) is None
    assert student.asked == []
