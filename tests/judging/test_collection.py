"""Which story is told of recorded rows, by worlds and rows that are made by hand."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from grader.engine.traces import Scenario
from grader.labs.imu.answers import SENSORS, Array, Collection
from grader.labs.imu.diagnosis import collection
from grader.labs.imu.diagnosis.collection import (
    CLAIMED_WORLD,
    LAST_SENSOR,
    LEARNT_IDS,
    OTHER_IMU,
    OWN_WORLD,
    TRUE_WORLD,
    Claim,
    Story,
    Worlds,
)

pytestmark = pytest.mark.quick
_STEPS, _DT = 200, 0.002
_ATOL = {"acceleration": 2e-3, "angular_velocity": 2e-4}
_ACCELERATION, _RATE = SENSORS


def _motion(seed: int, rows: int = _STEPS) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    return rng.normal((0, 0, 9.81), 2, (rows, 3)), rng.normal(0, 0.7, (rows, 3))


_ACCEL, _GYRO = _motion(1)
_WEAK, _SLOW = _motion(2)
_WORLDS = Worlds({TRUE_WORLD: (_ACCEL, _GYRO), "no_push": (_WEAK, _SLOW)}, _DT, _STEPS * _DT, _STEPS)
_STAMPS = _DT * np.arange(1, _STEPS + 1)


def _taken(wanted: object, accel: Array = _ACCEL, gyro: Array = _GYRO, time: Array | None = None) -> Collection:
    """The rows of these numbers, and stamps that tell nothing unless some are given."""
    return Collection(time, accel[wanted], gyro[wanted])  # type: ignore[index]


def _late(rows: int, by: int = 1) -> Collection:
    return _taken(np.maximum(np.arange(rows) - by, 0))


@pytest.mark.parametrize(
    "story",
    [
        Story(), Story(lag=1), Story(lag=-1), Story(lag=-9), Story(lag=30), Story(lag=-30), Story(skip=2), Story(skip=2, first=1),
        Story(skip=5, first=4), Story(skip=3, lag=2), Story(skip=3, lag=-4), Story(aliased=True), Story(skip=2, at=(1, 3, 4, 25)),
    ],
)  # fmt: skip
def test_rows_are_held_against_those_that_the_story_tells_of(story: Story) -> None:
    for n, available in itertools.product((0, 1, 12, 20), (0, 1, 7, 20, 40)):
        told = [r * story.skip + story.first - story.lag for r in range(n)]
        told = [n - 1] * n if story.aliased else list(story.at[:n]) if story.at else told
        pairs = [(row, wanted) for row, wanted in enumerate(told) if 0 <= wanted < available]
        rows, wanted = collection._rows(story, n, available)
        assert list(zip(np.arange(n)[rows].tolist(), np.arange(available)[wanted].tolist(), strict=True)) == pairs


_AT = tuple(int(step) for step in np.flatnonzero(np.random.default_rng(3).random(_STEPS) < 0.4))
_IRREGULAR = _taken(list(_AT), time=_STAMPS[list(_AT)])
_FLAT = (np.tile([0, 0, 9.81], (_STEPS, 1)), _GYRO)
_NANS = np.full((_STEPS, 3), np.nan)
_LONG = _motion(6, 600)
_LONG_WORLD = Worlds({TRUE_WORLD: _LONG}, _DT, 1.2, 600)
_RESTING = tuple(np.concatenate([np.tile(part[:1], (30, 1)), part]) for part in (_ACCEL, _GYRO))
_SHORT_WORLD = replace(_WORLDS, series={TRUE_WORLD: (_ACCEL[:110], _GYRO[:110])})
_HARDLY_THINNED = sorted({*range(30, 170)} - {*range(33, 170, 4)})


def _then_others(*wanted: int) -> Collection:
    """These rows, and ten that are of no world."""
    return Collection(None, *(np.vstack([part[list(wanted)], np.cos(part[:10])]) for part in (_ACCEL, _GYRO)))


def _padded(series: Collection) -> Collection:
    """The rows, ten that are left empty, and stamps that go on."""
    assert series.time is not None
    empty = np.zeros((10, 3))
    return Collection(
        np.append(series.time, series.time[-1] + _STAMPS[:10]),
        *(np.vstack([rows, empty]) for rows in series.sensors if rows is not None),
    )


@pytest.mark.parametrize(
    ("series", "worlds", "story"),
    [
        (_taken(slice(None)), _WORLDS, Story()),
        (_taken(slice(10)), _WORLDS, Story()),
        (_taken(slice(1)), _WORLDS, Story()),
        (_taken(slice(None), _WEAK, _SLOW), _WORLDS, Story("no_push")),
        (_taken(slice(None), _GYRO, _ACCEL), _WORLDS, Story(exchanged=True)),
        (_taken(slice(None), _SLOW, _WEAK), _WORLDS, Story("no_push", exchanged=True)),
        (_taken(slice(None), _ACCEL, _SLOW), _WORLDS, None),
        (_taken(slice(None), _ACCEL + 0.9 * 2e-3, _GYRO - 0.9 * 2e-4), _WORLDS, Story()),
        (_taken(slice(None), _ACCEL + 1.1 * 2e-3), _WORLDS, None),
        (_taken(slice(None), gyro=_GYRO + 1.1 * 2e-4), _WORLDS, None),
        (_late(_STEPS), _WORLDS, Story(lag=1)),
        (_late(_STEPS, 2), _WORLDS, None),
        (_late(21), _WORLDS, Story(lag=1)),
        (_late(20), _WORLDS, None),
        (_late(16), replace(_WORLDS, steps=30), Story(lag=1)),
        (_late(15), replace(_WORLDS, steps=30), None),
        (_late(2), replace(_WORLDS, steps=3), Story(lag=1)),
        (_taken(slice(1, None)), _WORLDS, Story(lag=-1)),
        (_taken(slice(7, None)), _WORLDS, Story(lag=-7)),
        (_taken(slice(181, None)), _WORLDS, None),
        (_taken(slice(180, None)), _WORLDS, Story(lag=-180)),
        (_taken(slice(0, None, 2)), _WORLDS, Story(skip=2)),
        (_taken(slice(1, None, 2)), _WORLDS, Story(skip=2, first=1)),
        (_taken(slice(0, None, 3)), _WORLDS, Story(skip=3)),
        (_taken(slice(0, None, 4)), _WORLDS, Story(skip=4)),
        (_taken(slice(4, None, 5)), _WORLDS, Story(skip=5, first=4)),
        (_taken(slice(0, None, 10)), _WORLDS, Story(skip=10)),
        (_taken(slice(0, 110, 10)), _WORLDS, Story(skip=10)),
        (_taken(slice(0, 90, 10)), _WORLDS, Story(skip=10)),
        (_taken(slice(19, None, 20)), _WORLDS, Story(skip=20, first=19)),
        (_taken(slice(0, None, 50)), _WORLDS, Story(skip=50)),
        (_taken(slice(0, None, 100)), _WORLDS, Story(skip=100)),
        (_taken(slice(0, None, 7)), _WORLDS, Story(skip=7)),
        (_taken(slice(0, None, 9)), _WORLDS, Story(skip=9)),
        (_taken(slice(0, 91, 7)), _WORLDS, None),
        (_taken(slice(0, 105, 7)), _WORLDS, None),
        (_taken(slice(0, 105, 7), time=_STAMPS[0:105:7]), _WORLDS, Story(skip=7)),
        (_taken(slice(0, 105, 7), time=_STAMPS[0:105:7] * np.nan), _WORLDS, None),
        *((_taken(slice(0, None, skip), *_LONG), _LONG_WORLD, Story(skip=skip)) for skip in (2, 3, 4, 5, 10, 20, 50, 100)),
        *((_taken(slice(0, 450, skip), *_LONG), _LONG_WORLD, Story(skip=skip)) for skip in (2, 3, 4, 5, 10, 20, 50, 100)),
        (_taken(slice(0, None, 15)), _WORLDS, Story(skip=15)),
        (_taken(slice(14, None, 15)), _WORLDS, Story(skip=15, first=14)),
        (_then_others(*range(0, 110, 10)), _SHORT_WORLD, Story(skip=10)),
        (_then_others(*range(0, 90, 10)), replace(_SHORT_WORLD, series={TRUE_WORLD: (_ACCEL[:90], _GYRO[:90])}), None),
        (_taken(slice(1, None), *_RESTING), replace(_WORLDS, series={TRUE_WORLD: _RESTING}), Story(lag=-1)),
        (_padded(_IRREGULAR), _WORLDS, Story(skip=2, at=(*_AT, *range(_AT[-1] + 1, _AT[-1] + 11)))),
        (_taken(_HARDLY_THINNED, time=_STAMPS[_HARDLY_THINNED]), _WORLDS, Story(skip=2, at=tuple(_HARDLY_THINNED))),
        (_taken(slice(2, None, 5)), _WORLDS, None),
        (_taken(slice(0, None, 5), *_FLAT), replace(_WORLDS, series={TRUE_WORLD: _FLAT}), None),
        (_taken(slice(None), *_FLAT), replace(_WORLDS, series={TRUE_WORLD: _FLAT}), Story()),
        (_taken(slice(0, None, 5), _GYRO, _ACCEL), _WORLDS, Story(skip=5, exchanged=True)),
        (_taken(slice(4, None, 5), _SLOW, _WEAK), _WORLDS, Story("no_push", skip=5, first=4, exchanged=True)),
        (_IRREGULAR, _WORLDS, Story(skip=round((_AT[-1] - _AT[0]) / (len(_AT) - 1)), at=_AT)),
        (replace(_IRREGULAR, acceleration=_IRREGULAR.angular_velocity, angular_velocity=_IRREGULAR.acceleration), _WORLDS,
         Story(skip=round((_AT[-1] - _AT[0]) / (len(_AT) - 1)), at=_AT, exchanged=True)),
        (replace(_IRREGULAR, time=None), _WORLDS, None),
        (replace(_IRREGULAR, time=_IRREGULAR.time * 3), _WORLDS, None),
        (_IRREGULAR.rows(0, 19), _WORLDS, None),
        (_IRREGULAR.rows(0, 20), _WORLDS, Story(skip=round((_AT[19] - _AT[0]) / 19), at=_AT[:20])),
        (_taken(np.full(_STEPS, _STEPS - 1)), _WORLDS, Story(aliased=True)),
        (_taken(np.full(_STEPS, _STEPS - 1), _WEAK, _SLOW), _WORLDS, Story("no_push", aliased=True)),
        (_taken(np.full(_STEPS, _STEPS - 1), _GYRO, _ACCEL), _WORLDS, Story(exchanged=True, aliased=True)),
        (_taken(np.full(_STEPS, _STEPS - 2)), _WORLDS, None),
        (_taken(slice(None), np.cos(_ACCEL), _GYRO), _WORLDS, None),
        (_taken(slice(None), _WEAK, _SLOW), replace(_WORLDS, series={"no_push": (_WEAK, _SLOW)}), Story("no_push")),
        (_taken(slice(None), _WEAK, _SLOW), replace(_WORLDS, series={"a": (_WEAK, _SLOW), "b": (_WEAK, _SLOW)}), None),
        (Collection(None, np.vstack([_ACCEL[:150], np.zeros((50, 3))]), np.vstack([_GYRO[:150], np.zeros((50, 3))])), _WORLDS, Story()),
        (Collection(None, np.zeros((_STEPS, 3)), np.zeros((_STEPS, 3))), _WORLDS, None),
        (Collection(None, np.vstack([_NANS[:1], _ACCEL]), np.vstack([_NANS[:1], _GYRO])), _WORLDS, Story(lag=1)),
    ],
)  # fmt: skip
def test_the_simplest_story_that_predicts_the_rows_is_told(
    series: Collection, worlds: Worlds, story: Story | None
) -> None:
    assert collection.explain(series, worlds) == story


def test_without_the_rows_of_a_sensor_no_story_fits() -> None:
    assert not Story().fits((Collection(None, None, _GYRO), _WORLDS))
    assert not Story().fits((Collection(None, _ACCEL, None), _WORLDS))


_STRANGE = np.cos(7 * _ACCEL**2)


@pytest.mark.parametrize(
    ("series", "altered"),
    [
        (_taken(slice(None), gyro=_STRANGE), (_RATE,)),
        (_taken(slice(None), _STRANGE), (_ACCELERATION,)),
        (_taken(slice(None), _STRANGE, _STRANGE), None),
        (_taken(slice(None), -_ACCEL, 2 * _GYRO + 1), SENSORS),
        (_taken(slice(12), gyro=_STRANGE), (_RATE,)),
        (_taken(slice(None), _NANS), (_ACCELERATION,)),
        (_taken(slice(None), _STRANGE, -_GYRO), None),
        (Collection(None, _STRANGE[:150], _GYRO), (_ACCELERATION,)),
        (Collection(None, _STRANGE, _GYRO[:150]), (_ACCELERATION,)),
    ],
)
def test_rows_of_one_sensor_tell_whose_numbers_were_altered(
    series: Collection, altered: tuple[str, ...] | None
) -> None:
    assert collection.explain_altered(series, _WORLDS) == (None if altered is None else Story(altered=altered))


def test_altered_rows_may_be_of_the_run_that_was_claimed() -> None:
    claimed = replace(_WORLDS, series={**_WORLDS.series, CLAIMED_WORLD: _motion(4)})
    accel, gyro = _motion(4)
    one, both = Collection(None, accel, _STRANGE), Collection(None, -accel, -gyro)
    assert collection.explain_altered(one, claimed) == Story(CLAIMED_WORLD, altered=(_RATE,))
    assert collection.explain_altered(both, claimed) == Story(CLAIMED_WORLD, altered=SENSORS)
    assert collection.explain_altered(Collection(None, -_WEAK, -_SLOW), claimed) is None


@pytest.mark.parametrize(
    ("story", "cost"),
    [
        (Story(), 0), (Story("no_push"), 1), (Story(lag=-3), 1), (Story(skip=5, first=4), 1), (Story(exchanged=True), 1),
        (Story(aliased=True), 1), (Story("no_push", skip=2, exchanged=True), 3), (Story(altered=(_RATE,)), 5),
        (Story(CLAIMED_WORLD, altered=SENSORS), 11),
    ],
)  # fmt: skip
def test_a_story_costs_what_is_odd_in_it_and_more_than_all_that_for_altered_numbers(story: Story, cost: int) -> None:
    assert story.cost == cost


def test_stories_are_told_by_what_is_odd_in_them() -> None:
    odd = [
        Story(), Story("no_push"), Story(lag=1), Story(skip=2), Story(exchanged=True), Story(aliased=True),
        Story(altered=(_RATE,)),
    ]  # fmt: skip
    assert len({story.told for story in odd}) == len(odd)
    assert Story(lag=1).told == Story(lag=-9).told
    assert Story(skip=2).told == Story(skip=5, first=4).told


@pytest.mark.parametrize(
    ("story", "of_claim", "of_others"),
    [
        (Story(), False, False), (Story("no_push"), False, False), (Story(CLAIMED_WORLD), True, False),
        (Story(OWN_WORLD), True, False), (Story(LAST_SENSOR), False, True), (Story(LEARNT_IDS), False, True),
        (Story(f"{OTHER_IMU} 2"), False, True), (Story(CLAIMED_WORLD, exchanged=True), True, True),
    ],
)  # fmt: skip
def test_a_story_says_whose_run_and_whose_sensors_it_tells_of(story: Story, of_claim: bool, of_others: bool) -> None:
    assert (story.of_claim, story.of_other_sensors) == (of_claim, of_others)


@pytest.mark.parametrize(
    ("story", "rows", "whole"),
    [
        (Story(), 200, True), (Story(), 199, True), (Story(), 201, True), (Story(), 198, False), (Story(), 202, False),
        (Story(skip=5), 40, True), (Story(skip=5), 39, True), (Story(skip=5), 41, True), (Story(skip=5), 38, False),
        (Story(skip=4, at=(0, 3, 195)), 3, True), (Story(skip=4, at=(0, 3, 194)), 3, False),
    ],
)  # fmt: skip
def test_rows_cover_the_run_within_one_row(story: Story, rows: int, whole: bool) -> None:
    assert story.covers(rows, _STEPS) == whole


_TWICE = Collection(*(np.concatenate([part[:60], part]) for part in (_STAMPS, _ACCEL, _GYRO)))
_RUN = Collection(_STAMPS, _ACCEL, _GYRO)


def _repeated(first: int, then: int) -> Collection:
    return Collection(*(np.concatenate([part[:first], part[:then]]) for part in (_STAMPS, _ACCEL, _GYRO)))


@pytest.mark.parametrize(
    ("series", "before", "left"),
    [
        (_RUN, None, 0),
        (_TWICE, None, 60),
        (_repeated(20, 100), None, 20),
        (_repeated(19, 100), None, 0),
        (_repeated(100, 20), None, 100),
        (_repeated(100, 19), None, 0),
        (Collection(*(np.concatenate([p[:60], p[:60], p]) for p in (_STAMPS, _ACCEL, _GYRO))), None, 120),
        (replace(_TWICE, acceleration=np.concatenate([_WEAK[:60], _ACCEL])), None, 0),
        (replace(_TWICE, angular_velocity=np.concatenate([_SLOW[:60], _GYRO])), None, 0),
        (Collection(np.concatenate([_STAMPS, _STAMPS]), np.ones((400, 3)), np.ones((400, 3))), None, 0),
        (Collection(np.concatenate([_STAMPS, _STAMPS]), np.ones((400, 3)), np.concatenate([_GYRO, _GYRO])), None, 200),
        (Collection(np.concatenate([_STAMPS, _STAMPS]), np.concatenate([_ACCEL, _ACCEL]), np.ones((400, 3))), None, 200),
        (replace(_TWICE, time=None), None, 0),
        (replace(_TWICE, acceleration=None), None, 0),
        (replace(_TWICE, angular_velocity=None), None, 0),
        (replace(_TWICE, time=np.concatenate([_STAMPS[:60], _STAMPS, _STAMPS[:40]])), None, 60),
        (replace(_TWICE, acceleration=_TWICE.acceleration[:-5]), None, 60),  # type: ignore[index]
        (_TWICE, _RUN.rows(0, 60), 60),
        (_TWICE, _RUN.rows(0, 1), 0),
        (_TWICE, _RUN.rows(0, 2), 2),
        (_TWICE, replace(_RUN.rows(0, 60), acceleration=_WEAK[:60]), 0),
        (_TWICE, replace(_RUN.rows(0, 60), angular_velocity=None), 0),
        (_TWICE, replace(_RUN, time=None), 0),
        (_TWICE, _RUN.rows(0, 0), 0),
        (_TWICE, _TWICE, 0),
        (_TWICE, replace(_TWICE, time=_TWICE.time[:259]), 259),  # type: ignore[index]
        (replace(_TWICE, acceleration=_NANS, angular_velocity=_TWICE.angular_velocity), replace(_RUN.rows(0, 60), acceleration=_NANS[:60]), 60),
    ],
)  # fmt: skip
def test_rows_of_earlier_runs_are_counted(series: Collection, before: Collection | None, left: int) -> None:
    assert collection.rows_left(series, before) == left


def _shaken(size: float, seed: int = 5) -> Collection:
    noise = np.random.default_rng(seed).choice([-1.0, 1.0], (2, _STEPS, 3)) * [[[2e-3]], [[2e-4]]]
    return Collection(None, _ACCEL + size * noise[0], _GYRO + size * noise[1])


_APART = collection._distance(_ACCEL, _GYRO, _WEAK, _SLOW)


@pytest.mark.parametrize(
    ("series", "worlds", "near"),
    [
        (_taken(slice(None)), _WORLDS, TRUE_WORLD),
        (_taken(slice(None), _WEAK, _SLOW), _WORLDS, "no_push"),
        (Collection(None, np.vstack([_WEAK[:20], _ACCEL[20:]]), np.vstack([_SLOW[:20], _GYRO[20:]])), _WORLDS, "no_push"),
        (Collection(None, np.vstack([_WEAK[:19], _ACCEL[19:]]), np.vstack([_SLOW[:19], _GYRO[19:]])), _WORLDS, TRUE_WORLD),
        (_shaken(0.24 * _APART), _WORLDS, TRUE_WORLD),
        (_shaken(0.26 * _APART), _WORLDS, None),
        (_shaken(2), replace(_WORLDS, series={"a": (_WEAK, _SLOW), "b": (_ACCEL, _GYRO)}), "b"),
        (_shaken(0.26 * _APART).rows(0, 0), _WORLDS, None),
        (replace(_shaken(2), acceleration=None), _WORLDS, None),
        (replace(_shaken(2), angular_velocity=None), _WORLDS, None),
        (replace(_shaken(2), acceleration=_NANS), _WORLDS, TRUE_WORLD),
        (replace(_shaken(2), angular_velocity=_NANS), _WORLDS, TRUE_WORLD),
        (_taken(slice(None)), replace(_WORLDS, series={TRUE_WORLD: (_ACCEL, _GYRO), "a": (_ACCEL, _GYRO)}), None),
        (_taken(slice(None)), replace(_WORLDS, series={**_WORLDS.series, CLAIMED_WORLD: (_ACCEL, _GYRO)}, claimed=frozenset([CLAIMED_WORLD])), TRUE_WORLD),
        (replace(_shaken(2), acceleration=_shaken(2).acceleration[:150]), _WORLDS, TRUE_WORLD),  # type: ignore[index]
    ],
)  # fmt: skip
def test_rows_without_a_story_are_of_the_world_that_they_are_far_nearest_to(
    series: Collection, worlds: Worlds, near: str | None
) -> None:
    assert collection.nearest(series, worlds) == near


def test_how_far_rows_are_from_a_world_is_counted_in_tolerances() -> None:
    zeros = np.zeros((4, 3))
    assert collection._distance(zeros + 2e-3, zeros, zeros, zeros) == pytest.approx(1)
    assert collection._distance(zeros, zeros - 6e-4, zeros, zeros) == pytest.approx(3)
    assert collection._distance(zeros + 4e-3, _NANS[:4], zeros, zeros) == pytest.approx(2)
    assert np.isnan(collection._distance(_NANS[:4], _NANS[:4], zeros, zeros))


_MIX = np.array([[1.0, 0.5, 0.0], [0.0, -1.0, 0.2], [0.3, 0.0, 2.0]])


def _other_rows(missed: float) -> Array:
    """The rows of the other run, of whose change a share was missed."""
    foretold, before = (np.asarray(x @ _MIX + 3) for x in (_WEAK, _ACCEL))
    return np.asarray(foretold + missed * (before - foretold))


def _mixed_up(rows: Array) -> Array:
    """A list of x, y, z, x, … that is taken for all of x, then all of y."""
    return np.asarray(rows.reshape(3, -1).T)


@pytest.mark.parametrize(
    ("rows", "other", "goes"),
    [
        (_ACCEL @ _MIX + 3, _other_rows(0), True),
        (_ACCEL @ _MIX + 3, _other_rows(0.49), True),
        (_ACCEL @ _MIX + 3, _other_rows(0.51), False),
        (_ACCEL @ _MIX + 3, _other_rows(1), False),
        ((_ACCEL @ _MIX + 3)[:20], _other_rows(0)[:20], True),
        ((_ACCEL @ _MIX + 3)[:19], _other_rows(0), False),
        (_ACCEL @ _MIX + 3, _other_rows(0)[:19], False),
        ((_ACCEL @ _MIX + 3)[:150], _other_rows(0), True),
        (np.vstack([_ACCEL, _ACCEL]) @ _MIX + 3, np.vstack([_other_rows(0), _NANS]), True),
        (np.vstack([_ACCEL[:100] @ _MIX + 3, _NANS]), _other_rows(0), False),
        (_ACCEL @ _MIX + 3, np.vstack([_other_rows(0)[:100], _NANS]), False),
        (np.vstack([_ACCEL @ _MIX + 3, _NANS]), _other_rows(0), True),
        (-_ACCEL @ _MIX - 3, -_other_rows(0.49), True),
        (-_ACCEL @ _MIX - 3, -_other_rows(0.51), False),
        (_mixed_up(_ACCEL), _mixed_up(_WEAK), True),
        (_mixed_up(_ACCEL), np.where(np.arange(_STEPS) < 0.08 * _STEPS, 0.0, _mixed_up(_WEAK).T).T, True),
        (_mixed_up(_ACCEL), np.where(np.arange(_STEPS) < 0.12 * _STEPS, 0.0, _mixed_up(_WEAK).T).T, False),
        (_mixed_up(_ACCEL), _mixed_up(_ACCEL), False),
        (_mixed_up(_ACCEL), _mixed_up(_WEAK) + 1e-6, False),
    ],
)
def test_rows_go_with_a_simulation_when_they_change_with_it(rows: Array, other: Array, goes: bool) -> None:
    assert collection.follows(rows, _ACCEL, other, _WEAK) == goes


@pytest.mark.parametrize(
    ("time", "story", "off"),
    [
        (_STAMPS, Story(), 0.0),
        (_STAMPS - _DT, Story(), 0.0),
        (_STAMPS + _DT, Story(), _DT),
        (_STAMPS - 2 * _DT, Story(), _DT),
        (_STAMPS + 0.0003, Story(), 0.0003),
        (_STAMPS + _DT, Story(lag=-1), 0.0),
        (_STAMPS + 2 * _DT, Story(lag=-1), _DT),
        (_STAMPS + _DT, Story(lag=1), _DT),
        (_STAMPS + 2 * _DT, Story(lag=-2), 0.0),
        (_STAMPS + _DT, Story(lag=-2), 0.0),
        (_STAMPS + 3 * _DT, Story(lag=-2), _DT),
        (_STAMPS + 5 * _DT, Story(lag=-5), 0.0),
        (_STAMPS[4::5], Story(skip=5), 0.0),
        (_STAMPS[0::5] - _DT, Story(skip=5), 0.0),
        (_STAMPS[0::5], Story(skip=5), 0.0),
        (_STAMPS[4::5] + _DT, Story(skip=5), _DT),
        (_STAMPS[[3, 7, 20]], Story(skip=5, at=(3, 7, 20)), 0.0),
        (_STAMPS[[3, 7]], Story(skip=5, at=(3, 7, 20)), 0.0),
        (_STAMPS[[3, 7, 21]], Story(skip=5, at=(3, 7, 20)), _DT),
        (_STAMPS[[3, 7, 19]], Story(skip=5, at=(3, 7, 20)), _DT),
        (_STAMPS[:0], Story(), 0.0),
    ],
)
def test_stamps_may_begin_with_or_after_the_first_step(time: Array, story: Story, off: float) -> None:
    error = collection.time_error(time, _DT, story)
    assert error.shape == time.shape
    assert np.max(error, initial=0.0) == pytest.approx(off, abs=1e-12)


_THIRDS = np.arange(0, 90, 3)


@pytest.mark.parametrize(
    ("time", "steps"),
    [
        (_DT * (_THIRDS + 1), _THIRDS),
        (_DT * (_THIRDS + 1.3), _THIRDS),
        (_DT * (_THIRDS + 0.7), _THIRDS),
        (_DT * (_THIRDS + 6), _THIRDS + 5),
        (_DT * _THIRDS, ()),
        (_DT * (_THIRDS[::-1] + 1), ()),
        (_DT * (np.where(_THIRDS == 45, 42, _THIRDS) + 1), ()),
        (_DT * (_THIRDS[:19] + 1), ()),
        (_DT * (_THIRDS[:20] + 1), _THIRDS[:20]),
        (_DT * np.where(_THIRDS == 45, np.nan, _THIRDS + 1), ()),
        (_DT * np.where(_THIRDS == 87, 1.1e6, _THIRDS + 1), ()),
        (_STAMPS[:60], ()),
        (_STAMPS[[*range(20), *range(25, 42)]], [*range(20), *range(25, 42)]),
        (_STAMPS[[*range(20), *range(21, 42)]], [*range(20), *range(21, 42)]),
        (_STAMPS[[*range(20), *range(30, 45)]], [*range(20), *range(30, 45)]),
        (None, ()),
    ],
)
def test_stamps_that_leave_steps_out_tell_which(time: Array | None, steps: Array) -> None:
    assert collection._steps_by_stamps(Collection(time, _ACCEL, _GYRO), _WORLDS) == tuple(steps)


def test_of_what_is_missing_at_first_a_row_of_no_numbers_tells_nothing() -> None:
    rows = _taken(slice(7, None))
    assert collection._missing_at_first(rows, _WORLDS, TRUE_WORLD) == 7
    assert collection._missing_at_first(rows.rows(0, 0), _WORLDS, TRUE_WORLD) == 0
    gap = replace(rows, acceleration=np.vstack([_ACCEL[7:8] * [1, np.nan, 1], _ACCEL[8:]]))
    assert collection._missing_at_first(gap, _WORLDS, TRUE_WORLD) == 0


_COURSE = {
    name: float(n) + np.arange(n)
    for n, name in enumerate(("qpos", "qvel", "gravity", "force", "set_at", "set_qvel", "timestep"), 1)
}
_CLAIM = Claim.of(_COURSE)


def test_a_claim_is_what_the_course_says() -> None:
    assert _CLAIM.timestep == 7.0
    for name in ("qpos", "qvel", "gravity", "force", "set_at", "set_qvel"):
        assert getattr(_CLAIM, name) is _COURSE[name]


def test_the_worlds_of_a_scenario_are_its_own_run_and_its_alternatives() -> None:
    arrays = {
        "acceleration": _ACCEL, "angular_velocity": _GYRO, "alt_no_push_acceleration": _WEAK, "alt_no_push_angular_velocity": _SLOW,
        "alt_weights": np.ones(2), "linear_acceleration": _WEAK,
    }  # fmt: skip
    worlds = Worlds.of(Scenario("push", "", None, {"timestep": 0.002, "duration_s": 0.4, "n_steps": 200}, arrays))
    assert (list(worlds.series), worlds.timestep, worlds.duration_s, worlds.steps) == (
        ["truth", "no_push"],
        0.002,
        0.4,
        200,
    )
    assert [id(part) for pair in worlds.series.values() for part in pair] == [*map(id, (_ACCEL, _GYRO, _WEAK, _SLOW))]
    assert worlds.claimed == frozenset()


_SENSED = np.arange(28.0).reshape(2, 14)
_ADDRESS, _PAIRS = np.array([0, 3, 6, 9, 12]), np.array([[0, 1], [3, 2]])


def test_the_worlds_of_a_claim_show_its_sensors_and_those_of_the_other_imus() -> None:
    worlds = collection.with_claim(_WORLDS, _CLAIM, _SENSED, _ADDRESS, _PAIRS, (0, 1))
    assert worlds.claimed == {CLAIMED_WORLD, f"{OTHER_IMU} 0"}
    assert set(worlds.series) == {*_WORLDS.series, *worlds.claimed}
    assert worlds.claim is _CLAIM
    assert [part[1].tolist() for part in worlds.series[CLAIMED_WORLD]] == [[14, 15, 16], [17, 18, 19]]
    assert [part[0].tolist() for part in worlds.series[f"{OTHER_IMU} 0"]] == [[9, 10, 11], [6, 7, 8]]


def test_the_worlds_of_a_claim_show_the_last_sensor_where_it_is_whole_and_the_learnt_ids_where_they_are_others() -> (
    None
):
    worlds = collection.with_claim(_WORLDS, _CLAIM, _SENSED, _ADDRESS[:4], _PAIRS, (2, 3))
    assert worlds.claimed == {CLAIMED_WORLD, f"{OTHER_IMU} 0", LAST_SENSOR, LEARNT_IDS}
    assert [part[0].tolist() for part in worlds.series[LAST_SENSOR]] == [[9, 10, 11], [9, 10, 11]]
    assert [part[0].tolist() for part in worlds.series[LEARNT_IDS]] == [[6, 7, 8], [9, 10, 11]]
    read = collection.with_own_reader(worlds, np.arange(12.0).reshape(2, 6))
    assert read.claimed == worlds.claimed | {OWN_WORLD}
    assert [part[1].tolist() for part in read.series[OWN_WORLD]] == [[6, 7, 8], [9, 10, 11]]


@pytest.mark.parametrize("rows", [_ACCEL, _WEAK + 1])
def test_rows_that_have_no_stamp_are_explained_without_them(rows: Array) -> None:
    stamped = _taken(slice(None), rows, time=_STAMPS[list(_AT)][:30])
    assert collection.explain(stamped, _WORLDS) == collection.explain(replace(stamped, time=None), _WORLDS)
