"""Which part of a curve is told to lie outside the limits."""

from __future__ import annotations

import numpy as np
import pytest

from grader.engine.figures import Sight
from grader.labs.imu.checks.curve_faults import _outside

PARTS = {
    "acceleration x outside the limits of the axes": (),
    "the last 40 % of the time of acceleration x outside the limits of the axes": range(60),
    "the first 30 % of the time of acceleration x outside the limits of the axes": range(30, 100),
    "41 % of the time of acceleration x outside the limits of the axes": [*range(58), 59],
    "the first 5 % of the time of acceleration x outside the limits of the axes": range(5, 100),
    "4 % of the time of acceleration x outside the limits of the axes": range(96),
    "60 % of the time of acceleration x outside the limits of the axes": range(30, 70),
    "50 % of the time of acceleration x outside the limits of the axes": range(0, 100, 2),
    "11 % of the time of acceleration x outside the limits of the axes": [*range(80), *range(84, 93)],
}


@pytest.mark.quick
@pytest.mark.parametrize(("told", "inside"), PARTS.items(), ids=lambda value: str(value)[:30])
def test_the_part_outside_is_told_as_it_is(told: str, inside: range) -> None:
    seen = np.isin(np.arange(100), list(inside))
    assert _outside({(0, 0): Sight(inside=seen, seen=seen)}) == told
