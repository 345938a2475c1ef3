"""What twins of a noise model tell: series from one seed with one thing changed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grader.labs.imu.compare import Array
from grader.labs.imu.noise_model.reads import TRUTH_ATOL, Twins
from grader.labs.imu.noise_model.reads import UNSEEDED as UNKNOWN

pytestmark = pytest.mark.quick
_RNG = np.random.default_rng(3)
_NOISE = 0.05 * _RNG.normal(size=(40, 3))
_DRIFT = np.cumsum(0.01 * _RNG.normal(size=(40, 3)), axis=0)
_CHANGE = np.array([0.1, -0.4, 0.2])
_BASE = _DRIFT + _NOISE
TWINS = Twins(_BASE, _BASE, _BASE + _CHANGE, _DRIFT + 3 * _NOISE, _CHANGE, 3.0)
UNSEEDED = replace(TWINS, again=_BASE[::-1])
_FIRST = np.eye(40, 3)[:, :1]
"""One at the first read, nothing after it."""


def _responding(response: Array) -> Twins:
    """Twins without noise, so that what the bias does is exact."""
    still = np.zeros_like(_BASE)
    return replace(TWINS, base=still, again=still, other=still + response)


@pytest.mark.parametrize(
    ("response", "grain", "adds"),
    [
        (_CHANGE, 0.0, True),
        (_CHANGE + 0.9 * TRUTH_ATOL, 0.0, True),
        (_CHANGE + 1.1 * TRUTH_ATOL, 0.0, False),
        (_CHANGE + 0.9 * TRUTH_ATOL, 0.01, True),
        (_CHANGE - 0.01, 0.01, True),
        (_CHANGE - 0.011, 0.01, False),
        (_CHANGE * _FIRST, 0.0, False),
        (0 * _CHANGE, 0.0, False),
    ],
)
def test_a_bias_is_added_where_every_read_is_larger_by_it(response: Array, grain: float, adds: bool) -> None:
    assert _responding(response).adds_bias(grain) == adds


@pytest.mark.parametrize(
    ("response", "begins"),
    [
        (_CHANGE * _FIRST, True),
        (_CHANGE + 0.019, True),
        (_CHANGE - 0.021, False),
        (_CHANGE * (1 - _FIRST), False),
    ],
)
def test_a_bias_that_does_not_stay_is_in_the_first_read_to_a_twentieth(response: Array, begins: bool) -> None:
    assert _responding(response).begins_with_bias() == begins


@pytest.mark.parametrize(
    ("response", "ignores"),
    [(0.0, True), (TRUTH_ATOL, True), (-TRUTH_ATOL, True), (1.1 * TRUTH_ATOL, False), (-1.1 * TRUTH_ATOL, False)],
)
def test_a_bias_that_does_nothing_is_ignored(response: float, ignores: bool) -> None:
    assert _responding(np.full(3, response) * _FIRST).ignores_bias() == ignores


def test_the_noise_is_told_beside_a_drift_by_what_more_of_it_adds() -> None:
    assert TWINS.noise_size() == pytest.approx(np.sqrt(np.mean(np.diff(_NOISE, axis=0) ** 2) / 2))


def test_noise_scales_where_most_differences_of_reads_do() -> None:
    assert not TWINS.scales()
    assert replace(TWINS, scaled=3 * _BASE + 1).scales()
    assert replace(TWINS, scaled=3 * _BASE + 0.9 * TRUTH_ATOL * _FIRST).scales()
    jumps = np.arange(40)[:, None] % 10 == 5
    assert replace(TWINS, scaled=3 * _BASE + jumps).scales()
    assert not replace(TWINS, scaled=3 * _BASE + np.arange(40)[:, None] % 2).scales()
    assert not replace(_responding(_CHANGE), scaled=np.zeros_like(_BASE)).scales()


def test_series_that_no_seed_determines_tell_nothing() -> None:
    assert not UNSEEDED.seeded
    assert not any((UNSEEDED.adds_bias(), UNSEEDED.begins_with_bias(), UNSEEDED.ignores_bias()))
    assert not replace(UNSEEDED, other=_BASE).ignores_bias()
    assert not replace(UNSEEDED, scaled=3 * _BASE).scales()
    assert UNSEEDED.noise_size() == 0
    assert not any((UNKNOWN.seeded, UNKNOWN.scales(), UNKNOWN.adds_bias(), UNKNOWN.ignores_bias()))
