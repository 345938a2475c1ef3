"""Measurement of the plot of the data (Step 4): which figure is judged, what can be seen of it, and which files hold it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from grader.base.errors import NoAnswer
from grader.engine.figures import Curve, Figure
from grader.engine.findings import (
    NEEDS_REVIEW,
    Charge,
    Charged,
    Cost,
    Deviation,
    GraderText,
    Missing,
    Raised,
    Skipped,
    StudentError,
)
from grader.engine.traces import Traces
from grader.labs.imu.answers import Drawing
from grader.labs.imu.collection import KEYS, SENSORS, Collection
from grader.labs.imu.returned import Array
from grader.labs.imu.robot import torso_ids
from grader.labs.imu.student import Student
from grader.labs.imu.visualization import compared_plots, curves
from grader.labs.imu.visualization.compared_plots import Comparison
from grader.labs.imu.visualization.curves import Channel, Plot
from grader.labs.imu.visualization.panel_words import labelled_units
from grader.labs.imu.visualization.pictures import PICTURE, was_handed_in

DOING = "plotting IMU data"
OF_WORDS = ("two_labelled_panels", "axis_labels_with_units", "legend_names_curves", "titles")
"""Checks that read the panels; what nobody sees has no words either."""
OF_PLOT = ("saves_image", "curves_match_data", *OF_WORDS)
_KEEPS = {"saves_image": 0.5} | dict.fromkeys(OF_PLOT[1:], 0.0)
"""Share of each check for a picture that no code draws: nobody knows what it shows."""
_NOT_THERE = ("KeyError", "AttributeError", "TypeError", "IndexError", "ValueError")
"""Exceptions of a plot that looks in a recording for what the sheet's recording does not have, or not in that form."""
_NEARER = 0.75
"""A curve of the data is so much nearer to a drawing of nearly the same numbers than to one of other numbers, in root mean square.

Curves of chance have a ratio of 1, within 0.04 for the run's 600 rows; lines that never change have none. Data with noise of 0.5
added at each call has 0.2 for the channel that changes most.
"""


@dataclass(frozen=True)
class File:
    """Properties of the picture files that `plot_imu_data` saves, for the check that it saves a readable picture.

    Attributes
    ----------
    size_px : size of the largest saved picture of the curves; (0, 0) without one
    formats : file formats of all saved pictures of the curves; empty if none is saved
    replaced, blank : why no file shows the curves: whether one was overwritten or deleted, whether an empty figure was saved
    handed_in : whether no file shows the curves and a picture under the lab sheet's name for it was handed in
    lost : the channels that only files overwritten later showed; empty if no file that is left shows curves
    """

    size_px: tuple[int, int] = (0, 0)
    formats: frozenset[str] = frozenset()
    replaced: bool = False
    blank: bool = False
    handed_in: bool = False
    lost: frozenset[Channel] = frozenset()


@dataclass(frozen=True)
class Facts:
    """All that is measured of a submission's plots: `measure` makes it, and the checks and the diagnosis read nothing else.

    Attributes
    ----------
    plot : the figure that shows most of the data
    file, comparison : the picture files of that plot, and the plots of raw and filtered data
    cut_off : the channels of which more than half lies outside the axis limits, with the share that is inside
    recorded : for each sensor, the unit of the submission's own recording, which a label may name instead of that drawn; "" if
        all labels fit what is drawn, or if the unit is unknown
    error : the exception that stopped `plot_imu_data`; None if it ran to its end
    departs : the sheet's names of parameters that `plot_imu_data` renames or moves; "global …" if it reads a global in place of one
    stopped : by name of a check, the exception with which it ends because its property could not be measured
    """

    plot: Plot
    file: File = field(default_factory=File)
    comparison: Comparison = field(default_factory=Comparison)
    cut_off: Mapping[Channel, float] = field(default_factory=dict)
    recorded: tuple[str, str] = ("", "")
    error: StudentError | None = None
    departs: tuple[str, ...] = ()
    stopped: Mapping[str, Exception] = field(default_factory=dict)


_NO_PLOT = Plot(Figure("shown", None, "", (0, 0)), [])


def measure(student: Student, truth: Traces) -> Facts:
    """Return the `Facts` of what `plot_imu_data` draws of a scenario in `truth`, and of what the files draw when they are run."""
    try:
        drawing = drawing_of_data(student, truth)
        if drawing.error is not None and drawing.error.type in _NOT_THERE:
            _note_missing_recording(student, truth)
        if drawing.error is not None and not drawing.figures:
            raise Raised(drawing.error, DOING)
    except (Missing, NoAnswer, Raised) as stop:
        stopped = _drawn_by_no_code(student) or dict.fromkeys(OF_PLOT, stop)
        return Facts(_NO_PLOT, comparison=compared_plots.measure(student), stopped=stopped)
    plots = candidates(student, truth, drawing)
    plot, file = best_of(plots) or _NO_PLOT, _file(student, drawing, plots)
    stopped = {} if any(map(curves.has_curves, drawing.figures)) else _drawn_by_no_code(student)
    outside: Mapping[Channel, float] = {}
    if not stopped:
        outside = _cut_off(student, truth, plot)
        stopped = _unseen(student, truth, plot, outside)
    if drawing.error is not None:
        stopped = {name: Raised(drawing.error, DOING) for name in stopped}
    return Facts(
        plot,
        file,
        compared_plots.measure(student),
        outside,
        _recorded_units(student, truth, plot),
        drawing.error,
        tuple(drawing.departs),
        stopped,
    )


# ---- what is drawn of given data ----


def series_of(truth: Traces, run: str = "tumbling") -> dict[str, Array]:
    return {key: truth[run][key] for key in KEYS}


def drawing_of_data(student: Student, truth: Traces, run: str = "tumbling") -> Drawing:
    """Return what `plot_imu_data` draws of the true data of scenario `run`, under the keys that the submission records."""
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


def _note_missing_recording(student: Student, truth: Traces) -> None:
    """Note that the plot could not be tried on the submission's own recording, if its recorder returns none.

    The plot may need more than the sheet's recording holds, and nobody knows what. So a person has to look.
    """
    with student.without_standins():
        own = _own_recording(student, truth)
    if own is None or not any(rows is not None for rows in own.sensors):
        student.note(
            GraderText(
                "plot_imu_data stopped on the sheet's recording, and your simulate_and_collect returns none. If the plot needs "
                f"more than the sheet records, {NEEDS_REVIEW}"
            )
        )


def _data(own: Collection | None, series: dict[str, Array]) -> dict[str, Array]:
    """Return the true series under the keys of the submission's own recording; under the sheet's if it has none or no names."""
    if own is None or any(name.isdigit() for name in own.keys.values()):
        return series
    return {own.keys.get(key, key): value for key, value in series.items()}


def _recorded_units(student: Student, truth: Traces, plot: Plot) -> tuple[str, str]:
    """Return, by sensor, the unit of the submission's own recording where a label names another unit than is drawn; else "".

    Such a label is right for the submission's own data, and only wrong for the data that the plot is given here.
    """
    asked = {shown.sensor for shown, _, said in labelled_units(plot) if said not in (None, shown.unit)}
    if not asked:
        return "", ""
    with student.without_standins():
        own = _own_recording(student, truth)
    rows = [own.sensors[sensor] if own and sensor in asked else None for sensor in (0, 1)]
    accel, gyro = (
        "" if each is None or not len(each) else curves.unit_in(each, truth["push"][SENSORS[sensor]], sensor)
        for sensor, each in enumerate(rows)
    )
    return accel, gyro


# ---- which figure is judged ----


def candidates(student: Student, truth: Traces, drawing: Drawing) -> list[Plot]:
    """Return the plots from which `best_of` chooses: each figure of `drawing`, and its saved figures joined into one.

    Two or more are joined, for code that draws each sensor in its own figure: once without and once with those whose file was
    overwritten or deleted later. Curves are matched with the plotted data: the true ones, or what the student's
    `simulate_and_collect` gave to the plot (`drawing.given`).
    """
    saved = [figure for figure in drawing.figures if figure.is_saved]
    ever_saved = [figure for figure in drawing.figures if figure.is_saved or figure.event == "overwritten"]
    joined = [curves.joined(figures) for figures in (saved, ever_saved) if len(figures) > 1]
    series = drawing.given or series_of(truth)
    return student.once("plots", lambda: [Plot(f, curves.panels(f, series)) for f in (*drawing.figures, *joined)])


def best_of(plots: Sequence[Plot]) -> Plot | None:
    """Return the plot with most of the six channels, in a tie the first saved, else the first; None if none has curves of data."""
    drawn = (plot for plot in plots if plot.panels)
    return max(drawn, key=lambda plot: (len(plot.drawn), plot.figure.is_saved), default=None)


def _file(student: Student, drawing: Drawing, plots: Sequence[Plot]) -> File:
    saved = _saved_curves(drawing)
    if not saved and drawing.figures:
        looks = {_appearance(figure) for figure in drawing.figures if curves.has_curves(figure)}
        found = (figure for d in student.scripts() for figure in _saved_curves(d) if _appearance(figure) in looks)
        saved = list(itertools.islice(found, 1))
    events = {figure.event for figure in drawing.figures if curves.has_curves(figure)}
    shown, gone = (
        {channel for plot in plots if plot.figure.event == event for channel in plot.drawn}
        for event in ("saved", "overwritten")
    )
    return File(
        size_px=max((figure.size_px for figure in saved), key=lambda size: size[0] * size[1], default=(0, 0)),
        formats=frozenset(figure.format for figure in saved),
        replaced=not saved and "overwritten" in events,
        blank=not saved and any(figure.is_saved for figure in drawing.figures),
        handed_in=not saved and was_handed_in(student, PICTURE),
        lost=frozenset(gone - shown) if saved else frozenset(),
    )


def _saved_curves(drawing: Drawing) -> list[Figure]:
    return [figure for figure in drawing.figures if figure.is_saved and curves.has_curves(figure)]


def _appearance(figure: Figure) -> tuple[tuple[str, str, int], ...]:
    """Return by what a figure is recognised if a script draws it of other data: titles, labels, number of curves."""
    return tuple((axes.title, axes.ylabel, len(axes.curves)) for axes in figure.axes)


def _drawn_by_no_code(student: Student) -> dict[str, Exception]:
    """Return by check what a handed-in picture costs that no code draws; nothing if there is no picture.

    It earns half of the check of the file. Nobody can read its curves, so a note asks a person whether the rest is earned.
    """
    if not was_handed_in(student, PICTURE):
        return {}
    student.note(
        GraderText(
            f"{PICTURE} was handed in, and plot_imu_data does not draw it. The grader cannot read its curves and labels; "
            f"{NEEDS_REVIEW}"
        )
    )
    return {
        name: Charged(Charge(f"visualization.{name}", (Cost("plot-not-drawn", 1 - kept, Deviation({})),)))
        for name, kept in _KEEPS.items()
    }


# ---- what is seen of it ----


def _cut_off(student: Student, truth: Traces, plot: Plot) -> dict[Channel, float]:
    """Return the channels that the axis limits cut off of the lab's own recording, with the share inside; none if no limit cuts.

    Limits in the code are chosen for the data that the code records. So that is drawn, too, where they leave out data given here.
    """
    if not plot.is_cropped:
        return {}
    drawing = drawing_of_data(student, truth, "push")
    series = drawing.given or series_of(truth, "push")
    of_lab = best_of([Plot(figure, curves.panels(figure, series)) for figure in drawing.figures]) or plot
    return {channel: share for channel, share in of_lab.cut_off().items() if channel in plot.drawn}


def _unseen(student: Student, truth: Traces, plot: Plot, outside: Mapping[Channel, float]) -> dict[str, Exception]:
    """Return by check why panels cannot be judged: no curves, none that a reader sees, or none made of the data; else nothing."""
    if not plot.panels:
        return dict.fromkeys((*OF_WORDS, "curves_match_data"), Skipped("a figure with curves"))
    if any(shown.channel not in outside or shown.curve.visible_parts.seen.any() for shown in plot.shown):
        return {}
    if not plot.strange:
        return dict.fromkeys(OF_WORDS, Skipped("a figure with visible curves"))
    if not plot.drawn and not _follows_data(student, truth, plot):
        return dict.fromkeys(OF_WORDS, Skipped("a figure of the data: no curve changes when the data changes"))
    return {}


def _follows_data(student: Student, truth: Traces, plot: Plot) -> bool:
    """Return whether a curve that shows no channel is made of the data, such as a norm, so that its labels count.

    The plot is asked twice more, with the same time stamps: of nearly the same numbers, and of the rows in another order. A curve
    made of the data stays nearer to the first than to the second, also if chance is added at each call.
    """
    series = series_of(truth)
    order = np.random.default_rng(0).permutation(len(series["time"]))
    nearly = {"time": series["time"]} | {key: series[key] * (1 + 1e-9) for key in SENSORS}
    mixed = {"time": series["time"]} | {key: series[key][order] for key in SENSORS}
    again, other = (_curves_of(student, truth, each) for each in (nearly, mixed))
    each = zip(_curves(plot), again, other, strict=False)
    return any(all(_nearer(a.y, b.y, c.y, order) for order in range(3)) for a, b, c in each)


def _nearer(one: Array, two: Array, three: Array, order: int) -> bool:
    """Return whether `one` is nearer to `two` than to `three` in differences of an order; those tell a random walk from data."""
    first, second, other = (np.diff(each, n=order) for each in (one, two, three))
    return _distance(first, second) < _NEARER * _distance(first, other)


def _curves(plot: Plot) -> list[Curve]:
    return [curve for axes in plot.figure.visible_axes for curve in axes.curves]


def _curves_of(student: Student, truth: Traces, series: dict[str, Array]) -> list[Curve]:
    own = _own_recording(student, truth)
    drawing = student.plot(data=_data(own, series), sheet=series, ids=torso_ids(truth))
    best = best_of([Plot(figure, curves.panels(figure, series)) for figure in drawing.figures])
    return [] if best is None else _curves(best)


def _distance(y: Array, other: Array) -> float:
    """Return the root mean square difference of two curves; infinite if they differ in length or are empty."""
    if y.shape != other.shape or not y.size:
        return math.inf
    return float(np.sqrt(np.mean((y - other) ** 2)))
