"""Faults of the rows of a recording, each raised as a finding: by the story that explains them, or without one."""

from __future__ import annotations

from typing import NoReturn

import numpy as np

from grader.engine.findings import CheckFailed, Ours, Size
from grader.labs.imu.answers import SENSOR_UNITS, SENSORS, Collection
from grader.labs.imu.compare import SHEETS_NOISE, deviation, told
from grader.labs.imu.diagnosis import collection as diagnosis
from grader.labs.imu.diagnosis.collection import Story, Worlds

_BOTH = Ours("Store all three components of both sensors in every pass, in arrays of shape (n_steps, 3) (Step 3).")
_FROM_THE_FIRST = Ours(
    "Store a row for the first mj_step after the push. Look for a step before the loop, or for rows that are left out (Step 3)."
)
_IN_THE_SAME_PASS = Ours(
    "Read the sensors once after every mj_step, and store this reading and data.time in the same pass of the loop (Step 3)."
)
_READ_AFTER_STEP = Ours(
    "Compare your loop with the sheet: one call of mj_step, then one reading, stored unchanged. A reading between mj_step1 and "
    "mj_step2 holds old values (Step 3)."
)
_GIVEN_IDS = Ours("Pass the accelerometer's and the gyroscope's ids that are given on to get_imu_readings (Step 3).")
_ENDS_EARLY = Ours(
    "The recording ends too early. Make int(duration_seconds / model.opt.timestep) steps, store a row for each, and return after "
    "the loop (Step 3)."
)
_KINDS = {
    "rounded": "the reading with fewer digits",
    "treated": "the reading scaled, shifted or mixed, such as another unit or sign",
}


def of_other_sensors(story: Story) -> None:
    """Charge rows of sensors whose ids were not given."""
    if story.world.startswith(diagnosis.OTHER_IMU):
        got = "readings of another IMU of the model"
        raise CheckFailed("readings of the IMU whose ids are given", got, hint=_GIVEN_IDS)
    if story.world == diagnosis.LEARNT_IDS:
        raise CheckFailed(
            "readings of the robot's IMU, with ids that are looked up by name in this model",
            "readings of other sensors: the ids are those of your own copy of the model",
            mistakes=["hard-coded-address"],
            hint=Ours("Look up each id by the sensor's name in the model that is given, with mj_name2id as in Step 2."),
        )
    if story.world == diagnosis.LAST_SENSOR:
        got = "readings of the model's last sensor, which is what the id -1 of an unknown name gives"
        raise CheckFailed("readings of the IMU whose ids are given", got, mistakes=["sensor-not-found"])


def shifted(story: Story, worlds: Worlds, series: Collection) -> None:
    """Charge rows that are late or early, but for those that stand at the times of their states."""
    if story.lag < -1:
        _begins_late(-story.lag)
    if story.lag == 0 or _at_own_times(story, worlds, series):
        return
    if _leaves_first_out(story, series):
        _begins_late(1)
    _by_one(story, series)


def _leaves_first_out(story: Story, series: Collection) -> bool:
    """Return whether rows are early by one because one step has no row, not because they were read after a later step."""
    assert series.acceleration is not None
    return story.lag == -1 and _steps(series) > len(series.acceleration)


def _steps(series: Collection) -> int:
    return int(series.first_step.get("steps", np.zeros(1))[0])


def _begins_late(steps: int) -> NoReturn:
    got = f"no row for the first {f'{steps} steps' if steps > 1 else 'step'}"
    off = Size("no row for the first steps")
    raise CheckFailed("a row for every step, from the first on", got, keeps=0.5, hint=_FROM_THE_FIRST, off=off)


def _by_one(story: Story, series: Collection) -> NoReturn:
    """A first row of zeros is one that was never filled if a step less was made."""
    assert series.acceleration is not None
    if story.lag > 0 and _steps(series) == len(series.acceleration) - 1 and not series.acceleration[0].any():
        got = "a first row that was never filled: there is one step less than rows"
        raise CheckFailed("a row for every step, also for the first", got, mistakes=["first-row-empty"], keeps=0.5)
    late, mistakes = ("late", ["read-before-step"]) if story.lag > 0 else ("early", [])
    got = f"every row {late} by one sample"
    hint = "" if mistakes else _IN_THE_SAME_PASS
    raise CheckFailed("each row read after its step", got, mistakes=mistakes, keeps=0.5, hint=hint)


def _at_own_times(story: Story, worlds: Worlds, series: Collection) -> bool:
    """Return whether each row has the time of its state: rows start before the first step, or follow mj_forward."""
    if series.time is None or series.acceleration is None or len(series.time) < 2:
        return False
    if story.lag == -1:
        return bool(abs(series.time[0] - worlds.timestep) < diagnosis.TIME_ATOL)
    first = worlds.series[story.world][0][0]
    at_once = np.abs(series.acceleration[0] - first).max() <= diagnosis.ATOL_ACCELERATION
    starts, second = abs(series.time[0]), abs(series.time[1] - worlds.timestep)
    return bool(at_once and starts < diagnosis.TIME_ATOL and second < diagnosis.TIME_ATOL)


def altered(story: Story, worlds: Worlds, series: Collection) -> NoReturn:
    """The run is right, and the rows of one sensor or both are others: called altered if one treatment predicts all of them."""
    key = story.altered[0]
    which = SENSORS.index(key)
    got, true, unit = series.sensors[which], worlds.series[story.world][which], SENSOR_UNITS[which]
    assert got is not None
    if key == series.absent:
        gone = f"no readings of this sensor under {key!r}"
        off = Size(f"no readings of this sensor under {key!r}")
        raise CheckFailed("rows of both sensors", gone, keeps=0.5, hint=_BOTH, off=off)
    alone = len(story.altered) == 1
    keeps, others = 0.5 if _is_near(story, worlds, series) else 0.0, "; the other sensor is right" if alone else ""
    if not np.isfinite(got).all():
        raise CheckFailed("finite numbers", f"NaN or infinity under {key!r}", mistakes=["not-finite"], keeps=keeps)
    gap = deviation(got, true)
    treatment = diagnosis.treatment(key, got, true)
    kind = _KINDS.get(treatment or "", "")
    beside = "the other sensor is right; " if alone else ""
    raise CheckFailed(
        f"{told(true[gap.row], got[gap.row])} {unit} under {key!r} in row {gap.row}",
        f"{told(got[gap.row], true[gap.row])}{kind and ': '}{kind}{others}",
        mistakes=["rows-altered"] if treatment else [],
        keeps=keeps,
        off=Size(f"{beside}{kind or 'rows'} under {key!r}, off", gap.rms, unit),
        hint="" if treatment else _READ_AFTER_STEP,
    )


def _is_near(story: Story, worlds: Worlds, series: Collection) -> bool:
    """Return whether both sensors' rows are off by less than a real sensor's noise."""
    both = zip(series.sensors, worlds.series[story.world], SHEETS_NOISE, strict=True)
    return all(rows is not None and deviation(rows, true).worst <= little for rows, true, little in both)


def broken_off(n: int, worlds: Worlds) -> NoReturn:
    """The first rows are right, and the others are not there."""
    rows = f"{n} row{'s' * (n != 1)}, then nothing"
    raise CheckFailed(
        f"{worlds.steps} rows", rows, hint=_ENDS_EARLY, off=Size("a few rows from the start, then nothing")
    )


def standing_still(n: int, series: Collection) -> NoReturn:
    """Raise the finding for rows that are all equal: no step was simulated, or no reading follows a step."""
    got, stepped = f"{n} equal rows, whatever gravity is", bool(series.first_step)
    raise CheckFailed(
        "a reading after every step" if stepped else "rows of a simulation",
        got,
        mistakes=[] if stepped else ["nothing-simulated"],
        hint=Ours("Read the sensors in every pass of the loop, after mj_step (Step 3).") if stepped else "",
    )


def unexplained(series: Collection, worlds: Worlds) -> NoReturn:
    """Rows that no story predicts: told by the sensor that is off, and by the row where it is furthest off."""
    if series.absent:
        found = (
            f"no readings of this sensor under {series.absent!r}, and other numbers than the truth for the other sensor"
        )
        raise CheckFailed("the readings of both sensors", found, hint=_BOTH)
    accel, gyro = worlds.series.get(diagnosis.CLAIMED_WORLD, worlds.series[diagnosis.TRUE_WORLD])
    assert series.acceleration is not None
    assert series.angular_velocity is not None
    n = min(len(series.acceleration), len(accel))
    if not (np.isfinite(series.acceleration).all() and np.isfinite(series.angular_velocity).all()):
        raise CheckFailed("finite numbers", "NaN or infinity in the rows", mistakes=["not-finite"])
    in_accel, in_gyro = deviation(series.acceleration, accel), deviation(series.angular_velocity[:n], gyro)
    in_these = slice(n)
    right = (
        in_accel.worst <= diagnosis.ATOL_ACCELERATION and diagnosis.moves(accel, diagnosis.ATOL_ACCELERATION, in_these),
        in_gyro.worst <= diagnosis.ATOL_RATE and diagnosis.moves(gyro, diagnosis.ATOL_RATE, in_these),
    )
    if all(right):
        broken_off(n, worlds)
    got, true, at, unit = (
        (series.angular_velocity, gyro, in_gyro, SENSOR_UNITS[1])
        if right[0]
        else (series.acceleration, accel, in_accel, SENSOR_UNITS[0])
    )
    nothing = [] if series.first_step else ["nothing-simulated"]
    raise CheckFailed(
        f"{told(true[at.row], got[at.row])} {unit} in row {at.row}",
        f"{told(got[at.row], true[at.row])} (RMS difference over all rows {at.rms:.3g} {unit})",
        off=Size("the rows differ", at.rms, unit),
        mistakes=nothing,
        hint=""
        if nothing
        else Ours("In each pass of the loop call mj_step once, read once, and store the reading unchanged (Step 3)."),
    )
