"""Random sound figures: six channels in panels of any style that students choose, drawn and looked at as the sandbox does it."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Iterator
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np

from grader.engine.figures import Figure, VisibleParts, figures_of
from grader.labs.imu.visualization.visibility import Patience, looked_at
from grader.sandbox.wire import Frame
from grader.worker import drawing, figures
from grader.worker.values import Packer

_STYLES = ["default", "ggplot", "bmh", "dark_background", "fivethirtyeight", "grayscale", "seaborn-v0_8", "Solarize_Light2",
           "seaborn-v0_8-whitegrid", "seaborn-v0_8-darkgrid", "tableau-colorblind10", "fast", "classic", "seaborn-v0_8-dark"]  # fmt: skip
_COLOURS = [None, None, ("r", "g", "b"), ("tab:red", "tab:green", "tab:blue"), ("C3", "C4", "C5"), ("k", "0.4", "0.7"),
            ("orange", "purple", "teal"), ("crimson", "gold", "navy"), ("#e41a1c", "#377eb8", "#4daf4a")]  # fmt: skip
_STROKES = ["-", "-", "-", "--", "-.", ":"]


@contextlib.contextmanager
def figure_of(seed: int) -> Iterator[Any]:
    """The figure of this seed, in its style."""
    rng = np.random.default_rng(seed)
    with mpl.rc_context():
        plt.style.use(str(rng.choice(_STYLES)))
        mpl.rcParams["lines.markeredgewidth"] = 1.0  # a style of no edges has no crosses and no hollow markers
        figure = _figure(rng)
        yield figure
        plt.close(figure)


def made(seed: int, left_out: str = "") -> dict[str, VisibleParts]:
    """What a reader sees of each curve of the figure of this seed, by its label; of one that is claimed and not drawn, too."""
    with figure_of(seed) as figure:
        found = looked_at(told(figure, left_out), Patience())
    return {curve.label: curve.visible_parts for panel in found.axes for curve in panel.curves if curve.n > 3}


def told(figure: Any, left_out: str = "") -> Figure:
    """What the sandbox tells of a figure; with a curve that is claimed and not drawn."""
    (record,) = figures_of(frame_of(figure, left_out))
    return record


def frame_of(figure: Any, left_out: str = "") -> Frame:
    """The same as it comes over the wire."""
    packer = Packer()
    facts = figures.facts_of(figure, packer)
    if left_out:
        _curve_of(figure, left_out).set_visible(False)
    seen = drawing.draw_preview(figure)
    facts |= {"event": "saved", "path": "imu_data.png", "format": "png", "size_px": [640, 480]}
    facts |= {"seen": "seen", "extent": list(seen.extent), "dots": seen.dots}
    return Frame({"figures": [facts]}, packer.arrays | {"seen": seen.pixels})


def _curve_of(figure: Any, label: str) -> Any:
    (artist,) = (a for axes in figure.axes for a in (*axes.lines, *axes.collections) if a.get_label() == label)
    return artist


def series(rng: Any) -> tuple[Any, list[Any]]:
    """Time, and two sensors (n, 3): a tumbling, a swaying or a nearly still one, with noise or without."""
    n, seconds = int(rng.integers(200, 2500)), float(rng.choice([0.6, 1.2, 3.0, 5.0, 10.0]))
    t = np.arange(n) * seconds / n
    kind = rng.integers(3)
    sensors = []
    for size, level in ((8.0, -9.81), (2.0, 0.0)):
        phase, rate = rng.uniform(0, 6, 3), rng.uniform(2, 12, 3) / seconds
        wave = size * np.sin(2 * np.pi * rate * t[:, None] / 4 + phase) * rng.uniform(0.5, 1, 3)
        wave = wave * np.exp(-3 * t / seconds)[:, None] if kind == 1 else wave * (0.1 if kind == 2 else 1)
        noise = rng.normal(size=(n, 3)) * size * float(rng.choice([0, 0.005, 0.03, 0.1]))
        sensors.append(wave + noise + level * np.array([0, 0, 1.0]) + (kind > 0) * size * np.array([0.0, 0.4, 0.0]))
    return t, sensors


def _figure(rng: Any) -> Any:
    t, sensors = series(rng)
    size = (rng.uniform(5, 16), rng.uniform(4, 12))
    layout = rng.integers(5)
    if layout == 0:
        figure, panels = plt.subplots(3, 2, figsize=size, sharex=bool(rng.integers(2)))
        places = [[panels[k, s] for k in range(3)] for s in (0, 1)]
    elif layout == 1:
        figure, left = plt.subplots(figsize=size)
        places = [[left] * 3, [left.twinx()] * 3]
    else:
        shape = (1, 2) if layout == 2 else (2, 1)
        figure, panels = plt.subplots(*shape, figsize=size, sharex=bool(rng.integers(2)))
        places = [[axes] * 3 for axes in panels]
    names = iter("abcdef")
    for sensor, (values, axes) in enumerate(zip(sensors, places, strict=True)):
        colours = (
            _COLOURS[rng.integers(len(_COLOURS))] if layout != 1 else ("r", "g", "b") if sensor else ("c", "m", "y")
        )
        if colours and "k" in colours and min(mpl.colors.to_rgb(mpl.rcParams["figure.facecolor"])) < 0.9:
            colours = None  # nobody draws greys on grey, or black on black
        for k, place in enumerate(axes):
            _draw(rng, place, t, values[:, k], {} if colours is None else {"color": colours[k]}, next(names))
    for place in itertools.chain(*places):
        _furnish(rng, place, t)
    return figure


def _draw(rng: Any, axes: Any, t: Any, values: Any, options: dict[str, Any], name: str) -> None:
    step = int(rng.choice([1, 1, 1, 2, 4])) if len(t) > 800 else 1
    t, values = t[::step], values[::step]
    way = rng.integers(8)
    if way == 0:
        axes.scatter(
            t, values, s=float(rng.uniform(4, 30)), marker=str(rng.choice(list(".ox+^"))), label=name, **options
        )
    elif way == 1:
        axes.step(t, values, where=str(rng.choice(["pre", "mid", "post"])), label=name, **options)
    elif way == 2:
        marker = str(rng.choice(list(".ox+sD^")))
        hollow = {"markerfacecolor": "none"} if rng.integers(2) else {}
        axes.plot(t, values, marker, markersize=float(rng.uniform(2, 8)), label=name, **hollow, **options)
    else:
        stroke = str(rng.choice(_STROKES))
        width, alpha = float(rng.uniform(0.4, 4)), float(rng.choice([1, 1, 0.8, 0.5, 0.3]))
        marker = {"marker": "o", "markevery": 40} if rng.integers(6) == 0 else {}
        axes.plot(t, values, stroke, linewidth=width, alpha=alpha, label=name, **marker, **options)


def _furnish(rng: Any, axes: Any, t: Any) -> None:
    """Grid, legend, reference lines, shades and limits, as people add them."""
    axes.legend(loc=str(rng.choice(["best", "upper right", "lower left"])), fontsize=float(rng.uniform(6, 14)))
    if rng.integers(2):
        axes.grid(True, alpha=float(rng.uniform(0.2, 1)))
    for _ in range(rng.integers(3)):
        which = rng.integers(6)
        if which == 0:
            axes.axhline(float(np.mean(axes.get_ylim())), color="k", linestyle="--", alpha=0.4)
        elif which == 1:
            axes.axvspan(t[len(t) // 5], t[len(t) // 3], color="C1", alpha=0.2, zorder=0)
        elif which == 2:
            axes.set_facecolor(
                str(rng.choice(["#fafafa", "#eeeeff", "#fffbe6"]))
                if mpl.rcParams["axes.facecolor"] == "white"
                else "none"
            )
        elif which == 3:
            axes.set_xlim(t[0], t[-1])
        elif which == 4:
            axes.margins(float(rng.uniform(0, 0.3)))
        else:
            axes.text(0.1, 0.8, "a word of explanation", transform=axes.transAxes)


def share_seen(sight: VisibleParts) -> float:
    """Of what is inside."""
    return float(sight.seen.sum() / max(1, sight.inside.sum()))
