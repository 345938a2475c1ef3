"""Run the student's `live_plot` without a window, and record its curves against the simulated time."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from grader.worker import recorder, submission
from grader.worker.screen import Screen, open_figures, replaced
from grader.worker.values import Packer

from . import calls, own_globals
from .questions import Reply, model_of, reporting_errors

_MAX_EVENTS = 5000
_SNAPSHOTS = 8
_MAX_CURVES = 24
_MAX_POINTS = 5000
_FEWEST = 3  # smallest number of points of a curve; markers and lines across the panel have fewer

Curve = tuple[str, np.ndarray, np.ndarray]


def live(fields: dict[str, Any], arrays: dict[str, Any]) -> Reply:
    """Call `live_plot` on the lab model, pushed as in the lab sheet's Step 3; record what a window would show, but open none.

    Parameters
    ----------
    fields : ``path`` (the student's file), ``model`` (XML), ``duration_s``, ``timestep``, ``push`` (m/s), ``accel_id``, ``gyro_id``

    Returns
    -------
    array ``events`` (k, 3): simulated time (s), points drawn, number of changes of the curves so far; ``curves`` at a few
    moments: ``label``, ``x``, ``y`` (array names), ``moment`` (simulated s) of each; ``simulated``: simulated time (s) in all;
    ``returned``: False if the call, or an animation that it left to be shown, raised; ``error``: what was raised, if anything.
    """
    import mujoco

    del arrays
    function = submission.find("live_plot", fields["path"])
    model = model_of(fields["model"])
    model.opt.timestep = fields["timestep"]
    data = mujoco.MjData(model)
    data.qvel[0] = fields["push"]
    ids = {"accel": fields["accel_id"], "gyro": fields["gyro_id"]}
    own_globals.provide_ids(ids)
    watch = _PlotRecorder(data, fields["duration_s"])
    screen = Screen(watch.seen, watch.done)
    answer: dict[str, Any] = {"returned": False}
    recorder.RECORDER.take(submission.STATE.folder)
    scene = own_globals.set_model_and_data(model, data)
    with reporting_errors(answer), scene, screen.installed(), watch.counting_steps():
        plot, _ = calls.adapt_collector(function, model, fields["duration_s"], ids)
        value = plot(model, data, fields["duration_s"])
        screen.show_animations_left()
        answer["returned"] = True
        del value  # an animation that was handed back lives until here
    recorder.RECORDER.take(submission.STATE.folder, with_open=False)
    return watch.reply(answer)


class _PlotRecorder:
    """Recorder of the curves that a live plot shows, with the simulated time of each change, to see whether the plot grows."""

    def __init__(self, data: Any, duration_s: float) -> None:
        self._data, self._start, self._duration_s = data, float(data.time), duration_s
        self._stepped = 0.0
        self._events: list[tuple[float, int, int]] = []
        self._digest = b""
        self._changes = 0
        self._kept: list[tuple[float, list[Curve]]] = []
        self._last: tuple[float, list[Curve]] | None = None

    @property
    def simulated(self) -> float:
        """Return the simulated time so far in s, by which a live plot is timed, also if the program resets the data."""
        return max(self._stepped, float(self._data.time) - self._start)

    def done(self) -> bool:
        return self.simulated >= self._duration_s * 0.999

    def seen(self, figure: Any) -> None:
        """Record the curves of a figure that is shown, and of all open ones, if they have changed."""
        shown = {id(one): one for one in (figure, *open_figures())}
        curves = [curve for one in shown.values() for curve in _curves(one)][:_MAX_CURVES]
        points = sum(len(x) for _, x, _ in curves)
        digest = hashlib.blake2b(b"".join(y.tobytes() + x.tobytes() for _, x, y in curves), digest_size=16).digest()
        if digest == self._digest or len(self._events) >= _MAX_EVENTS:
            return
        self._digest = digest
        self._changes += 1
        self._events.append((self.simulated, points, self._changes))
        self._keep(curves)

    def _keep(self, curves: list[Curve]) -> None:
        if not curves:
            return
        moment = (self.simulated, curves)
        if self.simulated >= len(self._kept) * self._duration_s / _SNAPSHOTS and len(self._kept) < _SNAPSHOTS:
            self._kept.append(moment)
        self._last = moment

    @contextlib.contextmanager
    def counting_steps(self) -> Iterator[None]:
        """Count the time that `mj_step` simulates, also if a file has imported the function by name."""
        import mujoco

        really = mujoco.mj_step

        def mj_step(model: Any, data: Any, nstep: int = 1) -> None:
            really(model, data, nstep)
            self._stepped += nstep * float(model.opt.timestep)

        with contextlib.ExitStack() as stack:
            for owner in (mujoco, *submission.STATE.modules.values()):
                names = [name for name, value in list(vars(owner).items()) if value is really]
                stack.enter_context(replaced(owner, dict.fromkeys(names, mj_step)))
            yield

    def reply(self, answer: dict[str, Any]) -> Reply:
        packer = Packer()
        last = self._last
        moments = self._kept + ([last] if last and not any(kept is last for kept in self._kept) else [])
        answer["curves"] = [
            {"moment": moment, "label": label, "x": packer.keep(x), "y": packer.keep(y)}
            for moment, curves in moments
            for label, x, y in curves
        ]
        answer["simulated"] = self.simulated
        return answer, packer.arrays | {"events": np.array(self._events, dtype=np.float64).reshape(-1, 3)}


def _curves(figure: Any) -> list[Curve]:
    """Return label and finite points of every visible curve of a figure, to see what it shows now."""
    found: list[Curve] = []
    for axes in figure.get_axes():
        artists: list[tuple[Any, Callable[[], tuple[Any, Any]]]] = [(one, one.get_data) for one in axes.get_lines()]
        artists += [(one, lambda o=one: np.asarray(o.get_offsets(), dtype=float).T) for one in axes.collections]  # type: ignore[misc]
        for artist, points in artists:
            curve = _finite(artist, points)
            if curve is not None:
                found.append(curve)
    return found


def _finite(artist: Any, points: Callable[[], tuple[Any, Any]]) -> Curve | None:
    x: np.ndarray
    y: np.ndarray
    try:
        x, y = (np.ma.asarray(v, dtype=float).filled(np.nan).ravel()[-_MAX_POINTS:] for v in points())
    except (TypeError, ValueError):
        return None
    n = min(len(x), len(y))
    known = np.isfinite(x[:n]) & np.isfinite(y[:n])
    if known.sum() < _FEWEST or not artist.get_visible():
        return None
    return str(artist.get_label())[:60], x[:n][known], y[:n][known]
