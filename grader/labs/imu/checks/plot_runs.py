"""What the checks of the plot judge: the figure that `plot_imu_data` draws of given data, and what is seen of each channel."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from grader.base.errors import NoAnswer
from grader.engine.figures import Curve, Figure, Mask, Sight
from grader.engine.findings import Missing, Raised, Skipped, raised
from grader.engine.traces import Traces
from grader.labs.imu.answers import KEYS, SENSORS, Array, Collection, Drawing
from grader.labs.imu.diagnosis import plots
from grader.labs.imu.diagnosis.plots import Channel, Panel, Shown
from grader.labs.imu.diagnosis.visibility import together
from grader.labs.imu.recordings import torso_ids
from grader.labs.imu.student import Student

CHANNELS: tuple[Channel, ...] = tuple((sensor, axis) for sensor in (0, 1) for axis in range(3))
SENSOR_WORDS = ("acceleration", "angular velocity")
_ENOUGH = 0.5
"""Of a channel's time. A plot may leave out how a recording begins; one that shows less than half is a detail of a plot."""

_OF_RUN = 0.9999
"""Correlation of a curve with a channel that it shows in any unit; a smooth function of time has less with a swaying robot."""

_MADE_OF = 0.7
"""Correlation with rows in no order: 50 points that are not made of them reach it once in 10 million channels."""


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
        """Those of them that show the data; what else is drawn beside these may stand without a title."""
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
        """What the curves are drawn against."""
        return {shown.x for shown in self.shown}

    @property
    def x_labels(self) -> list[str]:
        """What is written along the time axis, wherever that may stand; empty where nothing is."""
        return [panel.axes.xlabel for panel in self.panels] + [self.figure.xlabel, *self.figure.texts]

    @property
    def own_ticks(self) -> bool:
        """Whether the numbers beside the time axis may be others than those that are drawn."""
        return any(panel.axes.own_ticks for panel in self.panels)

    def sight(self, channel: Channel) -> Sight:
        """What is seen of a channel in all panels together."""
        return together(shown.sight for shown in self.shown if shown.channel == channel)

    def drawn_of(self, channel: Channel) -> Mask:
        """Over which parts of the recorded time a channel is drawn, in all panels together."""
        drawn: Mask = np.any([shown.drawn for shown in self.shown if shown.channel == channel], axis=0)
        return drawn

    def in_part(self) -> dict[Channel, Mask]:
        """The channels that are drawn over a part of the recorded time alone, with that part."""
        parts = {channel: self.drawn_of(channel) for channel in CHANNELS if channel in self.drawn}
        return {channel: part for channel, part in parts.items() if part.mean() < plots.NEARLY_ALL}

    @property
    def is_cropped(self) -> bool:
        """Whether no panel shows a channel to its last point, or might not with other data: matplotlib's limits leave none out."""
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


def series_of(truth: Traces, run: str = "tumbling") -> dict[str, Array]:
    return {key: truth[run][key] for key in KEYS}


def drawing_of_data(student: Student, truth: Traces, run: str = "tumbling") -> Drawing:
    """What `plot_imu_data` draws of a run, given under the names under which the submission itself records it."""
    series = series_of(truth, run)
    own = _own_recording(student, truth)
    return student.plot(
        data=_data(own, series),
        sheet=series,
        ids=torso_ids(truth),
        called="plot" if run == "tumbling" else "",
        own_form=own is not None and bool(own.oddities),
    )


def _own_recording(student: Student, truth: Traces) -> Collection | None:
    try:
        return student.simulate(duration_s=float(truth["push"].scalars["duration_s"]), ids=torso_ids(truth))
    except (NoAnswer, Missing, Raised):
        return None


def recorded_unit(student: Student, truth: Traces, sensor: int) -> str:
    """In which unit the submission itself records a sensor of the lab's run, by its own reader; empty where that is not known."""
    with student.without_standins():
        own = _own_recording(student, truth)
    rows = None if own is None else own.sensors[sensor]
    return "" if rows is None or not len(rows) else plots.unit_in(rows, truth["push"][SENSORS[sensor]], sensor)


def _data(own: Collection | None, series: dict[str, Array]) -> dict[str, Array]:
    """The true series under the submission's own names, with what else it records."""
    if own is None or any(name.isdigit() for name in own.keys.values()):
        return series
    return {own.keys.get(key, key): value for key, value in series.items()} | plots.as_recorded(own, series)


def drawing_or_fault(student: Student, truth: Traces) -> Drawing:
    drawing = drawing_of_data(student, truth)
    if drawing.fault is not None and not drawing.figures:
        raised(drawing.fault, "plotting IMU data")
    return drawing


def plot_of(student: Student, truth: Traces) -> Plot:
    """The figure that shows most; Skipped where none has a curve that a reader sees."""
    plot = drawn_plot(student, truth)
    outside = cut_off(student, truth, plot)
    if plot.drawn - {channel for channel in outside if not plot.sight(channel).seen.any()}:
        return plot
    if not plot.strange:
        raise Skipped("a figure with visible curves")
    if not plot.drawn and not student.once("follows data", lambda: _follows_data(student, truth, plot)):
        raise Skipped("a figure of the data: no curve changes when the data changes")
    return plot


def _follows_data(student: Student, truth: Traces, plot: Plot) -> bool:
    """Return whether a curve that shows no channel is made of the data: of what the plot is given, or of a run of its own.

    The plot is asked twice more, with stamps that stay: with numbers that are nearly the same, and with the rows in another order.
    A curve made of the data stays with the first and changes with the second, or is like a channel of the second: numbers in no
    order are like nothing else.
    """
    series = series_of(truth)
    order = np.random.default_rng(0).permutation(len(series["time"]))
    nearly = {"time": series["time"]} | {key: series[key] * (1 + 1e-9) for key in SENSORS}
    mixed = {"time": series["time"]} | {key: series[key][order] for key in SENSORS}
    again, other = (_curves_of(student, truth, each) for each in (nearly, mixed))
    curves = zip(_curves(plot), again, other, strict=False)
    return (
        any(_is_alike(one, two) and not _is_alike(one, three) for one, two, three in curves)
        or any(_likeness(curve, mixed) >= _MADE_OF for curve in other)
        or any(_likeness(curve, series_of(truth, "push")) >= _OF_RUN for curve in plot.strange)
    )


def _curves(plot: Plot) -> list[Curve]:
    return [curve for axes in plot.figure.visible_axes for curve in axes.curves]


def _curves_of(student: Student, truth: Traces, series: dict[str, Array]) -> list[Curve]:
    own = _own_recording(student, truth)
    drawing = student.plot(data=_data(own, series), sheet=series, ids=torso_ids(truth))
    best = best_of([Plot(figure, plots.panels(figure, series)) for figure in drawing.figures])
    return [] if best is None else _curves(best)


def _is_alike(curve: Curve, other: Curve) -> bool:
    """Return whether two curves agree to a thousandth of their height."""
    if curve.y.shape != other.y.shape:
        return False
    return bool(np.abs(curve.y - other.y).max(initial=0.0) <= 1e-3 * np.ptp(curve.y))


def _likeness(curve: Curve, series: dict[str, Array]) -> float:
    """Return the largest correlation of a curve against seconds with a channel, without its sign; 0 for less than half a run."""
    time = series["time"]
    within = (curve.x >= time[0]) & (curve.x <= time[-1]) & np.isfinite(curve.y)
    x, y = curve.x[within], curve.y[within]
    if len(x) < plots.FEWEST_POINTS or np.ptp(x) < _ENOUGH * np.ptp(time) or not np.ptp(y):
        return 0.0
    channels = np.stack([np.interp(x, time, series[key][:, axis]) for key in SENSORS for axis in range(3)])
    return float(np.abs(np.corrcoef(y, channels)[0, 1:]).max())


def drawn_plot(student: Student, truth: Traces) -> Plot:
    """The figure that shows most, whether a reader sees it or not."""
    drawing = drawing_or_fault(student, truth)
    best = best_of(candidates(student, truth, drawing))
    if best is None or not best.panels:
        raise Skipped("a figure with curves")
    return best


def finished(plot: Plot, truth: Traces) -> Plot | None:
    """The figure as it is at its end; None where nothing was drawn or written on it after it was saved."""
    figure = plot.figure.finished
    return None if figure is None else Plot(figure, plots.panels(figure, series_of(truth)))


def candidates(student: Student, truth: Traces, drawing: Drawing) -> list[Plot]:
    """Each figure, and those that were saved as one: a picture for each sensor. Of equal ones the first counts."""
    saved = [figure for figure in drawing.figures if figure.is_saved]
    ever_saved = [figure for figure in drawing.figures if figure.is_saved or figure.event == "overwritten"]
    joined = [plots.joined(figures) for figures in (saved, ever_saved) if len(figures) > 1]
    series = series_of(truth)
    return student.once("plots", lambda: [Plot(f, plots.panels(f, series)) for f in (*drawing.figures, *joined)])


def best_of(drawn: Sequence[Plot]) -> Plot | None:
    """The one that shows most; the first of equal ones."""
    return max(drawn, key=_showing, default=None)


def _showing(plot: Plot) -> tuple[int, int, bool]:
    return len(plot.drawn), len(plot.hidden), plot.figure.is_saved


def cut_off(student: Student, truth: Traces, plot: Plot) -> dict[Channel, Sight]:
    """The channels that the limits of the axes cut off of the recording of the lab.

    Limits that are written into the code are chosen for the data that the code records. So that is drawn, too, where they leave
    anything outside of the data that the plot was given here; of a channel that it does not show, this data tells.
    """
    if not plot.is_cropped:
        return {}
    series = series_of(truth, "push")
    figures = drawing_of_data(student, truth, "push").figures
    of_lab = max((Plot(f, plots.panels(f, series)) for f in figures), key=_showing, default=Plot(plot.figure, []))
    here = {channel: sight for channel, sight in plot.cut_off().items() if channel not in of_lab.drawn}
    return here | {channel: sight for channel, sight in of_lab.cut_off().items() if channel in plot.drawn}


def has_curves(figure: Figure) -> bool:
    return any(curve.n > 2 for axes in figure.visible_axes for curve in axes.curves)


def sensors_in_words(sensors: Iterable[int]) -> str:
    return " and ".join(SENSOR_WORDS[sensor] for sensor in sorted(sensors))
