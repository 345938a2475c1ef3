"""Diagnosis of *Visualization*: the known faults of a plot, in its file, panels, curves and labels, and how each shows."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping

from grader.engine.charging import Judge, Measure
from grader.engine.findings import Came, Deviation, Numbers, Raised
from grader.engine.hypothesis import Reason
from grader.labs.imu.lab import LAB
from grader.labs.imu.parameters import CALL_REASONS, departures
from grader.labs.imu.visualization import curves
from grader.labs.imu.visualization import panel_words as words
from grader.labs.imu.visualization.curves import CHANNELS, SENSOR_WORDS, Channel
from grader.labs.imu.visualization.measure import DOING, Facts, measure

SAVES, PANELS, CURVES, LABELS, LEGEND, TITLES, COMPARISON = (
    "saves_image", "two_labelled_panels", "curves_match_data", "axis_labels_with_units", "legend_names_curves", "titles",
    "comparison_plot",
)  # fmt: skip
_SMALLEST_PX = (400, 250)
"""Below this the six curves and their labels cannot be told apart; matplotlib's default figure has 640 × 480."""
_OTHER_FORMS = frozenset({"pdf", "svg", "svgz", "eps", "ps", "pgf"})
_OTHER_NUMBERS, _OUTSIDE = 0.5, 0.8
"""Least shares lost where curves show other numbers, and where limits leave curves outside: a reader of the picture is misled."""
_IN_PART = 0.8
"""Largest share that a channel keeps if some of its rows are not drawn; one that shows less keeps the share that it shows."""


def to_the_end(measured: Callable[[Facts], Deviation[Numbers] | None]) -> Callable[[Facts], Deviation[Numbers] | None]:
    """Wrap a measurement: if it finds a fault and the plot function raised, raise `Raised`, so that the exception is reported."""

    @functools.wraps(measured)
    def judged(facts: Facts) -> Deviation[Numbers] | None:
        found = measured(facts)
        if found is not None and facts.error is not None:
            raise Raised(facts.error, DOING)
        return found

    return judged


# ---- the file ----


def is_lost(facts: Facts) -> bool:
    """Return whether no saved file shows the plot, or a channel of it was only in a file that was overwritten."""
    return not facts.file.formats or bool(facts.file.lost)


def is_small(facts: Facts) -> bool:
    return any(size < least for size, least in zip(facts.file.size_px, _SMALLEST_PX, strict=True))


def is_no_png(facts: Facts) -> bool:
    return facts.file.formats <= _OTHER_FORMS


# ---- panels and curves ----


def shares_a_panel(facts: Facts) -> bool:
    """Return whether a drawn sensor has no panel with more curves of it than of the other sensor, as where one panel shows both."""
    return any(panel.mainly != {sensor} for sensor in (0, 1) for panel in facts.plot.of_sensor(sensor))


def misses_channels(facts: Facts) -> bool:
    return len(facts.plot.drawn - set(facts.cut_off)) < len(CHANNELS)


def _missing(facts: Facts) -> set[Channel]:
    """Return the channels (sensor, axis) of which no curve is drawn, seen or not."""
    return set(CHANNELS) - facts.plot.drawn - facts.plot.hidden


def _shows_others(facts: Facts) -> bool:
    """Return whether a channel is missing and other numbers, or another channel twice, are drawn in its place."""
    plot = facts.plot
    return bool(_missing(facts)) and (bool(plot.strange) or len(plot.shown) > len(plot.drawn))


def share_missing(facts: Facts) -> float:
    """Return the share of points lost for channels drawn in part: for each, a sixth of the part not drawn, taken as 0.2 or more."""
    parts = facts.plot.in_part()
    return sum(1 - min(_IN_PART, parts[c]) for c in facts.plot.drawn if c in parts) / len(CHANNELS)


@to_the_end
def missing_curves(facts: Facts) -> Deviation[Came] | None:
    """Return the `Deviation` for undrawn channels: 1/6 of points each, at least 1/2 if wrong or repeated data is drawn; or None."""
    if not (missing := _missing(facts)):
        return None
    affected = max(len(missing) / len(CHANNELS), _OTHER_NUMBERS if _shows_others(facts) else 0)
    return Deviation({"came": missing_in_words(facts)}, affected=affected)


@to_the_end
def unseen_curves(facts: Facts) -> Deviation[Came] | None:
    """Return the `Deviation` that deducts for drawn channels hidden or outside the limits, or a logarithmic axis; else None."""
    if any(panel.axes.scales[1] == "log" for sensor in (0, 1) for panel in facts.plot.of_sensor(sensor)):
        return Deviation({"came": "a logarithmic value axis, on which no value below zero can be drawn"})
    if not (facts.plot.hidden or facts.cut_off):
        return None
    unseen = len(facts.plot.hidden | set(facts.cut_off)) / len(CHANNELS)
    return Deviation({"came": missing_in_words(facts)}, affected=max(unseen, _OUTSIDE if facts.cut_off else 0))


def label_problem(name: str) -> Callable[[Facts], Deviation[Came] | None]:
    """Return a function that gives the `Deviation` that deducts for the fault `name` of axis labels, such as "no-units".

    Each label with that fault loses a third of the points; if there is none, the function gives None.
    """

    def measured(facts: Facts) -> Deviation[Came] | None:
        texts = [text for problem, text in words.label_problems(facts.plot) if problem == name]
        return Deviation({"came": "; ".join(texts)}, affected=min(1.0, len(texts) / 3)) if texts else None

    return to_the_end(measured)


def missing_in_words(facts: Facts) -> str:
    plot, missing, strange = facts.plot, _missing(facts), len(facts.plot.strange)
    said = [
        f"no curve that shows {_named(missing)}" if missing else "",
        f"{strange} {'curves show' if strange > 1 else 'curve shows'} other numbers" if missing and strange else "",
        f"{_named(plot.hidden)} drawn and not visible" if plot.hidden else "",
        f"{_outside(facts)} outside the limits of the axes" if facts.cut_off else "",
    ]
    return "; ".join(filter(None, said))


def _outside(facts: Facts) -> str:
    """Return in words how much of the channels is outside the limits: all, or so many per cent, the least if they differ."""
    shares = {round(100 * (1 - inside)) for inside in facts.cut_off.values()}
    least = "" if len(shares) == 1 else "at least "
    return f"{'all' if shares == {100} else f'{least}{min(shares)} %'} of {_named(facts.cut_off)}"


def _named(channels: Iterable[Channel]) -> str:
    of_sensors = [(SENSOR_WORDS[s], ["xyz"[axis] for sensor, axis in sorted(channels) if sensor == s]) for s in (0, 1)]
    return " and ".join(f"{word} {', '.join(axes)}" for word, axes in of_sensors if axes)


def part_in_words(parts: Mapping[Channel, float]) -> str:
    return f"{_named(parts)} over only {round(100 * min(parts.values()))} % of the recorded time"


def another_unit(facts: Facts) -> str:
    """Describe a curve drawn in another unit than its label says or, without a label, than the data have; "" for none.

    A label with the unit in which the submission itself records is right, too: the plot then fits the submission's own data.
    """
    for shown, label, said in words.labelled_units(facts.plot):
        family = curves.UNITS[shown.sensor]
        own = shown.unit == family[0] and said == facts.recorded[shown.sensor]
        if (said in family and said != shown.unit and not own) or (said is None and shown.unit != family[0]):
            factor = "" if shown.unit == family[0] else f" ({curves.factor_of(shown)} the given numbers)"
            return (
                f"numbers in {shown.unit}{factor} under {f'the label {words.quoted(label)}' if label else 'no label'}"
            )
    return ""


def names_are_exchanged(facts: Facts) -> bool:
    """Return whether all saved figures of raw and filtered data exchange the curves' names; call it only if there are any."""
    return all(
        any(pair.exchanged for pair in pairs) and not any(pair.in_order for pair in pairs)
        for pairs in facts.comparison.saved
    )


def shows_nothing(facts: Facts) -> bool:
    """Return whether there is no picture in which a title could be read: none saved that shows the plot, and none handed in."""
    file = facts.file
    return (file.replaced or file.blank or not file.formats) and not file.handed_in


def _file_reasons(cost: int, fault: str, holds: Callable[[Facts], bool]) -> tuple[Reason[Facts], ...]:
    """Return the reasons for which a fault of the file loses points: at the check of the file, and at that of the titles."""
    return (
        Reason(SAVES, cost, fault, holds),
        Reason(TITLES, cost, fault, lambda facts: shows_nothing(facts) and holds(facts)),
    )


_LABEL_PROBLEMS = ("no-axis-labels", "no-units")
REASONS: tuple[Reason[Facts], ...] = (
    *_file_reasons(1, "picture-overwritten", lambda f: f.file.replaced),
    *_file_reasons(2, "blank-image", lambda f: f.file.blank),
    *_file_reasons(3, "plot-not-saved", lambda f: not f.file.formats),
    Reason(SAVES, 3, "picture-overwritten", lambda f: bool(f.file.lost)),
    Reason(SAVES, 4, "low-resolution", is_small),
    Reason(PANELS, 1, "one-panel", shares_a_panel),
    Reason(PANELS, 2, "panels-swapped", lambda f: words.misnamed(f.plot) is not None),
    Reason("missing", 1, "wrong-data-plotted", _shows_others),
    Reason("missing", 2, "curves-missing", lambda _: True),
    Reason("unseen", 1, "curves-not-seen", lambda _: True),
    Reason(CURVES, 4, "x-not-time", lambda f: not misses_channels(f) and words.is_against_no_time(f.plot)),
    Reason(CURVES, 5, "wrong-data-plotted", lambda f: not misses_channels(f) and bool(another_unit(f))),
    *(Reason(problem, 1, problem, lambda _: True) for problem in _LABEL_PROBLEMS),
    Reason(LEGEND, 1, "legend-order-wrong", lambda f: bool(words.exchanged_name(f.plot))),
    Reason(LEGEND, 2, "no-legend", lambda f: words.share_nameless(f.plot) > 0),
    Reason(TITLES, 9, "no-title", lambda facts: words.share_untitled(facts.plot) > 0),
    Reason(COMPARISON, 1, "legend-order-wrong", lambda f: bool(f.comparison.saved) and names_are_exchanged(f)),
    Reason(COMPARISON, 2, "comparison-wrong-data", lambda f: f.comparison.meant[0] > 1 and not f.comparison.drawn),
    Reason(COMPARISON, 3, "script-stops", lambda f: f.comparison.error is not None and not f.comparison.drawn),
    Reason(COMPARISON, 4, "comparison-missing", lambda f: not f.comparison.saved),
    *CALL_REASONS,
)

OTHERS: Mapping[str, Measure[Facts]] = {
    "missing": missing_curves,
    "unseen": unseen_curves,
    **{problem: label_problem(problem) for problem in _LABEL_PROBLEMS},
    **departures("plot_imu_data", lambda facts: facts.departs),
}
JUDGE: Judge[Facts] = Judge(LAB, "visualization", measure, REASONS, OTHERS)
