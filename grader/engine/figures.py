"""Records of what was drawn: figures with their axes and curves, made once of a reply that keeps the rule for drawings.

Words, limits and curves are what the sandbox claims; the pixels are the witness, and a curve's `sight` is what these show of it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import PurePath
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from grader.sandbox.wire import Frame

T = TypeVar("T")
Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

FEWEST_SEEN = 0.12
"""Least share of the parts of a curve that must be seen.

Of 30,000 curves of 5,000 random sound figures one has less, 0.07, and leaving it out changes hardly any column of the whole
picture; the next has 0.13. Of 500 that are claimed and not drawn, among five that are, 426 have less; the others take the place of
curves of their colour, or of mixtures of it (`python -m tests.benchmarks.pictures`).
"""
PARTS = 100
"""Parts of a curve along its abscissa: dashes and thinned points leave gaps, and are seen from part to part."""


@dataclass(frozen=True, eq=False)
class Sight:
    """Visible parts of a curve.

    Attributes
    ----------
    inside, seen : (100,) ndarray of bool, which parts along its abscissa lie within the limits, and which of these can be seen
    """

    inside: Mask
    seen: Mask

    @property
    def is_hidden(self) -> bool:
        """True if hardly anything can be seen of what lies within the limits."""
        return bool(self.inside.any()) and float(self.seen.sum() / self.inside.sum()) < FEWEST_SEEN


_NOT_LOOKED_AT = Sight(np.ones(PARTS, bool), np.zeros(PARTS, bool))


@dataclass(frozen=True)
class Entry:
    """An entry of a legend: its words, and colour (``#rrggbb``), style, marker and stroke of the sample beside them."""

    text: str
    colour: str
    style: str
    marker: str
    stroke: str


@dataclass(frozen=True)
class Placed:
    """A text on a panel: where it stands, in the units of the panel's axes, and its colour (``#rrggbb``)."""

    text: str
    place: tuple[float, float]
    colour: str


@dataclass(frozen=True, eq=False)
class Curve:
    """A line, or points that were scattered.

    Attributes
    ----------
    label, colour : the name that the code gives it, and ``#rrggbb``
    kind : ``line`` or ``points``; ``nothing`` where it has neither stroke nor marker
    n : how many points it has
    x, y : (k,) ndarray, these points or every so many-th of them, in the units of the axes; not finite where nothing is drawn
    style, marker, stroke : as matplotlib calls them; in the last one dashes, width and opacity
    alpha : opacity, 0 to 1
    inks : the colours that it leaves in the picture, ``#rrggbbaa``; none where there are too many to tell
    width : of the stroke, or of the marker, in points (1/72 inch)
    sight : what a reader sees of it; nothing until it was looked at
    """

    label: str
    colour: str
    kind: str
    n: int
    x: Array
    y: Array
    style: str
    marker: str
    stroke: str
    alpha: float
    inks: tuple[str, ...]
    width: float
    sight: Sight

    @property
    def visible(self) -> bool:
        return not self.sight.is_hidden

    @cached_property
    def points(self) -> tuple[Array, Array]:
        """The finite points: while a filter warms up there is nothing to show."""
        known = np.isfinite(self.x) & np.isfinite(self.y)
        return self.x[known], self.y[known]


@dataclass(frozen=True, eq=False)
class Axes:
    """A panel of a figure.

    Attributes
    ----------
    visible : whether it is switched on
    position : its left, lower, right and upper border in parts of the figure's width and height
    title, xlabel, ylabel : as they can be read; empty where they cannot
    legend, texts : the entries of its legend, none without one, and what is written between the curves
    x_limits, y_limits : the values at its left and right, lower and upper border
    scales : of x and y, ``linear``, ``log`` or another
    own_ticks : whether the numbers along x are written by the code, and may be others than those that are drawn
    own_height : whether the limits of y are set by the code, for whatever it draws
    """

    visible: bool
    position: tuple[float, float, float, float]
    title: str
    xlabel: str
    ylabel: str
    legend: tuple[Entry, ...]
    texts: tuple[Placed, ...]
    curves: tuple[Curve, ...]
    x_limits: tuple[float, float]
    y_limits: tuple[float, float]
    scales: tuple[str, str]
    own_ticks: bool
    own_height: bool = False


@dataclass(frozen=True, eq=False)
class Figure:
    """A figure as it was when it was saved, shown or left behind; one that cannot be read has no axes.

    Attributes
    ----------
    event : ``saved`` where a file holds it at the end, ``overwritten`` or ``forgotten`` where one did; else how it was met
    path, format : of the file, as the call named them
    size_px : width and height that it was saved in, or would be
    title, xlabel, ylabel, texts, legend : what is said of all its panels
    extent, dots : width and height of `pixels`, not rounded, and how many of them there are to an inch
    pixels : (h, w, 3) ndarray of uint8, what was drawn, in red, green and blue
    """

    event: str
    path: str | None
    format: str
    size_px: tuple[int, int]
    axes: tuple[Axes, ...] = ()
    title: str = ""
    xlabel: str = ""
    ylabel: str = ""
    texts: tuple[str, ...] = ()
    legend: tuple[Entry, ...] = ()
    extent: tuple[float, float] = (0.0, 0.0)
    dots: float = 0.0
    pixels: NDArray[np.uint8] = field(default_factory=lambda: np.zeros((0, 0, 3), np.uint8))

    @property
    def file_name(self) -> str:
        """Name of its file, without the folder; "" without a file."""
        return PurePath(self.path or "").name

    @property
    def is_saved(self) -> bool:
        return self.event == "saved"

    @property
    def visible_axes(self) -> list[Axes]:
        return [axes for axes in self.axes if axes.visible]


@dataclass(frozen=True)
class Stray:
    """A picture file that shows none of the figures, and why it cannot be read; without a reason where it can."""

    path: str
    reason: str


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture that was handed in.

    Attributes
    ----------
    size_px : its width and height
    ink : share of it that is of none of its commonest colours
    preview : (h, w) ndarray of uint8, the picture in fewer pixels, by the rows of `palette`
    palette : (256, 3) ndarray of uint8, red, green and blue
    """

    size_px: tuple[int, int]
    ink: float
    preview: NDArray[np.uint8]
    palette: NDArray[np.uint8]


# --- made of what a rule of `engine.replies` has let pass ----------------------------------------------------------------


def figures_of(frame: Frame) -> list[Figure]:
    """Return the figures of an answer that tells of drawings, as they were saved or shown."""
    return [_figure(facts, frame.arrays) for facts in frame.fields["figures"] if facts["event"] != "finished"]


def strays_of(frame: Frame) -> tuple[Stray, ...]:
    """The pictures of such an answer that show none of its figures."""
    return tuple(_record(Stray, facts) for facts in frame.fields["strange"])


def picture_of(frame: Frame) -> Picture | None:
    """Return the handed-in picture that a reply describes; None if the picture could not be read."""
    return _record(Picture, {**frame.fields, **frame.arrays}) if frame.fields["readable"] else None


def _record(kind: type[T], facts: Mapping[str, Any], **resolved: Any) -> T:
    """A record of the facts that are called as its fields are, but for what was resolved already."""
    told = {name: _frozen(facts[name]) for name in kind.__annotations__ if name not in resolved}
    return kind(**told, **resolved)


def _frozen(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _figure(facts: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> Figure:
    if "unreadable" in facts:
        return Figure(facts["event"], facts["path"], facts["format"], tuple(facts["size_px"]))
    axes = tuple(_axes(each, arrays) for each in facts["axes"])
    entries = _entries(entry for legend in facts["legends"] for entry in legend)
    return _record(Figure, facts, axes=axes, legend=entries, pixels=arrays[facts["seen"]])


def _axes(facts: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> Axes:
    curves = tuple(
        _record(Curve, curve, x=arrays[curve["x"]], y=arrays[curve["y"]], sight=_NOT_LOOKED_AT)
        for curve in facts["curves"]
    )
    texts = tuple(_record(Placed, text) for text in facts["texts"])
    return _record(Axes, facts, legend=_entries(facts["legend"] or ()), texts=texts, curves=curves)


def _entries(legend: Iterable[Mapping[str, Any]]) -> tuple[Entry, ...]:
    return tuple(_record(Entry, entry) for entry in legend)
