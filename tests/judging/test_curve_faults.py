"""Which part of a curve is told to lie outside the limits, and what is told of units."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from grader.engine.figures import Sight
from grader.engine.findings import CheckFailed
from grader.labs.imu.checks.curve_faults import _outside, against_no_time, in_another_unit

PARTS = {
    "acceleration x outside the limits of the axes": (),
    "the last 40 % of the time of acceleration x outside the limits of the axes": range(60),
    "the first 30 % of the time of acceleration x outside the limits of the axes": range(30, 100),
    "41 % of the time of acceleration x outside the limits of the axes": [*range(58), 59],
    "the first 5 % of the time of acceleration x outside the limits of the axes": range(5, 100),
    "4 % of the time of acceleration x outside the limits of the axes": range(96),
    "31 % of the time of acceleration x outside the limits of the axes": [*range(30, 98), 99],
    "60 % of the time of acceleration x outside the limits of the axes": range(30, 70),
    "50 % of the time of acceleration x outside the limits of the axes": range(0, 100, 2),
    "11 % of the time of acceleration x outside the limits of the axes": [*range(80), *range(84, 93)],
}


@pytest.mark.quick
@pytest.mark.parametrize(("told", "inside"), PARTS.items(), ids=lambda value: str(value)[:30])
def test_the_part_outside_is_told_as_it_is(told: str, inside: range) -> None:
    seen = np.isin(np.arange(100), list(inside))
    assert _outside({(0, 0): Sight(inside=seen, seen=seen)}) == told


@pytest.mark.quick
@pytest.mark.parametrize(
    ("label", "fair"), [("TIME [MS]", True), ("Time in $\\mathrm{ms}$", True), ("", True), ("Time [s]", False)]
)
def test_milliseconds_are_told_by_the_label_in_whichever_letters(label: str, fair: bool) -> None:
    plot: Any = SimpleNamespace(abscissae={"ms"}, x_labels=[label], own_ticks=False)
    if fair:
        against_no_time(plot)
    else:
        with pytest.raises(CheckFailed, match="curves against milliseconds"):
            against_no_time(plot)


@pytest.mark.quick
@pytest.mark.parametrize(
    ("label", "told"), [("", "numbers in g under no label"), ("Force [N]", "numbers in g under the label “Force [N]”")]
)
def test_numbers_in_another_unit_are_told_with_the_label_that_is_there(label: str, told: str) -> None:
    panel = SimpleNamespace(axes=SimpleNamespace(ylabel=label, title=""), shown=[SimpleNamespace(sensor=0, unit="g")])
    plot = cast(Any, SimpleNamespace(panels=[panel], figure=SimpleNamespace(ylabel="")))
    with pytest.raises(CheckFailed) as lost:
        in_another_unit(plot, lambda sensor: "")
    assert lost.value.got == told


@pytest.mark.quick
@pytest.mark.parametrize(
    ("label", "drawn", "recorded", "fair"),
    [
        ("a [g]", "m/s²", "g", True),
        ("a [g]", "m/s²", "m/s²", False),
        ("a [g]", "m/s²", "", False),
        ("a [g]", "g", "g", True),
        ("a [m/s²]", "g", "m/s²", False),
        ("a [m/s²]", "m/s²", "g", True),
    ],
)
def test_a_label_may_name_the_unit_in_which_the_submission_records(
    label: str, drawn: str, recorded: str, fair: bool
) -> None:
    panel = SimpleNamespace(axes=SimpleNamespace(ylabel=label, title=""), shown=[SimpleNamespace(sensor=0, unit=drawn)])
    plot = cast(Any, SimpleNamespace(panels=[panel], figure=SimpleNamespace(ylabel="")))
    if fair:
        in_another_unit(plot, lambda sensor: recorded)
    else:
        with pytest.raises(CheckFailed, match="under the label"):
            in_another_unit(plot, lambda sensor: recorded)
