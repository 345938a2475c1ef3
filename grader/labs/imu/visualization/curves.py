"""Recognition of the curves in a figure: which channel of the data each one shows, what is seen of it, and what it is called.

A channel is one axis of one sensor. Curves are matched with the numbers that the plot function was given, not by their labels.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from grader.engine.figures import Axes, Curve, Entry, Figure, Placed
from grader.labs.imu.collection import SENSORS
from grader.labs.imu.returned import Array
from grader.labs.imu.visualization.labels import axis_of

_DAY_S = 86400.0  # matplotlib counts dates in days
FEWEST_POINTS = 50
"""A curve that is thinned to fewer points hides the motion. The sheet's 1,500 samples may be thinned to 200; here there are 600."""
_MATCH = 1e-3
"""Largest difference, as a share of the channel's range over the time of the curve.

Thinned and single-precision data agree to 1e-6, a smoothed or shifted curve misses by 0.01 and more.
"""
NEARLY_ALL = 0.9
"""Share of the recorded time; a curve over this much of it is drawn in full."""
_LEAST_PART = 0.05  # of the recorded time: a curve over less shows no motion

Channel = tuple[int, int]
"""Sensor 0 or 1, axis 0 to 2."""
CHANNELS: tuple[Channel, ...] = tuple((sensor, axis) for sensor in (0, 1) for axis in range(3))
SENSOR_WORDS = ("acceleration", "angular velocity")
_ENOUGH = 0.5
"""Share of a channel's drawn time that has to lie within the limits; a plot that shows less is a detail."""


@dataclass(frozen=True)
class Shown:
    """A drawn curve whose numbers are those of one channel of the data; checks compare this channel with labels and legends.

    Attributes
    ----------
    sensor, axis : the channel: sensor 0 (acceleration) or 1 (angular velocity), axis 0 to 2
    unit, x : the unit in which the values are drawn, and the kind of x values, such as ``s``, ``ms`` or ``index``
    drawn : the hundredths (0 to 99) of the recorded time over which the curve is drawn
    """

    sensor: int
    axis: int
    unit: str
    x: str
    curve: Curve
    drawn: range = range(100)

    @property
    def channel(self) -> Channel:
        return self.sensor, self.axis

    @property
    def share_inside(self) -> float:
        """Share (0 to 1) of the curve that lies within the axis limits, counted in a hundred parts of its x range."""
        return float(self.curve.visible_parts.inside.mean())


@dataclass(frozen=True)
class Panel:
    """Axes that plot data: curves of the six channels (`shown`), such curves that cannot be seen (`hidden`), others (`strange`)."""

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
        """The sensor (0 acceleration, 1 angular velocity) that most curves show; both in a tie, empty without curves of data."""
        counts = Counter(s.sensor for s in self.shown)
        return {sensor for sensor in counts if counts[sensor] == max(counts.values())}

    @property
    def area(self) -> float:
        left, low, right, high = self.axes.position
        return (right - left) * (high - low)

    def is_inset_of(self, other: Panel) -> bool:
        """Return whether this panel repeats, much smaller, channels of another panel, and so needs no labels of its own."""
        return bool(self.channels) and self.channels <= other.channels and self.area < other.area / 2

    @property
    def words(self) -> str:
        """The title and the y label of the panel, joined by " | ", in which the name of a sensor is looked for."""
        return " | ".join([self.axes.title, self.axes.ylabel])


@dataclass(frozen=True)
class Plot:
    """The figure that is judged as the plot of the data, with its panels: the axes on which it draws data."""

    figure: Figure
    panels: list[Panel]

    @property
    def main_panels(self) -> list[Panel]:
        """The panels that need axis labels and names of curves: all but insets, which repeat another panel."""
        return [panel for panel in self.panels if not any(map(panel.is_inset_of, self.panels))]

    @property
    def titled_panels(self) -> list[Panel]:
        """The `main_panels` that need a title: those that show a channel, not only other numbers; if none does, all of them."""
        return [panel for panel in self.main_panels if panel.shown] or self.main_panels

    def of_sensor(self, sensor: int) -> list[Panel]:
        """Return the panels that mainly show a sensor (0 acceleration, 1 angular velocity); if none, all that show it at all."""
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
        """The channels that the code draws and that nobody can see in any panel, such as below other curves."""
        return {shown.channel for panel in self.panels for shown in panel.hidden} - self.drawn

    @property
    def strange(self) -> list[Curve]:
        return [curve for panel in self.panels for curve in panel.strange]

    @property
    def abscissae(self) -> set[str]:
        """The kinds of x values (``s``, ``ms``, ``index``, …) of the curves that show a channel, to compare with the x label."""
        return {shown.x for shown in self.shown}

    @property
    def x_labels(self) -> list[str]:
        """Texts that may label the time axis: one for each panel ("" without one), then the label and texts of the whole figure."""
        return [panel.axes.xlabel for panel in self.panels] + [self.figure.xlabel, *self.figure.texts]

    @property
    def own_ticks(self) -> bool:
        """True if the code sets tick labels of the time axis itself: these may be in another unit than the x values."""
        return any(panel.axes.own_ticks for panel in self.panels)

    def of_channel(self, channel: Channel) -> list[Shown]:
        return [shown for shown in self.shown if shown.channel == channel]

    def in_part(self) -> dict[Channel, float]:
        """Return the channels that are drawn over less than 0.9 of the recorded time, each with its share of that time."""
        drawn = {c: {part for shown in self.of_channel(c) for part in shown.drawn} for c in sorted(self.drawn)}
        return {channel: len(parts) / 100 for channel, parts in drawn.items() if len(parts) < 100 * NEARLY_ALL}

    def cut_off(self) -> dict[Channel, float]:
        """Return the channels of which more than half lies outside the axis limits, each with the share that lies inside."""
        shares = {channel: sum(s.share_inside for s in self.of_channel(channel)) for channel in sorted(self.drawn)}
        return {channel: share for channel, share in shares.items() if share < _ENOUGH}

    @property
    def is_cropped(self) -> bool:
        """True if curves leave the axis limits or the code sets y limits: a plot of the sheet's push then tells what is cut off."""
        return any(panel.axes.own_height for panel in self.panels) or any(s.share_inside < 1 for s in self.shown)


def joined(figures: Sequence[Figure]) -> Figure:
    """Return several figures as one, for code that draws one for each sensor; axes take over labels and legend of their figure."""
    axes = tuple(_moved_axes(one, figure, number) for number, figure in enumerate(figures) for one in figure.axes)
    texts = tuple(text for figure in figures for text in figure.texts)
    return replace(figures[0], title="", xlabel="", ylabel="", legend=(), axes=axes, texts=texts)


def _moved_axes(axes: Axes, figure: Figure, number: int) -> Axes:
    """Return axes for a joined figure: labelled by their own figure where they have no label, and at a place of their own."""
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
    """Return the visible axes of a figure that hold a curve of data, each curve matched with `series`: the recorded rows by key."""
    found = (_panel(axes, series) for axes in figure.visible_axes)
    return [panel for panel in found if panel.shown or panel.strange or panel.hidden]


def _panel(axes: Axes, series: Mapping[str, Array]) -> Panel:
    """Match the curves of one set of axes with the recorded channels, and sort out those that cannot be seen.

    If a channel is drawn twice, one curve hides the other. The hidden one then counts as shown.
    """
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
    seen = {match.channel for match in shown}
    shown += [match for match in hidden if match.channel in seen]
    return Panel(axes, tuple(shown), tuple(strange), tuple(match for match in hidden if match.channel not in seen))


def has_curves(figure: Figure) -> bool:
    """Return whether a figure draws a curve of more than two points, to tell a plot from a blank figure that is saved."""
    return any(curve.n > 2 for axes in figure.visible_axes for curve in axes.curves)


def lacking(figures: Iterable[Figure], series: Mapping[str, Array]) -> bool:
    """Return whether a channel of `series` (rows by key) is seen in no figure: the plot may need data in the student's own form."""
    return len({channel for figure in figures for panel in panels(figure, series) for channel in panel.channels}) < 6


def is_reference(curve: Curve) -> bool:
    """Return whether a curve is no data: a line at a fixed value or moment, as `axhline` draws, or one of at most two points."""
    return len(curve.y) <= 2 or float(np.ptp(curve.y)) == 0.0 or float(np.ptp(curve.x)) == 0.0


def _channel(curve: Curve, series: Mapping[str, Array]) -> Shown | None:
    """Return the channel that a curve shows, for any meaning of x, sensor, axis, unit; None if none fits or points are few."""
    if len(curve.y) < FEWEST_POINTS:
        return None
    time = series["time"]
    for kind, stamps in _abscissae(curve.x, time):
        for sensor, key in enumerate(SENSORS):
            for axis in range(3):
                wanted = np.interp(stamps, time, series[key][:, axis])
                for unit, scale in _UNITS[sensor]:
                    if np.all(np.abs(curve.y - scale * wanted) <= _MATCH * scale * np.ptp(wanted)):
                        first, last = np.interp([stamps.min(), stamps.max()], time[[0, -1]], (0, 100))
                        return Shown(sensor, axis, unit, kind, curve, range(round(first), round(last)))
    return None


def _abscissae(x: Array, time: Array) -> list[tuple[str, Array]]:
    """Return what x values may mean, as kind and time stamps, those that span the recorded time first, then those of a part of it.

    Rows of thinned data may be counted anew, and are then spread over the recorded time.
    """
    rows = np.arange(len(time))
    kinds = [("s", x), ("ms", x / 1000), ("us", x / 1e6), ("ns", x / 1e9), ("s from start", x + time[0])]
    kinds.append(("date", (x - x[0]) * _DAY_S + time[0]))
    kinds += [("index", np.interp(x, rows, time)), ("index", np.interp(x - 1, rows, time))]
    if len(x) < len(time):
        kinds.append(("index", np.interp(x * ((len(time) - 1) / max(1, len(x) - 1)), rows, time)))
    spans = [float(np.ptp(stamps) / np.ptp(time)) for _, stamps in kinds]
    whole = [kind for kind, span in zip(kinds, spans, strict=True) if NEARLY_ALL <= span < 2 - NEARLY_ALL]
    return whole + [kind for kind, span in zip(kinds, spans, strict=True) if _LEAST_PART <= span < NEARLY_ALL]


_UNITS = (
    (("m/s²", 1.0), ("cm/s²", 100.0), ("g", 1 / 9.81), ("g", 1 / 9.80665), ("mg", 1000 / 9.81), ("mg", 1000 / 9.80665)),
    (("rad/s", 1.0), ("mrad/s", 1000.0), ("deg/s", 180 / np.pi)),
)
UNITS = tuple(tuple(unit for unit, _ in scales) for scales in _UNITS)
"""The units of each sensor, that of the recorded numbers first."""


def factor_of(shown: Shown) -> str:
    """Return in words the factor from the data to the numbers that a curve shows: "57.3 times" for deg/s, "1 times" if equal."""
    return f"{dict(_UNITS[shown.sensor])[shown.unit]:.3g} times"


def unit_in(rows: Array, true: Array, sensor: int) -> str:
    """Return the unit of `rows` of sensor 0 (acceleration) or 1 (rate): that in which `true` (SI) has their RMS to 10 %, or ""."""
    size, whole = (float(np.sqrt(np.mean(each**2))) for each in (rows, true))
    return next((unit for unit, scale in _UNITS[sensor] if abs(size - scale * whole) <= scale * whole / 10), "")


# --- legends -------------------------------------------------------------------------------------------------------------


def names_of(panel: Panel, figure: Figure) -> list[str | None]:
    """Return each shown curve's name: by `names_of_curves`, else a text in no shown curve's colour naming its axis, else None."""
    own = {s.curve.colour for s in panel.shown}
    neutral = [text for text in panel.axes.texts if text.colour not in own]
    names = names_of_curves([s.curve for s in panel.shown], panel, figure)
    beside = [next((text.text for text in neutral if axis_of(text.text) == s.axis), None) for s in panel.shown]
    return [name or text for name, text in zip(names, beside, strict=True)]


def names_of_curves(curves: Iterable[Curve], panel: Panel, figure: Figure) -> list[str | None]:
    """Return the name of each of `curves`: its entry in a legend of panel or figure, else a text in its colour; else None."""
    axes = panel.axes
    entries = [*axes.legend, *figure.legend]
    for other in figure.axes:
        if other is not axes and other.position == axes.position:
            entries += other.legend  # twin axes share one legend
    return [name_of(curve, entries, axes.texts) for curve in curves]


def name_of(curve: Curve, entries: Sequence[Entry], texts: Sequence[Placed]) -> str | None:
    """Return the text of the legend entry whose sample looks most like the curve, else one of `texts` in its colour, else None."""
    alike = [e for e in entries if e.colour == curve.colour]
    most = max((_likeness(e, curve) for e in alike), default=None)
    for entry in (e for e in alike if _likeness(e, curve) == most):
        if entry.text.strip() and not entry.text.startswith("_"):
            return entry.text
    return next((text.text for text in texts if text.text.strip() and text.colour == curve.colour), None)


def _likeness(entry: Entry, curve: Curve) -> tuple[bool, bool]:
    """Return how far a legend's sample looks like a curve, for `max`: by style and marker, then by dashes, width and opacity."""
    return (entry.style, entry.marker) == (curve.style, curve.marker), entry.stroke == curve.stroke
