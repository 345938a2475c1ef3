"""Facts about `simulate_and_collect`: its recordings, and the simulated runs that their rows may come from."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from grader.base.errors import NoAnswer
from grader.engine.findings import Missing, Raised, raised
from grader.engine.traces import Scenario, Traces
from grader.labs.imu.collection import SENSORS, Collection
from grader.labs.imu.compare import Array, share_among, triple
from grader.labs.imu.lab_copies import learnt_ids, learnt_timestep
from grader.labs.imu.robot import torso_ids
from grader.labs.imu.student import Student

ATOL_ACCELERATION = 2e-3
ATOL_RATE = 2e-4
"""m/s², rad/s. The same steps on the same machine repeat to 1e-9; an extra mj_forward before the first step or the use of
mj_step1/mj_step2 stays below 1e-6. A lag of one sample after the push moves the series by more than 0.01 m/s²."""
TIME_ATOL = 1e-6
"""s. Adding a time step 5,000 times errs by 1e-12 s, and single precision by 1e-7 s at 3 s."""
FEWEST_ROWS = 20
"""Rows that a hypothesis has to predict, unless fewer are all that there is."""
FORM = "a dictionary with 'time' (n,), 'acceleration' (n, 3), 'angular_velocity' (n, 3)"
SAME_STATE = 1e-9
"""A claimed state is reported in full precision: whatever differs by more was set to another number."""

TRUE_WORLD = "truth"
CLAIMED_WORLD = "claimed"
OWN_WORLD = "as the own reader reads it"
LAST_SENSOR = "the model's last sensor"
OTHER_IMU = "another IMU"
LEARNT_IDS = "the sensors whose ids are the torso's in the students' model"

_LONGEST_REPLAY = 3000
_LEANING_S = 0.5
_LEAN = 1.2
"""m/s² by which gravity leans, once, to see whether the rows follow: the robot sways and has no time to fall."""


@dataclass(frozen=True)
class Claim:
    """Start of a run as the worker reports it. Student code may have falsified it: only a simulation that gives the rows proves it.

    Attributes
    ----------
    qpos, qvel : the state before the first step; gravity : (3,); timestep : seconds
    force : forces that the code applied at the start: MuJoCo's `qfrc_applied` and `xfrc_applied` joined
    set_at : (m,) later steps before which the code set the state again; set_qvel : (m, nv) the velocities that it set then
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
        """Make a claim from `course`, what the student's process reports of its run: an array for each field, `timestep` (1,)."""
        names = ("qpos", "qvel", "gravity", "force", "set_at", "set_qvel")
        return cls(timestep=float(course["timestep"][0]), **{name: course[name] for name in names})

    @property
    def without_push(self) -> bool:
        return not (self.force.any() or len(self.set_at) or differ(self.qvel, 0.0))

    @property
    def push(self) -> str:
        """How the run starts, in words, if not with the lab sheet's push (``qvel[0] = 0.5``, once, at the first step); else ""."""
        pushed = np.flatnonzero(np.abs(self.qvel) > SAME_STATE)
        later = f"before step {self.set_at[0] + 1:.0f}" if len(self.set_at) else ""
        if self.force.any():
            return f"a recording with a force of up to {np.abs(self.force).max():.3g} N or Nm"
        if not len(pushed):
            return f"a velocity that is set {later}, and not at the start" if later else "a recording without a push"
        if list(pushed) != [0] or differ(self.qvel[0], 0.5):
            return f"a recording that starts with {velocities_in_words(self.qvel)}"
        times = "once" if len(self.set_at) == 1 else f"{len(self.set_at)} times"
        return f"qpos, qvel or a force set {times} while the simulation runs, first {later}" if later else ""


def differ(a: Array, b: Array | float) -> bool:
    """Return whether state `a` differs from `b` (a state, or one number for all) by more than rounding; if so, code set it."""
    return bool(np.abs(a - b).max(initial=0.0) > SAME_STATE)


def velocities_in_words(qvel: Array) -> str:
    pushed = np.flatnonzero(np.abs(qvel) > SAME_STATE)
    pushes = ", ".join(f"qvel[{i}] = {qvel[i]:.3g}" for i in pushed[:3]) + (" …" if len(pushed) > 3 else "")
    return pushes or "no velocity"


@dataclass(frozen=True)
class Run:
    """One recording of a student's `simulate_and_collect`, and the simulated runs (worlds) that its rows may come from.

    Attributes
    ----------
    series : the recording; recorded : the same with `left` more rows at its start, which the code kept from earlier runs
    worlds : sensor values in each simulated run: name -> (acceleration, angular velocity), each (rows, 3)
    duration_s, model_timestep : duration and time step (s) that the function was called with
    model_steps : the number of steps in this duration
    claim : the start from which worlds were simulated besides `TRUE_WORLD`, the run of right code; None if there are no such worlds
    """

    series: Collection
    worlds: Mapping[str, tuple[Array, Array]]
    duration_s: float
    model_timestep: float
    model_steps: int
    recorded: Collection
    left: int = 0
    claim: Claim | None = None

    @property
    def timestep(self) -> float:
        """Time step (s) reported for the start, if it is reported and the call left the model's changed; else `model_timestep`."""
        changed = "opt.timestep" in self.series.changed and "timestep" in self.series.first_step
        return float(self.series.first_step["timestep"][0]) if changed else self.model_timestep

    @property
    def steps(self) -> int:
        """Number of rows expected, one a step: `model_steps`, or `duration_s / timestep` rounded, if code changed the time step."""
        changed = self.timestep != self.model_timestep and self.timestep > 0
        return round(self.duration_s / self.timestep) if changed else self.model_steps

    @property
    def length(self) -> int:
        arrays = (*self.series.sensors, self.series.time)
        return next((len(each) for each in arrays if each is not None), 0)


@dataclass(frozen=True)
class Facts:
    """Facts measured of one student's `simulate_and_collect`, before anything is judged.

    Attributes
    ----------
    push : the run with the lab sheet's push, the first recording
    later : a second one, of another length and time step, on simulation data that earlier steps left moving; None if it failed
    start : (nq,) pose of the reset robot; gravity : (3,) of the model
    learnt_timestep : time step (s) of the model that students have, which code may hold as a constant
    left_at : time (s) in the simulation data when `later` was asked for; code that does not reset it goes on from there
    follows : whether the rows of `push` change as the robot's motion does; False for rows stored in the file
    velocities : (2, nv) at the start of two runs with the sheet's push; empty if they were not asked for
    stopped : by name of a check, the exception that kept its property from being measured
    """

    push: Run
    later: Run | None
    start: Array
    gravity: Array
    learnt_timestep: float
    left_at: float
    follows: bool = True
    velocities: tuple[Array, ...] = ()
    stopped: Mapping[str, Exception] = field(default_factory=dict)

    @property
    def runs(self) -> tuple[Run, ...]:
        """The runs that the student's function recorded: the first and, if it succeeded, one of another duration and time step."""
        return (self.push,) if self.later is None else (self.push, self.later)


def facts_of(truth: Traces, push: Run, later: Run | None, **more: Any) -> Facts:
    """Return the facts of two runs of the student's recorder: `push`, and `later` (on unreset data), None if it failed.

    Pose, gravity and times come from `truth`; `more` sets other fields.
    """
    lab, left_at = truth["reading_lab"], float(truth["push_dirty"]["dirty_time"])
    gravity = np.asarray(lab.scalars["gravity"], float)
    return Facts(push, later, lab["qpos"][-1], gravity, learnt_timestep(truth), left_at, **more)


# ---- questions


def asked(student: Student, truth: Traces, name: str) -> Collection:
    """Have student code record "push" or "push_dirty" (other time step, data not reset); return all rows, or none and `error`."""
    scenario = truth[name]
    duration_s, timestep = (float(scenario.scalars[key]) for key in ("duration_s", "timestep"))
    if name == "push":
        series = student.simulate(duration_s=duration_s, ids=torso_ids(truth), called="push")
    else:
        dirty = (scenario["dirty_qpos"], scenario["dirty_qvel"], float(scenario["dirty_time"]))
        series = student.simulate(duration_s=duration_s, ids=torso_ids(truth), timestep=timestep, dirty=dirty)
    return series.with_last_for_all().with_gap()


def recordings(student: Student, truth: Traces, tell: Callable[[str], None]) -> dict[str, Collection]:
    """Return what `simulate_and_collect` records, by scenario, for plots; call `tell` with the reason if a recording is missing."""
    own = {}
    for scenario in ("push", "push_dirty"):
        try:
            series = asked(student, truth, scenario)
            raised(series.error, "collecting data")
            own[scenario] = series
        except (Missing, NoAnswer, Raised) as why:
            tell(f"{scenario}: {why}")
    return own


def run(student: Student, truth: Traces, name: str, before: Run | None = None) -> Run:
    """Return the student's recording of the scenario `name`, without rows that the code kept from the run `before` (None: no run).

    If the code raises, the run has no rows, and the exception is in `series.error`.
    """
    return _run(asked(student, truth, name), truth[name], before.recorded if before else None)


def _run(series: Collection, scenario: Scenario, before: Collection | None = None) -> Run:
    left, scalars = rows_left(series, before), scenario.scalars
    asked = float(scalars["duration_s"]), float(scalars["timestep"]), int(scalars["n_steps"])
    true = scenario["acceleration"], scenario["angular_velocity"]
    return Run(series.rows(left), {TRUE_WORLD: true}, *asked, series, left)


def with_claim(student: Student, truth: Traces, run: Run) -> Run:
    """Return the run with simulated runs (worlds) from the start that the worker reported, one of which may explain the rows.

    No student code runs. The worlds differ in the sensors that are read: the right ones, those of another IMU, the last one
    (id -1), or those with the ids of the students' model. Without a reported start that can be simulated, the run is unchanged.
    """
    start = run.series.first_step
    if not start:
        return run
    rows = student.replay(start, min(int(start["steps"][0]) + 2, _LONGEST_REPLAY))
    if rows is None:
        return run
    address, pairs = (np.asarray(truth["reading_lab"][key], int) for key in ("sensor_adr", "pairs"))
    (accel, gyro), *others = address[pairs].tolist()
    series = {CLAIMED_WORLD: (triple(rows, accel), triple(rows, gyro))}
    for number, pair in enumerate(others):
        series[f"{OTHER_IMU} {number}"] = triple(rows, pair[0]), triple(rows, pair[1])
    if tuple(pairs[0]) != (learnt := learnt_ids(truth)):
        series[LEARNT_IDS] = triple(rows, int(address[learnt[0]])), triple(rows, int(address[learnt[1]]))
    if np.isfinite(last := triple(rows, int(address[-1]))).all():
        series[LAST_SENSOR] = last, last
    return replace(run, worlds={**run.worlds, **series}, claim=Claim.of(start))


def with_assumed_starts(student: Student, truth: Traces, run: Run, name: str) -> Iterator[Run]:
    """Yield copies of `run`, each with runs (`worlds`) simulated from a likely wrong start: no push, another push, or no reset.

    `name` is the run's scenario. Use it for runs that report no start: `mujoco.rollout`, for one, hides its steps from the worker.
    """
    lab, scenario = truth["reading_lab"], truth[name]
    rest, still = lab["qpos"][-1], np.zeros(lab["qvel"].shape[1])
    left = [(scenario["dirty_qpos"], scenario["dirty_qvel"], 0, _PUSH)] if "dirty_qpos" in scenario else []
    common = {"gravity": lab.scalars["gravity"], "timestep": [run.model_timestep], "steps": [run.model_steps]}
    never = {"set_at": np.zeros(0), **{f"set_{key}": np.zeros((0, 1)) for key in ("qpos", "qvel", "force")}}
    pushes = [(rest, still, axis, velocity) for axis, velocity in _OTHER_PUSHES if axis < len(still)]
    for qpos, qvel, axis, velocity in (*left, *pushes):
        pushed = np.array(qvel, float)
        pushed[axis] = velocity
        start = {"qpos": qpos, "qvel": pushed, "force": np.zeros(len(pushed) + 6), **common, **never}
        first_step = {key: np.asarray(value, float) for key, value in start.items()}
        yield with_claim(student, truth, replace(run, series=replace(run.series, first_step=first_step)))


_PUSH = 0.5
_OTHER_PUSHES = ((0, 0.0), (0, _PUSH / 2), (0, 2 * _PUSH), (0, -_PUSH), (1, _PUSH), (2, _PUSH))
"""Index of the velocity and its size (m/s): no push, and those that differ from the sheet's in size, sign or direction."""


def with_own_reader(student: Student, truth: Traces, run: Run) -> Run:
    """Return the run with another simulated run, from the start that the worker reported, read by the student's `get_imu_readings`.

    Rows that match it are no fault of the recording. If the function fails, the run is unchanged. `run` must have a `claim`.
    """
    steps = len(run.worlds[CLAIMED_WORLD][0])
    rows = student.read_along(run.series.first_step, steps, torso_ids(truth))
    return run if rows is None else replace(run, worlds={**run.worlds, OWN_WORLD: (rows[:, :3], rows[:, 3:])})


def follows_simulation(student: Student, truth: Traces, run: Run) -> bool:
    """Return whether the student's accelerations change with gravity as simulated ones do; False for rows stored in the file.

    A second recording, with tilted gravity, is compared with `run`; False if it fails, or if one of the two cannot be simulated. If
    all rows of `run` are equal, nothing is simulated: the first rows of the two recordings have to differ.
    """
    try:
        leaning = _record_leaning(student, truth)
    except NoAnswer:
        return False
    if all_alike(run.series):
        rows, others = run.series.acceleration, leaning.acceleration
        if rows is None or others is None or not len(others):
            return False
        return bool(np.abs(others[0] - rows[0]).max() > _LEAN / 10)
    first, second = (_with_simulation(student, truth, each) for each in (run.series, leaning))
    return first is not None and second is not None and follows(*first, *second)


def _record_leaning(student: Student, truth: Traces) -> Collection:
    """Return the student's recording of a short run with gravity tilted in a drawn direction, which no code can have stored."""
    sideways = np.asarray(truth["push_dirty"]["dirty_qvel"][:2])
    gravity = np.array([*(_LEAN * sideways / np.linalg.norm(sideways)), -9.81 - _LEAN])
    return student.simulate(duration_s=_LEANING_S, ids=torso_ids(truth), gravity=gravity).with_last_for_all()


def _with_simulation(student: Student, truth: Traces, series: Collection) -> tuple[Array, Array] | None:
    """Return the accelerations (n, 3) of a recording and of the grader's simulation from the same start; None if one is missing."""
    if not series.first_step or series.acceleration is None or not len(series.acceleration):
        return None
    ours = student.replay(series.first_step, min(len(series.acceleration), _LONGEST_REPLAY))
    address = int(np.asarray(truth["reading_lab"]["sensor_adr"])[torso_ids(truth)[0]])
    return None if ours is None else (series.acceleration, ours[:, address : address + 3])


def starting_velocities(student: Student, truth: Traces, push: Run) -> tuple[Array, ...]:
    """Record again; return the starting velocities (nv,) of `push` and this run, unlike if random; () if one reported no start."""
    again = student.simulate(duration_s=_LEANING_S, ids=torso_ids(truth))
    starts = [each.first_step for each in (push.series, again)]
    return tuple(start["qvel"] for start in starts) if all(starts) else ()


# ---- facts about rows


def complete(series: Collection) -> bool:
    return series.acceleration is not None and series.angular_velocity is not None


def all_alike(series: Collection) -> bool:
    """Return whether all rows are equal, which no simulation gives: even a standing robot moves a little."""
    pairs = zip(SENSORS, series.sensors, strict=True)
    there = [rows for key, rows in pairs if rows is not None and key != series.absent]
    return bool(there) and all(len(rows) > 1 and not np.ptp(rows, axis=0).any() for rows in there)


def rows_left(series: Collection, before: Collection | None = None) -> int:
    """Return how many first rows of a recording are left from earlier runs (or 0), as the submission's list outlives the call.

    Parameters
    ----------
    before : the earlier recording in the same process; None for the first one. If it is None or `series` does not begin with its
        rows, those before the last repetition of the first rows of `series` count: importing the file may have recorded them
    """
    if series.time is None or series.acceleration is None or series.angular_velocity is None:
        return 0
    n = min(len(series.time), len(series.acceleration), len(series.angular_velocity))
    kept = len(before.time) if before is not None and before.time is not None else 0
    if before is not None and 0 < kept < n and _alike(series, before, slice(kept), slice(kept)):
        return kept
    starts = np.flatnonzero(series.time[:n] == series.time[0])
    second, last = (int(starts[1]), int(starts[-1])) if len(starts) > 1 else (0, 0)
    shared = min(second, n - last)
    return last if shared >= FEWEST_ROWS and _alike(series, series, slice(shared), slice(last, last + shared)) else 0


def _alike(series: Collection, other: Collection, rows: slice, others: slice) -> bool:
    """Return whether `rows` of one recording were copied to `others` of another: they are equal, and not rows at rest."""
    pairs = ((series.acceleration, other.acceleration), (series.angular_velocity, other.angular_velocity))
    same_rows = all(
        a is not None and b is not None and np.array_equal(a[rows], b[others], equal_nan=True) for a, b in pairs
    )
    return same_rows and any(a is not None and bool(np.ptp(a[rows], axis=0).any()) for a, _ in pairs)


def follows(rows: Array, true: Array, other_rows: Array, other_true: Array) -> bool:
    """Return whether recorded rows (n, 3) change with the simulation, whatever linear map and offset code applies to them.

    `rows` were recorded and `true` simulated in one run, `other_rows` and `other_true` in another. A least-squares fit to the first
    run gives the map. It has to predict the rows of the other run with an error below half of the change between the runs. Stored
    rows do not change, so they fail. Rows in any order, late or repeated, pass if nearly all their numbers occur in `other_true`.
    """
    n, m = min(len(rows), len(true)), min(len(other_rows), len(other_true), len(rows), len(true))
    if m < FEWEST_ROWS or not (np.isfinite(rows[:n]).all() and np.isfinite(other_rows[:m]).all()):
        return False
    numbers = np.unique(other_rows)
    if len(numbers) >= _ENOUGH * other_true.size and share_among(numbers, other_true, _SAME_NUMBER) >= _NEARLY_ALL:
        return True
    first, second = (np.column_stack([one, np.ones(len(one))]) for one in (true[:n], other_true[:m]))
    treatment = np.linalg.lstsq(first, rows[:n], rcond=None)[0]
    change = (second - first[:m]) @ treatment
    left = other_rows[:m] - second @ treatment
    return bool(np.sum(left**2) < 0.25 * np.sum(change**2))


_NEARLY_ALL = 0.9
"""Share of the rows' numbers that have to occur in the simulation."""
_ENOUGH = 0.1
"""Share of the simulation's numbers that the rows have to hold. Rows that are stored five times hold a fifth; a few steps that are
simulated and repeated to the end are no recording."""
_SAME_NUMBER = 1e-7
"""m/s². Largest difference of equal numbers. Among some thousand values within 20 m/s², a wrong number is that close to one of
them once in ten thousand."""
