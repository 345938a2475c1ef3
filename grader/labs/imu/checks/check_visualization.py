"""Visualization: clear, labelled plots of the sensor data, judged by the figure that the code draws."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable

import numpy as np

from grader.base.errors import NoAnswer
from grader.base.text import printable
from grader.engine.check_runner import check
from grader.engine.figures import Figure
from grader.engine.findings import CheckFailed, Fault, Missing, Ours, Size, Skipped, raised
from grader.engine.traces import Traces
from grader.labs.imu.answers import Drawing
from grader.labs.imu.checks import curve_faults, handed_in, lost_pictures
from grader.labs.imu.checks.fitting import fits_in
from grader.labs.imu.checks.panel_words import has_empty_panel, is_named, label_problems, misnaming, quoted
from grader.labs.imu.checks.plot_runs import (
    SENSOR_WORDS,
    Plot,
    best_of,
    candidates,
    cut_off,
    drawing_or_fault,
    drawn_plot,
    finished,
    has_curves,
    plot_of,
    recorded_unit,
)
from grader.labs.imu.diagnosis import comparing, labels, plots
from grader.labs.imu.diagnosis.plots import Panel
from grader.labs.imu.student import Student

_COMPARISON = "filtered_imu.png"
_CURVES = "visualization.curves_match_data"
"""This charges what another check sees as well."""
_ALIKE = "a plot that shows the same numbers in every curve"
_SMALLEST_PX = (400, 250)
"""Below this the six curves and their labels cannot be told apart; matplotlib's default figure has 640 × 480."""
_OTHER_FORMS = ("pdf", "svg", "svgz", "eps", "ps", "pgf")


def _to_the_end(judge: Callable[[Student, Traces], None]) -> Callable[[Student, Traces], None]:
    """What is missing from a plot that an exception broke off is the exception's fault, and the finding says so."""

    @functools.wraps(judge)
    def judged(student: Student, truth: Traces) -> None:
        try:
            judge(student, truth)
        except (CheckFailed, Skipped, Missing):
            if handed_in.counts(student, truth):
                raise CheckFailed(
                    "a plot_imu_data that draws and saves the plot",
                    f"a picture {handed_in.PICTURE}, which plot_imu_data does not draw",
                    mistakes=["plot-not-saved"],
                    keeps=0.5,
                ) from None
            raised(drawing_or_fault(student, truth).fault, "plotting IMU data")
            raise

    return judged


Judge = Callable[[Plot], None]
"""Of a plot: what one of the checks says of it."""


def _better_one(student: Student, truth: Traces, plot: Plot) -> Plot:
    """The figure as it was saved, or as it is at its end: what its picture lacks of that is charged by the check of the picture."""
    at_its_end = finished(plot, truth)
    return plot if at_its_end is None or not _gains(student, truth, plot, at_its_end) else at_its_end


def _gains(student: Student, truth: Traces, before: Plot, after: Plot) -> int:
    """In how many respects a plot has become better; 0 where it has become worse in any."""
    gains = [_kept(judge, after) - _kept(judge, before) for judge in _respects(student, truth)]
    return sum(gain > 0 for gain in gains) if min(gains) >= 0 else 0


def _kept(judge: Judge, plot: Plot) -> float:
    try:
        judge(plot)
    except CheckFailed as lost:
        return lost.keeps
    return 1.0


def _saved_in_the_end(student: Student, truth: Traces, plot: Plot | None) -> None:
    """Charge what was drawn or written on the figure after it was saved, and is missing from its picture."""
    at_its_end = finished(plot, truth) if plot is not None else None
    if plot is None or at_its_end is None or not (gains := _gains(student, truth, plot, at_its_end)):
        return
    raise CheckFailed(
        "a picture of the finished figure",
        "a picture that was saved before the figure was finished",
        keeps=0.5 if gains == 1 else 0.0,
        hint=lost_pictures.SAVE_LAST,
        off=Size("a picture that was saved before the figure was finished"),
    )


@check("visualization.saves_image", lab_step=4)
@_to_the_end
def check_saves_image(student: Student, truth: Traces) -> None:
    """plot_imu_data saves a readable picture of the plot"""
    drawing = drawing_or_fault(student, truth)
    full = _saved_curves(drawing)
    if not full and drawing.figures:
        looks = {_look(figure) for figure in drawing.figures if has_curves(figure)}
        found = (f for d in student.scripts() for f in _saved_curves(d) if _look(f) in looks)
        full = list(itertools.islice(found, 1))
    if not full:
        lost_pictures.none_saved(drawing)
    lost_pictures.some_overwritten(candidates(student, truth, drawing))
    fits_in("plot_imu_data", drawing.departs, keeps=0.0)
    _saved_in_the_end(student, truth, best_of(candidates(student, truth, drawing)))
    width, height = max((figure.size_px for figure in full), key=lambda size: size[0] * size[1])
    if width < _SMALLEST_PX[0] or height < _SMALLEST_PX[1]:
        wanted = f"a picture of at least {_SMALLEST_PX[0]} × {_SMALLEST_PX[1]} pixels"
        raise CheckFailed(wanted, f"{width} × {height} pixels", mistakes=["low-resolution"], keeps=0.5)
    if all(figure.format in _OTHER_FORMS for figure in full):
        hint = Ours("Save imu_data.png, as the sheet asks. A PDF or an SVG may be saved as well (Step 4).")
        raise CheckFailed("a PNG picture", f"a picture only as {full[0].format.upper()}", keeps=0.8, hint=hint)


def _look(figure: Figure) -> tuple[tuple[str, str, int], ...]:
    """What makes a figure the same plot with other data: titles, labels, number of curves."""
    return tuple((axes.title, axes.ylabel, len(axes.curves)) for axes in figure.axes)


def _saved_curves(drawing: Drawing) -> list[Figure]:
    return [figure for figure in drawing.figures if figure.is_saved and has_curves(figure)]


@check("visualization.two_labelled_panels", lab_step=4)
@_to_the_end
def check_two_labelled_panels(student: Student, truth: Traces) -> None:
    """Acceleration and angular velocity have a panel each, which says what it shows"""
    _panels_say_what_they_show(_better_one(student, truth, plot_of(student, truth)))


def _panels_say_what_they_show(plot: Plot) -> None:
    if any(panel.mainly != {sensor} for sensor in (0, 1) for panel in plot.of_sensor(sensor)):
        raise CheckFailed("a panel of its own for each sensor", "both sensors on the same axes", mistakes=["one-panel"])
    unlabelled = []
    for sensor in (0, 1):
        for panel in plot.of_sensor(sensor):
            if wrong := misnaming(plot, panel, sensor):
                _named_as_the_other(panel, sensor, wrong)
        if not is_named(plot, sensor):
            unlabelled.append(SENSOR_WORDS[sensor])
    missing = [sensor for sensor in (0, 1) if not plot.of_sensor(sensor)]
    if missing and len(plot.panels) < 2:
        raise CheckFailed(
            "a panel for each sensor",
            f"no panel with the {SENSOR_WORDS[missing[0]]}",
            mistakes=["curves-missing"],
            belongs_to=_CURVES if has_empty_panel(plot, missing[0]) else "",
        )
    if unlabelled:
        got = f"no text on the panel that says {' or '.join(unlabelled)}"
        raise CheckFailed("panels whose title or axis label says what they show", got, keeps=0.5)


def _named_as_the_other(panel: Panel, sensor: int, wrong: list[str]) -> None:
    expected = f"a panel of the {SENSOR_WORDS[sensor]} that says so"
    got = f"a panel labelled {quoted(' | '.join(wrong))} that shows the {SENSOR_WORDS[sensor]}"
    if all(text in wrong for text in (panel.axes.title, panel.axes.ylabel) if text.strip()):
        raise CheckFailed(expected, got, mistakes=["panels-swapped"])
    hint = Ours(
        "Let title and label of a panel name the sensor that it shows. One of them names the other sensor (Step 4)."
    )
    raise CheckFailed(expected, got, mistakes=["panels-swapped"], keeps=0.5, hint=hint)


@check("visualization.curves_match_data", lab_step=4)
@_to_the_end
def check_curves_match_data(student: Student, truth: Traces) -> None:
    """Six curves show the six channels of the data against time"""
    _six_channels(student, truth, _better_one(student, truth, drawn_plot(student, truth)))


def _six_channels(student: Student, truth: Traces, plot: Plot) -> None:
    outside = cut_off(student, truth, plot)
    if len(plot.drawn - set(outside)) < 6:
        curve_faults.some_missing(plot, outside)
    curve_faults.against_no_time(plot)
    curve_faults.in_another_unit(plot, lambda sensor: recorded_unit(student, truth, sensor))
    curve_faults.drawn_in_part(plot)


@check("visualization.axis_labels_with_units", lab_step=4)
@_to_the_end
def check_axis_labels_with_units(student: Student, truth: Traces) -> None:
    """The axes are labelled, with units"""
    _axes_have_labels(_better_one(student, truth, plot_of(student, truth)))


def _axes_have_labels(plot: Plot) -> None:
    lost = label_problems(plot)
    if lost:
        mistakes = tuple(dict.fromkeys(mistake for mistake, _ in lost))
        keeps = round(1 - len(lost) / 3, 4) if len(lost) < 3 else 0.0
        raise CheckFailed(
            "labels such as “Acceleration (m/s²)” and “Time (s)”",
            "; ".join(text for _, text in lost),
            mistakes=mistakes,
            keeps=keeps,
        )


@check("visualization.legend_names_curves", lab_step=4)
@_to_the_end
def check_legend_names_curves(student: Student, truth: Traces) -> None:
    """A legend, or text beside the curves, tells the curves of a panel apart"""
    _curves_have_names(_better_one(student, truth, plot_of(student, truth)))


def _curves_have_names(plot: Plot) -> None:
    crowded = [panel for panel in plot.main_panels if len(panel.shown) > 1]
    nameless = []
    for panel in crowded:
        named = list(zip(panel.shown, plots.names_of(panel, plot.figure), strict=True))
        told = {(name, shown.channel) for shown, name in named if name}
        if {channel for _, channel in told} < panel.channels or len({name for name, _ in told}) < len(panel.channels):
            nameless.append(panel)
            continue
        if len(told) > len(panel.channels):
            continue  # one channel under several names: the curve is wrong, not its name
        for name, (_, axis) in sorted(told):
            said = labels.axis_of(name)
            if said is not None and said != axis:
                got = f"{quoted(name)} beside the curve of {'xyz'[axis]}"
                raise CheckFailed("legend entries that name their curves", got, mistakes=["legend-order-wrong"])
    if nameless:
        keeps = 0.5 if len(nameless) < len(crowded) else 0.0
        got = "curves without a name in a legend or a text" + (
            "" if len(nameless) == len(crowded) else " in one of the panels"
        )
        raise CheckFailed("a name for each curve of a panel", got, mistakes=["no-legend"], keeps=keeps)


@check("visualization.titles", lab_step=4)
@_to_the_end
def check_titles(student: Student, truth: Traces) -> None:
    """The panels, or the figure, have a title"""
    _panels_have_titles(_better_one(student, truth, plot_of(student, truth)))


def _panels_have_titles(plot: Plot) -> None:
    figure, panels = plot.figure, plot.titled_panels
    places = {axes.position for axes in figure.axes if axes.title.strip()}  # twin axes share a title
    titled = [panel.axes.position in places for panel in panels]
    if figure.title.strip() or any(len(text.strip()) > 2 for text in figure.texts) or (titled and all(titled)):
        return
    over = [panel for panel, has in zip(panels, titled, strict=True) if has]
    columns = {panel.axes.position[0] for panel in over} >= {panel.axes.position[0] for panel in panels}
    if columns and (len(panels) > 2 or all(len(labels.claims(panel.axes.title)) != 1 for panel in over)):
        return  # one title over each column of panels, or one that does not speak of a single sensor
    raise CheckFailed(
        "a title",
        "none" if not any(titled) else "a panel without one",
        mistakes=["no-title"],
        keeps=0.5 if any(titled) else 0.0,
    )


def _respects(student: Student, truth: Traces) -> tuple[Judge, ...]:
    six_channels = functools.partial(_six_channels, student, truth)
    return _panels_say_what_they_show, six_channels, _axes_have_labels, _curves_have_names, _panels_have_titles


_FILTER = "filtering.follows_recursion"
_DRAW_NOISE = Ours(
    "Read NoisyIMU in the loop, filter its reading, and draw both. Without noise the filter's effect cannot be seen (Step 6)."
)
_MORE_SAMPLES = Ours(
    "Read, filter and draw a few hundred samples. With fewer the filter's effect cannot be seen (Step 6)."
)
_OF_THEIR_OWN = Ours(
    "Raw and filtered data are one series: give each a list or an array of its own, as raw = filtered = [] makes one list with two "
    "names, and draw both (Step 6)."
)
_MEND_SCRIPT = Ours(
    "Run the file with python and fix the line where it stops. Nothing after that line is drawn (Step 6)."
)


@check("visualization.comparison_plot", lab_step=6)
def check_comparison_plot(student: Student, truth: Traces) -> None:
    """A saved plot shows raw and filtered data together"""
    drawn = late = False
    few = 0
    charged = _past_the_plot(student)
    broken_off: Fault | None = None
    seen = ""
    for drawing in student.scripts():
        broken_off = broken_off or (drawing.fault if drawing.fault != charged else None)
        seen = seen or next((_curves_in_words(figure) for figure in drawing.figures if _is_meant(figure)), "")
        pairs = [(figure, _compared(student, figure)) for figure in drawing.figures]
        compared = [(figure, of_it) for figure, of_it in pairs if of_it]
        saved = [of_it for figure, of_it in compared if figure.is_saved]
        if saved:
            _tell_of(drawing.fault, student)
            _names_are_right(saved)
            _noise_is_shown(saved, student)
            return
        drawn = drawn or bool(compared)
        late = late or any(_compared(student, figure.finished) for figure in drawing.figures if figure.finished)
        few = max([few, *(comparing.too_few(figure) for figure in drawing.figures if figure.is_saved)])
    if late and not drawn:
        got = "a picture that was saved before both curves were drawn"
        raise CheckFailed("a picture of raw and filtered data", got, keeps=0.5, hint=lost_pictures.SAVE_LAST)
    if few and not drawn:
        wanted = f"raw and filtered data of {plots.FEWEST_POINTS} samples or more"
        raise CheckFailed(wanted, f"{few} samples", keeps=0.5, hint=_MORE_SAMPLES)
    if drawn:
        if handed_in.shows_something(student, _COMPARISON):
            return
        raise CheckFailed(
            "a saved picture of raw and filtered data",
            "a figure that is not saved",
            mistakes=["comparison-missing"],
            keeps=0.5,
        )
    belongs_to = _FILTER if _is_defined(student, "plot_imu_data") and _stands_in_no_python(student) else ""
    if handed_in.shows_something(student, _COMPARISON):
        why = f"but code that draws {seen}" if seen else "but no code of the submission draws it"
        if broken_off:
            why = "but the code stops with an exception before it is drawn"
        got = f"{_COMPARISON}, {why}"
        raise CheckFailed(
            "code that draws raw and filtered data",
            got,
            mistakes=["comparison-missing"],
            keeps=0.5,
            belongs_to=belongs_to,
        )
    got = seen or f"no code that draws it, and no readable {_COMPARISON}"
    if broken_off is not None and broken_off.where:
        got += f"; the code stops with {broken_off.type} at {broken_off.where}"
    mistakes = (
        [] if broken_off else ["comparison-missing"]
    )  # an exception came first: what the script would draw is not known
    raise CheckFailed(
        "a picture with the raw and the filtered data",
        got,
        mistakes=mistakes,
        hint=_MEND_SCRIPT if broken_off else _OF_THEIR_OWN if seen == _ALIKE else "",
        fault=broken_off,
        belongs_to=belongs_to,
    )


def _stands_in_no_python(student: Student) -> bool:
    """Return whether the filter's file saves a picture and does not parse: what it would draw is not known."""
    if b"savefig" not in student.files.get("filters.py", b""):
        return False
    try:
        return bool(student.load("filters.py").unreadable)
    except NoAnswer:
        return False


def _is_defined(student: Student, name: str) -> bool:
    try:
        student.place_of(name)
    except (Missing, NoAnswer):
        return False
    return True


def _tell_of(fault: Fault | None, student: Student) -> None:
    """What a program does at its top level and cannot do is stepped over; where its import has told of that, it is known."""
    if fault is not None and fault.type == "AttributeError" and student.broken:
        return  # a stand-in has what the sheet gives it, and nothing of the submission's own
    if fault is not None and fault.where and not any(note.startswith(f"{fault.where} ") for note in student.notes):
        why = printable(fault.type or fault.message, 60)
        student.note(
            f"{fault.where} was stopped when the file was run: {why}. The grader skipped this line and ran the rest",
            Ours("A statement was stopped when a file was run as a script. The grader skipped it and ran the rest"),
        )


def _past_the_plot(student: Student) -> Fault | None:
    """Let scripts go on where `plot_imu_data` does not come to its end, which is charged: beside a stand-in. What it raised."""
    drawing = student.answered("plot")
    if drawing is None or drawing.fault is not None:
        student.replace_broken(["plot_imu_data"])
    return None if drawing is None else drawing.fault


def _compared(student: Student, figure: Figure) -> list[comparing.Compared]:
    """The raw and filtered curves; those of a filter that has been charged already go by their names."""
    found = comparing.comparisons(figure)
    return found or (comparing.named_comparisons(figure) if "LowPassFilter" in student.broken else [])


def _is_meant(figure: Figure) -> bool:
    """Whether a figure is meant to compare raw and filtered data: its file's name says so, or its curves' names."""
    return figure.file_name == _COMPARISON or bool(comparing.named_comparisons(figure))


def _curves_in_words(figure: Figure) -> str:
    series, unseen = comparing.series_drawn(figure), comparing.unseen(figure)
    alike = all(np.array_equal(one, series[0]) for one in series)
    longest = max(map(len, series), default=0)
    if 0 < longest < plots.FEWEST_POINTS:
        return f"a plot with {longest} samples at most"
    if len(series) > 1 and unseen and not alike:
        named = f" {quoted(unseen[0])}" if unseen[0] else ""
        return f"a plot on which the curve{named} cannot be seen"
    if len(series) < 2:
        nothing = "a plot of constant curves" if has_curves(figure) else "a plot without a curve"
        return "a plot with only one curve" if series else nothing
    if alike:
        return _ALIKE
    return f"a plot with {len(series)} curves, none of which is a smoother version of another"


def _names_are_right(saved: list[list[comparing.Compared]]) -> None:
    """No names are asked for here; but names that are exchanged tell the reader the opposite."""
    if all(any(pair.exchanged for pair in of_it) and not any(pair.in_order for pair in of_it) for of_it in saved):
        got = "the raw curve with the name of the filtered one"
        raise CheckFailed("each curve with its own name", got, mistakes=["legend-order-wrong"], keeps=0.5)


def _noise_is_shown(saved: list[list[comparing.Compared]], student: Student) -> None:
    """A filter takes noise away; where `NoisyIMU` adds none, that has been charged already."""
    if "NoisyIMU" in student.broken or any(pair.noisy for of_it in saved for pair in of_it):
        return
    raise CheckFailed("raw data with noise in it", "a raw curve without noise", keeps=0.5, hint=_DRAW_NOISE)
