"""Extension: a plot that grows while the simulation steps, judged by what its curves showed and when."""

from __future__ import annotations

from grader.engine.check_runner import check
from grader.engine.findings import CheckFailed, Skipped, raised
from grader.engine.traces import Traces
from grader.labs.imu.diagnosis import liveplot
from grader.labs.imu.recordings import torso_ids
from grader.labs.imu.student import Student
from grader.labs.imu.student_bonuses import LiveRun, SeenCurve, live

_UPDATES = 4
"""In one second of simulation: a plot that is redrawn four times a second is the slowest that is still called live."""
_SPAN = 0.4
"""Share of the simulated time between the first and the last change of the curves."""
_JUDGED = 10  # points that a curve needs before it is held against the truth
_MOST = 24  # curves that are held against it, the latest ones


@check("realtime_visualization.returns")
def check_returns(student: Student, truth: Traces) -> None:
    """live_plot simulates for the time that it was asked for, and returns"""
    run = _run(student, truth)
    raised(run.fault, "plotting live")
    duration = float(truth["watched"].scalars["duration_s"])
    if run.simulated < 0.9 * duration:
        raise CheckFailed(
            f"{duration:g} s of simulation", f"{run.simulated:.3g} s", keeps=0.5 if run.simulated > 0 else 0.0
        )


@check("realtime_visualization.grows_while_stepping")
def check_grows_while_stepping(student: Student, truth: Traces) -> None:
    """The curves grow while the simulation goes on, not after it"""
    run = _run(student, truth)
    raised(run.fault, "plotting live")
    duration = float(truth["watched"].scalars["duration_s"])
    updates = liveplot.updates(run.events)
    if updates >= _UPDATES and liveplot.span(run.events) >= _SPAN * duration:
        return
    once = len(run.events) <= 2
    replayed = liveplot.changes_after(run.events) >= _UPDATES
    hint = (
        "The curves grow only after the simulation. Call mj_step between two updates of the plot, not before the first."
        if replayed
        else ""
    )
    raise CheckFailed(
        f"curves that change at least {_UPDATES} times in {duration:g} s of simulation",
        f"{updates} changes during the simulation",
        mistakes=["plot-not-live"] if once else [],
        keeps=0.5 if updates >= _UPDATES - 2 and not once and not replayed else 0.0,
        hint=hint,
    )


@check("realtime_visualization.shows_true_data")
def check_shows_true_data(student: Student, truth: Traces) -> None:
    """The curves show what the IMU reads"""
    run = _run(student, truth)
    raised(run.fault, "plotting live")
    if not len(run.events):
        raise Skipped("a curve on a figure that is shown")
    judged = [curve for curve in run.curves if len(curve.y) >= _JUDGED][-_MOST:]
    if not judged:
        raise CheckFailed(f"curves of {_JUDGED} points or more", "none", mistakes=["curves-missing"])
    right = sum(_is_true(curve, truth) for curve in judged)
    if right * 2 < len(judged):
        got = f"{right} of {len(judged)} curves that follow one of its channels"
        raise CheckFailed(
            "curves that follow the readings of an IMU",
            got,
            mistakes=[] if right else ["wrong-data-plotted"],
            keeps=0.5 if right else 0.0,
        )


def _is_true(curve: SeenCurve, truth: Traces) -> bool:
    """Return whether it follows a channel of a robot that was pushed, or that was reset and rests."""
    watched = truth["watched"]
    dt = float(watched.scalars["timestep"])
    return any(liveplot.shows(curve.x, curve.y, watched[kind], dt) for kind in ("pushed", "still"))


# --- what the checks share -----------------------------------------------------------------------------------------------


def _run(student: Student, truth: Traces) -> LiveRun:
    scalars = truth["watched"].scalars
    return live(
        student,
        model=truth.models["lab"],
        ids=torso_ids(truth),
        duration_s=float(scalars["duration_s"]),
        timestep=float(scalars["timestep"]),
        push=float(scalars["push_mps"]),
    )
