"""Data collection: a time series of the simulated robot, from reset, after the push, every step once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grader.engine.examination import check
from grader.engine.findings import Lost, Size, Skipped
from grader.engine.traces import Traces

from ..answers import KEYS, Collection
from ..checks.fitting import fits_in
from ..compare import Array, deviation, told, vector
from ..diagnosis import collection as diagnosis
from ..diagnosis.collection import TRUE_WORLD, Story, Worlds
from ..lab_copies import learnt_timestep
from ..recordings import (
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
from ..student import Student

_ROWS = "data_collection.matches_truth"
"""This charges what other checks see as well."""
_SAME_START = 1e-9
_TIME_ATOL = 1e-6
"""s. Adding a time step 5,000 times errs by 1e-12 s, and single precision by 1e-7 s at 3 s."""


@check("data_collection.returns_named_arrays", lab_step=3)
def check_returns_named_arrays(student: Student, truth: Traces) -> None:
    """simulate_and_collect returns time (n), acceleration (n, 3) and angular_velocity (n, 3) under these names"""
    series = pushed(student, truth)
    if series.oddities:
        mistakes = tuple(dict.fromkeys(mistake for mistake, _ in series.oddities))
        got = "; ".join(sentence.removeprefix("got ") for _, sentence in series.oddities[:3])
        raise Lost(_SHAPES, got, mistakes=mistakes)
    present = [(key, value) for key, value in zip(KEYS, arrays_of(series), strict=True) if key != series.absent]
    sizes = {key: len(value) for key, value in present if value is not None}
    if len(sizes) < len(KEYS):
        raise Lost(
            _SHAPES, f"no numbers under {', '.join(sorted(set(KEYS) - set(sizes)))}", mistakes=["wrong-return-type"]
        )
    if len(set(sizes.values())) > 1:
        got = ", ".join(f"{key} has {n} rows" for key, n in sizes.items())
        raise Lost("arrays of the same length", got, mistakes=["wrong-return-type"])
    fits_in(student, "simulate_and_collect", series.departs, keeps=0.0)


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
    seen = []
    for name, series in (("push", pushed(student, truth)), ("push_dirty", from_dirt(student, truth))):
        worlds = _own_timestep(Worlds.of(truth[name]), series)
        seen.append((length(series), worlds))
    off = [(n, w) for n, w in seen if abs(n - w.steps) > 1]
    if not off:
        return
    n, worlds = off[-1]
    story, pushed_worlds = story_of(student, truth, "push", pushed(student, truth))
    at_once = story is not None and _ends_at_once(pushed(student, truth), pushed_worlds, story)
    elsewhere = at_once or _are_too_many(student, truth)
    raise Lost(
        f"{worlds.steps} samples for {worlds.duration_s:g} s at a time step of {worlds.timestep:g} s",
        f"{n} samples",
        mistakes=(mistakes := _count_mistakes(seen, skips=story is not None and story.skip > 1)),
        keeps=0.0,
        hint=""
        if mistakes
        else "Store one row for each step: n_steps = duration_seconds / model.opt.timestep (Step 3).",
        belongs_to=_ROWS if elsewhere else "",
    )


def _ends_at_once(series: Collection, worlds: Worlds, story: Story) -> bool:
    """Whether the first rows are all that there is, too few to tell how they go on: matches_truth charges that."""
    return story.skip == 1 and series.filled_rows < min(diagnosis.FEWEST_ROWS, worlds.steps // 2)


def _are_too_many(student: Student, truth: Traces) -> bool:
    """Whether as many rows as there are steps are filled, and those behind them never: matches_truth charges these."""
    pairs = ((pushed(student, truth), "push"), (from_dirt(student, truth), "push_dirty"))
    return all(
        complete(series) and abs(series.filled_rows - Worlds.of(truth[name]).steps) <= 1 < length(series)
        for series, name in pairs
    )


def _count_mistakes(seen: list[tuple[int, Worlds]], *, skips: bool) -> list[str]:
    (first, a), (second, b) = seen
    if not first and not second:
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
        raise Skipped("time stamps, which the returned value does not hold")
    story, worlds = story_of(student, truth, "push", series)
    filled = series.filled_rows if complete(series) else None
    time = series.time[:filled] if filled else series.time
    if not np.isfinite(time).all():
        raise Lost("finite time stamps", "NaN or infinity", mistakes=["not-finite"])
    error = diagnosis.time_error(time, _timestep(worlds, series), story or Story())
    worst = int(np.argmax(error)) if len(error) else 0
    if not len(error) or error[worst] > _TIME_ATOL:
        _keeps_timestep(time, worlds.timestep, learnt_timestep(truth))
        raise Lost(
            f"time stamps {worlds.timestep:g} s apart, from {worlds.timestep:g} s (or 0 s) on",
            f"{', '.join(f'{t:g}' for t in time[:3])} … {time[-1]:g} s" if len(time) else "no time stamps",
            mistakes=["time-axis-wrong"],
            keeps=0.5 if len(error) and error[worst] <= 1.001 * worlds.timestep else 0.0,
        )
    _follows_timestep(from_dirt(student, truth), Worlds.of(truth["push_dirty"]), worlds.timestep)


def _follows_timestep(series: Collection, worlds: Worlds, usual: float) -> None:
    """Whether the stamps keep to another time step, too; where they start is a matter of the reset."""
    if series.time is None or len(series.time) < 2:
        return
    _keeps_timestep(series.time[: worlds.steps - 1], _timestep(worlds, series), usual)


def _keeps_timestep(time: Array, timestep: float, usual: float) -> None:
    """Stamps that are as far apart as the model's usual time step, where it has another."""
    apart = np.abs(np.diff(time) - usual)
    if len(apart) and apart.max() <= _TIME_ATOL and abs(timestep - usual) > _TIME_ATOL:
        got = f"{usual:g} s apart, as with the model's usual time step"
        raise Lost(f"time stamps {timestep:g} s apart", got, mistakes=["hard-coded-timestep"], keeps=0.5)


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
        _rows_differ(series, worlds)
    assert story is not None
    if _ends_at_once(series, worlds, story):
        _rows_end(filled, worlds)
    if story.altered:
        _rows_altered(story, series, worlds)
    _same_sensors(story)
    _same_physics(story, worlds, series, np.asarray(truth["reading_lab"].scalars["gravity"], float))
    if all_alike(series) and not one_row_follows(student, truth):
        raise Lost(
            "rows that a simulation made", f"{n} rows, all alike, whatever gravity is", mistakes=["nothing-simulated"]
        )
    if story.aliased:
        raise Lost(
            "rows that differ from step to step", f"{n} rows, all equal to the last sample", mistakes=["aliased-rows"]
        )
    if story.exchanged:
        raise Lost(
            "accelerations under 'acceleration'",
            "angular velocities there, and the other way round",
            mistakes=["channels-swapped"],
        )
    if story.skip != 1 and not story.covers(n, worlds.steps):  # else too few rows, which sample_count charges
        raise Lost(
            "one stored sample for each step",
            f"{story.skip} steps between stored samples",
            mistakes=["samples-skipped"],
        )
    if story.lag < -1:
        raise Lost("a row for every step from the start on", f"none for the first {-story.lag} steps", keeps=0.5)
    if story.lag != 0 and not _at_own_times(story, worlds, series):
        _shifted(story, series)
    if filled < n - 1:
        raise Lost(f"{n} filled rows", f"{filled} filled rows, then zeros", mistakes=["rows-left-zero"], keeps=0.5)


def _same_sensors(story: Story) -> None:
    if story.world.startswith(diagnosis.OTHER_IMU):
        raise Lost("readings of the IMU whose ids are given", "those of another IMU of the model")
    if story.world == diagnosis.LEARNT_IDS:
        raise Lost(
            "readings of the robot's IMU, its ids looked up by their names",
            "those of the sensors that have their ids in your copy of the model",
            mistakes=["hard-coded-address"],
            hint="Look each id up by its sensor's name, with mj_name2id as in Step 2: another model has others.",
        )
    if story.world == diagnosis.LAST_SENSOR:
        got = "those of the model's last sensor, which the id -1 of an unknown name reads"
        raise Lost("readings of the IMU whose ids are given", got, mistakes=["sensor-not-found"])


def _shifted(story: Story, series: Collection) -> None:
    """Rows that are late or early by one; a first row of zeros is one that was never filled if a step less was made."""
    assert series.acceleration is not None
    steps = series.first_step.get("steps", np.zeros(1))[0]
    if story.lag > 0 and steps == len(series.acceleration) - 1 and not series.acceleration[0].any():
        got = "a first row that was never filled: the loop makes a step less than there are rows"
        raise Lost("a row for every step, the first one too", got, mistakes=["first-row-empty"], keeps=0.5)
    late, mistakes = ("late", ["read-before-step"]) if story.lag > 0 else ("early", [])
    hint = (
        ""
        if mistakes
        else "Read the sensors once after every mj_step, and store that reading in the same pass (Step 3)."
    )
    got = f"every row {late} by one sample"
    raise Lost("each row read after its step", got, mistakes=mistakes, keeps=0.5, hint=hint)


def _rows_altered(story: Story, series: Collection, worlds: Worlds) -> None:
    """The run is right, and the rows of one sensor or both are others: called altered if one treatment predicts all of them."""
    rows = dict(zip(diagnosis.SENSORS, (series.acceleration, series.angular_velocity), strict=True))
    true = dict(zip(diagnosis.SENSORS, worlds.series[story.world], strict=True))
    key = story.altered[0]
    got = rows[key]
    assert got is not None
    if key == series.absent:
        gone = f"none that can be made out under {key!r}"
        off = Size(f"no rows that can be made out under {key!r}")
        raise Lost("rows of both sensors", gone, keeps=0.5, hint=_BOTH, off=off)
    keeps, others = (0.5, ", while the other sensor is right") if len(story.altered) == 1 else (0.0, "")
    if not np.isfinite(got).all():
        raise Lost("finite numbers", f"NaN or infinity under {key!r}", mistakes=["not-finite"], keeps=keeps)
    gap, unit = deviation(got, true[key]), ("m/s²", "rad/s")[diagnosis.SENSORS.index(key)]
    treatment = diagnosis.treatment(key, got, true[key])
    others = f"{_KINDS.get(treatment or '', '')}{others}"
    raise Lost(
        f"{told(true[key][gap.row], got[gap.row])} {unit} under {key!r} in row {gap.row}",
        f"{told(got[gap.row], true[key][gap.row])}{others}",
        mistakes=["rows-altered"] if treatment else [],
        keeps=keeps,
        off=Size(f"rows under {key!r} are off{others}", gap.rms, unit),
        hint="" if treatment else "Store what get_imu_readings returns, as it is (Step 3).",
    )


_BOTH = "Store both vectors of every reading, each whole, in arrays of shape (n_steps, 3) (Step 3)."
_KINDS = {
    "sign-flipped": ": the reading with other signs",
    "axes-permuted": ": the reading with its axes in another order",
    "precision-lost": ": the reading with digits cut off",
    "wrong-units": ": the reading in another unit",
    "gravity-removed": ": the reading with gravity added or taken away",
    "treated": ": the reading scaled, shifted or mixed",
}


def _at_own_times(story: Story, worlds: Worlds, series: Collection) -> bool:
    """Whether each row stands at the time of its state: from the one before any step on, or by mj_forward after every step."""
    if series.time is None or series.acceleration is None or len(series.time) < 2:
        return False
    if story.lag == -1:
        return bool(abs(series.time[0] - worlds.timestep) < _TIME_ATOL)
    first = worlds.series[story.world][0][0]
    at_once = np.abs(series.acceleration[0] - first).max() <= diagnosis.ATOL_ACCELERATION
    return bool(at_once and abs(series.time[0]) < _TIME_ATOL and abs(series.time[1] - worlds.timestep) < _TIME_ATOL)


def _same_physics(story: Story, worlds: Worlds, series: Collection, gravity: Array) -> None:
    """A model that was changed for the run and put back: what is left changed is charged by starts_from_reset."""
    claim = worlds.claim
    if not story.of_claim or claim is None or series.changed:
        return
    if abs(claim.timestep - worlds.timestep) > _SAME_START:
        got = f"rows of a simulation with a time step of {claim.timestep:g} s"
        raise Lost(
            f"a simulation with the model's time step of {worlds.timestep:g} s", got, mistakes=["modifies-model"]
        )
    if np.abs(claim.gravity - gravity).max() > 1e-3:
        raise Lost(
            "a simulation with the model's gravity",
            f"rows of one with {vector(claim.gravity)} m/s²",
            mistakes=["modifies-model"],
        )


def _rows_end(n: int, worlds: Worlds) -> None:
    rows = f"{n} row{'s' * (n != 1)}, then nothing"
    hint = "Return after the loop, when all rows are stored (Step 3)."
    raise Lost(f"{worlds.steps} rows", rows, hint=hint, off=Size("a few rows from the start, then nothing"))


def _rows_differ(series: Collection, worlds: Worlds) -> None:
    if series.absent:
        found = f"no rows that can be made out under {series.absent!r}, and others than the truth of the other sensor"
        raise Lost("the readings of both sensors", found, hint=_BOTH)
    accel, gyro = worlds.series.get(diagnosis.CLAIMED_WORLD, worlds.series[TRUE_WORLD])
    assert series.acceleration is not None
    assert series.angular_velocity is not None
    n = min(len(series.acceleration), len(accel))
    if not (np.isfinite(series.acceleration).all() and np.isfinite(series.angular_velocity).all()):
        raise Lost("finite numbers", "NaN or infinity in the rows", mistakes=["not-finite"])
    in_accel, in_gyro = deviation(series.acceleration[:n], accel[:n]), deviation(series.angular_velocity[:n], gyro[:n])
    right = (in_accel.worst <= diagnosis.ATOL_ACCELERATION, in_gyro.worst <= diagnosis.ATOL_RATE)
    if all(right):
        _rows_end(n, worlds)
    got, true, at, unit = (
        (series.angular_velocity, gyro, in_gyro, "rad/s")
        if right[0]
        else (series.acceleration, accel, in_accel, "m/s²")
    )
    nothing = [] if series.first_step else ["nothing-simulated"]
    raise Lost(
        f"{told(true[at.row], got[at.row])} {unit} in row {at.row}",
        f"{told(got[at.row], true[at.row])} (RMS difference over the series {at.rms:.3g} {unit})",
        keeps=0.5 if any(right) else 0.0,
        off=Size("the rows differ over the series", at.rms, unit),
        mistakes=nothing,
        hint=""
        if nothing
        else "In each pass of the loop step once, read once and store that reading as it is (Step 3).",
    )


@check("data_collection.starts_from_reset", lab_step=3, needs=simulated)
def check_starts_from_reset(student: Student, truth: Traces) -> None:
    """A run starts from the reset state, whatever happened before, and leaves the model as it was"""
    series = from_dirt(student, truth)
    has_rows(series)
    if series.changed:
        raise Lost(
            "a model that is the same afterwards", f"{', '.join(series.changed)} changed", mistakes=["modifies-model"]
        )
    push = after_push(student, truth)
    left = diagnosis.rows_left(push), diagnosis.rows_left(after_dirt(student, truth), push)
    if any(left):
        got = f"a series that begins with {max(left)} rows of the run before"
        raise Lost("the same series as from a fresh start", got, mistakes=["keeps-old-rows"])
    first, first_worlds = story_of(student, truth, "push", pushed(student, truth))
    story, worlds = story_of(student, truth, "push_dirty", series)
    start = truth["reading_lab"]["qpos"][-1]
    goes_on = _time_goes_on(series, truth) or _starts_elsewhere(story, worlds, start)
    if goes_on or (_other_velocity(story, worlds, push) and not _pushes_at_random(student, truth)):
        got = "a series that goes on from where the data was left"
        raise Lost("the same series as from a fresh start", got, mistakes=["no-reset"])
    unknown = story is None and not (first or Story()).fits((series, worlds))
    near = recognised(student, truth, series, worlds) if unknown else TRUE_WORLD
    elsewhere = near == diagnosis.CLAIMED_WORLD and _starts_elsewhere(Story(near), worlds, start)
    if near == "no_reset" or elsewhere or _starts_elsewhere(first, first_worlds, start):
        accel = worlds.series[TRUE_WORLD][0]
        assert series.acceleration is not None
        wanted = f"{vector(accel[0])} m/s² in the first row, as from a fresh start"
        hint = "Call mujoco.mj_resetData(model, data) first, and push the robot right after it (Step 3)."
        off = Size("another series than from a fresh start")
        raise Lost(wanted, vector(series.acceleration[0]), off=off, hint=hint)


def _starts_elsewhere(story: Story | None, worlds: Worlds, start: Array) -> bool:
    """Whether a run is known to begin in another pose than the model's own (nq,)."""
    if story is None or not story.of_claim or worlds.claim is None:
        return story is not None and story.world == "no_reset"
    return bool(np.abs(worlds.claim.qpos - start).max() > _SAME_START)


def _other_velocity(story: Story | None, worlds: Worlds, push: Collection) -> bool:
    """Whether a run is known to begin with other velocities than the first run did: what an earlier one left stays in them."""
    if story is None or not story.of_claim or worlds.claim is None or not push.first_step:
        return False
    return bool(np.abs(worlds.claim.qvel - push.first_step["qvel"]).max() > _SAME_START)


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
        first, second = (_velocity(each) for each in (series, pushed_again(student, truth)))
        got = f"a series that starts with {first}, and one from the same state that starts with {second}"
        off = Size("a series that starts with another velocity in every run")
        raise Lost("data.qvel[0] = 0.5 after the reset, in every run", got, mistakes=["random-push"], off=off)
    if world == "no_push":
        mistake = "no-perturbation" if story else "wrong-perturbation"
        raise Lost("data.qvel[0] = 0.5 after the reset", "a series that starts without a push", mistakes=[mistake])
    if world in (diagnosis.CLAIMED_WORLD, diagnosis.OWN_WORLD):
        _other_push(worlds)
    elif world.startswith("push"):
        words = world.replace("push_", "").replace("_", " ")
        got = f"a series after another push ({words})"
        raise Lost("data.qvel[0] = 0.5 after the reset", got, mistakes=["wrong-perturbation"])


def _other_push(worlds: Worlds) -> None:
    claim = worlds.claim
    assert claim is not None
    pushed = np.flatnonzero(np.abs(claim.qvel) > _SAME_START)
    if claim.force.any():
        got = f"a series under a force of up to {np.abs(claim.force).max():.3g} N or Nm"
        raise Lost("data.qvel[0] = 0.5 after the reset, and no force", got, mistakes=["wrong-perturbation"])
    if not len(pushed) and len(claim.set_at):
        got = f"a series whose velocity is set before step {claim.set_at[0] + 1:.0f}, and not at the start"
        _wrongly_pushed(got, Size("a series whose velocity is set later, and not at the start"))
    if not len(pushed):
        raise Lost("data.qvel[0] = 0.5 after the reset", "a series without a push", mistakes=["no-perturbation"])
    if len(pushed) != 1 or pushed[0] != 0 or abs(claim.qvel[0] - 0.5) > _SAME_START:
        _wrongly_pushed(
            f"a series that starts with {_velocities(claim.qvel)}", Size("a series that starts with another push")
        )
    if len(claim.set_at):
        times = "once more" if len(claim.set_at) == 1 else f"{len(claim.set_at)} times more"
        got = f"a series whose state is set {times}, first before step {claim.set_at[0] + 1:.0f}"
        _wrongly_pushed(got, Size("a series whose state is set again while it runs"))


def _wrongly_pushed(got: str, off: Size) -> None:
    raise Lost("data.qvel[0] = 0.5 once, right after the reset", got, mistakes=["wrong-perturbation"], off=off)


def _velocities(qvel: Array) -> str:
    pushed = np.flatnonzero(np.abs(qvel) > _SAME_START)
    return ", ".join(f"qvel[{i}] = {qvel[i]:.3g}" for i in pushed[:3]) + (" …" if len(pushed) > 3 else "")


def _velocity(series: Collection) -> str:
    return _velocities(series.first_step["qvel"]) or "no velocity"


def _pushes_at_random(student: Student, truth: Traces) -> bool:
    """Whether two runs of one kind, both from a fresh state, start with other velocities."""
    first, second = pushed(student, truth).first_step, pushed_again(student, truth).first_step
    return bool(first and second and np.abs(first["qvel"] - second["qvel"]).max() > _SAME_START)
