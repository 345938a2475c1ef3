"""Reading a figure: which curve shows which channel, and under which name.

Curves are tied to the data that the plot function was given, not to their labels; the labels are then held against the curves.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from grader.engine.figures import PARTS, Axes, Curve, Entry, Figure, Mask, Placed, Sight
from grader.labs.imu.answers import SENSORS, Array, Collection, column_named
from grader.labs.imu.diagnosis.labels import axis_of

_DAY_S = 86400.0  # matplotlib counts dates in days
FEWEST_POINTS = 50
"""A curve that is thinned to fewer points hides the motion. The sheet's 1,500 samples may be thinned to 200; here there are 600."""
_NEAR = 0.2  # of a panel's width or height: what is farther from a curve is not beside it
_MATCH = 1e-3
"""Of the channel's range over the time of the curve. Thinned and single-precision data agree to 1e-6, a smoothed or shifted curve
misses by 0.01 and more."""
NEARLY_ALL = 0.9
"""Of the recorded time: a curve over this much of it is drawn in full."""
_LEAST_PART = 0.05  # of the recorded time: a curve over less shows no motion

_MIDDLES = (np.arange(PARTS) + 0.5) / PARTS

Channel = tuple[int, int]
"""Sensor 0 or 1, axis 0 to 2."""


@dataclass(frozen=True)
class Shown:
    """A curve that shows a channel: sensor 0 or 1, axis 0 to 2, the scale of y, what x is, and between which shares of the time."""

    sensor: int
    axis: int
    unit: str
    x: str
    curve: Curve
    part: tuple[float, float] = (0.0, 1.0)

    @property
    def channel(self) -> Channel:
        return self.sensor, self.axis

    @property
    def drawn(self) -> Mask:
        """Over which parts of the recorded time it is drawn."""
        first, last = self.part
        return (first <= _MIDDLES) & (last >= _MIDDLES)

    @property
    def sight(self) -> Sight:
        """What is seen of it, in parts of the recorded time."""
        (first, last), own = self.part, self.curve.sight
        along = np.clip((_MIDDLES - first) / (last - first) * PARTS, 0, PARTS - 1).astype(int)
        return Sight(self.drawn & own.inside[along], self.drawn & own.seen[along])


@dataclass(frozen=True)
class Panel:
    """One set of axes with what it shows: known channels, curves that show none, and channels whose curves nobody sees."""

    axes: Axes
    shown: tuple[Shown, ...]
    strange: tuple[Curve, ...]
    hidden: tuple[Shown, ...] = ()

    @property
    def channels(self) -> set[Channel]:
        return {s.channel for s in self.shown}

    @property
    def sensors(self) -> set[int]:
        return {s.sensor for s in self.shown}

    @property
    def mainly(self) -> set[int]:
        """The sensor that most of its curves show; both if they are as many."""
        counts = Counter(s.sensor for s in self.shown)
        return {sensor for sensor in counts if counts[sensor] == max(counts.values())}

    @property
    def area(self) -> float:
        left, low, right, high = self.axes.position
        return (right - left) * (high - low)

    def leaves_out(self, curve: Curve) -> bool:
        """Whether any point of a curve lies outside the limits of the axes."""
        limits = (sorted(self.axes.x_limits), sorted(self.axes.y_limits))
        return any(bool(np.any((v < low) | (v > high))) for v, (low, high) in zip(curve.points, limits, strict=True))

    def is_inset_of(self, other: Panel) -> bool:
        """Whether it shows again, and much smaller, what another panel shows: that one has the names for both."""
        return bool(self.channels) and self.channels <= other.channels and self.area < other.area / 2

    @property
    def words(self) -> str:
        """Everything that is written on the panel to say what it shows."""
        return " | ".join([self.axes.title, self.axes.ylabel])


def joined(figures: Sequence[Figure]) -> Figure:
    """Several figures as the panels of one, each with what its own figure says of all its panels."""
    axes = tuple(_alone(one, figure, number) for number, figure in enumerate(figures) for one in figure.axes)
    texts = tuple(text for figure in figures for text in figure.texts)
    late = any(figure.finished is not None for figure in figures)
    finished = joined([figure.finished or figure for figure in figures]) if late else None
    return replace(figures[0], title="", xlabel="", ylabel="", legend=(), axes=axes, texts=texts, finished=finished)


def _alone(axes: Axes, figure: Figure, number: int) -> Axes:
    left, low, right, high = axes.position
    return replace(
        axes,
        title=axes.title or figure.title,
        xlabel=axes.xlabel or figure.xlabel,
        ylabel=axes.ylabel or figure.ylabel,
        legend=axes.legend + figure.legend,
        position=(number + left, number + low, number + right, number + high),  # over no panel of another figure
    )


def panels(figure: Figure, series: Mapping[str, Array]) -> list[Panel]:
    """The axes that hold at least one curve of data."""
    found = (_panel(axes, series) for axes in figure.visible_axes)
    return [panel for panel in found if panel.shown or panel.strange or panel.hidden]


def _panel(axes: Axes, series: Mapping[str, Array]) -> Panel:
    shown: list[Shown] = []
    hidden: list[Shown] = []
    strange = []
    for curve in axes.curves:
        if curve.kind == "nothing":
            continue
        match = _channel(curve, series)
        if match is not None:
            (shown if curve.visible else hidden).append(match)
        elif curve.visible and not is_reference(curve):
            strange.append(curve)
    seen = {match.channel for match in shown}  # one channel drawn twice hides itself
    shown += [match for match in hidden if match.channel in seen]
    return Panel(axes, tuple(shown), tuple(strange), tuple(match for match in hidden if match.channel not in seen))


def lacking(figures: Iterable[Figure], series: Mapping[str, Array]) -> bool:
    """Whether one of the six channels is drawn in none of these figures."""
    return len({channel for figure in figures for panel in panels(figure, series) for channel in panel.channels}) < 6


def is_reference(curve: Curve) -> bool:
    """Whether a curve is a line at a fixed value or moment: `axhline`, `axvline` and their like."""
    return len(curve.y) <= 2 or float(np.ptp(curve.y)) == 0.0 or float(np.ptp(curve.x)) == 0.0


def _channel(curve: Curve, series: Mapping[str, Array]) -> Shown | None:
    if len(curve.y) < FEWEST_POINTS:
        return None
    time = series["time"]
    for kind, stamps in _abscissae(curve.x, time):
        for sensor, key in enumerate(SENSORS):
            for axis in range(3):
                wanted = np.interp(stamps, time, series[key][:, axis])
                for unit, scale in _UNITS[sensor]:
                    if np.all(np.abs(curve.y - scale * wanted) <= _MATCH * scale * np.ptp(wanted)):
                        return Shown(sensor, axis, unit, kind, curve, _part(stamps, time))
    return None


def _part(stamps: Array, time: Array) -> tuple[float, float]:
    first, last = np.interp([stamps.min(), stamps.max()], time[[0, -1]], (0.0, 1.0))
    return float(first), float(last)


def _abscissae(x: Array, time: Array) -> list[tuple[str, Array]]:
    """What x may be, with the time stamps that follow: the readings under which x spans the recorded time, then a part of it.

    Rows of thinned data are counted anew, and spread over the recorded time: over a part of it nobody knows what they are.
    """
    rows = np.arange(len(time))
    kinds = [("s", x), ("ms", x / 1000), ("us", x / 1e6), ("ns", x / 1e9), ("s from start", x + time[0])]
    kinds.append(("date", (x - x[0]) * _DAY_S + time[0]))
    kinds += [("index", np.interp(x, rows, time)), ("index", np.interp(x - 1, rows, time))]
    spread = [("index", np.interp(x * ((len(time) - 1) / max(1, len(x) - 1)), rows, time))] * (len(x) < len(time))
    whole, part = (NEARLY_ALL, 2 - NEARLY_ALL), (_LEAST_PART, NEARLY_ALL)
    return [*_spanning(whole, kinds + spread, time), *_spanning(part, kinds, time)]


def _spanning(
    shares: tuple[float, float], kinds: Sequence[tuple[str, Array]], time: Array
) -> Iterator[tuple[str, Array]]:
    """The readings under which x spans at least the first of these shares of the recorded time, and less than the second."""
    least, most = (share * (time[-1] - time[0]) for share in shares)
    return ((kind, stamps) for kind, stamps in kinds if np.isfinite(stamps).all() and least <= np.ptp(stamps) < most)


_UNITS = (
    (("m/s²", 1.0), ("cm/s²", 100.0), ("g", 1 / 9.81), ("g", 1 / 9.80665), ("mg", 1000 / 9.81), ("mg", 1000 / 9.80665)),
    (("rad/s", 1.0), ("mrad/s", 1000.0), ("deg/s", 180 / np.pi)),
)
UNITS = tuple(tuple(unit for unit, _ in scales) for scales in _UNITS)
"""The units of each sensor, that of the recorded numbers first."""


def unit_in(rows: Array, true: Array, sensor: int) -> str:
    """The unit in which rows (n, 3) are as large as the true ones (m, 3), to a tenth; empty where they are in none."""
    size, whole = (float(np.sqrt(np.mean(each**2))) for each in (rows, true))
    return next((unit for unit, scale in _UNITS[sensor] if abs(size - scale * whole) <= scale * whole / 10), "")


# --- what else was recorded ----------------------------------------------------------------------------------------------


def as_recorded(own: Collection, series: Mapping[str, Array]) -> dict[str, Array]:
    """What a submission records beside the three series, as it would have recorded it of the true ones.

    Multiples of a series, of a column and of a magnitude are made anew; numbers stay, and other rows are stretched to the length.
    """
    return {name: _as_recorded(name, value, own, series) for name, value in own.extras.items()}


def _as_recorded(name: str, value: Array, own: Collection, series: Mapping[str, Array]) -> Array:
    if value.ndim == 0:
        return value
    derived = _derived(name, own, series)
    alike = [(true, rows) for rows, true in derived if rows.shape == value.shape and rows.any() == value.any()]
    for true, recorded in alike:
        scale = np.vdot(value, recorded) / max(np.vdot(recorded, recorded), 1e-300)
        if np.abs(value - scale * recorded).max() <= 1e-9 * max(1.0, np.abs(value).max()):
            return scale * true if recorded.any() else true
    if own.time is None or len(value) != len(own.time):
        return value
    stretched: Array = value[np.linspace(0, len(value) - 1, len(series["time"])).round().astype(int)]
    return stretched


def _derived(name: str, own: Collection, series: Mapping[str, Array]) -> Iterator[tuple[Array, Array]]:
    """What may follow from the three series, as recorded and as true: that which the name speaks of first."""
    if own.time is not None:
        yield own.time, series["time"]
    said, axis = column_named(name), axis_of(name)
    for key in sorted(SENSORS, key=lambda key: key != said):
        recorded, true = getattr(own, key), series[key]
        if recorded is not None:
            for i in sorted(range(3), key=lambda i: i != axis):
                yield recorded[:, i], true[:, i]
            yield recorded, true
            yield np.linalg.norm(recorded, axis=1), np.linalg.norm(true, axis=1)


# --- legends -------------------------------------------------------------------------------------------------------------


def names_of(panel: Panel, figure: Figure) -> list[str | None]:
    """What the reader is told about each shown curve: its legend entry, or a text beside it."""
    axes = panel.axes
    entries = [*axes.legend, *figure.legend]
    for other in figure.axes:
        if other is not axes and other.position == axes.position:
            entries += other.legend  # twin axes share one legend
    own = {s.curve.colour for s in panel.shown}
    neutral = [text for text in axes.texts if text.colour not in own]
    room = _NEAR * float(np.ptp(axes.y_limits))
    return [name_of(s.curve, entries, axes.texts) or _beside(s, neutral, room) for s in panel.shown]


def _beside(shown: Shown, texts: Sequence[Placed], room: float) -> str | None:
    """A text in a colour of its own that names the curve's axis and stands near it.

    Where curves run close together nobody can tell which of them such a text stands nearest to, so none is called wrong by it.
    """
    x, y = shown.curve.points
    for text in texts:
        at, height = text.place
        within = x.min() - _NEAR * np.ptp(x) <= at <= x.max() + _NEAR * np.ptp(x)
        if within and y.min() - room <= height <= y.max() + room and axis_of(text.text) == shown.axis:
            return text.text
    return None


def name_of(curve: Curve, entries: Sequence[Entry], texts: Sequence[Placed]) -> str | None:
    alike = [e for e in entries if e.colour == curve.colour]
    most = max((_likeness(e, curve) for e in alike), default=None)
    for entry in (e for e in alike if _likeness(e, curve) == most):
        if entry.text.strip() and not entry.text.startswith("_"):
            return entry.text
    return next((text.text for text in texts if text.text.strip() and text.colour == curve.colour), None)


def _likeness(entry: Entry, curve: Curve) -> tuple[bool, bool]:
    """How far a legend's sample looks like a curve of its colour: by style and marker, then by dashes, width and opacity."""
    return (entry.style, entry.marker) == (curve.style, curve.marker), entry.stroke == curve.stroke
