"""Explanation of a wrong time series: the run, the choice of rows and the order of columns that predict it.

A recorded series is explained by what the simulation did (the *world*: pushed, not pushed, not reset, …) and by how its
samples became rows (late by one, several steps a row, references to one array, rows left empty, channels exchanged).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grader.engine import hypothesis
from grader.engine.traces import Scenario

from ..answers import SENSORS, Collection
from ..compare import Array, same

ATOL_ACCELERATION = 2e-3
ATOL_RATE = 2e-4
"""m/s², rad/s. The same steps on the same machine repeat to 1e-9; an extra mj_forward before the first step or the use of
mj_step1/mj_step2 stays below 1e-6. A lag of one sample after the push moves the series by more than 0.01 m/s²."""
TIME_ATOL = 1e-6
"""s. Adding a time step 5,000 times errs by 1e-12 s, and single precision by 1e-7 s at 3 s."""
FEWEST_ROWS = 20
"""That a story has to predict, unless fewer are all that there is."""
Rows = slice | NDArray[np.intp]
"""Of a series: equally far apart, or one by one."""

TRUE_WORLD = "truth"
CLAIMED_WORLD = "claimed"
OWN_WORLD = "as the own reader reads it"
LAST_SENSOR = "the model's last sensor"
OTHER_IMU = "another IMU"
LEARNT_IDS = "the sensors whose ids are the torso's in the students' model"


@dataclass(frozen=True)
class Claim:
    """Start of a run as the worker reports it. It counts only if a simulation from there gives the same rows.

    Attributes
    ----------
    qpos, qvel : the state before the first step; gravity : (3,); timestep : seconds
    force : what was applied to the joints and bodies then
    set_at : (m,) before which later steps the state was set from outside once more; set_qvel : (m, nv) to which velocities
    """

    qpos: Array
    qvel: Array
    gravity: Array
    timestep: float
    force: Array
    set_at: Array
    set_qvel: Array

    @classmethod
    def of(cls, course: Mapping[str, Array]) -> Claim:
        names = ("qpos", "qvel", "gravity", "force", "set_at", "set_qvel")
        return cls(timestep=float(course["timestep"][0]), **{name: course[name] for name in names})


@dataclass(frozen=True)
class Worlds:
    """Sensor values in each simulated run, called world: name -> (acceleration, angular velocity), each (rows, 3).

    Those that rest on a `claim` are named in `claimed`; the others are of the traces.
    """

    series: Mapping[str, tuple[Array, Array]]
    timestep: float
    duration_s: float
    steps: int
    claim: Claim | None = None
    claimed: frozenset[str] = frozenset()

    @classmethod
    def of(cls, scenario: Scenario) -> Worlds:
        series = {TRUE_WORLD: (scenario["acceleration"], scenario["angular_velocity"])}
        for key in scenario.arrays:
            if key.startswith("alt_") and key.endswith("_acceleration"):
                name = key[len("alt_") : -len("_acceleration")]
                series[name] = (scenario[key], scenario[f"alt_{name}_angular_velocity"])
        scalars = scenario.scalars
        return cls(series, float(scalars["timestep"]), float(scalars["duration_s"]), int(scalars["n_steps"]))


def with_claim(
    worlds: Worlds, claim: Claim, run: Array, address: np.ndarray, pairs: np.ndarray, learnt: tuple[int, int]
) -> Worlds:
    """The same worlds and those that go as claimed.

    Parameters
    ----------
    run : (rows, n) ndarray, all sensors of a simulation that goes as claimed
    learnt : ids of the right ones in the students' model
    address : first index of each sensor; pairs : ids of every accelerometer and its gyroscope, the right ones first

    Returns
    -------
    Worlds
        With the claimed run's right sensors, its last one as ``id = -1`` reads it, those that have the ids of the students' model
        where they are others, and those of the other IMUs.
    """

    def at(first: int) -> Array:
        out = np.full((len(run), 3), np.nan)
        part = run[:, first : first + 3]
        out[:, : part.shape[1]] = part
        return out

    (first, second), *others = np.asarray(address)[pairs].tolist()
    series = {CLAIMED_WORLD: (at(first), at(second))}
    series |= {f"{OTHER_IMU} {number}": (at(accel), at(gyro)) for number, (accel, gyro) in enumerate(others)}
    if tuple(pairs[0]) != learnt:
        series[LEARNT_IDS] = (at(int(address[learnt[0]])), at(int(address[learnt[1]])))
    if np.isfinite(last := at(int(address[-1]))).all():
        series[LAST_SENSOR] = (last, last)
    return replace(worlds, series={**worlds.series, **series}, claim=claim, claimed=frozenset(series))


def with_own_reader(worlds: Worlds, rows: Array) -> Worlds:
    """The same worlds and what the submission's own reader (rows, 6) reads in the run that was claimed."""
    series = {**worlds.series, OWN_WORLD: (rows[:, :3], rows[:, 3:])}
    return replace(worlds, series=series, claimed=worlds.claimed | {OWN_WORLD})


@dataclass(frozen=True)
class Story:
    """Explanation of the rows: world, rows late by `lag` samples, `skip` steps a row, channels exchanged, rows aliased.

    With several steps a row, `first` tells after which of them a row is stored, from 0 on; where the rows are not equally far
    apart, `at` tells of which step each of them is. `altered` are the sensors whose numbers are others: of one, where the rows
    of the other sensor tell the story alone; of both, where one treatment predicts all rows of each.
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
    def of_claim(self) -> bool:
        """Return whether the run went as it was claimed, as the claim alone tells."""
        return self.world in (CLAIMED_WORLD, OWN_WORLD)

    @property
    def of_other_sensors(self) -> bool:
        """Return whether other sensors than the right ones were read, or in the other order: that may be the reader's doing."""
        return self.exchanged or self.world in (LAST_SENSOR, LEARNT_IDS) or self.world.startswith(OTHER_IMU)

    def covers(self, rows: int, steps: int) -> bool:
        """Return whether so many rows of such a story reach through the whole run."""
        reached = self.at[-1] + 1 if self.at else rows * self.skip
        return abs(reached - steps) <= self.skip

    def fits(self, seen: tuple[Collection, Worlds]) -> bool:
        """Return whether it predicts every filled row that the truth reaches."""
        series, worlds = seen
        if series.acceleration is None or series.angular_velocity is None:
            return False
        accel, gyro = series.acceleration, series.angular_velocity
        if self.exchanged:
            accel, gyro = gyro, accel
        true_accel, true_gyro = worlds.series[self.world]
        there = min(len(accel), len(gyro))
        rows, wanted = _rows(self, there if self.altered else series.filled_rows, len(true_accel))
        every = series.filled_rows if self.lag == 0 else FEWEST_ROWS  # a few rows do not tell late from early
        if len(accel[rows]) < min(FEWEST_ROWS, max(1, worlds.steps // (2 * self.skip)), max(1, every)):
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
        # Where nothing moves in these rows, they would come of any number of steps.
        return self.skip == 1 or not same(true_accel[rows], true_accel[wanted], ATOL_ACCELERATION)

    @property
    def told(self) -> tuple[object, ...]:
        return (self.world, self.lag != 0, self.skip != 1, self.exchanged, self.aliased, self.altered)

    @property
    def cost(self) -> int:
        odd = (self.world != TRUE_WORLD, self.lag != 0, self.skip != 1, self.exchanged, self.aliased)
        return sum(odd) + len(odd) * len(self.altered)


def moves(true: Array, atol: float, rows: Rows) -> bool:
    """Return whether a sensor shows motion in these rows: right numbers in one row, or at rest, do not tell which run it is."""
    return bool(np.ptp(true[rows], axis=0).max() > atol) if len(true[rows]) else False


def rows_left(series: Collection, before: Collection | None = None) -> int:
    """Return the number of first rows that are left from earlier runs because a list outlives the call.

    Parameters
    ----------
    before
        What the same process returned before. None for the first run that was asked for: what the submission has recorded
        by itself begins with the same rows.
    """
    if series.time is None or series.acceleration is None or series.angular_velocity is None:
        return 0
    n = min(len(series.time), len(series.acceleration), len(series.angular_velocity))
    if before is not None:
        kept = len(before.time) if before.time is not None else 0
        return kept if 0 < kept < n and _alike(series, before, slice(kept), slice(kept)) else 0
    starts = np.flatnonzero(series.time[:n] == series.time[0])
    second, last = (int(starts[1]), int(starts[-1])) if len(starts) > 1 else (0, 0)
    shared = min(second, n - last)
    return last if shared >= FEWEST_ROWS and _alike(series, series, slice(shared), slice(last, last + shared)) else 0


def _alike(series: Collection, other: Collection, rows: slice, others: slice) -> bool:
    """Return whether the same motion stands there; rows in which nothing moves are like any others, and tell nothing."""
    pairs = ((series.acceleration, other.acceleration), (series.angular_velocity, other.angular_velocity))
    same_rows = all(
        a is not None and b is not None and np.array_equal(a[rows], b[others], equal_nan=True) for a, b in pairs
    )
    return same_rows and any(a is not None and bool(np.ptp(a[rows], axis=0).any()) for a, _ in pairs)


def explain(series: Collection, worlds: Worlds) -> Story | None:
    """The simplest story that predicts the rows, or None where none does or two equally simple ones do."""
    return hypothesis.first_that_fits(_by_cost(series, worlds), (series, worlds))


def _by_cost(series: Collection, worlds: Worlds) -> Iterator[Iterable[Story]]:
    """Alone costs nothing that the run went as it should: nearly all did."""
    if TRUE_WORLD in worlds.series:
        yield [Story()]
    yield from hypothesis.by_cost(_stories(series, worlds))


def explain_altered(series: Collection, worlds: Worlds) -> Story | None:
    """The run whose rows were altered after they were read: of one sensor anyhow, or of both in a way that predicts all of them."""
    known = [Story(world) for world in (TRUE_WORLD, CLAIMED_WORLD) if world in worlds.series]
    one = (replace(story, altered=(key,)) for story in known for key in SENSORS)
    both = (replace(story, altered=SENSORS) for story in known)
    return hypothesis.explain((*one, *both), (series, worlds))


def _stories(series: Collection, worlds: Worlds) -> Iterator[Story]:
    strides, at = sorted(_strides(series, worlds)), _steps_by_stamps(series, worlds)
    apart = max(2, round((at[-1] - at[0]) / (len(at) - 1))) if at else 1
    for world in worlds.series:
        lags = {0, 1, -1, -_missing_at_first(series, worlds, world)}
        for exchanged in (False, True):
            yield from (Story(world, lag, exchanged=exchanged) for lag in lags)
            for skip in strides:
                yield from (Story(world, skip=skip, first=first, exchanged=exchanged) for first in {0, skip - 1})
            if at and len(at) >= series.filled_rows:
                yield Story(world, skip=apart, at=at, exchanged=exchanged)
            yield Story(world, exchanged=exchanged, aliased=True)


def _strides(series: Collection, worlds: Worlds) -> set[int]:
    """Return the likely numbers of steps between two rows: by the stamps, by the number of rows, or round numbers."""
    n = series.filled_rows
    likely = {2, 3, 4, 5, 10, 20, 50, 100, *((round(worlds.steps / n), -(-worlds.steps // n)) if n else ())}
    if series.time is not None and len(series.time) > 1:
        apart = float(np.median(np.diff(series.time))) / worlds.timestep
        likely.add(round(apart) if np.isfinite(apart) and apart < worlds.steps else 1)
    return {stride for stride in likely if stride > 1}


def _steps_by_stamps(series: Collection, worlds: Worlds) -> tuple[int, ...]:
    """After which step each row was stored if its stamp is right; nothing where no step is left out."""
    if series.time is None or len(series.time) < FEWEST_ROWS:
        return ()
    steps = np.round(series.time / worlds.timestep) - 1
    apart = np.diff(steps)
    thinned = steps[0] >= 0 and apart.min() >= 1 and steps[-1] < 1e6 and apart.max() > 1
    return tuple(int(step) for step in steps) if thinned else ()


def _missing_at_first(series: Collection, worlds: Worlds, world: str) -> int:
    """Return the number of samples of a world before the first row: the index of the sample that is nearest to it."""
    assert series.acceleration is not None
    if not len(series.acceleration):
        return 0
    return int(np.argmin(np.abs(worlds.series[world][0] - series.acceleration[0]).max(axis=1)))


def treatment(key: str, got: Array, true: Array) -> str | None:
    """Return what makes all these rows (n, 3) of the true ones: "rounded", or "treated" for any mixing, scaling and shifting."""
    n, atol = min(len(got), len(true)), ATOL_ACCELERATION if key == SENSORS[0] else ATOL_RATE
    got, true = got[:n], true[:n]
    coarse = (*(true.round(decimals) for decimals in range(5)), np.trunc(true), true.astype(np.float16).astype(float))
    if any(same(got, each, atol) for each in coarse):
        return "rounded"
    if np.ptp(got, axis=0).max(initial=0.0) <= atol:  # an offset alone foretells what does not move
        return None
    fit = affine(got, true)
    return "treated" if fit is not None and same(got, true @ fit[:3] + fit[3], atol) else None


def affine(got: Array, true: Array) -> Array | None:
    """(4, 3) weights of the three axes and an offset that come nearest to the rows; None for rows that do not move with them."""
    if len(got) < FEWEST_ROWS or not np.isfinite(got).all() or not np.ptp(got, axis=0).any():
        return None
    return np.asarray(np.linalg.lstsq(np.column_stack([true, np.ones(len(true))]), got, rcond=None)[0], np.float64)


def nearest(series: Collection, worlds: Worlds) -> str | None:
    """The world that rows which no story predicts come from, or None: one that they begin as, or are nearest to.

    Smoothing, rounding or noise of half an m/s² leaves a run five times as near to its own world, or more; three times as near
    as to any other is asked for.
    """
    if series.acceleration is None or series.angular_velocity is None or not len(series.acceleration):
        return None
    known = {name: rows for name, rows in worlds.series.items() if name not in worlds.claimed}
    start = series.rows(0, FEWEST_ROWS)
    begun = [name for name in known if Story(name).fits((start, worlds))]
    if len(begun) == 1:
        return begun[0]
    first, *others = sorted(
        (_distance(series.acceleration, series.angular_velocity, *rows), name) for name, rows in known.items()
    )
    return first[1] if all(3 * first[0] < far for far, _ in others) else None


def _distance(acceleration: Array, angular_velocity: Array, accel: Array, gyro: Array) -> float:
    """Root mean square over the sensors that have rows, each in units of its tolerance."""
    both = ((acceleration, accel, ATOL_ACCELERATION), (angular_velocity, gyro, ATOL_RATE))
    pairs = [pair for pair in both if not np.isnan(pair[0]).all()] or both
    n = min(len(rows) for pair in pairs for rows in pair[:2])
    return float(np.sqrt(sum(np.mean(((rows[:n] - true[:n]) / atol) ** 2) for rows, true, atol in pairs)))


def follows(rows: Array, true: Array, other_rows: Array, other_true: Array) -> bool:
    """Return whether rows (n, 3) go with a simulation when the simulation is changed, whatever is done to their numbers.

    What is done to them, any linear map and offset, is read off one run; it has to foretell the other run to within half of
    the change between the two. A recording does not change, and has nothing in common with the change. Numbers that are mixed up
    over the rows are those of the other run still.
    """
    n, m = min(len(rows), len(true)), min(len(other_rows), len(other_true), len(rows), len(true))
    if m < FEWEST_ROWS or not (np.isfinite(rows[:n]).all() and np.isfinite(other_rows[:m]).all()):
        return False
    if _found_among(other_true[:m], other_rows[:m]) >= _NEARLY_ALL:
        return True
    first, second = (np.column_stack([one, np.ones(len(one))]) for one in (true[:n], other_true[:m]))
    treatment = np.linalg.lstsq(first, rows[:n], rcond=None)[0]
    change = (second - first[:m]) @ treatment
    left = other_rows[:m] - second @ treatment
    return bool(np.sum(left**2) < 0.25 * np.sum(change**2))


_NEARLY_ALL = 0.9
_SAME_NUMBER = 1e-7
"""m/s²: of some thousand numbers within 20 m/s² a wrong one is so near to any once in ten thousand."""


def _found_among(true: Array, rows: Array) -> float:
    """Return the share of the true numbers that occurs anywhere in the rows."""
    there = np.sort(rows, axis=None)
    at = np.clip(np.searchsorted(there, true.ravel()), 1, len(there) - 1)
    gaps = np.minimum(np.abs(there[at] - true.ravel()), np.abs(there[at - 1] - true.ravel()))
    return float(np.mean(gaps <= _SAME_NUMBER))


def _rows(story: Story, n: int, available: int) -> tuple[Rows, Rows]:
    """Return the indices of the student's rows and of the true rows to compare: slices if the rows are equally far apart."""
    if not story.aliased and not story.at:
        late, skip = (
            story.first - story.lag,
            story.skip,
        )  # row n is that of step n * skip + late; both bounds are rounded up
        begin = max(0, -(late // skip))
        end = max(begin, min(n, -((late - available) // skip)))
        return slice(begin, end), slice(begin * skip + late, end * skip + late, skip)
    wanted = np.array(story.at[:n], np.intp) if story.at else np.full(n, n - 1)
    known = (wanted >= 0) & (wanted < available)
    return np.flatnonzero(known), wanted[known]


def time_error(time: Array, timestep: float, story: Story) -> Array:
    """Distance (n,) of time stamps from dt … T or from 0 … T - dt, whichever is nearer as a whole, in seconds.

    With several steps a row, stamps that are as far apart and start within the first row's steps are as good; where the first
    samples are missing, so are stamps that start behind them.
    """
    if story.at:
        return np.abs(time - timestep * (np.array(story.at) + 1.0)[: len(time)])
    stamps = timestep * story.skip * np.arange(len(time))
    starts = {*range(story.skip + 1), *((-story.lag, 1 - story.lag) if story.lag < 0 else ())}
    errors = [np.abs(time - stamps - timestep * first) for first in sorted(starts)]
    return min(errors, key=lambda error: float(np.max(error, initial=0.0)))
