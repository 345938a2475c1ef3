"""Data collection: a time series of the simulated robot, from reset, after the push, every step once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grader.engine.check_runner import check
from grader.engine.faults import rows
from grader.engine.findings import CheckFailed, Ours, Size, Skipped
from grader.engine.traces import Traces
from grader.labs.imu.answers import KEYS, Collection, if_nothing
from grader.labs.imu.checks import row_faults, run_starts
from grader.labs.imu.checks.run_starts import PUSH
from grader.labs.imu.compare import Array, vector
from grader.labs.imu.diagnosis import collection as diagnosis
from grader.labs.imu.diagnosis.collection import TIME_ATOL, TRUE_WORLD, Story, Worlds
from grader.labs.imu.lab import LAB
from grader.labs.imu.lab_copies import learnt_timestep
from grader.labs.imu.parameters import departure, reads_global
from grader.labs.imu.recordings import (
    FOLLOWING,
    after_dirt,
    after_push,
    all_alike,
    arrays_of,
    complete,
    follows_simulation,
    from_dirt,
    has_rows,
    length,
    one_row_follows,
    pushed,
    pushed_again,
    recognised,
    story_of,
)
from grader.labs.imu.student import Student

_BUT_FOR_ONE = 0.75
"""Of the rows' points, where the last one alone was never filled."""
_IN_THE_LOOP = Ours(
    "Only the last row is there. Indent the lines that read and store as far as mj_step, so that they belong to the loop (Step 3)."
)
_ONE_A_STEP = Ours("Store one row for each step: n_steps = int(duration_seconds / model.opt.timestep) (Step 3).")
_NAMED, _ROWS, _COUNT, _PUSH = (
    "data_collection.returns_named_arrays",
    "data_collection.matches_truth",
    "data_collection.sample_count",
    "data_collection.applies_push",
)
"""These charge what other checks see as well."""


@check("data_collection.returns_named_arrays", lab_step=3)
def check_returns_named_arrays(student: Student, truth: Traces) -> None:
    """simulate_and_collect returns time (n), acceleration (n, 3) and angular_velocity (n, 3) under these names"""
    series = pushed(student, truth)
    if series.oddities:
        mistakes = tuple(dict.fromkeys(mistake for mistake, _ in series.oddities))
        got = "; ".join(sentence.removeprefix("got ") for _, sentence in series.oddities[:3])
        raise CheckFailed(_SHAPES, got, mistakes=mistakes, hint=if_nothing(got))
    present = [(key, value) for key, value in zip(KEYS, arrays_of(series), strict=True) if key != series.absent]
    sizes = {key: len(value) for key, value in present if value is not None}
    if not sizes:
        raise CheckFailed("rows in every array", "all keys, but empty arrays", hint=_ONE_A_STEP)
    if len(sizes) < len(KEYS):
        raise CheckFailed(
            _SHAPES, f"no numbers under {', '.join(sorted(set(KEYS) - set(sizes)))}", mistakes=["wrong-return-type"]
        )
    if len(set(sizes.values())) > 1:
        got = ", ".join(f"{key} has {n} rows" for key, n in sizes.items())
        raise CheckFailed("arrays of the same length", got, mistakes=["wrong-return-type"])
    if departs := departure("simulate_and_collect", series.departs):
        fault = rows(LAB)["global-for-parameter" if reads_global(series.departs) else "other-parameters"]
        expected, got = (text.format_map(departs.numbers) for text in (fault.expected, fault.got))
        raise CheckFailed(expected, got, off=departs.size, mistakes=[fault.id])


_SHAPES = "a dictionary with 'time' (n,), 'acceleration' (n, 3), 'angular_velocity' (n, 3)"


def simulated(student: Student, truth: Traces) -> None:
    """The rows come from a simulation: a story tells them, or they change as the robot's motion does."""
    series = pushed(student, truth)
    if not complete(series):
        return
    if all_alike(series):
        follows = one_row_follows(student, truth)
    else:
        follows = story_of(student, truth, "push", series)[0] is not None or follows_simulation(student, truth)
    if not follows:
        raise Skipped(FOLLOWING)


@check("data_collection.sample_count", lab_step=3, needs=simulated)
def check_sample_count(student: Student, truth: Traces) -> None:
    """One sample for every time step of the duration, whatever the duration and the time step"""
    seen = [(length(series), _own_timestep(worlds, series)) for series, worlds in _both_runs(student, truth)]
    off = [(n, w) for n, w in seen if abs(n - w.steps) > 1]
    if not off:
        return
    n, worlds = off[-1]
    story, pushed_worlds = story_of(student, truth, "push", pushed(student, truth))
    at_once = story is not None and _ends_at_once(pushed(student, truth), pushed_worlds, story)
    elsewhere = at_once or _is_last_alone(pushed(student, truth), story) or _are_too_many(student, truth)
    raise CheckFailed(
        f"{worlds.steps} samples for {worlds.duration_s:g} s at a time step of {worlds.timestep:g} s",
        f"{n} samples",
        off=Size("another number of samples"),
        mistakes=(mistakes := _count_mistakes(seen, skips=story is not None and story.skip > 1)),
        hint="" if mistakes else _ONE_A_STEP,
        belongs_to=_ROWS if elsewhere else "",
    )


def _both_runs(student: Student, truth: Traces) -> list[tuple[Collection, Worlds]]:
    """The two that were asked for: of other lengths, and with other time steps."""
    runs = (("push", pushed(student, truth)), ("push_dirty", from_dirt(student, truth)))
    return [(series, Worlds.of(truth[name])) for name, series in runs]


def _ends_at_once(series: Collection, worlds: Worlds, story: Story) -> bool:
    """Return whether the first rows are all that there is, too few to tell how they go on: matches_truth charges that."""
    return story.skip == 1 and series.filled_rows < min(diagnosis.FEWEST_ROWS, worlds.steps // 2)


def _is_last_alone(series: Collection, story: Story | None) -> bool:
    """Return whether the reading after the last step is all that there is: matches_truth charges that, too."""
    return story is not None and story.skip > 1 and length(series) == 1


def _are_too_many(student: Student, truth: Traces) -> bool:
    """Return whether as many rows as there are steps are filled, and those behind them never: matches_truth charges these."""
    return all(
        complete(series) and abs(series.filled_rows - worlds.steps) <= 1 < length(series)
        for series, worlds in _both_runs(student, truth)
    )


def _count_mistakes(seen: list[tuple[int, Worlds]], *, skips: bool) -> list[str]:
    (first, a), (second, b) = seen
    if not (first and second):
        return []
    if skips:
        same_rate = abs(first / a.duration_s - second / b.duration_s) <= 1 / min(a.duration_s, b.duration_s)
        return ["fixed-rate" if same_rate else "samples-skipped"]
    same_time = abs(first * a.timestep - second * b.timestep) <= max(a.timestep, b.timestep)
    if first == second or (same_time and abs(first - a.steps) > 1):
        return ["ignores-duration"]
    if abs(first / a.duration_s - second / b.duration_s) <= 1 / b.duration_s:
        return ["hard-coded-timestep"]
    return []


@check("data_collection.time_axis", lab_step=3)
def check_time_axis(student: Student, truth: Traces) -> None:
    """Each sample carries its simulation time in seconds"""
    series = pushed(student, truth)
    if series.time is None:
        if complete(series):
            raise CheckFailed("a time stamp for each sample", "none", belongs_to=_NAMED)
        raise Skipped("time stamps; the returned value has none")
    story, worlds = story_of(student, truth, "push", series)
    filled = series.filled_rows if complete(series) else None
    time = series.time[:filled] if filled else series.time
    if not np.isfinite(time).all():
        raise CheckFailed("finite time stamps", "NaN or infinity", mistakes=["not-finite"])
    error = diagnosis.time_error(time, _timestep(worlds, series), story or Story())
    worst = float(np.max(error))
    if worst > TIME_ATOL:
        _keeps_timestep(time, worlds.timestep, learnt_timestep(truth))
        raise CheckFailed(
            f"time stamps {worlds.timestep:g} s apart, from {worlds.timestep:g} s (or 0 s) on",
            f"{', '.join(f'{t:g}' for t in time[:3])} … {time[-1]:g} s",
            mistakes=["time-axis-wrong"],
            keeps=0.5 if worst <= 1.001 * worlds.timestep else 0.0,
            hint=_of_stamps(time, _timestep(worlds, series) * (story or Story()).skip),
            belongs_to=_ROWS if story and story.altered and _has_few_digits(time) else _charging(series, worlds),
        )
    _follows_timestep(from_dirt(student, truth), Worlds.of(truth["push_dirty"]), worlds.timestep)


def _has_few_digits(time: Array) -> bool:
    """Return whether stamps lost their digits with whatever else is kept in float16."""
    return bool(np.array_equal(time, time.astype(np.float16)))


def _charging(series: Collection, worlds: Worlds) -> str:
    """The check that charges the same: of right stamps that are too few or too many, or of those that every push resets.

    So are those of rows that were never filled.
    """
    assert series.time is not None
    if series.last_alone and not series.time[:-1].any():
        return _ROWS
    rows = {len(sensor) for sensor in (series.acceleration, series.angular_velocity) if sensor is not None}
    if rows and len(series.time) not in rows and _each_of_a_step(series.time, worlds):
        return _NAMED
    return _PUSH if _stand_still(series.time) and worlds.claim and len(worlds.claim.set_at) else ""


def _each_of_a_step(time: Array, worlds: Worlds) -> bool:
    """Return whether every stamp is that of a step of the run, each of a later one."""
    steps = np.round(time / worlds.timestep)
    whole = np.abs(time - steps * worlds.timestep).max() <= TIME_ATOL
    return bool(whole and np.all(np.diff(steps) > 0) and steps.min() >= 0 and steps.max() <= worlds.steps)


def _stand_still(time: Array) -> bool:
    return len(time) > 1 and not np.ptp(time)


def _of_stamps(time: Array, apart: float) -> str:
    """Return a hint on stamps that stand still or are off by a constant; "" for any others."""
    if _stand_still(time):
        return _STILL
    return _OFF_BY_THE_SAME if np.abs(np.diff(time) - apart).max(initial=0.0) <= TIME_ATOL else ""


_STILL = Ours(
    "Your time stamps are all equal. Store data.time in each pass of the loop, and reset only once, before the loop (Step 3)."
)
_OFF_BY_THE_SAME = Ours(
    "All your time stamps are off by the same amount. Start to store with the first step after the reset, and add nothing to "
    "data.time (Step 3)."
)


def _follows_timestep(series: Collection, worlds: Worlds, usual: float) -> None:
    """Return whether the stamps keep to another time step, too; where they start is a matter of the reset."""
    if series.time is not None:
        _keeps_timestep(series.time[: worlds.steps - 1], _timestep(worlds, series), usual)


def _keeps_timestep(time: Array, timestep: float, usual: float) -> None:
    """Stamps that are as far apart as the model's usual time step, where it has another."""
    apart = np.abs(np.diff(time) - usual)
    if len(apart) and apart.max() <= TIME_ATOL and abs(timestep - usual) > TIME_ATOL:
        got = f"{usual:g} s apart, the time step of the lab model"
        raise CheckFailed(f"time stamps {timestep:g} s apart", got, mistakes=["hard-coded-timestep"], keeps=0.5)


def _timestep(worlds: Worlds, series: Collection) -> float:
    """The time step of a run; another one where the student's code changed the model's, which starts_from_reset charges."""
    changed = "opt.timestep" in series.changed and "timestep" in series.first_step
    return float(series.first_step["timestep"][0]) if changed else worlds.timestep


def _own_timestep(worlds: Worlds, series: Collection) -> Worlds:
    timestep = _timestep(worlds, series)
    steps = round(worlds.duration_s / timestep) if timestep > 0 else worlds.steps
    return replace(worlds, timestep=timestep, steps=steps)


@check("data_collection.matches_truth", lab_step=3)
def check_matches_truth(student: Student, truth: Traces) -> None:
    """The rows are what the sensors read, step by step"""
    series = pushed(student, truth)
    has_rows(series)
    story, worlds = story_of(student, truth, "push", series)
    filled, n = series.filled_rows, length(series)
    if story is None:
        row_faults.unexplained(series, worlds)
    if _ends_at_once(series, worlds, story):
        row_faults.broken_off(filled, worlds)
    if _is_last_alone(series, story):
        raise CheckFailed(
            f"{worlds.steps} rows",
            "one row, of the last step",
            off=Size("one row, of the last step"),
            hint=_IN_THE_LOOP,
        )
    if story.altered:
        row_faults.altered(story, worlds, series)
    row_faults.of_other_sensors(story)
    run_starts.in_another_model(story, worlds, series, np.asarray(truth["reading_lab"].scalars["gravity"], float))
    if all_alike(series) and not one_row_follows(student, truth):
        row_faults.standing_still(n, series)
    if series.last_alone:
        raise CheckFailed(
            f"{n} filled rows", "only the last row filled", mistakes=["rows-left-zero"], hint=_IN_THE_LOOP
        )
    if story.aliased:
        raise CheckFailed(
            "rows that differ from step to step", f"{n} rows, all equal to the last sample", mistakes=["aliased-rows"]
        )
    if story.exchanged:
        raise CheckFailed(
            "accelerations under 'acceleration', angular velocities under 'angular_velocity'",
            "each under the key of the other",
            mistakes=["channels-swapped"],
        )
    if story.skip != 1 and not story.covers(n, worlds.steps):  # else too few rows, which sample_count charges
        raise CheckFailed(
            "one stored sample for each step",
            f"{story.skip} steps between stored samples",
            mistakes=["samples-skipped"],
        )
    row_faults.shifted(story, worlds, series)
    if filled < n:
        keeps = _BUT_FOR_ONE if filled == n - 1 else 0.5
        raise CheckFailed(
            f"{n} filled rows", f"{filled} filled rows, then zeros", mistakes=["rows-left-zero"], keeps=keeps
        )


@check("data_collection.starts_from_reset", lab_step=3, needs=simulated)
def check_starts_from_reset(student: Student, truth: Traces) -> None:
    """A run starts from the reset state, whatever happened before, and leaves the model as it was"""
    series = from_dirt(student, truth)
    if complete(pushed(student, truth)) and not length(series):
        duration = f"{Worlds.of(truth['push_dirty']).duration_s:g} s"
        raise CheckFailed(f"the rows of a run of {duration}", "none", hint=_ONE_A_STEP, belongs_to=_COUNT)
    has_rows(series)
    if series.changed:
        raise CheckFailed("an unchanged model", f"{', '.join(series.changed)} changed", mistakes=["modifies-model"])
    push = after_push(student, truth)
    left = diagnosis.rows_left(push), diagnosis.rows_left(after_dirt(student, truth), push)
    if any(left):
        got = f"a recording that begins with {max(left)} rows of the previous run"
        raise CheckFailed("the same recording as from a fresh start", got, mistakes=["keeps-old-rows"])
    first, first_worlds = story_of(student, truth, "push", pushed(student, truth))
    story, worlds = story_of(student, truth, "push_dirty", series)
    start = truth["reading_lab"]["qpos"][-1]
    goes_on = (
        _time_goes_on(series, truth)
        or run_starts.in_another_pose(story, worlds, start)
        or (run_starts.with_other_velocities(story, worlds, push) and not _pushes_at_random(student, truth))
    )
    if goes_on:
        got = "a recording that continues from the state in which data was left"
        raise CheckFailed("the same recording as from a fresh start", got, mistakes=["no-reset"])
    unknown = story is None and not (first or Story()).fits((series, worlds))
    near = recognised(student, truth, series, worlds) if unknown else TRUE_WORLD
    elsewhere = near == diagnosis.CLAIMED_WORLD and run_starts.in_another_pose(Story(near), worlds, start)
    if near == "no_reset" or elsewhere or run_starts.in_another_pose(first, first_worlds, start):
        accel = worlds.series[TRUE_WORLD][0]
        assert series.acceleration is not None
        wanted = f"{vector(accel[0])} m/s² in the first row, as from a fresh start"
        hint = Ours("Call mujoco.mj_resetData(model, data) first, and set the push right after it (Step 3).")
        off = Size("another recording than from a fresh start")
        raise CheckFailed(wanted, vector(series.acceleration[0]), off=off, hint=hint)


def _time_goes_on(series: Collection, truth: Traces) -> bool:
    left_at = float(truth["push_dirty"]["dirty_time"])
    return series.time is not None and len(series.time) > 0 and abs(series.time[0] - left_at) < 0.5 * left_at


@check("data_collection.applies_push", lab_step=3, needs=simulated)
def check_applies_push(student: Student, truth: Traces) -> None:
    """The run starts with the push of the sheet: 0.5 m/s forward"""
    series = pushed(student, truth)
    has_rows(series)
    story, worlds = story_of(student, truth, "push", series)
    world = recognised(student, truth, series, worlds) if story is None else story.world
    if world != TRUE_WORLD and _pushes_at_random(student, truth):
        first, second = (run_starts.velocities(each) for each in (series, pushed_again(student, truth)))
        got = f"a recording that starts with {first}, and the next one with {second}"
        off = Size("a recording that starts with another velocity in every run")
        raise CheckFailed(f"{PUSH}, in every run", got, mistakes=["random-push"], off=off)
    if world == "no_push":
        raise CheckFailed(PUSH, "a recording that starts without a push", mistakes=["no-perturbation"])
    if world in (diagnosis.CLAIMED_WORLD, diagnosis.OWN_WORLD):
        assert worlds.claim is not None
        run_starts.with_another_push(worlds.claim)
    elif world.startswith("push"):
        got = f"a recording after another push ({world.removeprefix('push_')})"
        raise CheckFailed(PUSH, got, mistakes=["wrong-perturbation"])


def _pushes_at_random(student: Student, truth: Traces) -> bool:
    """Return whether two runs of one kind, both from a fresh state, start with other velocities."""
    return run_starts.are_pushed_apart(pushed(student, truth), pushed_again(student, truth))
