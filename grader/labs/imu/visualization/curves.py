"""Facts about a figure of the data: which curve shows which channel, what is seen of it, and under which name.

Curves are matched with the data that the plot function was given, not by their labels.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from grader.engine.figures import PARTS, Axes, Curve, Entry, Figure, Mask, Placed, Sight
from grader.labs.imu.answers import SENSORS, Array, Collection, column_named
from grader.labs.imu.visualization.labels import axis_of

_DAY_S = 86400.0  # matplotlib counts dates in days
FEWEST_POINTS = 50
"""A curve that is thinned to fewer points hides the motion. The sheet's 1,500 samples may be thinned to 200; here there are 600."""
_NEAR = 0.2  # of a panel's width or height: what is farther from a curve is not beside it
_MATCH = 1e-3
"""Largest difference, as a share of the channel's range over the time of the curve.

Thinned and single-precision data agree to 1e-6, a smoothed or shifted curve misses by 0.01 and more.
"""
NEARLY_ALL = 0.9
"""Share of the recorded time; a curve over this much of it is drawn in full."""
_LEAST_PART = 0.05  # of the recorded time: a curve over less shows no motion

_MIDDLES = (np.arange(PARTS) + 0.5) / PARTS

Channel = tuple[int, int]
"""Sensor 0 or 1, axis 0 to 2."""
CHANNELS: tuple[Channel, ...] = tuple((sensor, axis) for sensor in (0, 1) for axis in range(3))
SENSOR_WORDS = ("acceleration", "angular velocity")
_ENOUGH = 0.5
"""Share of a channel's drawn time that has to lie within the limits; a plot that shows less is a detail."""


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
        """The visible parts of the recorded time."""
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
        """Return whether any point of a curve lies outside the limits of the axes."""
        limits = (sorted(self.axes.x_limits), sorted(self.axes.y_limits))
        return any(bool(np.any((v < low) | (v > high))) for v, (low, high) in zip(curve.points, limits, strict=True))

    def is_inset_of(self, other: Panel) -> bool:
        """Return whether it repeats, much smaller, what another panel shows; that one has the names for both."""
        return bool(self.channels) and self.channels <= other.channels and self.area < other.area / 2

    @property
    def words(self) -> str:
        """Everything that is written on the panel to say what it shows."""
        return " | ".join([self.axes.title, self.axes.ylabel])


@dataclass(frozen=True)
class Plot:
    """The figure under judgement, and its panels."""

    figure: Figure
    panels: list[Panel]

    @property
    def main_panels(self) -> list[Panel]:
        """The panels that need words of their own: all but the insets."""
        return [panel for panel in self.panels if not any(map(panel.is_inset_of, self.panels))]

    @property
    def titled_panels(self) -> list[Panel]:
        """The main panels that show the data; others may stand without a title."""
        return [panel for panel in self.main_panels if panel.shown] or self.main_panels

    def of_sensor(self, sensor: int) -> list[Panel]:
        """The sensor's own panels; where it has none, those that it shares."""
        own = [panel for panel in self.panels if panel.mainly == {sensor}]
        return own or [panel for panel in self.panels if sensor in panel.sensors]

    @property
    def shown(self) -> list[Shown]:
        return [shown for panel in self.panels for shown in panel.shown]

    @property
    def drawn(self) -> set[Channel]:
        return {shown.channel for shown in self.shown}

    @property
    def hidden(self) -> set[Channel]:
        """The channels whose curves are drawn, and that nobody sees in any panel."""
        return {shown.channel for panel in self.panels for shown in panel.hidden} - self.drawn

    @property
    def strange(self) -> list[Curve]:
        return [curve for panel in self.panels for curve in panel.strange]

    @property
    def abscissae(self) -> set[str]:
        """The kinds of x values of the curves."""
        return {shown.x for shown in self.shown}

    @property
    def x_labels(self) -> list[str]:
        """Texts along the time axis, wherever they may stand; "" where there is none."""
        return [panel.axes.xlabel for panel in self.panels] + [self.figure.xlabel, *self.figure.texts]

    @property
    def own_ticks(self) -> bool:
        """True if the numbers beside the time axis may be others than those that are drawn."""
        return any(panel.axes.own_ticks for panel in self.panels)

    def sight(self, channel: Channel) -> Sight:
        """Return the visible parts of a channel in all panels together."""
        sights = [shown.sight for shown in self.shown if shown.channel == channel]
        return Sight(np.any([each.inside for each in sights], axis=0), np.any([each.seen for each in sights], axis=0))

    def drawn_of(self, channel: Channel) -> Mask:
        """Over which parts of the recorded time a channel is drawn, in all panels together."""
        drawn: Mask = np.any([shown.drawn for shown in self.shown if shown.channel == channel], axis=0)
        return drawn

    def in_part(self) -> dict[Channel, Mask]:
        """The channels that are drawn over a part of the recorded time alone, with that part."""
        parts = {channel: self.drawn_of(channel) for channel in CHANNELS if channel in self.drawn}
        return {channel: part for channel, part in parts.items() if part.mean() < NEARLY_ALL}

    @property
    def is_cropped(self) -> bool:
        """Return whether some channel has points outside the limits in every panel that draws it.

        Also True if the code sets the limits of y itself: other data may lie outside them.
        """
        if any(panel.axes.own_height for panel in self.panels):
            return True
        drawn = [(panel, shown) for panel in self.panels for shown in panel.shown]
        return bool(self.drawn - {shown.channel for panel, shown in drawn if not panel.leaves_out(shown.curve)})

    def cut_off(self) -> dict[Channel, Sight]:
        """The channels that the limits of the axes leave outside for the most part of what is drawn of them."""
        sights = {channel: self.sight(channel) for channel in CHANNELS if channel in self.drawn}
        return {
            channel: sight
            for channel, sight in sights.items()
            if sight.inside.sum() < _ENOUGH * self.drawn_of(channel).sum()
        }


def joined(figures: Sequence[Figure]) -> Figure:
    """Several figures as the panels of one, each with what its own figure says of all its panels."""
    axes = tuple(_alone(one, figure, number) for number, figure in enumerate(figures) for one in figure.axes)
    texts = tuple(text for figure in figures for text in figure.texts)
    return replace(figures[0], title="", xlabel="", ylabel="", legend=(), axes=axes, texts=texts)


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


def has_curves(figure: Figure) -> bool:
    return any(curve.n > 2 for axes in figure.visible_axes for curve in axes.curves)


def lacking(figures: Iterable[Figure], series: Mapping[str, Array]) -> bool:
    """Return whether one of the six channels is drawn in none of these figures."""
    return len({channel for figure in figures for panel in panels(figure, series) for channel in panel.channels}) < 6


def is_reference(curve: Curve) -> bool:
    """Return whether a curve is a line at a fixed value or moment, such as `axhline` and `axvline`."""
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
    """Return the kinds that x may be, with time stamps: those that span the recorded time first, then those of a part of it.

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


def factor_of(shown: Shown) -> str:
    """Return how many times the given numbers a curve draws."""
    return f"{dict(_UNITS[shown.sensor])[shown.unit]:.3g} times"


def unit_in(rows: Array, true: Array, sensor: int) -> str:
    """The unit in which rows (n, 3) are as large as the true ones (m, 3), to a tenth; empty where they are in none."""
    size, whole = (float(np.sqrt(np.mean(each**2))) for each in (rows, true))
    return next((unit for unit, scale in _UNITS[sensor] if abs(size - scale * whole) <= scale * whole / 10), "")


# --- what else was recorded ----------------------------------------------------------------------------------------------


def as_recorded(own: Collection, series: Mapping[str, Array]) -> dict[str, Array]:
    """Return what a submission records beside the three series, as it would have recorded it of the true ones.

    Multiples of a series, of a column and of a magnitude are made anew; everything else stays.
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
    return value


def _derived(name: str, own: Collection, series: Mapping[str, Array]) -> Iterator[tuple[Array, Array]]:
    """Yield what may follow from the three series, as recorded and as true: first what the name speaks of."""
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
    """Return the name of each shown curve: its legend entry, or a text beside it."""
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
    """Return how far a legend's sample looks like a curve of its colour: by style and marker, then by dashes, width and opacity."""
    return (entry.style, entry.marker) == (curve.style, curve.marker), entry.stroke == curve.stroke
