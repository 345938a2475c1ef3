"""The recordings that the checks of data collection ask for, and the stories that explain them."""

from __future__ import annotations

import numpy as np

from grader.engine.findings import Skipped, raised
from grader.engine.traces import Traces

from .answers import SENSORS, Collection
from .compare import Array
from .diagnosis import collection as diagnosis
from .diagnosis.collection import Claim, Story, Worlds
from .lab_copies import learnt_ids
from .student import Student

_LONGEST_REPLAY = 3000
FOLLOWING = "a recording of the simulation: these rows do not change when the robot's motion changes"
_LEANING_S = 0.5
_LEAN = 1.2
"""m/s² by which gravity leans, once, to see whether the rows follow: the robot sways and has no time to fall."""


def pushed(student: Student, truth: Traces) -> Collection:
    """The series after the push, without rows of earlier runs: starts_from_reset charges those."""
    series = after_push(student, truth)
    return series.rows(diagnosis.rows_left(series))


def from_dirt(student: Student, truth: Traces) -> Collection:
    """The series from a state that was left by an earlier run, without rows of that."""
    series = after_dirt(student, truth)
    return series.rows(diagnosis.rows_left(series, after_push(student, truth)))


def after_push(student: Student, truth: Traces) -> Collection:
    scalars = truth["push"].scalars
    series = student.simulate(duration_s=float(scalars["duration_s"]), ids=torso_ids(truth), called="push")
    raised(series.fault, "collecting data")
    return series.with_last_for_all().with_gap()


def after_dirt(student: Student, truth: Traces) -> Collection:
    scenario = truth["push_dirty"]
    scalars = scenario.scalars
    dirty = (scenario["dirty_qpos"], scenario["dirty_qvel"], float(scenario["dirty_time"]))
    series = student.simulate(
        duration_s=float(scalars["duration_s"]),
        ids=torso_ids(truth),
        timestep=float(scalars["timestep"]),
        dirty=dirty,
    )
    raised(series.fault, "collecting data with another time step, after an earlier run")
    return series.with_last_for_all().with_gap()


def torso_ids(truth: Traces) -> tuple[int, int]:
    """Ids of the accelerometer and gyroscope that are graded: the torso's in the lab model."""
    accel, gyro = (int(i) for i in truth["reading_lab"]["pairs"][0])
    return accel, gyro


def story_of(student: Student, truth: Traces, name: str, series: Collection) -> tuple[Story | None, Worlds]:
    """Return the explanation of a series, and the worlds that were tried: those of the traces, then the claimed one.

    The claim is simulated again by a worker that has never seen the submission, and counts only if the rows are the same.
    """
    worlds = Worlds.of(truth[name])
    if not complete(series):
        return None, worlds
    story = diagnosis.explain(series, worlds)
    if (story is None or story.exchanged) and series.first_step:
        worlds = _with_claim(student, truth, series, worlds)
        story = (
            diagnosis.explain(series, worlds) or story
        )  # where a claim tells the same as a known world, that one tells it
    if (story is None or story.of_other_sensors) and worlds.claim is not None:
        worlds = _with_own_reader(student, truth, series, worlds)
        if (own := Story(diagnosis.OWN_WORLD)).fits((series, worlds)):
            return own, worlds
    return story or diagnosis.explain(series, worlds) or diagnosis.explain_altered(series, worlds), worlds


def _with_own_reader(student: Student, truth: Traces, series: Collection, worlds: Worlds) -> Worlds:
    steps = len(worlds.series[diagnosis.CLAIMED_WORLD][0])
    rows = student.read_along(series.first_step, steps, torso_ids(truth))
    empty = np.full((steps, 6), np.nan)
    return diagnosis.with_own_reader(worlds, empty if rows is None else rows)


def _with_claim(student: Student, truth: Traces, series: Collection, worlds: Worlds) -> Worlds:
    run = student.replay(series.first_step, min(int(series.first_step["steps"][0]) + 2, _LONGEST_REPLAY))
    if run is None:
        return worlds
    address, pairs = (np.asarray(truth["reading_lab"][key], int) for key in ("sensor_adr", "pairs"))
    return diagnosis.with_claim(worlds, Claim.of(series.first_step), run, address, pairs, learnt_ids(truth))


def recognised(student: Student, truth: Traces, series: Collection, worlds: Worlds) -> str:
    """The world that rows come from which no story predicts: a known one that they are near, else the one that the sandbox claims.

    Rows that do not follow the simulation come from none, however near they are to one.
    """
    follows = one_row_follows if all_alike(series) else follows_simulation
    if worlds.claim is None or not follows(student, truth):
        raise Skipped(FOLLOWING)
    return diagnosis.nearest(series, worlds) or diagnosis.CLAIMED_WORLD


def follows_simulation(student: Student, truth: Traces) -> bool:
    """Ask once more with a gravity that leans, and hold both runs against ours from the states that they started in."""
    first, second = (_beside_ours(student, truth, each) for each in (pushed(student, truth), _leaning(student, truth)))
    return first is not None and second is not None and diagnosis.follows(*first, *second)


def _leaning(student: Student, truth: Traces) -> Collection:
    """The push under a gravity that leans by what is drawn with the scenario: nobody has recorded this run."""
    sideways = np.asarray(truth["push_dirty"]["dirty_qvel"][:2])
    gravity = np.array([*(_LEAN * sideways / np.linalg.norm(sideways)), -9.81 - _LEAN])
    return student.simulate(duration_s=_LEANING_S, ids=torso_ids(truth), gravity=gravity).with_last_for_all()


def _beside_ours(student: Student, truth: Traces, series: Collection) -> tuple[Array, Array] | None:
    """Accelerations (n, 3) of a run of theirs, and of a run of ours from the state in which theirs is said to begin."""
    if not series.first_step or series.acceleration is None or not len(series.acceleration):
        return None
    ours = student.replay(series.first_step, min(len(series.acceleration), _LONGEST_REPLAY))
    address = int(np.asarray(truth["reading_lab"]["sensor_adr"])[torso_ids(truth)[0]])
    return None if ours is None else (series.acceleration, ours[:, address : address + 3])


def complete(series: Collection) -> bool:
    return series.acceleration is not None and series.angular_velocity is not None


def has_rows(series: Collection) -> None:
    if not complete(series):
        raise Skipped("accelerations and angular velocities; the returned value does not have both")


def arrays_of(series: Collection) -> tuple[np.ndarray | None, ...]:
    return series.time, series.acceleration, series.angular_velocity


def length(series: Collection) -> int:
    return next((len(a) for a in (series.acceleration, series.angular_velocity, series.time) if a is not None), 0)


def all_alike(series: Collection) -> bool:
    """Return whether every row is the same: a robot that stands still moves a little, too."""
    there = [
        rows for key, rows in zip(SENSORS, series.sensors, strict=True) if rows is not None and key != series.absent
    ]
    return bool(there) and all(len(rows) > 1 and not np.ptp(rows, axis=0).any() for rows in there)


def one_row_follows(student: Student, truth: Traces) -> bool:
    """Return whether a series whose rows are all alike is another one where gravity leans."""
    series, leaning = pushed(student, truth), _leaning(student, truth)
    if series.acceleration is None or leaning.acceleration is None or not len(leaning.acceleration):
        return False
    return bool(np.abs(leaning.acceleration[0] - series.acceleration[0]).max() > _LEAN / 10)


def pushed_again(student: Student, truth: Traces) -> Collection:
    return student.simulate(duration_s=_LEANING_S, ids=torso_ids(truth))
