"""Charts of the student's own figures, redrawn from what was graded: curves, labels, legends and titles."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from grader.base.text import printable
from grader.engine import figures
from grader.engine.chart_data import Chart, Curve, Panel
from grader.engine.figures import Axes, Entry, Figure, Mask
from grader.labs.imu.answers import Drawing
from grader.labs.imu.charts.points import curve
from grader.labs.imu.compare import Array, thinned

_FIGURES = 3
_PANELS = 6
_CURVES = 12
_PIECES = 20  # of a curve that goes in and out
_UNSEEN = "Dotted curves are drawn by the code but not visible in the picture."
_FED = "The grader plotted a test recording, so these are not the curves of your own simulation."
_COLOUR = re.compile(r"#[0-9a-f]{6}")


def charts(plotted: Drawing | None, drawings: Iterable[Drawing]) -> Iterator[Chart]:
    """Yield at most three charts of unlike figures: `plotted`, by `plot_imu_data`, then `drawings`, by all submitted code."""
    told: set[tuple[object, ...]] = set()
    for drawing in (*([plotted] if plotted else []), *drawings):
        for figure in sorted(drawing.figures, key=lambda figure: not figure.is_saved):
            panels = _panels(figure)
            look = tuple((panel.title, panel.y_label, len(panel.curves)) for panel in panels)
            if panels and look not in told and len(told) < _FIGURES:
                told.add(look)
                yield _chart(figure, panels, by_function=drawing is plotted)


def _chart(figure: Figure, panels: tuple[Panel, ...], *, by_function: bool) -> Chart:
    """Return the chart of one figure, with a caption on whether it was saved and who drew it."""
    width, height = figure.size_px
    saved = f"Saved, {width} × {height} pixels" if figure.is_saved else "Drawn, not saved"
    who = "What plot_imu_data draws" if by_function else "What your files draw"
    title = _words(figure.title, 80)
    unseen = any(each.role == "not-seen" for panel in panels for each in panel.curves)
    said = [f"{saved}; redrawn from what the grader read in it.", _FED * by_function, _UNSEEN * unseen]
    return Chart("visualization", f"{who}: {title}" if title else who, " ".join(filter(None, said)), panels)


def _panels(figure: Figure) -> tuple[Panel, ...]:
    found = (_panel(axes, figure) for axes in figure.visible_axes)
    return tuple(panel for panel in found if panel.curves)[:_PANELS]


def _panel(axes: Axes, figure: Figure) -> Panel:
    """Return one set of axes of the student's figure as a panel of the chart, with at most twelve of its curves."""
    entries, across = axes.legend or figure.legend, _reach(axes)
    curves = [
        piece
        for each in axes.curves[:_CURVES]
        if each.n > 1 and each.kind != "nothing"
        for piece in _pieces(each, axes, entries, across)
    ]
    x_label, y_label = _words(axes.xlabel or figure.xlabel, 120), _words(axes.ylabel or figure.ylabel, 120)
    return Panel(_words(axes.title, 120), x_label, y_label, tuple(each for each in curves if len(each.x) > 1))


def _reach(axes: Axes) -> Array:
    """Return the first and the last x of all visible curves of data, for lines across the panel; 0 and 1 if there are none."""
    ends = [each.x[[0, -1]] for each in axes.curves if each.visible and len(each.x) > 2]
    return np.array([np.min(ends), np.max(ends)]) if ends else np.array([0.0, 1.0])


def _pieces(each: figures.Curve, axes: Axes, entries: Sequence[Entry], across: Array) -> Iterator[Curve]:
    """Split a curve into pieces that are visible and pieces that are not: outside the axis limits, or all of a hidden curve.

    A piece has its name from the legend: a label that no legend shows is not seen by a reader either. A curve without points, or in
    more than 20 pieces, is not split.
    """
    colour = each.colour if _COLOUR.fullmatch(each.colour) else "#000000"
    shown = [entry.text for entry in entries if entry.colour == each.colour]
    name = each.label if each.label in shown else shown[0] if len(shown) == 1 else ""
    x, y = each.x, each.y
    if len(x) == len(y) == 2 and x[0] == 0 and x[1] == 1 and y[0] == y[1]:
        x = across  # axhline goes from border to border
    if not len(x):
        return
    rows = thinned(len(x))
    seen = _within(x[rows], axes.x_limits) & _within(y[rows], axes.y_limits) & each.visible
    turns = np.flatnonzero(np.diff(seen)) + 1
    if len(turns) > _PIECES:
        seen, turns = np.full(len(rows), each.visible), turns[:0]
    for piece in np.split(np.arange(len(rows)), turns):
        whole = rows[piece[0] : piece[-1] + 2]  # up to where the next one starts
        there = bool(seen[piece[0]])
        named = _words(name, 60) if there or not seen.any() else ""
        yield curve(named, "drawn" if there else "not-seen", x[whole], y[whole], colour)


def _within(values: Array, limits: tuple[float, float]) -> Mask:
    low, high = sorted(limits)
    return np.asarray(~((values < low) | (values > high)))


def _words(text: str, limit: int) -> str:
    r"""Return a text of the figure for the chart, readable where a formula was meant: ``$\omega_x$`` becomes ``omega_x``."""
    plain = text.replace("$", "").replace("\\", "") if "$" in text else text
    return printable(plain, limit)
