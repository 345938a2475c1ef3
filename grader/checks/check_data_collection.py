"""Data collection: a time series of the simulated robot, from reset, after the push, every step once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..answers import KEYS, Collection
from ..compare import Array, deviation, vector
from ..diagnosis import collection as diagnosis
from ..diagnosis.collection import TRUE_WORLD, Claim, Story, Worlds
from ..plugin import check
from ..student import Student
from ..traces import Traces
from ..verdicts import Lost, Skipped, raised

_SAME_START = 1e-9
_LONGEST_REPLAY = 3000
_RECOGNISABLE = "a series that can be recognised: its rows fit neither the push nor another one"
_TIME_ATOL = 1e-6
"""s. Adding a time step 5,000 times errs by 1e-12 s, and single precision by 1e-7 s at 3 s."""


@check("data_collection.returns_named_arrays", lab_step=3)
def check_returns_named_arrays(student: Student, truth: Traces) -> None:
    """simulate_and_collect returns time (n), acceleration (n, 3) and angular_velocity (n, 3) under these names"""
    series = _push(student, truth)
    if series.oddities:
        mistakes = tuple(dict.fromkeys(mistake for mistake, _ in series.oddities))
        got = "; ".join(sentence.removeprefix("got ") for _, sentence in series.oddities[:3])
        raise Lost(_SHAPES, got, mistakes=mistakes)
    sizes = {key: len(value) for key, value in zip(KEYS, _arrays(series), strict=True) if value is not None}
    if len(sizes) < len(KEYS):
        raise Lost(
            _SHAPES, f"no numbers under {', '.join(sorted(set(KEYS) - set(sizes)))}", mistakes=["wrong-return-type"]
        )
    if len(set(sizes.values())) > 1:
        got = ", ".join(f"{key} has {n} rows" for key, n in sizes.items())
        raise Lost("arrays of the same length", got, mistakes=["wrong-return-type"])


_SHAPES = "a dictionary with 'time' (n,), 'acceleration' (n, 3), 'angular_velocity' (n, 3)"


@check("data_collection.sample_count", lab_step=3)
def check_sample_count(student: Student, truth: Traces) -> None:
    """One sample for every time step of the duration, whatever the duration and the time step"""
    seen = []
    for name, series in (("push", _push(student, truth)), ("push_dirty", _dirty(student, truth))):
        worlds = _own_timestep(Worlds.of(truth[name]), series)
        seen.append((_length(series), worlds))
    off = [(n, w) for n, w in seen if abs(n - w.steps) > 1]
    if not off:
        return
    n, worlds = off[-1]
    story, _ = _story(student, truth, "push", _push(student, truth))
    raise Lost(
        f"{worlds.steps} samples for {worlds.duration_s:g} s at a time step of {worlds.timestep:g} s",
        f"{n} samples",
        mistakes=_count_mistakes(seen, skips=story is not None and story.skip > 1),
        keeps=0.0,
    )


def _count_mistakes(seen: list[tuple[int, Worlds]], *, skips: bool) -> list[str]:
    (first, a), (second, b) = seen
    if not first and not second:
        return []
    same_time = abs(first * a.timestep - second * b.timestep) <= max(a.timestep, b.timestep)
    if first == second or (same_time and abs(first - a.steps) > 1):
        return ["ignores-duration"]
    if abs(first / a.duration_s - second / b.duration_s) <= 1 / b.duration_s:
        return ["hard-coded-timestep"]
    return ["samples-skipped"] if skips else []


@check("data_collection.time_axis", lab_step=3)
def check_time_axis(student: Student, truth: Traces) -> None:
    """Each sample carries its simulation time in seconds"""
    series = _push(student, truth)
    if series.time is None:
        raise Skipped("time stamps, which the returned value does not hold")
    story, worlds = _story(student, truth, "push", series)
    filled = diagnosis.filled_rows(series) if _complete(series) else None
    time = series.time[:filled] if filled else series.time
    if not np.isfinite(time).all():
        raise Lost("finite time stamps", "NaN or infinity", mistakes=["not-finite"])
    error = diagnosis.time_error(time, _timestep(worlds, series), story or Story())
    worst = int(np.argmax(error)) if len(error) else 0
    if not len(error) or error[worst] > _TIME_ATOL:
        raise Lost(
            f"time stamps {worlds.timestep:g} s apart, from {worlds.timestep:g} s (or 0 s) on",
            f"{', '.join(f'{t:g}' for t in time[:3])} … {time[-1]:g} s" if len(time) else "no time stamps",
            mistakes=["time-axis-wrong"],
            keeps=0.5 if len(error) and error[worst] <= 1.001 * worlds.timestep else 0.0,
        )
    _follows_timestep(_dirty(student, truth), Worlds.of(truth["push_dirty"]), worlds.timestep)


def _follows_timestep(series: Collection, worlds: Worlds, usual: float) -> None:
    """Whether the stamps keep to another time step, too; where they start is a matter of the reset."""
    if series.time is None or len(series.time) < 2:
        return
    apart = np.diff(series.time[: worlds.steps - 1])
    if np.all(np.abs(apart - usual) <= _TIME_ATOL) and abs(_timestep(worlds, series) - usual) > _TIME_ATOL:
        got = f"{usual:g} s apart, as with the model's usual time step"
        raise Lost(f"time stamps {worlds.timestep:g} s apart", got, mistakes=["hard-coded-timestep"], keeps=0.5)


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
    series = _push(student, truth)
    _has_rows(series)
    story, worlds = _story(student, truth, "push", series)
    filled, n = diagnosis.filled_rows(series), _length(series)
    if story is None:
        _rows_differ(series, worlds)
    assert story is not None
    if story.altered:
        _one_sensor_differs(story.altered, series, worlds)
    if story.world.startswith(diagnosis.OTHER_IMU):
        raise Lost("readings of the torso's sensors", "those of another IMU of the model")
    if story.world == diagnosis.LAST_SENSOR:
        got = "those of the model's last sensor, which the id -1 of an unknown name reads"
        raise Lost("readings of the torso's sensors", got, mistakes=["sensor-not-found"])
    _same_physics(story, worlds, series)
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
    if story.skip != 1:
        raise Lost(
            "one stored sample for each step",
            f"{story.skip} steps between stored samples",
            mistakes=["samples-skipped"],
        )
    if story.lag < -1:
        raise Lost("a row for every step from the start on", f"none for the first {-story.lag} steps", keeps=0.5)
    if story.lag != 0 and not _at_own_times(story, worlds, series):
        late = "late" if story.lag > 0 else "early"
        mistakes = ["read-before-step"] if story.lag > 0 else []
        raise Lost("each row read after its step", f"every row {late} by one sample", mistakes=mistakes, keeps=0.5)
    if filled < n - 1:
        raise Lost(f"{n} filled rows", f"{filled} filled rows, then zeros", mistakes=["rows-left-zero"], keeps=0.5)


def _one_sensor_differs(altered: str, series: Collection, worlds: Worlds) -> None:
    """One sensor's rows are right, the other's are not: what made others of them is named if it predicts every row."""
    sensor = diagnosis.SENSORS.index(altered)
    got, true = (series.acceleration, series.angular_velocity)[sensor], worlds.series[TRUE_WORLD][sensor]
    assert got is not None
    if not np.isfinite(got).all():
        raise Lost("finite numbers", f"NaN or infinity under {altered!r}", mistakes=["not-finite"], keeps=0.5)
    gap, unit = deviation(got, true), ("m/s²", "rad/s")[sensor]
    mistakes = diagnosis.altered_by(altered, got, true)
    raise Lost(
        f"{vector(true[gap.row])} {unit} under {altered!r} in row {gap.row}",
        f"{vector(got[gap.row])}, while the other sensor is right",
        mistakes=mistakes,
        keeps=0.5,
        off=f"rows under {altered!r} that differ by {gap.rms:.3g} {unit} (RMS), while the other sensor is right",
        hint="" if mistakes else "Store what get_imu_readings returns, as it is (Step 3).",
    )


def _at_own_times(story: Story, worlds: Worlds, series: Collection) -> bool:
    """Whether each row stands at the time of its state: from the one before any step on, or by mj_forward after every step."""
    if series.time is None or series.acceleration is None or len(series.time) < 2:
        return False
    if story.lag == -1:
        return bool(abs(series.time[0] - worlds.timestep) < _TIME_ATOL)
    first = worlds.series[story.world][0][0]
    at_once = np.abs(series.acceleration[0] - first).max() <= diagnosis.ATOL_ACCELERATION
    return bool(at_once and abs(series.time[0]) < _TIME_ATOL and abs(series.time[1] - worlds.timestep) < _TIME_ATOL)


def _same_physics(story: Story, worlds: Worlds, series: Collection) -> None:
    """A model that was changed for the run and put back: what is left changed is charged by starts_from_reset."""
    claim = worlds.claim
    if story.world != diagnosis.CLAIMED_WORLD or claim is None or series.changed:
        return
    if abs(claim.timestep - worlds.timestep) > _SAME_START:
        got = f"rows of a simulation with a time step of {claim.timestep:g} s"
        raise Lost(
            f"a simulation with the model's time step of {worlds.timestep:g} s", got, mistakes=["modifies-model"]
        )
    if np.abs(claim.gravity - np.array([0, 0, -9.81])).max() > 1e-3:
        raise Lost(
            "a simulation with the model's gravity",
            f"rows of one with {vector(claim.gravity)} m/s²",
            mistakes=["modifies-model"],
        )


def _rows_differ(series: Collection, worlds: Worlds) -> None:
    accel, gyro = worlds.series[TRUE_WORLD]
    assert series.acceleration is not None
    assert series.angular_velocity is not None
    n = min(len(series.acceleration), len(accel))
    if not (np.isfinite(series.acceleration).all() and np.isfinite(series.angular_velocity).all()):
        raise Lost("finite numbers", "NaN or infinity in the rows", mistakes=["not-finite"])
    in_accel, in_gyro = deviation(series.acceleration[:n], accel[:n]), deviation(series.angular_velocity[:n], gyro[:n])
    right = (in_accel.worst <= diagnosis.ATOL_ACCELERATION, in_gyro.worst <= diagnosis.ATOL_RATE)
    if all(right):
        rows = f"{n} row{'s' * (n != 1)}, then nothing"
        raise Lost(f"{worlds.steps} rows", rows, hint="Return after the loop, when all rows are stored (Step 3).")
    got, true, at, unit = (
        (series.angular_velocity, gyro, in_gyro, "rad/s")
        if right[0]
        else (series.acceleration, accel, in_accel, "m/s²")
    )
    raise Lost(
        f"{vector(true[at.row])} {unit} in row {at.row}",
        f"{vector(got[at.row])} (RMS difference over the series {at.rms:.3g} {unit})",
        keeps=0.5 if any(right) else 0.0,
        off=f"rows that differ by {at.rms:.3g} {unit} (RMS) over the series",
        hint="Compare your loop with Step 3: reset, push, then step, read and store, once each.",
    )


@check("data_collection.starts_from_reset", lab_step=3)
def check_starts_from_reset(student: Student, truth: Traces) -> None:
    """A run starts from the reset state, whatever happened before, and leaves the model as it was"""
    series = _dirty(student, truth)
    _has_rows(series)
    if series.changed:
        raise Lost(
            "a model that is the same afterwards", f"{', '.join(series.changed)} changed", mistakes=["modifies-model"]
        )
    push = _after_push(student, truth)
    left = diagnosis.rows_left(push), diagnosis.rows_left(_after_dirt(student, truth), push)
    if any(left):
        got = f"a series that begins with {max(left)} rows of the run before"
        raise Lost("the same series as from a fresh start", got, mistakes=["keeps-old-rows"])
    first, first_worlds = _story(student, truth, "push", _push(student, truth))
    story, worlds = _story(student, truth, "push_dirty", series)
    start = truth["reading_lab"]["qpos"][-1]
    goes_on = _time_goes_on(series, truth) or _starts_elsewhere(story, worlds, start)
    if goes_on or _other_velocity(story, worlds, push):
        got = "a series that goes on from where the data was left"
        raise Lost("the same series as from a fresh start", got, mistakes=["no-reset"])
    unknown = story is None and not diagnosis.tells(first or Story(), series, worlds)
    near = diagnosis.nearest(series, worlds) if unknown else TRUE_WORLD
    if near is None:
        raise Skipped(_RECOGNISABLE)
    if near == "no_reset" or _starts_elsewhere(first, first_worlds, start):
        accel = worlds.series[TRUE_WORLD][0]
        assert series.acceleration is not None
        wanted = f"{vector(accel[0])} m/s² in the first row, as from a fresh start"
        raise Lost(wanted, vector(series.acceleration[0]), off="another series than from a fresh start")


def _starts_elsewhere(story: Story | None, worlds: Worlds, start: Array) -> bool:
    """Whether a run is known to begin in another pose than the model's own (nq,)."""
    if story is None or story.world != diagnosis.CLAIMED_WORLD or worlds.claim is None:
        return story is not None and story.world == "no_reset"
    return bool(np.abs(worlds.claim.qpos - start).max() > _SAME_START)


def _other_velocity(story: Story | None, worlds: Worlds, push: Collection) -> bool:
    """Whether a run is known to begin with other velocities than the first run did: what an earlier one left stays in them."""
    if story is None or story.world != diagnosis.CLAIMED_WORLD or worlds.claim is None or not push.first_step:
        return False
    return bool(np.abs(worlds.claim.qvel - push.first_step["qvel"]).max() > _SAME_START)


def _time_goes_on(series: Collection, truth: Traces) -> bool:
    left_at = float(truth["push_dirty"]["dirty_time"])
    return series.time is not None and len(series.time) > 0 and abs(series.time[0] - left_at) < 0.5 * left_at


@check("data_collection.applies_push", lab_step=3)
def check_applies_push(student: Student, truth: Traces) -> None:
    """The run starts with the push of the sheet: 0.5 m/s forward"""
    series = _push(student, truth)
    _has_rows(series)
    story, worlds = _story(student, truth, "push", series)
    world = diagnosis.nearest(series, worlds) if story is None else story.world
    if world is None:
        raise Skipped(_RECOGNISABLE)
    if world == "no_push":
        mistake = "no-perturbation" if story else "wrong-perturbation"
        raise Lost("data.qvel[0] = 0.5 after the reset", "a series that starts without a push", mistakes=[mistake])
    if world == diagnosis.CLAIMED_WORLD:
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
    if not len(pushed):
        raise Lost("data.qvel[0] = 0.5 after the reset", "a series without a push", mistakes=["no-perturbation"])
    if len(pushed) != 1 or pushed[0] != 0 or abs(claim.qvel[0] - 0.5) > _SAME_START:
        words = ", ".join(f"qvel[{i}] = {claim.qvel[i]:.3g}" for i in pushed[:3]) + (" …" if len(pushed) > 3 else "")
        got = f"a series that starts with {words}"
        raise Lost("data.qvel[0] = 0.5 after the reset", got, mistakes=["wrong-perturbation"])


# --- what the checks share -----------------------------------------------------------------------------------------------


def _push(student: Student, truth: Traces) -> Collection:
    """The series after the push, without rows of earlier runs: starts_from_reset charges those."""
    series = _after_push(student, truth)
    return series.rows(diagnosis.rows_left(series))


def _dirty(student: Student, truth: Traces) -> Collection:
    """The series from a state that was left by an earlier run, without rows of that."""
    series = _after_dirt(student, truth)
    return series.rows(diagnosis.rows_left(series, _after_push(student, truth)))


def _after_push(student: Student, truth: Traces) -> Collection:
    scalars = truth["push"].scalars
    series = student.simulate("push", duration_s=float(scalars["duration_s"]), ids=torso_ids(truth))
    raised(series.fault, "collecting data")
    return series


def _after_dirt(student: Student, truth: Traces) -> Collection:
    scenario = truth["push_dirty"]
    scalars = scenario.scalars
    dirty = (scenario["dirty_qpos"], scenario["dirty_qvel"], float(scenario["dirty_time"]))
    series = student.simulate(
        "push_dirty",
        duration_s=float(scalars["duration_s"]),
        ids=torso_ids(truth),
        timestep=float(scalars["timestep"]),
        dirty=dirty,
    )
    raised(series.fault, "collecting data with another time step, from a state that was left by an earlier run")
    return series


def torso_ids(truth: Traces) -> tuple[int, int]:
    """Ids of the torso's accelerometer and gyroscope in the lab model."""
    accel, gyro = (int(i) for i in truth["reading_lab"]["pairs"][0])
    return accel, gyro


def _story(student: Student, truth: Traces, name: str, series: Collection) -> tuple[Story | None, Worlds]:
    """What explains a series, and the worlds that were tried: those of the traces, then the one that the box claims.

    The claim is simulated again by a worker that has never seen the submission, and counts only if the rows are the same.
    """
    worlds = Worlds.of(truth[name])
    if not _complete(series):
        return None, worlds
    story = diagnosis.explain(series, worlds)
    if story is None and series.first_step:
        qpos, qvel, gravity, force = (series.first_step[key] for key in ("qpos", "qvel", "gravity", "force"))
        claim = Claim(qpos, qvel, gravity, float(series.first_step["timestep"][0]), force)
        steps = min(_length(series) + 2, _LONGEST_REPLAY)
        runs = [student.replay(series.first_step, steps, held=held) for held in (False, True)]
        address, pairs = (np.asarray(truth["reading_lab"][key], int) for key in ("sensor_adr", "pairs"))
        if runs[0] is not None and runs[1] is not None:
            worlds = diagnosis.with_claim(worlds, claim, runs[0], runs[1], address, pairs)
            story = diagnosis.explain(series, worlds)
    return story, worlds


def _complete(series: Collection) -> bool:
    return series.acceleration is not None and series.angular_velocity is not None


def _has_rows(series: Collection) -> None:
    if series.acceleration is None or series.angular_velocity is None:
        raise Skipped("accelerations and angular velocities, which the returned value does not hold")


def _arrays(series: Collection) -> tuple[np.ndarray | None, ...]:
    return series.time, series.acceleration, series.angular_velocity


def _length(series: Collection) -> int:
    return next((len(a) for a in (series.acceleration, series.angular_velocity, series.time) if a is not None), 0)
