"""The statistical checks in small: the benchmark in `tests/benchmarks/chance.py` runs many more of the same."""

from __future__ import annotations

import pytest

from grader.labs.imu import statistics
from tests.benchmarks.chance import LAWS, losses


def test_no_sound_model_of_a_hundred_loses_a_point() -> None:
    assert set(losses(LAWS["sound: normal"], 100, seed=7).values()) == {0}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.weekly] if n % 3 else [])
        for n, name in enumerate(LAWS)
        if LAWS[name].caught_by
    ],
)
def test_each_fault_is_caught_in_twenty_of_twenty_models(name: str) -> None:
    law = LAWS[name]
    assert losses(law, 20, seed=11)[law.caught_by] == 20


def test_the_bounds_are_those_that_the_docstrings_state() -> None:
    assert pytest.approx(6.81, abs=0.01) == statistics.Z
    assert statistics.spread_bounds(7500, 6) == pytest.approx((0.945, 1.056), abs=0.001)
    assert statistics.mean_bound(2500, 1.0) == pytest.approx(0.136, abs=0.001)
    assert statistics.correlation_bound(2500) == pytest.approx(0.135, abs=0.001)
    assert statistics.geary_bounds(7500) == pytest.approx((0.776, 0.820), abs=0.001)
