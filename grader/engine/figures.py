"""Records of the figures that student code drew, with axes and curves, made from a reply of the sandbox that was validated.

Student code may forge texts, limits and curves. The pixels are the evidence: `Curve.visible_parts` says what they show of a curve.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain
from pathlib import PurePath
from typing import Annotated, Any, TypeAlias

import msgspec
import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from grader.engine.reply_types import Long, Names, Number, Pair, Short, Whole
from grader.sandbox.wire import Frame

Array: TypeAlias = NDArray[np.float64]
Pixels: TypeAlias = NDArray[np.uint8]
Mask = NDArray[np.bool_]

FEWEST_SEEN = 0.12
"""Smallest share of a curve's parts that must be visible; a curve with less counts as hidden.

Of 30,000 curves in 5,000 random sound figures, one has less (0.07), and removing it changes hardly any column of the picture; the
next has 0.13. Of 500 curves that are claimed but not drawn, each among five drawn ones, 426 have less; the others coincide with
curves of their colour or of mixtures of it (`python -m tests.benchmarks.pictures`).
"""
PARTS = 100
"""Number of parts along a curve's abscissa. Visibility is judged per part, because dashes and thinned points leave gaps."""


@dataclass(frozen=True, eq=False)
class VisibleParts:
    """Which of 100 parts of a curve, along its x range, a reader of the picture can see; checks deduct for curves that are hidden.

    Attributes
    ----------
    inside : (100,) ndarray of bool, which parts lie within the axis limits
    seen : (100,) ndarray of bool, which of the parts within the limits the pixels show
    """

    inside: Mask
    seen: Mask

    @property
    def is_hidden(self) -> bool:
        """True if the pixels show too little of the curve to count it as drawn.

        The visible share of its parts within the axis limits is less than `FEWEST_SEEN`. False for a curve outside the limits.
        """
        return bool(self.inside.any()) and float(self.seen.sum() / self.inside.sum()) < FEWEST_SEEN


_NOT_EXAMINED = VisibleParts(np.ones(PARTS, bool), np.zeros(PARTS, bool))


@dataclass(frozen=True)
class Entry:
    """A legend entry: its text, and its sample's colour, line style, marker and stroke (as in `Curve`), to find the curve."""

    text: Short
    colour: Short
    style: Short
    marker: Short
    stroke: Short


@dataclass(frozen=True)
class Placed:
    """A text inside a panel, which may name a curve: its position in the units of the panel's axes, its colour (``#rrggbb``)."""

    text: Short
    place: Pair
    colour: Short


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve that student code drew in a panel, a line or scattered points, for checks to compare with the data.

    Attributes
    ----------
    label, colour : the label that the code gives it, and ``#rrggbb``
    kind : ``line`` or ``points``; ``nothing`` if it has neither stroke nor marker
    n : number of points that the code drew
    x, y : (k,) ndarray in the units of the axes, every second, third, … point if `n` is above 6000; not finite where none is drawn
    style, marker : matplotlib's names of its line style and marker
    stroke : dashes, width and opacity of its line as text, to compare with a legend's sample; "" for points
    alpha : opacity, 0 to 1
    inks : the colours that it leaves in the picture, ``#rrggbbaa``; empty if there are too many to tell
    width : width of the stroke or of the marker, in points (1/72 inch)
    visible_parts : which parts the pixels show; no part counts as seen before the pixels are examined
    """

    label: Short
    colour: Short
    kind: Short
    n: Whole
    x: Array
    y: Array
    style: Short
    marker: Short
    stroke: Short
    alpha: Number
    inks: Annotated[tuple[Short, ...], Meta(max_length=16)]
    width: Number
    visible_parts: VisibleParts = _NOT_EXAMINED

    @property
    def visible(self) -> bool:
        return not self.visible_parts.is_hidden

    @cached_property
    def points(self) -> tuple[Array, Array]:
        """The x and the y of the points at which both are finite; the output of a filter may be NaN while it warms up."""
        known = np.isfinite(self.x) & np.isfinite(self.y)
        return self.x[known], self.y[known]


@dataclass(frozen=True, eq=False)
class Axes:
    """A panel of a figure that student code drew, one pair of axes with its texts and curves, for checks to judge.

    Attributes
    ----------
    visible : whether it is switched on
    position : left, lower, right and upper border of the panel as fractions of the figure's width and height
    title, xlabel, ylabel : the visible text; "" if it cannot be read in the picture
    legend, texts : the entries of its legend (empty without one), and the texts among the curves
    x_limits, y_limits : the values at its left and right, lower and upper border
    scales : the scales of x and y: ``linear``, ``log`` or another
    own_ticks : whether the code sets the tick labels along x, which may then differ from the drawn values
    own_height : whether the code sets the limits of y itself
    """

    visible: bool
    position: tuple[Number, Number, Number, Number]
    title: Short
    xlabel: Short
    ylabel: Short
    legend: Annotated[tuple[Entry, ...], Meta(max_length=64)]
    texts: Annotated[tuple[Placed, ...], Meta(max_length=64)]
    curves: Annotated[tuple[Curve, ...], Meta(max_length=64)]
    x_limits: Pair
    y_limits: Pair
    scales: tuple[Short, Short]
    own_ticks: bool
    own_height: bool = False


@dataclass(frozen=True, eq=False)
class Figure:
    """A figure that student code drew, as it was at an event such as saving; one that raises when examined has no axes.

    Attributes
    ----------
    event : ``saved`` if a file shows it at the end, and for a film's frame; ``overwritten`` if its file was replaced or deleted;
        ``forgotten`` if it was saved to memory alone; else ``shown``, ``closed``, ``cleared``, or ``open`` at the end
    path, format : the file's path (None if the code named none) and format ("" if it was not saved)
    size_px : width and height in pixels in which the code saved it, or would have; `pixels` are another, small drawing
    title, xlabel, ylabel, texts, legend : the texts and legend entries that apply to all its panels
    extent, dots : width and height of `pixels` before rounding, and the resolution of `pixels` in dots per inch
    pixels : (h, w, 3) ndarray of uint8, the small picture that the sandbox draws to find visible curves, in red, green and blue
    """

    event: Short
    path: Long | None
    format: Short
    size_px: tuple[Whole, Whole]
    axes: Annotated[tuple[Axes, ...], Meta(max_length=24)] = ()
    title: Short = ""
    xlabel: Short = ""
    ylabel: Short = ""
    texts: Names = ()
    legend: Annotated[tuple[Entry, ...], Meta(max_length=512)] = ()
    extent: Pair = (0.0, 0.0)
    dots: Number = 0.0
    pixels: Pixels = field(default_factory=lambda: np.zeros((0, 0, 3), np.uint8))

    @property
    def file_name(self) -> str:
        """Name of the file that the figure was saved to, without the folder; "" without a file."""
        return PurePath(self.path or "").name

    @property
    def is_saved(self) -> bool:
        return self.event == "saved"

    @property
    def visible_axes(self) -> list[Axes]:
        return [axes for axes in self.axes if axes.visible]


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture that was handed in, decoded by the sandbox.

    Attributes
    ----------
    size_px : width and height in pixels
    ink : share of the pixels that have none of the four most frequent colours, which count as background
    preview : (h, w) ndarray of uint8, the picture in fewer pixels, as row numbers of `palette`
    palette : (256, 3) ndarray of uint8, red, green and blue
    """

    size_px: tuple[int, int]
    ink: float
    preview: NDArray[np.uint8]
    palette: NDArray[np.uint8]


# --- records from a reply ------------------------------------------------------------------------------------------------


def figures_of(frame: Frame) -> list[Figure]:
    """Return the figures that a reply of the sandbox describes; `replies.drawings` must have validated the reply."""
    return decode_figures(frame, lambda _, name: frame.arrays[name])


def decode_figures(frame: Frame, array_of: Callable[[Any, Any], Any]) -> list[Figure]:
    """Return the figures that a reply of the sandbox describes, with each array from `array_of`, which may validate it.

    `array_of(type, name)` gets the annotation of the array's field, such as `Pixels`, and the array's name in the reply.

    Raises
    ------
    msgspec.ValidationError, ValueError, TypeError, KeyError
        If the reply describes no valid figures.
    """
    return [msgspec.convert(_figure_fields(each), Figure, dec_hook=array_of) for each in frame.fields["figures"]]


def _figure_fields(told: Mapping[str, Any]) -> dict[str, Any]:
    """Return a figure's description in the form of a `Figure`; an unreadable figure has only event, path, format and size."""
    head = {name: told[name] for name in ("event", "path", "format", "size_px")}
    if "unreadable" in told:
        return head
    axes = [
        {**each, "legend": each["legend"] or (), "curves": [_without_visible_parts(curve) for curve in each["curves"]]}
        for each in told["axes"]
    ]
    legend = [*chain.from_iterable(told["legends"])]
    rest = {name: told[name] for name in ("title", "xlabel", "ylabel", "texts", "extent", "dots")}
    return {**head, **rest, "axes": axes, "legend": legend, "pixels": told["seen"]}


def _without_visible_parts(curve: Mapping[str, Any]) -> dict[str, Any]:
    """Return a curve's description without visible parts: the grader takes them from the pixels, whatever a reply claims."""
    return {name: value for name, value in curve.items() if name != "visible_parts"}


def picture_of(frame: Frame) -> Picture | None:
    """Return the handed-in picture that a reply of the sandbox describes; None if the picture could not be read."""
    if not frame.fields["readable"]:
        return None
    return Picture(
        tuple(frame.fields["size_px"]), frame.fields["ink"], frame.arrays["preview"], frame.arrays["palette"]
    )
