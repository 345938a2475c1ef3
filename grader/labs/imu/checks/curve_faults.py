"""What is wrong with the curves of a plot: missing, not seen, against no time, or in another unit: each fault as its finding."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import NoReturn

import numpy as np

from grader.engine.figures import Mask, Sight
from grader.engine.findings import CheckFailed, Ours, Size
from grader.labs.imu.checks.panel_words import quoted
from grader.labs.imu.checks.plot_runs import CHANNELS, SENSOR_WORDS, Plot, sensors_in_words
from grader.labs.imu.diagnosis import labels, plots
from grader.labs.imu.diagnosis.plots import Channel

_NONE_AS_GIVEN = Ours(
    "Draw the arrays that plot_imu_data is given, from the first row to the last, against their time in seconds (Step 4)."
)
_IN_BOTH_PANELS = (
    Ours("Every panel draws the angular velocity. Draw imu_data['acceleration'] in one of them (Step 4)."),
    Ours("Every panel draws the acceleration. Draw imu_data['angular_velocity'] in one of them (Step 4)."),
)
"""By the sensor that is missing."""
_IN_UNIT = Ours(
    "Let each label name the unit of the numbers that are drawn. The recorded numbers are in m/s² and rad/s (Step 4)."
)
_IN_PART = 0.8
"""Of a channel's points at most, where some of its rows are not drawn; of those that show less of it the share that they show."""

_MISLEADS = 0.2
"""Largest share kept where curves show other numbers or limits leave curves outside: a reader of the picture is misled."""


def some_missing(plot: Plot, cut_off: Mapping[Channel, Sight]) -> NoReturn:
    """Charge the channels of which nothing is drawn, nothing is seen, or the most lies outside the limits."""
    shown = plot.drawn - set(cut_off)
    strange = bool(plot.strange)
    missing = set(CHANNELS) - plot.drawn - plot.hidden
    got, mistakes = [], []
    if missing:
        twice = len(plot.shown) > len(plot.drawn)
        got += [f"no curve that shows {_named(missing)}", *_in_their_place(plot)]
        mistakes.append("wrong-data-plotted" if strange or twice else "curves-missing")
    if plot.hidden:
        got.append(
            f"{_named(plot.hidden)} drawn and not visible: covered, outside the limits, or in the background's colour"
        )
        mistakes.append("curves-not-seen")
    if cut_off:
        got.append(_outside(cut_off))
        mistakes.append("curves-not-seen")
    if parts := plot.in_part():
        got.append(_over_a_part(parts))
    raise CheckFailed(
        "six curves, one for each channel of the data",
        "; ".join(got),
        mistakes=list(dict.fromkeys(mistakes)),
        keeps=min(_worth(plot, shown), _MISLEADS if cut_off or "wrong-data-plotted" in mistakes else 1.0),
        hint=_hint_for(plot, missing),
    )


def _in_their_place(plot: Plot) -> list[str]:
    """Return what is drawn instead of the missing curves: a channel of the other sensor, a channel twice, or unknown numbers."""
    found = []
    for panel in plot.main_panels:
        if others := {shown.channel for shown in panel.shown if panel.mainly and shown.sensor not in panel.mainly}:
            found.append(f"{_named(others)} in the panel of the {sensors_in_words(panel.mainly)}")
        channels = [shown.channel for shown in panel.shown if shown.channel not in others]
        if twice := {channel for channel in channels if channels.count(channel) > 1}:
            found.append(f"{_named(twice)} more than once")
    strange = len(plot.strange)
    return [
        *found,
        *([f"{strange} {'curves show' if strange > 1 else 'curve shows'} other numbers"] if strange else []),
    ]


def _hint_for(plot: Plot, missing: set[Channel]) -> str:
    """Words for channels that are missing by the whole sensor: columns that were mixed up are not all missing."""
    without = [sensor for sensor in (0, 1) if {channel for channel in CHANNELS if channel[0] == sensor} <= missing]
    if not without or {sensor for sensor, _ in missing} != set(without):
        return ""
    if plot.strange:
        return _NONE_AS_GIVEN
    of_the_other = [panel for panel in plot.main_panels if panel.sensors == {1 - without[0]}]
    return _IN_BOTH_PANELS[without[0]] if len(of_the_other) > 1 else ""


def _worth(plot: Plot, channels: Iterable[Channel]) -> float:
    """Which share of the points these channels earn, each by how much of the recorded time is drawn of it."""
    parts = plot.in_part()
    return sum(min(_IN_PART, float(parts[c].mean())) if c in parts else 1.0 for c in channels) / len(CHANNELS)


def drawn_in_part(plot: Plot) -> None:
    """Charge channels that are drawn over a part of the recorded time alone."""
    parts = plot.in_part()
    if parts:
        raise CheckFailed(
            "curves of the data from its first row to its last",
            _over_a_part(parts),
            keeps=_worth(plot, CHANNELS),
            hint=_NONE_AS_GIVEN,
            off=Size("curves over only a part of the recorded time"),
        )


def _over_a_part(parts: Mapping[Channel, Mask]) -> str:
    """Which part of the recorded time the curves show: that of the channel that shows least."""
    part = min(parts.values(), key=lambda part: float(part.mean()))
    share, (first, last) = f"{round(100 * float(part.mean()))} %", part[[0, -1]]
    where = f"the {'first' if first else 'last'} {share}" if first != last else share
    what = "all six curves" if len(parts) == len(CHANNELS) else _named(parts)
    return f"{what} over only {where} of the recorded time"


def _named(channels: Iterable[Channel]) -> str:
    of_sensors = [(SENSOR_WORDS[s], ["xyz"[axis] for sensor, axis in sorted(channels) if sensor == s]) for s in (0, 1)]
    return " and ".join(f"{word} {', '.join(axes)}" for word, axes in of_sensors if axes)


def _outside(cut_off: Mapping[Channel, Sight]) -> str:
    """Which part of the curves lies outside the limits: that of the channel that loses most."""
    inside = min((sight.inside for sight in cut_off.values()), key=lambda mask: float(mask.mean()))
    if not inside.any():
        return f"{_named(cut_off)} outside the limits of the axes"
    first, last = np.flatnonzero(inside)[[0, -1]]
    part = f"{round(100 * float(np.mean(~inside)))} % of the time"
    if inside[first : last + 1].all() and first < 5 and last < 95:
        part = f"the last {99 - last} % of the time"
    elif inside[first : last + 1].all() and first >= 5 and last >= 95:
        part = f"the first {first} % of the time"
    return f"{part} of {_named(cut_off)} outside the limits of the axes"


def against_no_time(plot: Plot) -> None:
    """Charge curves against the sample's index, or against a time in another unit than the label's."""
    if "index" in plot.abscissae:
        raise CheckFailed(
            "curves against time", "curves against the sample's index", mistakes=["x-not-time"], keeps=0.5
        )
    labelled = [labels.plain(text) for text in plot.x_labels]
    said = not any(labelled) or any(unit in text for text in labelled for unit in ("ms", "milli", "мс"))
    if "ms" in plot.abscissae and not said and not plot.own_ticks:
        raise CheckFailed(
            "curves against time in the unit of the label",
            "curves against milliseconds",
            mistakes=["x-not-time"],
            keeps=0.5,
        )


def in_another_unit(plot: Plot, recorded: Callable[[int], str]) -> None:
    """Charge numbers in another unit than the label's; without one, than that of the data.

    Parameters
    ----------
    recorded : the unit in which the submission itself records a sensor: a label that names it is right of numbers as they are given
    """
    for panel in plot.panels:
        texts = (panel.axes.ylabel, plot.figure.ylabel, panel.axes.title)
        label = next(filter(labels.unit_of, texts), panel.axes.ylabel)
        said = labels.unit_of(label)
        for shown in panel.shown:
            family = plots.UNITS[shown.sensor]
            as_given = shown.unit == family[0]
            wrong = said in family and said != shown.unit and not (as_given and said == recorded(shown.sensor))
            unsaid = said is None and shown.unit != family[0]
            if wrong or unsaid:
                got = f"numbers in {shown.unit} under {f'the label {quoted(label)}' if label else 'no label'}"
                raise CheckFailed(
                    "numbers in the unit of the label", got, mistakes=["wrong-data-plotted"], keeps=0.5, hint=_IN_UNIT
                )
