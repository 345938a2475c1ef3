"""What is written on panels, held against what they show: plots of two panels whose words are changed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from grader.labs.imu.visualization import panel_words
from grader.labs.imu.visualization.curves import Panel, Plot
from tests.judging.test_check_visualization import Sheet
from tests.judging.test_plot_measure import _plot

pytestmark = pytest.mark.quick
BOTH = _plot(Sheet().figure)


def _said(panel: Panel, **words: Any) -> Panel:
    return replace(panel, axes=replace(panel.axes, **words))


def _with(*panels: Panel) -> Plot:
    return Plot(BOTH.figure, list(panels))


def test_a_panel_is_misnamed_only_where_another_one_shows_what_it_says() -> None:
    accel = _said(BOTH.panels[0], title="Angular velocity", ylabel="value")
    assert panel_words.misnamed(_with(accel, BOTH.panels[0])) is None
    found = panel_words.misnamed(_with(accel, BOTH.panels[1]))
    assert found == panel_words.Misnamed(["Angular velocity", "value"], "acceleration", 1.0)


def test_the_label_of_the_time_is_missed_only_where_both_sensors_have_a_panel() -> None:
    accel, gyro = (_said(panel, xlabel="") for panel in BOTH.panels)
    missing = [("no-axis-labels", "no label on the time axis")]
    assert panel_words.label_problems(_with(accel, gyro)) == missing
    for alone in (accel, gyro):
        assert panel_words.label_problems(_with(alone)) == []


def test_milliseconds_in_the_label_are_wrong_above_seconds_from_whichever_start() -> None:
    accel, gyro = (_said(panel, xlabel="Time [ms]") for panel in BOTH.panels)
    later = replace(gyro, shown=tuple(replace(shown, x="s from start") for shown in gyro.shown))
    for panels in ((accel, gyro), (accel, later)):
        ((mistake, _),) = panel_words.label_problems(_with(*panels))
        assert mistake == "no-units"
    index = replace(gyro, shown=tuple(replace(shown, x="index") for shown in gyro.shown))
    assert panel_words.label_problems(_with(accel, index)) == []


def test_the_sheets_own_words_have_no_problem() -> None:
    assert panel_words.label_problems(BOTH) == []
