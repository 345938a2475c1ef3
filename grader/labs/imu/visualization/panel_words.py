"""Judgement of a plot's labels, titles and legends against what its panels show, for the checks of words."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from grader.base.text import printable
from grader.engine.figures import Axes
from grader.labs.imu.visualization import curves, labels
from grader.labs.imu.visualization.curves import SENSOR_WORDS, Panel, Plot, Shown

Problem = tuple[str, str]
"""A fault, and what is wrong in words."""


def quoted(text: str) -> str:
    """Return a student's text in quotation marks for a message, cut to 60 characters and without control characters."""
    return f"“{printable(text, 60)}”"


# ---- which sensor ----


@dataclass(frozen=True)
class Misnamed:
    """Texts (`said`) that name only the wrong sensor, on a panel that shows the sensor `shows`.

    `share` is the share of points lost: 1 if title and y label of the panel (if not empty) are both such texts, else 0.5.
    """

    said: list[str]
    shows: str
    share: float


def misnamed(plot: Plot) -> Misnamed | None:
    """Return the texts that name only the sensor of another panel, on the first panel that has such texts; None if none has."""
    for sensor, panel in [(which, panel) for which in (0, 1) for panel in plot.of_sensor(which)]:
        if said := _misnaming(plot, panel, sensor):
            written = [text for text in (panel.axes.title, panel.axes.ylabel) if text.strip()]
            return Misnamed(said, SENSOR_WORDS[sensor], 1.0 if set(written) <= set(said) else 0.5)
    return None


def _misnaming(plot: Plot, panel: Panel, sensor: int) -> list[str]:
    """Return the texts on a panel of this sensor that name the other sensor only; none if no other panel shows that sensor."""
    if not any(other is not panel and 1 - sensor in other.sensors for other in plot.panels):
        return []
    texts = [text for text in (panel.axes.title, panel.axes.ylabel) if text.strip()]
    if _claimed(panel.axes) == {1 - sensor}:
        return texts
    return [text for text in texts if labels.names_only(1 - sensor, text)]


def _claimed(axes: Axes) -> frozenset[int]:
    """Return the sensors (0 acceleration, 1 angular velocity) that title and y label of a panel name; perhaps none."""
    return labels.claims(axes.title) | labels.claims(axes.ylabel)


def missing_panel(plot: Plot) -> str:
    """Return in words the first sensor that a plot of at most one panel neither shows nor names on axes without data; else ""."""
    if len(plot.panels) > 1:
        return ""
    empty = [axes for axes in plot.figure.visible_axes if axes not in [panel.axes for panel in plot.panels]]
    missing = [sensor for sensor in (0, 1) if not plot.of_sensor(sensor)]
    return next((SENSOR_WORDS[s] for s in missing if not any(s in _claimed(axes) for axes in empty)), "")


def is_named(plot: Plot, sensor: int) -> bool:
    """Return whether a sensor's panels, or title or y label of the figure, have a text that names it, such as a curve's name.

    Also True without a panel, or if all panels lack a title or all lack a y label, but not both: other checks deduct for that.
    """
    panels = _panels_for(plot, sensor)
    if not panels or any(sensor in labels.claims(p.words) for p in panels):
        return True  # a sensor without a panel is `missing_panel`
    title_only = all(not p.axes.ylabel.strip() for p in panels) or all(not p.axes.title.strip() for p in panels)
    inside = [text.text for p in panels for text in p.axes.texts]
    whole = [plot.figure.title, plot.figure.ylabel, *_names_on(plot, panels), *inside]
    written = any(p.words.replace("|", "").strip() for p in panels)
    return any(sensor in labels.claims(text) for text in whole) or (title_only and written)


def _panels_for(plot: Plot, sensor: int) -> list[Panel]:
    """Return the panels whose texts should name a sensor: its own, else those that show no channel and do not name the other.

    A panel of other numbers, such as a norm, needs labels as much as one of the sensor's axes.
    """
    others = [panel for panel in plot.main_panels if not panel.shown and _claimed(panel.axes) != {1 - sensor}]
    return plot.of_sensor(sensor) or [panel for panel in others if sensor in _claimed(panel.axes)] or others


def _names_on(plot: Plot, panels: list[Panel]) -> list[str]:
    """Return the name of each curve of these panels, by legend or text beside it; "" for a curve without one."""
    return [name or "" for panel in panels for name in curves.names_of(panel, plot.figure)]


# ---- labels of the axes ----


def label_problems(plot: Plot) -> list[Problem]:
    """Return what is missing from the axis labels, as pairs of a fault's id and words: at most one for each sensor and for time."""
    found: list[Problem] = []
    for sensor in (0, 1):
        panels = _panels_for(plot, sensor)
        written = [p.axes.ylabel for p in panels] + [plot.figure.ylabel]
        beside = [*(p.axes.title for p in panels), *plot.figure.texts, *_names_on(plot, panels)]
        elsewhere = {text for panel in panels for text in _misnaming(plot, panel, sensor)}
        if panels and elsewhere.isdisjoint(written):  # the other sensor's label: another check charges that name
            found += _of_sensor(written, beside, sensor)
    if all(_panels_for(plot, sensor) for sensor in (0, 1)):  # the label may have stood on the panel that is missing
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


def is_against_no_time(plot: Plot) -> bool:
    """Return whether curves are drawn against the sample's index, or against milliseconds under a label that does not say so."""
    labelled = [labels.plain(text) for text in plot.x_labels]
    said = not any(labelled) or any(unit in text for text in labelled for unit in ("ms", "milli", "мс"))
    return "index" in plot.abscissae or ("ms" in plot.abscissae and not said and not plot.own_ticks)


def labelled_units(plot: Plot) -> Iterator[tuple[Shown, str, str | None]]:
    """Yield each visible curve with its panel's label and the label's unit (or None), to compare with the unit of its numbers.

    The label is the first text that names a unit: the y label, the figure's y label or the title; if none does, the y label.
    """
    for panel in plot.panels:
        texts = (panel.axes.ylabel, plot.figure.ylabel, panel.axes.title)
        label = next(filter(labels.unit_of, texts), panel.axes.ylabel)
        yield from ((shown, label, labels.unit_of(label)) for shown in panel.shown)


# ---- names of the curves, and titles ----


def _crowded(plot: Plot) -> list[Panel]:
    """Return the panels whose curves need names: those of several channels, or of other numbers in place of a missing sensor."""
    in_place = [panel for sensor in (0, 1) if not plot.of_sensor(sensor) for panel in _panels_for(plot, sensor)]
    return [panel for panel in plot.main_panels if len(panel.shown) > 1 or panel in in_place]


def _is_nameless(plot: Plot, panel: Panel) -> bool:
    """Return whether a reader cannot tell the curves of a panel apart: one has no name, or one name stands for two channels."""
    if not panel.shown:  # one curve may be named by the label of its axis
        others = curves.names_of_curves(panel.strange, panel, plot.figure)
        return None in others and not (len(others) == 1 and panel.axes.ylabel.strip())
    named = zip(panel.shown, curves.names_of(panel, plot.figure), strict=True)
    names = {(name, shown.channel) for shown, name in named if name}
    told = {channel for _, channel in names}
    return told < panel.channels or len({name for name, _ in names}) < len(panel.channels)


def share_nameless(plot: Plot) -> float:
    """Return the share lost: 1 if all panels of several curves or in place of a sensor's lack curve names, 0.5 if some, else 0."""
    crowded = _crowded(plot)
    nameless = [panel for panel in crowded if _is_nameless(plot, panel)]
    return 0.0 if not nameless else 0.5 if len(nameless) < len(crowded) else 1.0


def exchanged_name(plot: Plot) -> str:
    """Describe a curve that is named after another axis than it shows, such as "Y" at the curve of x; "" without one.

    A panel with nameless curves, or with a channel under several names, is left to other checks.
    """
    for panel in _crowded(plot):
        named = zip(panel.shown, curves.names_of(panel, plot.figure), strict=True)
        told = {(name, shown.channel) for shown, name in named if name}
        if _is_nameless(plot, panel) or len(told) > len(panel.channels):
            continue
        for name, (_, axis) in sorted(told):
            if labels.axis_of(name) not in (None, axis):
                return f"{quoted(name)} beside the curve of {'xyz'[axis]}"
    return ""


def share_untitled(plot: Plot) -> float:
    """Return the share of points lost for lack of titles: 1 if no panel has one, 0.5 if some have, 0 if all or the figure has one.

    A title over each column of panels is enough, too; with only two panels, these titles must not name just one sensor.
    """
    figure, panels = plot.figure, plot.titled_panels
    places = {axes.position for axes in figure.axes if axes.title.strip()}  # twin axes share a title
    titled = [panel.axes.position in places for panel in panels]
    if figure.title.strip() or any(text.strip() for text in figure.texts) or all(titled):
        return 0.0
    over = [panel for panel, has in zip(panels, titled, strict=True) if has]
    columns = {panel.axes.position[0] for panel in over} >= {panel.axes.position[0] for panel in panels}
    if columns and (len(panels) > 2 or all(len(labels.claims(panel.axes.title)) != 1 for panel in over)):
        return 0.0  # one title over each column of panels, or one that does not speak of a single sensor
    return 0.5 if over else 1.0
