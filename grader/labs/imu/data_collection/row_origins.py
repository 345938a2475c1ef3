"""Hypotheses on the origin of the rows of a recording: what the simulation did, and how its samples became rows.

A simulated run (the *world*: the true one, or one from the start that the worker reports) explains a recording together with what
became of its samples: late by one, several steps a row, references to one array, channels exchanged, numbers altered.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grader.engine import hypothesis
from grader.labs.imu.collection import SENSORS
from grader.labs.imu.compare import Array, same
from grader.labs.imu.data_collection.measure import (
    ATOL_ACCELERATION,
    ATOL_RATE,
    CLAIMED_WORLD,
    FEWEST_ROWS,
    LAST_SENSOR,
    LEARNT_IDS,
    OTHER_IMU,
    TRUE_WORLD,
    Run,
)

Rows = slice | NDArray[np.intp]
"""Indices of rows: a slice if they are equally far apart, otherwise an array."""


@dataclass(frozen=True)
class RowOrigin:
    """Guess at which readings a student's `simulate_and_collect` stored as its rows; without arguments, the right ones.

    Attributes
    ----------
    world : name of the simulation (a key of `Run.worlds`) that the rows come from
    lag : number of samples by which rows are late; negative if the first samples are missing
    skip : number of time steps per row; first : which of the `skip` steps of a row is stored, counted from 0
    exchanged : whether acceleration and angular velocity are in each other's place
    aliased : whether all rows are references to one array, so that each shows the last reading
    at : for rows that are not equally far apart, the step, counted from 0, after which each was stored; else empty
    altered : keys of the sensors whose numbers the code changed: one sensor in any way, or both, each rounded or mapped linearly
    """

    world: str = TRUE_WORLD
    lag: int = 0
    skip: int = 1
    first: int = 0
    exchanged: bool = False
    aliased: bool = False
    at: tuple[int, ...] = ()
    altered: tuple[str, ...] = ()

    @property
    def of_other_sensors(self) -> bool:
        """Return whether wrong sensors, or the right ones in the wrong order, were read: a fault of `get_imu_readings`."""
        return self.exchanged or self.world in (LAST_SENSOR, LEARNT_IDS) or self.world.startswith(OTHER_IMU)

    def covers(self, rows: int, steps: int) -> bool:
        """Return whether the last of `rows` rows was stored within `skip` steps of the end of a simulation of `steps` steps."""
        reached = self.at[-1] + 1 if self.at else rows * self.skip
        return abs(reached - steps) <= self.skip

    def fits(self, run: Run) -> bool:
        """Return whether this origin predicts a recording's rows; False if too few rows can be compared.

        Rows of zeros at the end count as never filled and are left out, unless `altered` is set: code may have made these zeros.
        """
        accel, gyro = run.series.sensors
        if accel is None or gyro is None or self.world not in run.worlds:
            return False
        if self.exchanged:
            accel, gyro = gyro, accel
        true_accel, true_gyro = run.worlds[self.world]
        filled, there = run.series.filled_rows, min(len(accel), len(gyro))
        rows, wanted = _rows(self, there if self.altered else filled, len(true_accel))
        every = filled if self.lag == 0 else FEWEST_ROWS  # a few rows cannot distinguish late from early
        if len(accel[rows]) < min(FEWEST_ROWS, max(1, run.model_steps // (2 * self.skip)), max(1, every)):
            return False
        if self.altered == SENSORS:
            pairs = ((accel[rows], true_accel[wanted]), (gyro[rows], true_gyro[wanted]))
            return all(treatment(key, *pair) is not None for key, pair in zip(SENSORS, pairs, strict=True))
        if same(accel[rows], true_accel[wanted], ATOL_ACCELERATION) == (SENSORS[0] in self.altered):
            return False
        if same(gyro[rows], true_gyro[wanted], ATOL_RATE) == (SENSORS[1] in self.altered):
            return False
        if self.altered and not moves(
            *((true_gyro, ATOL_RATE) if SENSORS[0] in self.altered else (true_accel, ATOL_ACCELERATION)), wanted
        ):
            return False
        # If the robot does not move in these rows, any number of steps per row would predict them.
        return self.skip == 1 or not same(true_accel[rows], true_accel[wanted], ATOL_ACCELERATION)

    @property
    def cause(self) -> tuple[object, ...]:
        return (self.world, self.lag != 0, self.skip != 1, self.exchanged, self.aliased, self.altered)

    @property
    def cost(self) -> int:
        odd = (self.world != TRUE_WORLD, self.lag != 0, self.skip != 1, self.exchanged, self.aliased)
        return sum(odd) + len(odd) * len(self.altered)


def _rows(origin: RowOrigin, n: int, available: int) -> tuple[Rows, Rows]:
    """Return the indices of the student's rows and of the true rows to compare: slices if the rows are equally far apart."""
    if not origin.aliased and not origin.at:  # row n is that of step n * skip + late; both bounds are rounded up
        late, skip = origin.first - origin.lag, origin.skip
        begin = max(0, -(late // skip))
        end = max(begin, min(n, -((late - available) // skip)))
        return slice(begin, end), slice(begin * skip + late, end * skip + late, skip)
    wanted = np.array(origin.at[:n], np.intp) if origin.at else np.full(n, n - 1)
    known = (wanted >= 0) & (wanted < available)
    return np.flatnonzero(known), wanted[known]


def moves(true: Array, atol: float, rows: Rows) -> bool:
    """Return whether `true` values vary by more than `atol` in `rows` (a slice or indices); if not, equal numbers prove nothing."""
    return bool(np.ptp(true[rows], axis=0).max() > atol) if len(true[rows]) else False


def explain(run: Run) -> RowOrigin | None:
    """Return the origin with fewest faults that predicts the run's rows; None if none does, or if such origins differ in fault."""
    return hypothesis.first_that_fits(_by_cost(run), run)


def _by_cost(run: Run) -> Iterator[Iterable[RowOrigin]]:
    """Yield the possible origins in groups of equal cost. The first, the unaltered true run, fits most recordings at once."""
    if TRUE_WORLD in run.worlds:
        yield [RowOrigin()]
    yield from hypothesis.by_cost(_origins(run))


def explain_altered(run: Run) -> RowOrigin | None:
    """Return the origin of rows that code altered: one sensor's in any way, or both by rounding or a linear map; else None."""
    known = [RowOrigin(world) for world in (TRUE_WORLD, CLAIMED_WORLD) if world in run.worlds]
    changed = ((SENSORS[0],), (SENSORS[1],), SENSORS)
    return hypothesis.explain((replace(origin, altered=keys) for keys in changed for origin in known), run)


def _origins(run: Run) -> Iterator[RowOrigin]:
    strides, at = sorted(_strides(run)), _steps_by_stamps(run)
    apart = max(2, round((at[-1] - at[0]) / (len(at) - 1))) if at else 1
    for world in run.worlds:
        lags = {0, 1, -1, -_missing_at_first(run, world)}
        for exchanged in (False, True):
            yield from (RowOrigin(world, lag, exchanged=exchanged) for lag in lags)
            for skip in strides:
                yield from (RowOrigin(world, skip=skip, first=first, exchanged=exchanged) for first in {0, skip - 1})
                yield RowOrigin(world, lag=1, skip=skip, exchanged=exchanged)  # read before the first of them
            if at and len(at) >= run.series.filled_rows:
                yield RowOrigin(world, skip=apart, at=at, exchanged=exchanged)
            yield RowOrigin(world, exchanged=exchanged, aliased=True)


def _strides(run: Run) -> set[int]:
    """Return likely numbers of steps per row to try: from the stamps, from the number of rows, and round numbers."""
    n, steps, time = run.series.filled_rows, run.model_steps, run.series.time
    likely = {2, 3, 4, 5, 10, 20, 50, 100, *((round(steps / n), -(-steps // n)) if n else ())}
    if time is not None and len(time) > 1:
        apart = float(np.median(np.diff(time))) / run.model_timestep
        likely.add(round(apart) if np.isfinite(apart) and apart < steps else 1)
    return {stride for stride in likely if stride > 1}


def _steps_by_stamps(run: Run) -> tuple[int, ...]:
    """Return the step after which each row was stored, by its time stamp, to try as an origin; () if no step is left out."""
    time = run.series.time
    if time is None or len(time) < FEWEST_ROWS:
        return ()
    steps = np.round(time / run.model_timestep) - 1
    apart = np.diff(steps)
    thinned = steps[0] >= 0 and apart.min() >= 1 and steps[-1] < 1e6 and apart.max() > 1
    return tuple(int(step) for step in steps) if thinned else ()


def _missing_at_first(run: Run, world: str) -> int:
    """Return how many first samples of a world have no row, as far as the first row tells by the sample nearest to it; else 0."""
    accel = run.series.acceleration
    if accel is None or not len(accel):
        return 0
    return int(np.argmin(np.abs(run.worlds[world][0] - accel[0]).max(axis=1)))


# ---- what was done to the numbers


def treatment(key: str, got: Array, true: Array) -> str | None:
    """Return how the rows `got` differ from a sensor's `true` rows: "rounded" (or equal), "treated" (a linear map), else None.

    `key` names the sensor, "acceleration" or "angular_velocity", and so the tolerance.
    """
    n, atol = min(len(got), len(true)), ATOL_ACCELERATION if key == SENSORS[0] else ATOL_RATE
    got, true = got[:n], true[:n]
    coarse = (*(true.round(decimals) for decimals in range(5)), np.trunc(true), true.astype(np.float16).astype(float))
    if any(same(got, each, atol) for each in coarse):
        return "rounded"
    if np.ptp(got, axis=0).max(initial=0.0) <= atol:  # constant rows are predicted by any offset
        return None
    fit = affine(got, true)
    return "treated" if fit is not None and same(got, true @ fit[:3] + fit[3], atol) else None


def affine(got: Array, true: Array) -> Array | None:
    """Return the least-squares map (4, 3) from true to recorded rows, offset last; None for few, constant or infinite rows."""
    if len(got) < FEWEST_ROWS or not np.isfinite(got).all() or not np.ptp(got, axis=0).any():
        return None
    return np.asarray(np.linalg.lstsq(np.column_stack([true, np.ones(len(true))]), got, rcond=None)[0], np.float64)


def time_error(time: Array, timestep: float, origin: RowOrigin) -> Array:
    """Return the error (n,), in seconds, of each time stamp against the right series of stamps.

    The first stamp may be 0, the time after any of the steps of the first row, or a later one if the first samples are missing; the
    nearest counts. If rows are not equally far apart (`origin.at`), each row's right stamp is the time after its step.
    """
    if origin.at:
        return np.abs(time - timestep * (np.array(origin.at) + 1.0)[: len(time)])
    stamps = timestep * origin.skip * np.arange(len(time))
    starts = {*range(origin.skip + 1), *((-origin.lag, 1 - origin.lag) if origin.lag < 0 else ())}
    errors = [np.abs(time - stamps - timestep * first) for first in sorted(starts)]
    return min(errors, key=lambda error: float(np.max(error, initial=0.0)))
