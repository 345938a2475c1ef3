"""What is written on the panels of a plot, held against what they show: which sensor, in which unit, and against what."""

from __future__ import annotations

from grader.base.text import printable
from grader.engine.figures import Axes
from grader.labs.imu.checks.plot_runs import SENSOR_WORDS, Plot
from grader.labs.imu.diagnosis import labels, plots
from grader.labs.imu.diagnosis.plots import Panel

Problem = tuple[str, str]
"""A mistake, and what is wrong in words."""


def quoted(text: str) -> str:
    """What somebody has written, in a sentence of ours."""
    return f"“{printable(text, 60)}”"


def has_empty_panel(plot: Plot, sensor: int) -> bool:
    """Whether axes without a curve say that they are this sensor's."""
    drawn = [panel.axes for panel in plot.panels]
    return any(sensor in _claimed(axes) for axes in plot.figure.visible_axes if axes not in drawn)


def misnaming(plot: Plot, panel: Panel, sensor: int) -> list[str]:
    """What is written on a panel of this sensor and speaks of the other one alone."""
    texts = [panel.axes.title, panel.axes.ylabel]
    if not _shown_elsewhere(plot, 1 - sensor, panel):
        return []
    if _claimed(panel.axes) == {1 - sensor}:
        return [text for text in texts if text.strip()]
    return [text for text in texts if labels.names_only(1 - sensor, text)]


def _claimed(axes: Axes) -> frozenset[int]:
    """The sensors that title and label of a panel speak of."""
    return labels.claims(axes.title) | labels.claims(axes.ylabel)


def _shown_elsewhere(plot: Plot, sensor: int, panel: Panel) -> bool:
    """Whether another panel shows the sensor that this one claims; if none does, the wrong data is drawn, not the wrong panel."""
    return any(other is not panel and sensor in other.sensors for other in plot.panels)


def is_named(plot: Plot, sensor: int) -> bool:
    """Whether a reader can tell which sensor it is; missing labels and titles are charged by their own checks."""
    panels = plot.of_sensor(sensor)
    if not panels or any(sensor in labels.claims(p.words) for p in panels):
        return True
    title_only = all(not p.axes.ylabel.strip() for p in panels) or all(not p.axes.title.strip() for p in panels)
    inside = [text.text for p in panels for text in p.axes.texts]
    whole = [plot.figure.title, plot.figure.ylabel, *_names_on(plot, panels), *inside]
    written = any(p.words.replace("|", "").strip() for p in panels)
    return any(sensor in labels.claims(text) for text in whole) or (title_only and written)


def _names_on(plot: Plot, panels: list[Panel]) -> list[str]:
    """What the reader is told about each curve of these panels; empty where it is nothing."""
    return [name or "" for panel in panels for name in plots.names_of(panel, plot.figure)]


def label_problems(plot: Plot) -> list[Problem]:
    """What is missing from the labels of the axes: one problem for each sensor, and one for the time."""
    found: list[Problem] = []
    for sensor in (0, 1):
        panels = plot.of_sensor(sensor)
        written = [p.axes.ylabel for p in panels] + [plot.figure.ylabel]
        beside = [*(p.axes.title for p in panels), *plot.figure.texts, *_names_on(plot, panels)]
        elsewhere = {text for panel in panels for text in misnaming(plot, panel, sensor)}
        if panels and elsewhere.isdisjoint(written):  # the other sensor's label: another check charges that name
            found += _of_sensor(written, beside, sensor)
    if all(map(plot.of_sensor, (0, 1))):  # the label may have stood on the panel that is missing
        found += _of_time(plot)
    return found


def _of_sensor(texts: list[str], beside: list[str], sensor: int) -> list[Problem]:
    written, what = [text for text in texts if text.strip()], SENSOR_WORDS[sensor]
    if not written:
        told = any(labels.has_unit_of(sensor, text) and sensor in labels.claims(text) for text in beside)
        return [] if told else [("no-axis-labels", f"no label on the y axis of the {what}")]
    if any(labels.has_unit_of(sensor, text) for text in written + beside):
        return []
    return [("no-units", f"{quoted(written[0])} on the y axis, which names no unit of {what}")]


def _of_time(plot: Plot) -> list[Problem]:
    written = [label for label in plot.x_labels if label.strip()]
    if not written:
        return [("no-axis-labels", "no label on the time axis")]
    with_unit = [label for label in written if labels.has_time_unit(label)]
    if not with_unit and not any(map(labels.counts_samples, written)):
        return [("no-units", f"{quoted(written[0])} on the time axis, which names no unit of time")]
    seconds = plot.abscissae <= {"s", "s from start"}
    if with_unit and all(map(labels.in_milliseconds, with_unit)) and seconds and not plot.own_ticks:
        return [("no-units", f"{quoted(with_unit[0])} on a time axis whose numbers are seconds")]
    return []
