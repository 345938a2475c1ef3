"""Checks of *Visualization*: each returns how one measured property of the plots deviates from the sheet, None if it is right."""

from __future__ import annotations

from typing import TypedDict

from grader.engine.findings import Came, Deviation, NoNumbers, Size
from grader.labs.imu.visualization import curves, explain
from grader.labs.imu.visualization import panel_words as words
from grader.labs.imu.visualization.explain import JUDGE, to_the_end
from grader.labs.imu.visualization.measure import Facts

Picture = TypedDict("Picture", {"width": int, "height": int, "form": str})
Panels = TypedDict("Panels", {"came": str, "said": str, "shows": str})
Compared = TypedDict("Compared", {"came": str, "stop": str})


@JUDGE.check("visualization.saves_image", lab_step=4)
@to_the_end
def check_saves_image(facts: Facts) -> Deviation[Picture] | None:
    """plot_imu_data saves a readable picture of the plot"""
    width, height = facts.file.size_px
    form = " and ".join(sorted(facts.file.formats)).upper()
    numbers: Picture = {"width": width, "height": height, "form": form}
    if explain.is_lost(facts) or explain.is_small(facts):
        return Deviation(numbers, affected=len(facts.file.lost) / len(curves.CHANNELS) or 1.0)
    return Deviation(numbers, share=0.2) if explain.is_no_png(facts) else None


@JUDGE.check("visualization.two_labelled_panels", lab_step=4)
@to_the_end
def check_two_labelled_panels(facts: Facts) -> Deviation[Panels] | None:
    """Acceleration and angular velocity have one panel each, with a label"""
    plot, wrong = facts.plot, words.misnamed(facts.plot)
    said, shows = (words.quoted(" | ".join(wrong.said)), wrong.shows) if wrong else ("", "")
    numbers: Panels = {"came": "both sensors in one panel", "said": said, "shows": shows}
    if explain.shares_a_panel(facts):
        return Deviation(numbers)
    if wrong:
        return Deviation({**numbers, "came": f"the name of another sensor, {said}"}, affected=wrong.share)
    if missing := words.missing_panel(plot):
        return Deviation({**numbers, "came": f"no panel with the {missing}"})
    if nameless := [curves.SENSOR_WORDS[sensor] for sensor in (0, 1) if not words.is_named(plot, sensor)]:
        return Deviation({**numbers, "came": f"no text on the panel that says {' or '.join(nameless)}"}, share=0.5)
    return None


@JUDGE.check("visualization.curves_match_data", lab_step=4)
@to_the_end
def check_curves_match_data(facts: Facts) -> Deviation[Came] | None:
    """Six curves show the six channels of the data against time"""
    if explain.misses_channels(facts):
        return Deviation({"came": explain.missing_in_words(facts)})
    if words.is_against_no_time(facts.plot):
        return Deviation({"came": "curves against something else than the time in the unit of its label"})
    if came := explain.another_unit(facts):
        return Deviation({"came": came})
    if parts := facts.plot.in_part():
        size = Size("curves over only a part of the recorded time")
        return Deviation({"came": explain.part_in_words(parts)}, explain.share_missing(facts), size)
    return None


@JUDGE.check("visualization.axis_labels_with_units", lab_step=4)
@to_the_end
def check_axis_labels_with_units(facts: Facts) -> Deviation[Came] | None:
    """The axes are labelled, with units"""
    problems = words.label_problems(facts.plot)
    came = "; ".join(text for _, text in problems)
    return Deviation({"came": came}, affected=min(1.0, len(problems) / 3)) if problems else None


@JUDGE.check("visualization.legend_names_curves", lab_step=4)
@to_the_end
def check_legend_names_curves(facts: Facts) -> Deviation[Came] | None:
    """A legend, or text beside the curves, names each curve of a panel"""
    if came := words.exchanged_name(facts.plot):
        return Deviation({"came": came})
    nameless = words.share_nameless(facts.plot)
    return Deviation({"came": "curves without a name"}, affected=nameless) if nameless else None


@JUDGE.check("visualization.titles", lab_step=4)
@to_the_end
def check_titles(facts: Facts) -> Deviation[NoNumbers] | None:
    """The panels, or the figure, have a title"""
    untitled = 1.0 if explain.shows_nothing(facts) else words.share_untitled(facts.plot)
    return Deviation({}, affected=untitled) if untitled else None


@JUDGE.check("visualization.comparison_plot", lab_step=6)
def check_comparison_plot(facts: Facts) -> Deviation[Compared] | None:
    """A saved plot shows raw and filtered data together"""
    comparison = facts.comparison
    numbers: Compared = {"came": comparison.in_words, "stop": comparison.stop_in_words}
    if not comparison.saved:
        if comparison.drawn and comparison.handed_in:
            return None
        affected = 0.5 if comparison.drawn or comparison.handed_in else 1.0
        return Deviation(numbers, affected=affected, error=comparison.error)
    if explain.names_are_exchanged(facts):
        return Deviation({**numbers, "came": "the raw curve with the name of the filtered one"}, share=0.5)
    return None if comparison.noisy else Deviation({**numbers, "came": "a raw curve without noise"}, share=0.5)
