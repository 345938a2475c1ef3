"""Visualization: clear, labelled plots of the sensor data, judged by the figure that the code draws."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterable, Mapping
from pathlib import PurePath

import numpy as np

from grader.engine.examination import check
from grader.engine.figures import Figure, Sight
from grader.engine.findings import A_PERSON_MAY, Fault, Lost, Missing, Skipped, raised
from grader.engine.traces import Traces
from grader.ground.text import printable
from grader.labs.imu.answers import Drawing
from grader.labs.imu.checks import handed_in
from grader.labs.imu.checks.fitting import fits_in
from grader.labs.imu.checks.plot_runs import (
    CHANNELS,
    Plot,
    candidates,
    drawing_or_fault,
    drawn_plot,
    has_curves,
    limits_fit,
    plot_of,
    share,
)
from grader.labs.imu.diagnosis import comparing, labels, plots
from grader.labs.imu.diagnosis.plots import Channel, Panel
from grader.labs.imu.student import Student

_COMPARISON = "filtered_imu.png"
_CURVES = "visualization.curves_match_data"
"""This charges what another check sees as well."""
_SMALLEST_PX = (400, 250)
"""Below this the six curves and their labels cannot be told apart; matplotlib's default figure has 640 × 480."""
_NONE_AS_GIVEN = (
    "Draw what plot_imu_data is given: its arrays from the first row to the last, against its time in s (Step 4)."
)
_OTHER_FORMS = ("pdf", "svg", "svgz", "eps", "ps", "pgf")
_SENSOR_WORDS = ("acceleration", "angular velocity")


def _to_the_end(judge: Callable[[Student, Traces], None]) -> Callable[[Student, Traces], None]:
    """What is missing from a plot that an exception broke off is the exception's fault, and the finding says so."""

    @functools.wraps(judge)
    def judged(student: Student, truth: Traces) -> None:
        try:
            judge(student, truth)
        except (Lost, Skipped, Missing):
            if handed_in.counts(student, truth):
                raise Lost(
                    "code that draws and saves the plot",
                    f"{handed_in.PICTURE}, which shows both sensors, and no code that draws it",
                    mistakes=["plot-not-saved"],
                    keeps=0.5,
                ) from None
            raised(drawing_or_fault(student, truth).fault, "plotting IMU data")
            raise

    return judged


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
        return _not_saved(student, truth, drawing)
    _nothing_is_overwritten(candidates(student, truth, drawing))
    fits_in(student, "plot_imu_data", drawing.departs, keeps=0.0)
    width, height = max((figure.size_px for figure in full), key=lambda size: size[0] * size[1])
    if width < _SMALLEST_PX[0] or height < _SMALLEST_PX[1]:
        wanted = f"a picture of at least {_SMALLEST_PX[0]} × {_SMALLEST_PX[1]} pixels"
        raise Lost(wanted, f"{width} × {height} pixels", mistakes=["low-resolution"], keeps=0.5)
    if all(figure.format in _OTHER_FORMS for figure in full):
        hint = "The sheet asks for imu_data.png; a PDF or an SVG may lie beside it (Step 4)."
        raise Lost("a PNG picture", f"a picture as {full[0].format.upper()} alone", keeps=0.8, hint=hint)


def _look(figure: Figure) -> tuple[tuple[str, str, int], ...]:
    """What makes a figure the same plot with other data: titles, labels, number of curves."""
    return tuple((axes.title, axes.ylabel, len(axes.curves)) for axes in figure.axes)


def _saved_curves(drawing: Drawing) -> list[Figure]:
    return [figure for figure in drawing.figures if figure.is_saved and has_curves(figure)]


def _nothing_is_overwritten(drawn: list[Plot]) -> None:
    """What a figure showed that is in no file at the end is lost to the reader."""
    standing, gone = (
        {channel for plot in drawn if plot.figure.event == event for channel in plot.drawn}
        for event in ("saved", "overwritten")
    )
    if gone - standing:
        path = next(plot.figure.path for plot in drawn if plot.figure.event == "overwritten")
        missing = " and ".join(_SENSOR_WORDS[s] for s in (0, 1) if s in {sensor for sensor, _ in gone - standing})
        raise Lost(
            "each figure in a picture file of its own",
            f"{_shown(path or handed_in.PICTURE)}, saved a second time, without the {missing}",
            mistakes=["picture-overwritten"],
            keeps=0.5,
        )


def _not_saved(student: Student, truth: Traces, drawing: Drawing) -> None:
    events = {figure.event for figure in drawing.figures if has_curves(figure)}
    broken = next((picture for picture in drawing.strange if picture.reason), None)
    if events & {"overwritten", "forgotten"} and broken is not None:
        hint = "Let savefig write the whole file, under a name that ends in .png, and leave it as it is afterwards (Step 4)."
        raise Lost("a picture that can be read", f"{_shown(broken.path)}, which no program can open", hint=hint)
    if "overwritten" in events:
        hint = "Save the figure last, under a name that nothing else is written to afterwards (Step 4)."
        got = "a file in which the figure no longer stands at the end"
        raise Lost(f"a picture of the curves, {handed_in.PICTURE}", got, mistakes=["picture-overwritten"], hint=hint)
    if any(figure.is_saved for figure in drawing.figures):
        raise Lost("a picture of the curves", "a picture that was saved from an empty figure", mistakes=["blank-image"])
    if handed_in.shows_something(student, handed_in.PICTURE) and not drawing.figures:
        if not handed_in.counts(student, truth):
            student.note(f"{handed_in.PICTURE} was handed in, and no code draws it: {A_PERSON_MAY} for what it shows")
        got = f"{handed_in.PICTURE}, which no code draws, and on which the recording was not recognised"
        raise Lost("code that draws and saves the plot", got, mistakes=["plot-not-saved"], keeps=0.5)
    drawn = "a figure that is drawn and never saved" if events else "no figure"
    if "forgotten" in events:
        drawn = "a figure that is saved to memory, and never written to a file"
    raise Lost(f"a saved picture, {handed_in.PICTURE}", drawn, mistakes=["plot-not-saved"])


@check("visualization.two_labelled_panels", lab_step=4)
@_to_the_end
def check_two_labelled_panels(student: Student, truth: Traces) -> None:
    """Acceleration and angular velocity have a panel each, which says what it shows"""
    plot = plot_of(student, truth)
    if any(panel.mainly != {sensor} for sensor in (0, 1) for panel in plot.of_sensor(sensor)):
        raise Lost("a panel of its own for each sensor", "both sensors on the same axes", mistakes=["one-panel"])
    unlabelled = []
    for sensor in (0, 1):
        for panel in plot.of_sensor(sensor):
            if wrong := _misnaming(plot, panel, sensor):
                _named_as_the_other(panel, sensor, wrong)
        if not _is_named(plot, sensor):
            unlabelled.append(_SENSOR_WORDS[sensor])
    missing = [_SENSOR_WORDS[s] for s in (0, 1) if not plot.of_sensor(s)]
    if missing and len(plot.panels) < 2:
        raise Lost(
            "a panel for each sensor",
            f"no panel with the {missing[0]}",
            mistakes=["curves-missing"],
            belongs_to=_CURVES if _has_empty_panel(plot, _SENSOR_WORDS.index(missing[0])) else "",
        )
    if unlabelled:
        got = f"nothing on the panel that says {' or '.join(unlabelled)}"
        raise Lost("panels that say what they show, by title or axis label", got, keeps=0.5)


def _has_empty_panel(plot: Plot, sensor: int) -> bool:
    """Whether axes without a curve say that they are this sensor's."""
    drawn = [panel.axes for panel in plot.panels]
    return any(
        sensor in labels.claims(axes.title) | labels.claims(axes.ylabel)
        for axes in plot.figure.visible_axes
        if axes not in drawn
    )


def _misnaming(plot: Plot, panel: Panel, sensor: int) -> list[str]:
    """What is written on a panel of this sensor and speaks of the other one alone."""
    texts = [panel.axes.title, panel.axes.ylabel]
    if not _shown_elsewhere(plot, 1 - sensor, panel):
        return []
    if labels.claims(texts[0]) | labels.claims(texts[1]) == {1 - sensor}:
        return [text for text in texts if text.strip()]
    return [text for text in texts if labels.names_only(1 - sensor, text)]


def _named_as_the_other(panel: Panel, sensor: int, wrong: list[str]) -> None:
    expected = f"{_SENSOR_WORDS[sensor]} under its own name"
    got = f"a panel labelled “{_shown(' | '.join(wrong))}” that shows the {_SENSOR_WORDS[sensor]}"
    if all(text in wrong for text in (panel.axes.title, panel.axes.ylabel) if text.strip()):
        raise Lost(expected, got, mistakes=["panels-swapped"])
    hint = (
        "Let the title and the label of a panel name the sensor that it shows; a copied line names the other (Step 4)."
    )
    raise Lost(expected, got, mistakes=["panels-swapped"], keeps=0.5, hint=hint)


def _shown_elsewhere(plot: Plot, sensor: int, panel: Panel) -> bool:
    """Whether another panel shows the sensor that this one claims; if none does, the wrong data is drawn, not the wrong panel."""
    return any(other is not panel and sensor in other.sensors for other in plot.panels)


def _is_named(plot: Plot, sensor: int) -> bool:
    """Whether a reader can tell which sensor it is; missing labels and titles are charged by their own checks."""
    panels = plot.of_sensor(sensor)
    if not panels or any(sensor in labels.claims(p.words) for p in panels):
        return True
    title_only = all(not p.axes.ylabel.strip() for p in panels) or all(not p.axes.title.strip() for p in panels)
    names = [name or "" for p in panels for name in plots.names_of(p, plot.figure)]
    whole = [plot.figure.title, plot.figure.ylabel, *names, *(text.text for p in panels for text in p.axes.texts)]
    written = any(p.words.replace("|", "").strip() for p in panels)
    return any(sensor in labels.claims(text) for text in whole) or (title_only and written)


@check("visualization.curves_match_data", lab_step=4)
@_to_the_end
def check_curves_match_data(student: Student, truth: Traces) -> None:
    """Six curves show the six channels of the data against time"""
    try:
        _six_channels(student, truth)
    finally:
        handed_in.hold_against_code(student, truth)


def _six_channels(student: Student, truth: Traces) -> None:
    plot = drawn_plot(student, truth)
    cut_off = {} if limits_fit(student, truth, plot) else plot.cut_off()
    shown = plot.drawn - set(cut_off)
    if len(shown) < 6:
        _some_are_missing(plot, cut_off)
    _axis_is_time(plot)
    _scale_is_labelled(plot)


def _some_are_missing(plot: Plot, cut_off: Mapping[Channel, Sight]) -> None:
    shown = plot.drawn - set(cut_off)
    strange = [curve for panel in plot.panels for curve in panel.strange]
    missing = set(CHANNELS) - plot.drawn - plot.hidden
    got, mistakes = [], []
    if missing:
        twice = sum(len(panel.shown) for panel in plot.panels) > len(plot.drawn)
        got.append(
            f"no curve that shows {_named(missing)}" + (f"; {len(strange)} that show something else" if strange else "")
        )
        mistakes.append("wrong-data-plotted" if strange or twice else "curves-missing")
    if plot.hidden:
        got.append(
            f"{_named(plot.hidden)} in the code and not in the picture: covered, clipped, or in the colour of what is behind"
        )
        mistakes.append("curves-not-seen")
    if cut_off:
        got.append(_outside(cut_off))
        mistakes.append("curves-not-seen")
    raise Lost(
        "six curves, one for each channel of the data",
        "; ".join(got),
        mistakes=list(dict.fromkeys(mistakes)),
        keeps=len(shown) / 6 if shown else 0.0,
        hint="" if plot.drawn or plot.hidden or not strange else _NONE_AS_GIVEN,
    )


def _named(channels: Iterable[Channel]) -> str:
    of_sensors = [(_SENSOR_WORDS[s], ["xyz"[axis] for sensor, axis in sorted(channels) if sensor == s]) for s in (0, 1)]
    return " and ".join(f"{word} {', '.join(axes)}" for word, axes in of_sensors if axes)


def _outside(cut_off: Mapping[Channel, Sight]) -> str:
    """Which part of the curves lies outside the limits: that of the channel that loses most."""
    inside = min((sight.inside for sight in cut_off.values()), key=lambda mask: float(mask.mean()))
    if not inside.any():
        return f"{_named(cut_off)} outside the limits of the axes"
    first, last = np.flatnonzero(inside)[[0, -1]]
    ends = f"the last {99 - last} % of the time" if first < 5 and last < 95 else f"{share(~inside)} % of the time"
    ends = f"the first {first} % of the time" if first >= 5 and last >= 95 else ends
    return f"{ends} of {_named(cut_off)} outside the limits of the axes"


def _axis_is_time(plot: Plot) -> None:
    kinds = {s.x for panel in plot.panels for s in panel.shown}
    if "index" in kinds:
        raise Lost("curves against time", "curves against the sample's index", mistakes=["x-not-time"], keeps=0.5)
    labelled = [labels.plain(text) for text in _x_labels(plot)]
    said = not any(labelled) or any(unit in text for text in labelled for unit in ("ms", "milli", "мс"))
    if "ms" in kinds and not said and not _own_ticks(plot):
        raise Lost(
            "curves against time in the unit of the label",
            "curves against milliseconds",
            mistakes=["x-not-time"],
            keeps=0.5,
        )


def _own_ticks(plot: Plot) -> bool:
    """Whether the numbers beside the time axis may be others than those that are drawn."""
    return any(panel.axes.own_ticks for panel in plot.panels)


def _scale_is_labelled(plot: Plot) -> None:
    for panel in plot.panels:
        texts = (panel.axes.ylabel, plot.figure.ylabel, panel.axes.title)
        said = next(filter(None, map(labels.unit_of, texts)), None)
        for shown in panel.shown:
            family = plots.UNITS[shown.sensor]
            wrong = said in family and said != shown.unit
            unsaid = said is None and shown.unit != family[0]
            if wrong or unsaid:
                got = f"numbers in {shown.unit} under the label “{_shown(panel.axes.ylabel)}”"
                hint = f"Draw the values as they were recorded, or write {shown.unit} into the label (Step 4)."
                raise Lost(
                    "numbers in the unit of the label", got, mistakes=["wrong-data-plotted"], keeps=0.5, hint=hint
                )


@check("visualization.axis_labels_with_units", lab_step=4)
@_to_the_end
def check_axis_labels_with_units(student: Student, truth: Traces) -> None:
    """The axes are labelled, with units"""
    plot = plot_of(student, truth)
    lost: list[tuple[str, str]] = []
    for sensor in (0, 1):
        panels = plot.of_sensor(sensor)
        written = [p.axes.ylabel for p in panels] + [plot.figure.ylabel]
        named = [name or "" for p in panels for name in plots.names_of(p, plot.figure)]
        beside = [*(p.axes.title for p in panels), *plot.figure.texts, *named]
        elsewhere = {text for panel in panels for text in _misnaming(plot, panel, sensor)}
        if panels and elsewhere.isdisjoint(written):  # the other sensor's label: another check charges that name
            lost += _label_problem(written, beside, sensor)
    if all(map(plot.of_sensor, (0, 1))):  # the label may have stood on the panel that is missing
        lost += _time_problem(plot)
    if lost:
        mistakes = tuple(dict.fromkeys(mistake for mistake, _ in lost))
        keeps = round(1 - len(lost) / 3, 4) if len(lost) < 3 else 0.0
        raise Lost(
            "labels such as “Acceleration (m/s²)” and “Time (s)”",
            "; ".join(text for _, text in lost),
            mistakes=mistakes,
            keeps=keeps,
        )


def _label_problem(texts: list[str], beside: list[str], sensor: int) -> list[tuple[str, str]]:
    written, what = [text for text in texts if text.strip()], _SENSOR_WORDS[sensor]
    if not written:
        told = any(labels.has_unit_of(sensor, text) and sensor in labels.claims(text) for text in beside)
        return [] if told else [("no-axis-labels", f"no label on the y axis of the {what}")]
    if any(labels.has_unit_of(sensor, text) for text in written + beside):
        return []
    return [("no-units", f"“{_shown(written[0])}” without a unit of {what} on its y axis")]


def _time_problem(plot: Plot) -> list[tuple[str, str]]:
    written = [label for label in _x_labels(plot) if label.strip()]
    if not written:
        return [("no-axis-labels", "no label on the time axis")]
    with_unit = [label for label in written if labels.has_time_unit(label)]
    if not with_unit and not any(map(labels.counts_samples, written)):
        return [("no-units", f"“{_shown(written[0])}” without a unit on the time axis")]
    seconds = {s.x for panel in plot.panels for s in panel.shown} <= {"s", "s from start"}
    if with_unit and all(map(labels.in_milliseconds, with_unit)) and seconds and not _own_ticks(plot):
        return [("no-units", f"“{_shown(with_unit[0])}” under a time axis in seconds")]
    return []


def _x_labels(plot: Plot) -> list[str]:
    return [panel.axes.xlabel for panel in plot.panels] + [plot.figure.xlabel, *plot.figure.texts]


@check("visualization.legend_names_curves", lab_step=4)
@_to_the_end
def check_legend_names_curves(student: Student, truth: Traces) -> None:
    """A legend, or text beside the curves, tells the curves of a panel apart"""
    plot = plot_of(student, truth)
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
                got = f"“{_shown(name)}” beside the curve of {'xyz'[axis]}"
                raise Lost("legend entries that name their curves", got, mistakes=["legend-order-wrong"])
    if nameless:
        keeps = 0.5 if len(nameless) < len(crowded) else 0.0
        got = "curves that no legend and no text names" + (
            "" if len(nameless) == len(crowded) else " in one of the panels"
        )
        raise Lost("a name for each curve of a panel", got, mistakes=["no-legend"], keeps=keeps)


@check("visualization.titles", lab_step=4)
@_to_the_end
def check_titles(student: Student, truth: Traces) -> None:
    """The panels, or the figure, have a title"""
    plot = plot_of(student, truth)
    figure, panels = plot.figure, plot.titled_panels
    places = {axes.position for axes in figure.axes if axes.title.strip()}  # twin axes share a title
    titled = [panel.axes.position in places for panel in panels]
    if figure.title.strip() or any(len(text.strip()) > 2 for text in figure.texts) or (titled and all(titled)):
        return
    columns = {panel.axes.position[0] for panel, has in zip(panels, titled, strict=True) if has}
    if len(panels) > 2 and columns >= {panel.axes.position[0] for panel in panels}:
        return  # one title over each column of panels
    raise Lost(
        "a title",
        "none" if not any(titled) else "a panel without one",
        mistakes=["no-title"],
        keeps=0.5 if any(titled) else 0.0,
    )


_FILTER = "filtering.follows_recursion"
_NO_PYTHON = ("SyntaxError", "IndentationError", "TabError")
"""What a file cannot be read with: nobody knows what it would draw, and what it defines is charged where it is missed."""
_DRAW_NOISE = (
    "Read NoisyIMU in the loop, filter that and draw both: without noise nobody sees what a filter does (Step 6)."
)
_MEND_SCRIPT = "Run the file by itself and mend what stops it: what it draws after that line is not drawn (Step 6)."


@check("visualization.comparison_plot", lab_step=6)
def check_comparison_plot(student: Student, truth: Traces) -> None:
    """A saved plot shows raw and filtered data together"""
    drawn = unread = False
    broken_off: Fault | None = None
    seen = ""
    for drawing in student.scripts():
        broken_off = broken_off or drawing.fault
        unread = unread or (drawing.fault is not None and drawing.fault.type in _NO_PYTHON)
        seen = seen or next((_curves_in_words(figure) for figure in drawing.figures if _is_meant(figure)), "")
        pairs = [(figure, _compared(student, figure)) for figure in drawing.figures]
        compared = [(figure, of_it) for figure, of_it in pairs if of_it]
        saved = [of_it for figure, of_it in compared if figure.is_saved]
        if saved:
            _names_are_right(saved)
            _noise_is_shown(saved, student)
            return
        drawn = drawn or bool(compared)
    if drawn:
        if handed_in.shows_something(student, _COMPARISON):
            return
        raise Lost(
            "a saved picture of raw and filtered data",
            "a figure that is not saved",
            mistakes=["comparison-missing"],
            keeps=0.5,
        )
    if handed_in.shows_something(student, _COMPARISON):
        why = f"and code that draws {seen}" if seen else "which no code of the submission draws"
        if broken_off:
            why = "and code that stops with an exception before it is drawn"
        got = f"{_COMPARISON}, {why}"
        raise Lost("code that draws raw and filtered data", got, mistakes=["comparison-missing"], keeps=0.5)
    got = seen or f"no code that draws it and no readable {_COMPARISON}"
    if broken_off is not None and broken_off.where:
        got += f"; the code stops with {broken_off.type} at {broken_off.where}"
    mistakes = (
        [] if broken_off else ["comparison-missing"]
    )  # an exception came first: what the script would draw is not known
    raise Lost(
        "a picture with the raw and the filtered series in it",
        got,
        mistakes=mistakes,
        hint=_MEND_SCRIPT if broken_off else "",
        fault=broken_off,
        belongs_to=_FILTER if unread else "",
    )


def _compared(student: Student, figure: Figure) -> list[comparing.Compared]:
    """The raw and filtered curves; those of a filter that has been charged already go by their names."""
    found = comparing.comparisons(figure)
    return found or (comparing.named_comparisons(figure) if "LowPassFilter" in student.broken else [])


def _is_meant(figure: Figure) -> bool:
    """Whether a figure is meant to compare raw and filtered data: its file's name says so, or its curves' names."""
    return PurePath(figure.path or "").name == _COMPARISON or bool(comparing.named_comparisons(figure))


def _curves_in_words(figure: Figure) -> str:
    series, unseen = comparing.series_drawn(figure), comparing.unseen(figure)
    if len(series) > 1 and unseen and not all(np.array_equal(one, series[0]) for one in series):
        named = f" “{_shown(unseen[0])}”" if unseen[0] else ""
        return f"a plot on which the curve{named} cannot be seen"
    if len(series) < 2:
        return "a plot with one curve alone" if series else "a plot without a curve"
    if all(np.array_equal(one, series[0]) for one in series):
        return "a plot with the same series in every curve"
    return f"a plot with {len(series)} curves, none of which is a smoother version of another"


def _names_are_right(saved: list[list[comparing.Compared]]) -> None:
    """No names are asked for here; but names that are exchanged tell the reader the opposite."""
    if all(any(pair.exchanged for pair in of_it) and not any(pair.in_order for pair in of_it) for of_it in saved):
        got = "the raw curve under the name of the filtered one"
        raise Lost("each curve under its own name", got, mistakes=["legend-order-wrong"], keeps=0.5)


def _noise_is_shown(saved: list[list[comparing.Compared]], student: Student) -> None:
    """A filter takes noise away; where `NoisyIMU` adds none, that has been charged already."""
    if "NoisyIMU" in student.broken or any(pair.noisy for of_it in saved for pair in of_it):
        return
    raise Lost("raw data with noise in it", "a raw curve without noise", keeps=0.5, hint=_DRAW_NOISE)


# --- what the checks share -----------------------------------------------------------------------------------------------


def _shown(text: str) -> str:
    return printable(text, 60)
