"""What is written on panels, held against what they show: plots of two panels whose words are changed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from grader.labs.imu.checks import panel_words
from grader.labs.imu.checks.plot_runs import Plot
from grader.labs.imu.diagnosis.plots import Panel
from tests.judging.test_check_visualization import Sheet
from tests.judging.test_plot_runs import _plot

pytestmark = pytest.mark.quick
BOTH = _plot(Sheet().figure)


def _said(panel: Panel, **words: Any) -> Panel:
    return replace(panel, axes=replace(panel.axes, **words))


def _with(*panels: Panel) -> Plot:
    return Plot(BOTH.figure, list(panels))


@pytest.mark.parametrize(("sensor", "other"), [(0, "Angular velocity"), (1, "Acceleration")])
def test_a_panel_that_speaks_of_the_other_sensor_alone_is_misnamed_by_all_that_it_says(sensor: int, other: str) -> None:
    panels = list(BOTH.panels)
    panels[sensor] = _said(panels[sensor], title=other, ylabel="value")
    assert panel_words.misnaming(_with(*panels), panels[sensor], sensor) == [other, "value"]


def test_a_panel_is_misnamed_only_where_another_one_shows_what_it_says() -> None:
    accel = _said(BOTH.panels[0], title="Angular velocity", ylabel="value")
    assert panel_words.misnaming(_with(accel, BOTH.panels[0]), accel, 0) == []
    assert panel_words.misnaming(_with(accel, BOTH.panels[1]), accel, 0) == ["Angular velocity", "value"]


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
