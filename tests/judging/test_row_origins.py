"""Tests of the origins of recorded rows, and of the facts about a recorder, on arrays made by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from grader.labs.imu.collection import SENSORS, Collection
from grader.labs.imu.data_collection import measure, row_origins
from grader.labs.imu.data_collection.diagnosis import Explained, counting_fault
from grader.labs.imu.data_collection.measure import CLAIMED_WORLD, TRUE_WORLD, Claim, Facts, Run
from grader.labs.imu.data_collection.row_origins import RowOrigin
from grader.labs.imu.returned import Array

pytestmark = pytest.mark.quick
_STEPS, _DT = 200, 0.002


def _motion(seed: int) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    return rng.normal((0, 0, 9.81), 2, (_STEPS, 3)), rng.normal(0, 0.7, (_STEPS, 3))


_WORLDS = {TRUE_WORLD: _motion(1), CLAIMED_WORLD: _motion(2)}
_STAMPS: Array = np.asarray(_DT * np.arange(1, _STEPS + 1), np.float64)


def _run(accel: Array, gyro: Array, time: Array | None = None, **more: object) -> Run:
    series = Collection(time, accel, gyro)
    return replace(Run(series, _WORLDS, _STEPS * _DT, _DT, _STEPS, series), **more)  # type: ignore[arg-type]


def _taken(rows: object, world: str = TRUE_WORLD, time: Array | None = None) -> Run:
    accel, gyro = _WORLDS[world]
    return _run(accel[rows], gyro[rows], time)  # type: ignore[call-overload]


@given(
    world=st.sampled_from(list(_WORLDS)),
    exchanged=st.booleans(),
    how=st.sampled_from(
        [{}, {"lag": 1}, {"lag": -1}, {"lag": -7}, {"skip": 2}, {"skip": 5, "first": 4}, {"aliased": True}]
    ).map(lambda words: RowOrigin(**words)),  # type: ignore[arg-type]
)
def test_rows_are_told_by_the_story_that_they_were_made_by(world: str, exchanged: bool, how: RowOrigin) -> None:
    assume(not exchanged or how.lag > -7)  # where the first sample is looked for, sensors are not exchanged
    made = replace(how, world=world, exchanged=exchanged)
    rows = how.skip * np.arange(_STEPS // how.skip) + how.first - how.lag
    rows = np.full(_STEPS, _STEPS - 1) if how.aliased else rows[rows < _STEPS]
    run = _taken(np.maximum(rows, 0), world)
    accel, gyro = run.series.sensors
    if exchanged:
        run = replace(run, series=Collection(None, gyro, accel))
    assert row_origins.explain(run) == made


def test_rows_at_uneven_steps_are_told_by_their_stamps() -> None:
    at = np.flatnonzero(np.random.default_rng(3).random(_STEPS) < 0.4)
    found = row_origins.explain(_taken(at, time=_STAMPS[at]))
    assert found is not None
    assert found.at == tuple(at)
    assert found.covers(len(at), _STEPS)


@pytest.mark.parametrize(("by", "told"), [(0.9, RowOrigin()), (1.1, None)])
def test_rows_within_the_tolerance_are_right(by: float, told: RowOrigin | None) -> None:
    accel, gyro = _WORLDS[TRUE_WORLD]
    assert row_origins.explain(_run(accel + by * 2e-3, gyro)) == told
    assert row_origins.explain(_run(accel, gyro - by * 2e-4)) == told


def test_a_few_rows_do_not_tell_late_from_early() -> None:
    late = np.maximum(np.arange(21) - 1, 0)
    assert row_origins.explain(_taken(late)) == RowOrigin(lag=1)
    assert row_origins.explain(_taken(late[:20])) is None
    assert row_origins.explain(_taken(slice(1))) == RowOrigin()


def _turned(rows: Array) -> Array:
    return rows[:, [1, 0, 2]]


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (lambda rows: rows.round(1), "rounded"),
        (lambda rows: rows.astype(np.float16).astype(float), "rounded"),
        (lambda rows: -2 * rows + 0.5, "treated"),
        (_turned, "treated"),
        (lambda rows: rows**2, None),
    ],
)
def test_altered_rows_of_one_sensor_are_told_beside_the_other(change, found: str | None) -> None:  # type: ignore[no-untyped-def]
    accel, gyro = _WORLDS[TRUE_WORLD]
    origin = row_origins.explain_altered(_run(change(accel), gyro))
    assert origin == RowOrigin(altered=SENSORS[:1])
    assert row_origins.treatment(SENSORS[0], change(accel), accel) == found


@pytest.mark.parametrize(
    ("stamps", "origin", "worst"),
    [
        (_STAMPS - _DT, RowOrigin(), 0.0),
        (_STAMPS + _DT, RowOrigin(), _DT),
        (_STAMPS[:100] * 2, RowOrigin(skip=2), 0.0),
        (_STAMPS[7:], RowOrigin(lag=-7), 0.0),
        (_STAMPS[[1, 4]], RowOrigin(at=(1, 4)), 0.0),
    ],
)
def test_stamps_are_right_from_the_first_step_or_from_zero_on(stamps: Array, origin: RowOrigin, worst: float) -> None:
    assert row_origins.time_error(stamps, _DT, origin).max() == pytest.approx(worst, abs=1e-12)


def _of_length(n: int, **more: object) -> Run:
    series = Collection(None, np.ones((n, 3)), np.ones((n, 3)))
    return replace(Run(series, _WORLDS, 1.2, _DT, 600, series), **more)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("first", "second", "skips", "fault"),
    [
        (602, 301, False, "ignores-duration"),
        (300, 290, False, ""),
        (601, 300, False, "hard-coded-timestep"),
        (60, 30, True, "fixed-rate"),
        (57, 30, True, "samples-skipped"),
    ],
)
def test_the_numbers_of_rows_tell_what_they_were_made_of(first: int, second: int, skips: bool, fault: str) -> None:
    other = _of_length(second, duration_s=0.6, model_timestep=0.004, model_steps=150)
    assert counting_fault(_of_length(first), other, skips=skips) == fault


_CLAIM = Claim(
    np.zeros(3), np.array([0.5, 0, 0]), np.array([0, 0, -9.81]), _DT, np.zeros(3), np.zeros(0), np.zeros((0, 3))
)


@pytest.mark.parametrize(
    ("claim", "words"),
    [
        (_CLAIM, ""),
        (replace(_CLAIM, qvel=np.zeros(3)), "a recording without a push"),
        (replace(_CLAIM, qvel=np.array([0, 0.5, 0])), "a recording that starts with qvel[1] = 0.5"),
        (replace(_CLAIM, force=np.array([30.0, 0, 0])), "a recording with a force of up to 30 N or Nm"),
        (
            replace(_CLAIM, qvel=np.zeros(3), set_at=np.array([40])),
            "a velocity that is set before step 41, and not at the start",
        ),
        (
            replace(_CLAIM, set_at=np.array([40, 80])),
            "qpos, qvel or a force set 2 times while the simulation runs, first before step 41",
        ),
    ],
)
def test_a_claimed_start_is_the_sheets_push_or_told_in_words(claim: Claim, words: str) -> None:
    assert claim.push == words
    assert claim.without_push is (words == "a recording without a push")


def test_a_list_that_outlives_the_call_leaves_the_rows_of_the_earlier_run() -> None:
    accel, gyro = _WORLDS[TRUE_WORLD]
    once = Collection(_STAMPS, accel, gyro)
    twice = Collection(np.tile(_STAMPS, 2), np.tile(accel, (2, 1)), np.tile(gyro, (2, 1)))
    assert measure.rows_left(once) == 0
    assert measure.rows_left(twice) == _STEPS
    assert measure.rows_left(twice, once) == _STEPS
    assert measure.rows_left(once.rows(0, 20), once) == 0


def test_rows_follow_a_simulation_whatever_is_done_to_their_numbers() -> None:
    true, leaning = _WORLDS[TRUE_WORLD][0], _WORLDS[CLAIMED_WORLD][0]
    assert measure.follows(2 * true + 1, true, 2 * leaning + 1, leaning)
    assert measure.follows(true[::-1], true, leaning[::-1], leaning)
    assert not measure.follows(true, true, true, leaning)
    assert not measure.follows(true[:19], true, leaning[:19], leaning)
    assert measure.follows(np.repeat(true, 5, axis=0), true, np.repeat(leaning, 5, axis=0), leaning)
    assert not measure.follows(np.resize(true[:8], true.shape), true, np.resize(leaning[:8], leaning.shape), leaning)


@pytest.mark.parametrize(
    ("begins", "later", "goes_on"), [(0, 9, True), (0, 2, False), (9, 9, False), (2000, 2009, False)]
)
def test_a_run_goes_on_if_it_begins_where_time_was_left_and_the_first_one_did_not(
    begins: int, later: int, goes_on: bool
) -> None:
    push, other = (_taken(slice(None), time=_STAMPS + late * _DT) for late in (begins, later))
    facts = Facts(push, other, np.zeros(3), np.zeros(3), _DT, left_at=10 * _DT)
    assert Explained(facts, RowOrigin(), RowOrigin()).goes_on is goes_on


class _Scenario(dict):  # type: ignore[type-arg]
    scalars: ClassVar = {"gravity": [0.0, 0.0, -9.81]}


@pytest.mark.parametrize(("joints", "starts"), [(1, 4), (2, 5), (24, 6)])
def test_starts_are_assumed_for_the_joints_that_a_robot_has(joints: int, starts: int) -> None:
    robot = _Scenario(qpos=np.zeros((2, joints)), qvel=np.zeros((2, joints)))
    student: Any = SimpleNamespace(replay=lambda _start, _steps: None)
    truth: Any = {"reading_lab": robot, "push": _Scenario()}
    assumed = list(measure.with_assumed_starts(student, truth, _taken(slice(None)), "push"))
    assert [each.claim for each in assumed] == [None] * starts
