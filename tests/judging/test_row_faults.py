"""What is wrong with rows, by series of a few rows that are made by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from grader.engine.findings import CheckFailed, Ours
from grader.labs.imu.answers import SENSORS, Array, Collection
from grader.labs.imu.checks import row_faults
from grader.labs.imu.diagnosis.collection import (
    ATOL_ACCELERATION,
    ATOL_RATE,
    CLAIMED_WORLD,
    LAST_SENSOR,
    LEARNT_IDS,
    TRUE_WORLD,
    Story,
    Worlds,
)

pytestmark = pytest.mark.quick
_ACCEL, _GYRO = np.arange(30.0).reshape(10, 3), np.arange(30.0).reshape(10, 3) / 10
_TIME = 0.002 * np.arange(10)
_STEPPED = {"steps": np.array([10.0])}


def _worlds(**series: tuple[Array, Array]) -> Worlds:
    return Worlds({TRUE_WORLD: (_ACCEL, _GYRO), **series}, 0.002, 0.02, 10)


def _series(accel: Array = _ACCEL, gyro: Array = _GYRO, time: Array | None = _TIME) -> Collection:
    return Collection(time, accel, gyro, first_step=_STEPPED)


def _unexplained(series: Collection, worlds: Worlds) -> CheckFailed:
    with pytest.raises(CheckFailed) as lost:
        row_faults.unexplained(series, worlds)
    return lost.value


def test_of_rows_without_a_story_the_sensor_that_is_off_is_told() -> None:
    lost = _unexplained(_series(gyro=_GYRO + np.eye(10, 3)), _worlds())
    assert (lost.keeps, lost.mistakes) == (0.0, ())
    assert lost.expected == "[0.000 0.100 0.200] rad/s in row 0"
    assert lost.got == "[1.000 0.100 0.200] (RMS difference over all rows 0.316 rad/s)"
    lost = _unexplained(_series(accel=_ACCEL - np.eye(10, 3)), _worlds())
    assert (lost.keeps, lost.expected) == (0.0, "[0.000 1.000 2.000] m/s² in row 0")
    assert str(lost.off) == "the rows differ by 0.1 to 1 m/s²"
    lost = _unexplained(_series(_ACCEL - np.eye(10, 3), _GYRO + 1), _worlds())
    assert (lost.keeps, lost.expected) == (0.0, "[0.000 1.000 2.000] m/s² in row 0")


def test_rows_without_a_story_are_held_against_the_run_that_was_claimed() -> None:
    claimed = _worlds(**{CLAIMED_WORLD: (_ACCEL + 1, _GYRO)})
    assert _unexplained(_series(_ACCEL + 1), claimed).got == "10 rows, then nothing"
    assert _unexplained(_series(), claimed).expected == "[1.000 2.000 3.000] m/s² in row 0"


def test_rows_are_right_within_the_tolerance_and_on_it() -> None:
    rows = np.array([[0.0], [0.0], [1.0]]) * np.ones(3)  # the first two are equal, and zeros plus a tolerance are exact
    on_it = _worlds(**{CLAIMED_WORLD: (rows, rows)})
    within, beyond = rows.copy(), rows.copy()
    within[0], beyond[0] = ATOL_ACCELERATION, 1.01 * ATOL_ACCELERATION
    assert _unexplained(_series(within, rows), on_it).got == "3 rows, then nothing"
    assert _unexplained(_series(beyond, rows), on_it).got != "3 rows, then nothing"
    assert _unexplained(_series(rows, beyond / 10 + 0.9 * rows), on_it).got != "3 rows, then nothing"
    within[0] = ATOL_RATE
    assert _unexplained(_series(rows, within), on_it).got == "3 rows, then nothing"


def test_one_row_that_is_right_by_chance_does_not_tell_that_a_sensor_is_right() -> None:
    assert _unexplained(_series(_ACCEL[:1], _GYRO[:1]), _worlds()).got != "1 row, then nothing"


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
        (_series(_ACCEL + np.array([ATOL_ACCELERATION, 0, 0])), True),
        (_series(_ACCEL - 2 * ATOL_ACCELERATION), False),
        (_series(_ACCEL + 2 * ATOL_ACCELERATION), False),
        (_series(time=_TIME + 0.001), False),
        (_series(time=_TIME - 0.001), False),
        (_series(time=2 * _TIME), False),
        (_series(time=np.array([-0.002, 0.002])), False),
        (_series(time=np.zeros(2)), False),
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
    with pytest.raises(CheckFailed) as lost:
        row_faults.shifted(story, _worlds(), series)
    assert (lost.value.keeps, lost.value.mistakes) == (0.5, ("read-before-step",))


@pytest.mark.parametrize(
    ("series", "fits"),
    [
        (_series(time=None), False),
        (_series(time=_TIME[:1]), False),
        (_series(time=_TIME + 0.002), True),
        (_series(time=_TIME[:2] + 0.002), True),
    ],
)
def test_early_rows_may_stand_at_the_times_of_their_states(series: Collection, fits: bool) -> None:
    assert row_faults._at_own_times(Story(lag=-1), _worlds(), series) is fits


@pytest.mark.parametrize("first", [0.002 + 2e-6, 0.002 - 2e-6, 0.0, 0.004])
def test_early_rows_begin_with_the_first_step(first: float) -> None:
    row_faults.shifted(Story(lag=-1), _worlds(), _series(time=_TIME + 0.002))
    with pytest.raises(CheckFailed) as lost:
        row_faults.shifted(Story(lag=-1), _worlds(), _series(time=_TIME + first))
    assert lost.value.got == "every row early by one sample"


_LATE = ("each row read after its step", "every row late by one sample", ("read-before-step",), 0.5, "")
_ZEROS = np.concatenate([np.zeros((1, 3)), _ACCEL[1:]])
_MORE = {"steps": np.array([11.0])}
_START = "Store a row for the first mj_step after the push. Look for a step before the loop, or for rows that are left out (Step 3)."
_LEFT_OUT = ("a row for every step, from the first on", "no row for the first step", (), 0.5, _START)
_LESS = {"steps": np.array([9.0])}


def _found(fault: Callable[[], object]) -> tuple[str, str, tuple[str, ...], float, str]:
    """What is said of expected and got, the mistakes, what is kept, and the beginning of what is left to try."""
    with pytest.raises(CheckFailed) as lost:
        fault()
    said = lost.value
    return said.expected, said.got, said.mistakes, said.keeps, said.hint.partition(":")[0]


@pytest.mark.parametrize(
    ("story", "told"),
    [
        (
            Story(world="another IMU 2"),
            (
                "readings of another IMU of the model",
                (),
                "Pass the accelerometer's and the gyroscope's ids that are given on to get_imu_readings (Step 3).",
            ),
        ),
        (
            Story(world=LEARNT_IDS),
            (
                "readings of other sensors: the ids are those of your own copy of the model",
                ("hard-coded-address",),
                "Look up each id by the sensor's name in the model that is given, with mj_name2id as in Step 2.",
            ),
        ),
        (
            Story(world=LAST_SENSOR),
            (
                "readings of the model's last sensor, which is what the id -1 of an unknown name gives",
                ("sensor-not-found",),
                "",
            ),
        ),
    ],
)
def test_rows_of_other_sensors_are_told_as_whose_they_are(story: Story, told: tuple[str, tuple[str, ...], str]) -> None:
    expected, got, mistakes, keeps, hint = _found(lambda: row_faults.of_other_sensors(story))
    assert (got, mistakes, hint, keeps) == (*told, 0.0)
    assert expected.startswith("readings of the ")


def test_rows_of_the_sensors_that_were_asked_for_are_no_fault() -> None:
    row_faults.of_other_sensors(Story())
    row_faults.shifted(Story(), _worlds(), _series(time=None))


@pytest.mark.parametrize(
    ("lag", "series", "told"),
    [
        (1, _series(time=None), _LATE),
        (2, _series(time=None), _LATE),
        (1, Collection(None, _ACCEL, _GYRO), _LATE),
        (1, Collection(None, _ZEROS, _GYRO, first_step=_STEPPED), _LATE),
        (1, Collection(None, _ACCEL, _GYRO, first_step=_LESS), _LATE),
        (
            1,
            Collection(None, _ZEROS, _GYRO, first_step=_LESS),
            (
                "a row for every step, also for the first",
                "a first row that was never filled: there is one step less than rows",
                ("first-row-empty",), 0.5, "",
            ),
        ),
        (
            -1,
            Collection(None, _ZEROS, _GYRO, first_step=_LESS),
            (
                "each row read after its step", "every row early by one sample", (), 0.5,
                "Read the sensors once after every mj_step, and store this reading and data.time in the same pass of the loop (Step 3).",
            ),
        ),
        (-1, Collection(None, _ACCEL, _GYRO, first_step=_MORE), _LEFT_OUT),
        (-1, Collection(None, _ACCEL[:9], _GYRO[:9], first_step=_STEPPED), _LEFT_OUT),
        (-2, _series(), ("a row for every step, from the first on", "no row for the first 2 steps", (), 0.5, _START)),
    ],
    ids=[
        "late", "later", "no step is known", "a first row of zeros", "a step less", "both", "early", "a step more",
        "a row less", "earlier",
    ],
)  # fmt: skip
def test_rows_that_are_late_or_early_are_told_as_that(
    lag: int, series: Collection, told: tuple[str, str, tuple[str, ...], float, str]
) -> None:
    assert _found(lambda: row_faults.shifted(Story(lag=lag), _worlds(), series)) == told


_RNG = np.random.default_rng(5)
_MOVING, _TURNING = _RNG.normal(0, 5, (40, 3)), _RNG.normal(0, 1, (40, 3))
_MOVED = Worlds({TRUE_WORLD: (_MOVING, _TURNING)}, 0.002, 0.08, 40)
_OTHERS = "; the other sensor is right"
_AS_IT_IS = "Compare your loop with the sheet: one call of mj_step, then one reading, stored unchanged. A reading between mj_step1 and mj_step2 holds old values (Step 3)."
_ODD = _TURNING + 0.1 * np.sin(np.arange(40.0))[:, None]


_BOTH = "Store all three components of both sensors in every pass, in arrays of shape (n_steps, 3) (Step 3)."


@pytest.mark.parametrize("which", [0, 1])
def test_rows_that_cannot_be_made_out_are_told_by_the_sensor(which: int) -> None:
    pair = [None if which == n else rows for n, rows in enumerate((_MOVING, _TURNING))]
    series = Collection(None, *pair).with_gap()
    gone = f"no readings of this sensor under '{SENSORS[which]}'"
    with pytest.raises(CheckFailed) as lost:
        row_faults.altered(Story(altered=(SENSORS[which],)), _MOVED, series)
    said = lost.value
    assert (said.expected, said.got, said.mistakes) == ("rows of both sensors", gone, ())
    assert (said.keeps, said.hint, str(said.off)) == (0.5, _BOTH, gone.replace("none", "no rows"))
    with pytest.raises(CheckFailed) as lost:
        row_faults.unexplained(series, _MOVED)
    said = lost.value
    assert (said.expected, said.keeps, said.hint) == ("the readings of both sensors", 0.0, _BOTH)
    found = (
        f"no readings of this sensor under '{SENSORS[which]}', and other numbers than the truth for the other sensor"
    )
    assert said.got == found


@pytest.mark.parametrize(("both", "keeps"), [(False, 0.0), (True, 0.0)])
def test_one_number_that_is_none_is_told(both: bool, keeps: float) -> None:
    odd = _TURNING.copy()
    odd[7, 1] = np.nan
    series = Collection(None, _MOVING, odd)
    story = Story(altered=SENSORS[::-1] if both else SENSORS[1:])
    told = ("finite numbers", "NaN or infinity under 'angular_velocity'", ("not-finite",), keeps, "")
    assert _found(lambda: row_faults.altered(story, _MOVED, series)) == told
    for rows in ((_MOVING, odd), (odd, _TURNING)):
        told = ("finite numbers", "NaN or infinity in the rows", ("not-finite",), 0.0, "")
        assert _found(lambda rows=rows: row_faults.unexplained(Collection(None, *rows), _MOVED)) == told


@pytest.mark.parametrize(("n", "rows"), [(1, "1 row, then nothing"), (5, "5 rows, then nothing")])
def test_rows_that_end_at_once_are_counted(n: int, rows: str) -> None:
    told = (
        "10 rows",
        rows,
        (),
        0.0,
        "The recording ends too early. Make int(duration_seconds / model.opt.timestep) steps, store a row for each, and return after the loop (Step 3).",
    )
    assert _found(lambda: row_faults.broken_off(n, _worlds())) == told
    with pytest.raises(CheckFailed) as lost:
        row_faults.broken_off(n, _worlds())
    assert str(lost.value.off) == "a few rows from the start, then nothing"


def test_ids_of_the_students_own_model_are_told_in_a_hidden_run_as_well() -> None:
    with pytest.raises(CheckFailed) as lost:
        row_faults.of_other_sensors(Story(LEARNT_IDS))
    assert isinstance(lost.value.hint, Ours)


def test_steps_are_counted_in_whole_numbers_and_the_hint_for_late_rows_is_ours() -> None:
    assert isinstance(row_faults._IN_THE_SAME_PASS, Ours)
    assert type(row_faults._steps(_series())) is int


def test_rows_that_stand_still_are_told_by_whether_a_step_was_made() -> None:
    with pytest.raises(CheckFailed) as stepped:
        row_faults.standing_still(10, _series())
    assert (stepped.value.expected, stepped.value.mistakes) == ("a reading after every step", ())
    assert isinstance(stepped.value.hint, Ours)
    with pytest.raises(CheckFailed) as never:
        row_faults.standing_still(10, Collection(_TIME, _ACCEL, _GYRO))
    assert (never.value.expected, never.value.mistakes) == ("rows of a simulation", ("nothing-simulated",))
    assert never.value.got == stepped.value.got == "10 equal rows, whatever gravity is"
