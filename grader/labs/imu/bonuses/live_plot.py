"""The extension *Live plot*: the growth of its curves against simulated time, and the sensor readings that they follow."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from grader.engine.charging import Judge
from grader.engine.findings import Raised, Skipped, StudentError
from grader.engine.hypothesis import Reason
from grader.engine.question import Question
from grader.engine.traces import Traces
from grader.labs.imu.compare import Array
from grader.labs.imu.lab import LAB
from grader.labs.imu.robot import torso_ids
from grader.labs.imu.student import Student
from grader.sandbox.wire import Frame

UPDATES = 4
"""Changes of the curves in one second of simulation; a plot that is redrawn less often is not called live."""
SPAN = 0.4
"""Least share of the simulated time between the first and the last change of the curves."""
_EXACT = 1e-3
"""m/s², rad/s. Simulations on two machines differ by 1e-6 here; neighbouring channels by far more."""
_NOISY = np.repeat([0.9, 0.1], 3)
"""m/s², rad/s. What the sheet's noise and bias add at most, once in a billion readings: 6 × 0.05 + 6 × 0.1 and a tenth of it."""
_LONGEST_STRIDE = 60
_FEWEST = 8  # readings in a row that are no coincidence
_LATEST = 1e6  # s; beyond, nothing is a time of this simulation
_OWN_ROWS = 0.25
"""Least share of rows among a curve's points: 1 for a curve of all readings, 1/3 where each is drawn three times. Where seconds are
taken for milliseconds it is 1/1000, and 1/16 of every sixtieth reading: those rows are all of a robot at rest, and any
line is near them."""
_SCALES = (1.0, float(np.degrees(1.0)))

# ---- the question


@dataclass(frozen=True)
class LiveRun:
    """Facts about a student's `live_plot`, seen while it ran.

    Attributes
    ----------
    events : (k, 3) ndarray, each time that the curves had changed: seconds simulated, points drawn, changes so far
    curves : a pair x, y of (n,) arrays for each curve at each of a few moments spread over the run, in order of time
    simulated : simulated time in all, in seconds
    """

    events: Array
    curves: tuple[tuple[Array, Array], ...]
    simulated: float
    error: StudentError | None = None

    @property
    def updates(self) -> int:
        """Number of moments of simulated time at which the curves had changed; a live plot has many."""
        return len(np.unique(self.events[self.events[:, 0] > 0, 0]))

    @property
    def changes_after(self) -> int:
        """Number of changes of the curves at the latest simulated time; if many, they were drawn after the simulation."""
        moments = self.events[:, 0]
        return int(np.count_nonzero(moments == moments.max(initial=0.0)))

    @property
    def span(self) -> float:
        """Simulated time (s) between the first and the last change of the curves; 0 if they never changed."""
        return float(np.ptp(self.events[:, 0])) if len(self.events) else 0.0


def live(
    student: Student, *, model: str, ids: tuple[int, int], duration_s: float, timestep: float, push: float
) -> LiveRun:
    """Ask the student's `live_plot` for `duration_s` of simulated time; return what it drew and, in `error`, what it raised.

    The robot of `model` (MJCF text) starts with ``qvel[0] = push`` (m/s), so that it moves; its time step is set to `timestep` (s).
    `ids` are the sensor ids of accelerometer and gyroscope, for code that reads ids as arguments or globals.
    """
    fields = {
        "model": model, "accel_id": ids[0], "gyro_id": ids[1], "duration_s": duration_s, "timestep": timestep, "push": push
    }  # fmt: skip
    return student.answer(Question("live", "live_plot", _run, fields))


def _run(frame: Frame) -> LiveRun:
    answer, arrays = frame.fields, frame.arrays
    curves = tuple((arrays[curve["x"]], arrays[curve["y"]]) for curve in answer["curves"])
    return LiveRun(arrays["events"], curves, float(answer["simulated"]), StudentError.of(answer.get("error")))


# ---- what a curve follows


def shows(x: Array, y: Array, channels: Array, dt: float) -> bool:
    """Return whether a curve (n,) follows one of the columns of `channels` (m, c): each IMU's true readings every `dt` seconds.

    An IMU has six columns: three axes of the accelerometer, then three of the gyroscope. Angular velocity may be drawn in degrees
    per second; the first IMU's readings may have the noise and bias of the lab sheet.
    """
    finite = np.isfinite(x) & np.isfinite(y)
    x, y = x[finite], y[finite]
    rows = list(_rows(x, len(channels), dt))
    if any(_noisy(y[inside], channels[row]) for inside, row in rows):
        return True
    exact = any(_exact(y[inside] / scale, channels[row]) for inside, row in rows for scale in _SCALES)
    return exact or any(_by_order(y / scale, channels) for scale in _SCALES)


def _rows(x: Array, count: int, dt: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield ways to match the points of a curve (a mask) to rows of the truth: x in s or ms, stamped before or after the step."""
    for unit in (1.0, 1e-3):
        for shift in (-1, 0):
            row = np.round(np.clip(x * unit, -_LATEST, _LATEST) / dt).astype(np.int64) + shift
            inside = (row >= 0) & (row < count)
            many = inside.sum() >= max(3, 0.9 * len(x))
            if many and len(np.unique(row[inside])) > _OWN_ROWS * inside.sum():
                yield inside, row[inside]


def _exact(y: Array, truth: Array) -> bool:
    """Return whether y (n,) is a column of the truth (n, c)."""
    return bool(np.any(np.abs(truth - y[:, None]).max(axis=0) <= _EXACT))


def _noisy(y: Array, truth: Array) -> bool:
    """Return whether y (n,) is a column of the first IMU's truth (n, 6 or more) beside noise; False for a line that never moves."""
    own = truth[:, :6]
    close = np.abs(own - y[:, None]).max(axis=0) <= _NOISY
    moving = own.std(axis=0) > _NOISY / 3
    return bool(np.any(close & np.where(moving, _correlation(y, own) > 0.8, np.std(y) > 10 * _EXACT)))


def _correlation(y: Array, truth: Array) -> Array:
    a, b = y - y.mean(), truth - truth.mean(axis=0)
    power = np.sqrt((a**2).sum() * (b**2).sum(axis=0))
    return np.asarray((a @ b) / np.where(power > 0, power, np.inf))


def _by_order(y: Array, channels: Array) -> bool:
    """Return whether y (n,) ends in every s-th reading of a channel in order, for some s, whatever its x values are.

    Points before the channel's first reading do not count: the code filled them in. False for a line that is flat at its end.
    """
    if len(y) < _FEWEST or np.ptp(y[-_FEWEST:]) <= 10 * _EXACT:
        return False  # a flat line is like any channel that rests
    return any(_in_order(y, column) for column in channels.T)


def _in_order(y: Array, column: Array) -> bool:
    """Return whether the last points of a curve are samples of a column in order, every s-th one for some s."""
    ends = np.flatnonzero(np.abs(column - y[-1]) <= _EXACT)[:, None]
    strides = np.arange(1, _LONGEST_STRIDE + 1)
    fits = ends - (_FEWEST - 1) * strides >= 0
    for back in range(1, _FEWEST):
        place = np.where(fits, ends - back * strides, 0)
        fits &= np.abs(column[place] - y[-1 - back]) <= _EXACT
    return any(_all_in_order(y, column, int(ends[row, 0]), int(strides[which])) for row, which in np.argwhere(fits))


def _all_in_order(y: Array, column: Array, end: int, stride: int) -> bool:
    steps = min(len(y), end // stride + 1)
    return bool(np.abs(y[::-1][:steps] - column[end - stride * np.arange(steps)]).max() <= _EXACT)


# ---- the facts, and the faults


@dataclass(frozen=True)
class Live:
    """All that is measured of a `live_plot`: `measure` makes it, and checks and diagnosis read nothing else.

    Attributes
    ----------
    run : what was seen while it ran
    duration_s, timestep : the time that it was asked to simulate, and the time between rows of `channels`, in s
    channels : two arrays (m, c) of true readings: of a robot that was pushed, and of one that was reset and rests
    """

    run: LiveRun
    duration_s: float
    timestep: float
    channels: Sequence[Array] = ()
    stopped: Mapping[str, Exception] = field(default_factory=dict)

    @property
    def shows_once(self) -> bool:
        return len(self.run.events) <= 2 and self.run.updates < UPDATES


def measure(student: Student, truth: Traces) -> Live:
    """Run the student's live plot once, on a robot that is pushed; return what it drew, with the true readings."""
    watched = truth["watched"]
    duration, timestep, push = (float(watched.scalars[name]) for name in ("duration_s", "timestep", "push_mps"))
    ids = torso_ids(truth)
    run = live(student, model=truth.models["lab"], ids=ids, duration_s=duration, timestep=timestep, push=push)
    stopped: dict[str, Exception] = {}
    if run.error:
        raised = Raised(run.error, "plotting live")
        stopped = dict.fromkeys(("returns", "grows_while_stepping", "shows_true_data"), raised)
    elif not len(run.events):
        stopped["shows_true_data"] = Skipped("a curve on a figure that is shown")
    return Live(run, duration, timestep, (watched["pushed"], watched["still"]), stopped)


_REASONS: tuple[Reason[Live], ...] = (
    Reason("grows_while_stepping", 1, "plot-not-live", lambda facts: facts.shows_once),
)
LIVE: Judge[Live] = Judge(LAB, "realtime_visualization", measure, _REASONS)
