"""Units and time of curves, on facts that are made by hand."""

from __future__ import annotations

from dataclasses import replace

import pytest

from grader.labs.imu.visualization import explain
from grader.labs.imu.visualization.measure import Facts
from tests.judging.test_check_visualization import Sheet
from tests.judging.test_plot_measure import _plot

pytestmark = pytest.mark.quick
BOTH = _plot(Sheet().figure)


def facts(x: str = "s", unit: str = "m/s²", recorded: str = "", **words: str) -> Facts:
    """Return the sheet's plot with other words on the acceleration's panel, drawn against `x` in `unit`."""
    accel, gyro = BOTH.panels
    shown = tuple(replace(each, x=x, unit=unit) for each in accel.shown)
    panel = replace(accel, axes=replace(accel.axes, **words), shown=shown)
    return Facts(
        replace(BOTH, panels=[panel, replace(gyro, axes=replace(gyro.axes, xlabel=""))]), recorded=(recorded, "")
    )


@pytest.mark.parametrize(
    ("x", "label", "wrong"),
    [
        ("s", "Time [s]", False),
        ("ms", "TIME [MS]", False),
        ("ms", "Time in $\\mathrm{ms}$", False),
        ("ms", "", False),
        ("ms", "Time [s]", True),
        ("index", "Time [s]", True),
    ],
)
def test_time_is_in_the_unit_of_its_label(x: str, label: str, wrong: bool) -> None:
    assert explain.is_against_no_time(facts(x, xlabel=label)) is wrong


@pytest.mark.parametrize(
    ("label", "drawn", "recorded", "got"),
    [
        ("a [m/s²]", "m/s²", "", ""),
        ("a [g]", "m/s²", "g", ""),
        ("a [g]", "m/s²", "m/s²", "numbers in m/s² under the label “a [g]”"),
        ("a [g]", "g", "", ""),
        ("a [m/s²]", "g", "m/s²", "numbers in g (0.102 times the given numbers) under the label “a [m/s²]”"),
        ("", "g", "", "numbers in g (0.102 times the given numbers) under no label"),
    ],
)
def test_numbers_are_in_the_unit_of_their_label_or_in_that_of_the_submissions_recording(
    label: str, drawn: str, recorded: str, got: str
) -> None:
    assert explain.another_unit(facts(unit=drawn, recorded=recorded, ylabel=label, title="")) == got
