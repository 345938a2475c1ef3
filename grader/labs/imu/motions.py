"""Show the motions in a bundle of traces to people: as pictures, and as tables of time and the two sensors."""

from __future__ import annotations

import io
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from matplotlib.figure import Figure

from grader.base.errors import RequestError
from grader.engine.traces import Scenario, Traces
from grader.labs.imu.compare import Array

_PANELS = (("acceleration", "Specific force (m/s²)"), ("angular_velocity", "Angular velocity (rad/s)"))


class Series(Protocol):
    """Protocol of a recording by `simulate_and_collect` that `plot` draws over the true motion; None for a missing series."""

    @property
    def time(self) -> Array | None: ...

    @property
    def acceleration(self) -> Array | None: ...

    @property
    def angular_velocity(self) -> Array | None: ...


def plot(traces: Traces, out: Path, mine: Mapping[str, Series] | None = None) -> list[Path]:
    """Draw each motion of the traces (time and both sensors) as a picture in the folder `out`; return the pictures' paths.

    Parameters
    ----------
    mine
        A student's recordings by scenario: only these scenarios are drawn, each recording over the truth. None draws all motions.

    Raises
    ------
    RequestError
        If a picture cannot be written.
    """
    moving = _moving(traces)
    if mine is None:
        return [_draw(scenario, None, out / f"{traces.name}_{scenario.name}.png") for scenario in moving]
    over = [(scenario, mine[scenario.name]) for scenario in moving if scenario.name in mine]
    return [_draw(scenario, series, out / f"mine_{scenario.name}.png") for scenario, series in over]


def tables(traces: Traces, names: Collection[str]) -> dict[str, bytes]:
    """Return files for the students' folder by name: for each motion in `names`, a CSV table (time, both sensors) and a picture."""
    chosen = [scenario for scenario in _moving(traces) if scenario.name in names]
    tables = {f"{scenario.name}.csv": _table(scenario) for scenario in chosen}
    return tables | {f"{scenario.name}.png": _picture(scenario) for scenario in chosen}


def _moving(traces: Traces) -> list[Scenario]:
    return [scenario for scenario in traces.scenarios.values() if _is_motion(scenario)]


def _table(scenario: Scenario) -> bytes:
    columns = np.column_stack([scenario["time"], *(scenario[key] for key, _ in _PANELS)])
    heading = ",".join(["time", *(f"{key}_{axis}" for key, _ in _PANELS for axis in "xyz")])
    stream = io.StringIO()
    np.savetxt(stream, columns, fmt="%.9g", delimiter=",", header=heading, comments="")
    return stream.getvalue().encode()


def _is_motion(scenario: Scenario) -> bool:
    samples = scenario.arrays.get("time", np.empty(0)).shape
    return len(samples) == 1 and all(
        getattr(scenario.arrays.get(key), "shape", ()) == (*samples, 3) for key, _ in _PANELS
    )


def _draw(scenario: Scenario, mine: Series | None, path: Path) -> Path:
    return _saved(_figure(scenario, mine), path)


def _picture(scenario: Scenario) -> bytes:
    stream = io.BytesIO()
    _figure(scenario, None).savefig(stream, dpi=120)
    return stream.getvalue()


def _figure(scenario: Scenario, mine: Series | None) -> Figure:
    figure = Figure(figsize=(10, 6), layout="constrained")
    panels: Any = figure.subplots(2, 1, sharex=True)
    wide = {"linewidth": 1.0} if mine is None else {"linewidth": 5.0, "alpha": 0.3}
    for axes, (key, label) in zip(panels, _PANELS, strict=True):
        for column, name in enumerate("XYZ"):
            truth = f"{name}, truth" if mine else name
            axes.plot(scenario["time"], scenario[key][:, column], label=truth, color=f"C{column}", **wide)
        if mine is not None:
            _draw_over(axes, scenario, mine.time, getattr(mine, key))
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
    if mine is None:
        for axes in panels:
            axes.legend(loc="upper right", ncols=3)
    else:
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=6)
    panels[0].set_title(scenario.description)
    panels[1].set_xlabel("Time (s)")
    return figure


def _draw_over(axes: Any, scenario: Scenario, time: Array | None, rows: Array | None) -> None:
    """Draw a student's rows over the truth: at the student's own times if there is one for each row, otherwise row by row.

    The truth sets the limits of the axes, so that a wild recording does not hide it.
    """
    if rows is None or not len(rows):
        return
    if time is None or len(time) != len(rows):
        rows = rows[: len(scenario["time"])]
        time = scenario["time"][: len(rows)]
    limits = axes.get_ylim()
    for column, name in enumerate("XYZ"):
        axes.plot(time, rows[:, column], label=f"{name}, yours", color=f"C{column}", linewidth=1.2)
    spread, finite = limits[1] - limits[0], rows[np.isfinite(rows)]
    low, high = finite.min(initial=limits[0]) - 0.05 * spread, finite.max(initial=limits[1]) + 0.05 * spread
    axes.set_ylim(max(low, limits[0] - spread), min(high, limits[1] + spread))
    axes.set_xlim(-0.02 * scenario["time"][-1], 1.02 * scenario["time"][-1])


def _saved(figure: Figure, path: Path) -> Path:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=120)
    except OSError as problem:
        raise RequestError(f"{path}: cannot write it: {problem.strerror or problem}; choose another place") from problem
    return path
