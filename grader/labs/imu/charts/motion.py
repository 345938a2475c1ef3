"""Chart of the series that `simulate_and_collect` recorded, over the truth, and of the difference."""

from __future__ import annotations

import numpy as np

from grader.engine.chart_data import Chart, Panel
from grader.engine.traces import Scenario
from grader.labs.imu.charts.points import curve, worst_of_each
from grader.labs.imu.collection import Collection
from grader.labs.imu.compare import Array
from grader.labs.imu.data_collection.measure import ATOL_ACCELERATION, ATOL_RATE

_AXES = ("x", "y", "z")


def chart(series: Collection | None, truth: Scenario) -> Chart | None:
    """Return the chart of recorded and true readings for the report; None if neither sensor has two rows."""
    if series is None:
        return None
    told = [
        _sensor("Acceleration", "m/s²", series.acceleration, truth["acceleration"], truth["time"], ATOL_ACCELERATION),
        _sensor(
            "Angular velocity", "rad/s", series.angular_velocity, truth["angular_velocity"], truth["time"], ATOL_RATE
        ),
    ]
    known = [each for each in told if each is not None]
    if not known:
        return None
    sizes = " and ".join(size for _, size in known if size)
    within = f"{ATOL_ACCELERATION:g} m/s² and {ATOL_RATE:g} rad/s"
    said = f"Largest difference: {sizes}." if sizes else f"They agree within {within}."
    caption = f"Your rows in colour, over the truth as a wide pale line of the same colour. {said}"
    return Chart(
        "data_collection", "Your series and the truth", caption, tuple(p for panels, _ in known for p in panels)
    )


def _sensor(
    name: str, unit: str, got: Array | None, true: Array, time: Array, tolerance: float
) -> tuple[list[Panel], str] | None:
    """Return the panels of one sensor, and its largest error in words: recording over truth, then the error if it is too large.

    The words are "" if the recording agrees. None if fewer than two rows were recorded.
    """
    n = min(len(true), 0 if got is None else len(got))
    if got is None or n < 2:
        return None
    error = got[:n] - true[:n]
    worst = np.nanmax(np.abs(error), axis=1, initial=0.0)
    rows = worst_of_each(worst)
    at, row = time[rows], int(np.argmax(worst))
    truths = (curve(f"true {axis}", f"true-{axis}", at, true[rows, i]) for i, axis in enumerate(_AXES))  # type: ignore[arg-type]
    own = (curve(axis, axis, at, got[rows, i]) for i, axis in enumerate(_AXES))  # type: ignore[arg-type]
    traces = Panel(name, "Time (s)", unit, (*truths, *own))
    if worst[row] <= tolerance:
        return [traces], ""  # a flat line shows nothing that the caption does not say
    errors = tuple(curve(axis, axis, at, error[rows, i]) for i, axis in enumerate(_AXES))  # type: ignore[arg-type]
    residual = Panel(f"{name}: yours minus the truth", "Time (s)", unit, errors, spread=2 * tolerance)
    return [traces, residual], f"{worst[row]:.2g} {unit} at {time[row]:.3g} s"
