"""What is wrong with rows, by series of a few rows that are made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from grader.engine.findings import Lost
from grader.labs.imu.answers import Array, Collection
from grader.labs.imu.checks import row_faults
from grader.labs.imu.diagnosis.collection import ATOL_ACCELERATION, CLAIMED_WORLD, TRUE_WORLD, Story, Worlds

pytestmark = pytest.mark.quick
_ACCEL, _GYRO = np.arange(30.0).reshape(10, 3), np.arange(30.0).reshape(10, 3) / 10
_TIME = 0.002 * np.arange(10)
_STEPPED = {"steps": np.array([10.0])}


def _worlds(**series: tuple[Array, Array]) -> Worlds:
    return Worlds({TRUE_WORLD: (_ACCEL, _GYRO), **series}, 0.002, 0.02, 10)


def _series(accel: Array = _ACCEL, gyro: Array = _GYRO, time: Array | None = _TIME) -> Collection:
    return Collection(time, accel, gyro, first_step=_STEPPED)


def _unexplained(series: Collection, worlds: Worlds) -> Lost:
    with pytest.raises(Lost) as lost:
        row_faults.unexplained(series, worlds)
    return lost.value


def test_of_rows_without_a_story_the_sensor_that_is_off_is_told() -> None:
    lost = _unexplained(_series(gyro=_GYRO + np.eye(10, 3)), _worlds())
    assert (lost.keeps, lost.mistakes) == (0.5, ())
    assert lost.expected == "[0.000 0.100 0.200] rad/s in row 0"
    assert lost.got == "[1.000 0.100 0.200] (RMS difference over the series 0.316 rad/s)"
    lost = _unexplained(_series(accel=_ACCEL - np.eye(10, 3)), _worlds())
    assert (lost.keeps, lost.expected) == (0.5, "[0.000 1.000 2.000] m/s² in row 0")
    assert str(lost.off) == "the rows differ over the series by 0.1 to 1 m/s²"
    lost = _unexplained(_series(_ACCEL - np.eye(10, 3), _GYRO + 1), _worlds())
    assert (lost.keeps, lost.expected) == (0.0, "[0.000 1.000 2.000] m/s² in row 0")


def test_rows_without_a_story_are_held_against_the_run_that_was_claimed() -> None:
    claimed = _worlds(**{CLAIMED_WORLD: (_ACCEL + 1, _GYRO)})
    assert _unexplained(_series(_ACCEL + 1), claimed).got == "10 rows, then nothing"
    assert _unexplained(_series(), claimed).expected == "[1.000 2.000 3.000] m/s² in row 0"


def test_rows_are_right_within_the_tolerance_and_on_it() -> None:
    on_it = _worlds(**{CLAIMED_WORLD: (np.zeros((3, 3)), np.zeros((3, 3)))})
    rates = np.zeros((3, 3))
    assert _unexplained(_series(rates + ATOL_ACCELERATION, rates), on_it).got == "3 rows, then nothing"
    assert _unexplained(_series(rates + 1.01 * ATOL_ACCELERATION, rates), on_it).keeps == 0.5
    assert _unexplained(_series(rates, rates + 1.01e-1 * ATOL_ACCELERATION), on_it).keeps == 0.5
    assert _unexplained(_series(rates, rates + 1e-1 * ATOL_ACCELERATION), on_it).got == "3 rows, then nothing"


def test_of_sensors_with_rows_in_other_numbers_those_that_both_have_are_compared() -> None:
    longer = np.concatenate([_GYRO, _GYRO])
    longer[5:] += 1
    assert _unexplained(_series(_ACCEL[:5], longer), _worlds()).got == "5 rows, then nothing"


def test_rows_without_a_step_are_of_no_simulation() -> None:
    series = Collection(_TIME, _ACCEL + 1, _GYRO + 1)
    lost = _unexplained(series, _worlds())
    assert (lost.mistakes, lost.hint) == (("nothing-simulated",), "")


@pytest.mark.parametrize(
    ("series", "fits"),
    [
        (_series(), True),
        (_series(_ACCEL + 0.9 * ATOL_ACCELERATION), True),
        (_series(_ACCEL - 2 * ATOL_ACCELERATION), False),
        (_series(_ACCEL + 2 * ATOL_ACCELERATION), False),
        (_series(time=_TIME + 0.001), False),
        (_series(time=_TIME - 0.001), False),
        (_series(time=2 * _TIME), False),
        (_series(time=_TIME[:1]), False),
        (_series(time=_TIME[:2]), True),
        (_series(time=None), False),
    ],
)
def test_late_rows_may_stand_at_the_times_of_their_states(series: Collection, fits: bool) -> None:
    story = Story(lag=1)
    if fits:
        row_faults.shifted(story, _worlds(), series)
        return
    with pytest.raises(Lost) as lost:
        row_faults.shifted(story, _worlds(), series)
    assert (lost.value.keeps, lost.value.mistakes) == (0.5, ("read-before-step",))


@pytest.mark.parametrize("first", [0.002 + 2e-6, 0.002 - 2e-6, 0.0, 0.004])
def test_early_rows_begin_with_the_first_step(first: float) -> None:
    row_faults.shifted(Story(lag=-1), _worlds(), _series(time=_TIME + 0.002))
    with pytest.raises(Lost) as lost:
        row_faults.shifted(Story(lag=-1), _worlds(), _series(time=_TIME + first))
    assert lost.value.got == "every row early by one sample"
