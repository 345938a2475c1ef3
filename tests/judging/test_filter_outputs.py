"""What was done to a filter's output, told from the sheet's recursion and outputs that differ from it in one thing."""

from __future__ import annotations

import numpy as np
import pytest

from grader.labs.imu.compare import Array
from grader.labs.imu.diagnosis import filter_outputs as outputs

pytestmark = pytest.mark.quick
_N, _ALPHA, _ATOL = 240, 0.3, 1e-5
_RNG = np.random.default_rng(9)
_X = _RNG.normal((0.5, -9.6, 2), 1, (_N, 3))
_Y = outputs.recursion(_ALPHA, _X, _X[0])


def test_the_recursion_begins_at_its_start_and_forgets_it() -> None:
    y = outputs.recursion(0.25, np.array([[9.0, 0], [4, 8], [8, 0]]), np.array([0.0, 4]))
    assert y.tolist() == [[0, 4], [1, 5], [2.75, 3.75]]


def _state_rounded(decimals: int) -> Array:
    """A recursion whose state is rounded on every step."""
    y = _X[:1].copy()
    for x in _X[1:]:
        y = np.vstack([y, (_ALPHA * x + (1 - _ALPHA) * y[-1]).round(decimals)])
    return y


def _halves(y: Array) -> Array:
    return y.astype(np.float16).astype(float)


_LARGE = 500 * _X
_LOWERED = np.eye(_N)[:, [int(np.flatnonzero(_Y.round(2)[:, 1] < _Y[:, 1] - 0.002)[9])]] * [0, 1, 0]
"""One output that rounding makes smaller."""


def _state_floored(x: Array, size: float) -> Array:
    """A slow recursion whose state is cut off on every step: it stays five grains behind the exact one."""
    y = x[:1].copy()
    for sample in x[1:]:
        y = np.vstack([y, np.floor((0.1 * sample + 0.9 * y[-1]) / size) * size])
    return y


def test_the_grain_of_a_state_is_seen_from_each_output_to_the_next() -> None:
    cut = _state_floored(_X, 0.001)
    assert outputs.grain(0.1, _X, cut) == pytest.approx(0.001)
    assert outputs.grain(0.1, _X, cut + 0.003 * _LOWERED) == 0


def test_what_stays_the_same_was_not_rounded() -> None:
    whole = np.tile([1.0, 2, 3], (_N, 1))
    assert outputs.grain(_ALPHA, whole, whole) == 0


@pytest.mark.parametrize(
    ("y", "grain"),
    [
        (_Y, 0),
        (_Y.round(0), 1),
        (_Y.round(1), 0.1),
        (_Y.round(2), 0.01),
        (np.trunc(100 * _Y) / 100, 0.01),
        (_Y.round(4), 1e-4),
        (_Y.round(5), 0),
        (np.vstack([_Y[:1], _Y[1:].round(2)]), 0.01),
        (_state_rounded(1), 0.1),
        (_state_rounded(2), 0.01),
        (_state_rounded(4), 1e-4),
        (_halves(_Y), 2.0**-7),
        (np.vstack([_Y[:1], _halves(_Y[1:])]), 2.0**-7),
        (_X.round(2), 0),
        ((0.9 * _Y).round(2), 0),
        (np.full_like(_Y, 0.5), 0),
        (np.round(_Y, 2) + 1.5e-9, 0),
        (np.floor(100 * _Y) / 100 + 0.006, 0),
        (_halves(_Y) - 3e-6, 0),
        (_Y.round(2) + 0.01 * np.sign(_X).round(), 0.01),
        (_Y.round(2) + 0.03 * _LOWERED, 0),
    ],
)
def test_the_grain_is_that_of_outputs_that_are_the_recursion_but_for_it(y: Array, grain: float) -> None:
    assert outputs.grain(_ALPHA, _X, y) == pytest.approx(grain)


@pytest.mark.parametrize(
    ("x", "y", "grain"),
    [
        (_LARGE, _halves(outputs.recursion(_ALPHA, _LARGE, _LARGE[0])), 4.0),
        (-_X, _halves(-_Y), 2.0**-7),
        (4 * _LARGE, _halves(outputs.recursion(_ALPHA, 4 * _LARGE, 4 * _LARGE[0])), 0),
    ],
)
def test_the_grain_of_half_precision_is_that_of_the_largest_output(x: Array, y: Array, grain: float) -> None:
    assert outputs.grain(_ALPHA, x, y) == pytest.approx(grain)


@pytest.mark.parametrize(
    ("y", "limits"),
    [
        (_Y, None),
        (_Y.clip(-9.6, 2), (-9.6, 2)),
        (_Y.clip(None, 1.9), (float(_Y.min()), 1.9)),
        (_Y.clip(-9.5, None), (-9.5, float(_Y.max()))),
        (_Y.clip(-9.6, 2) + 0.9 * _ATOL * np.eye(_N, 3), (-9.6, 2)),
        (_Y.clip(-9.6, 2) + 2 * _ATOL * np.eye(_N, 3), None),
        (_Y.clip(-1, 0.5), None),
        (_X.clip(-9.6, 2), None),
    ],
)
def test_limits_leave_most_of_the_recursion(y: Array, limits: tuple[float, float] | None) -> None:
    assert outputs.limits(_ALPHA, _X, y) == (None if limits is None else pytest.approx(limits, abs=2 * _ATOL))


@pytest.mark.parametrize(("high", "most"), [(0.6, True), (0.4, False)])
def test_half_of_the_outputs_is_not_most(high: float, most: bool) -> None:
    y = outputs.recursion(_ALPHA, x := _X - [0.5, -9.6, 2], x[0])
    assert (outputs.limits(_ALPHA, x, y.clip(None, np.quantile(y, high))) is not None) == most


def _mean_of(size: int, x: Array = _X) -> Array:
    return np.array([x[max(0, n - size + 1) : n + 1].mean(axis=0) for n in range(len(x))])


@pytest.mark.parametrize(
    ("x", "y", "size"),
    [
        (_X, _X, 1),
        (_X, _mean_of(2), 2),
        (_X, _mean_of(5), 5),
        (_X, _mean_of(100), 100),
        (_X, _mean_of(101), 0),
        (_X[:40], _mean_of(20)[:40], 20),
        (_X[:40], _mean_of(21)[:40], 0),
        (_X, np.vstack([0 * _X[:4], _mean_of(5)[4:]]), 5),
        (_X, np.vstack([0 * _X[:7], _mean_of(5)[7:]]), 0),
        (_X, _mean_of(5) + 0.9 * _ATOL, 5),
        (_X, _mean_of(5) - 1.1 * _ATOL, 0),
        (_X, _Y, 0),
        (_X[:1], _Y[:1], 0),
    ],
)
def test_the_window_is_how_many_samples_each_output_is_the_mean_of(x: Array, y: Array, size: int) -> None:
    assert outputs.window(x, y) == size


_DELAYED = np.vstack([_X[:1], _Y[:-1]])


@pytest.mark.parametrize(
    ("y", "behind"),
    [
        (_DELAYED, True),
        (np.vstack([0 * _X[:1], _DELAYED[1:]]), True),
        (_Y, False),
        (np.vstack([_Y[:1] * 0, _Y[:1] * 0, _Y[:-2]]), False),
        (_DELAYED + 2 * _ATOL * np.eye(_N, 3), False),
        (np.vstack([_DELAYED[:-1], _DELAYED[-1:] + 1]), False),
    ],
)
def test_an_output_one_behind_is_that_of_the_measurement_before(y: Array, behind: bool) -> None:
    assert outputs.one_behind(_ALPHA, _X, y) == behind


_DECAY = 0.7 ** np.arange(60.0)[:, None] * [5, -3, 1]


@pytest.mark.parametrize(
    ("difference", "settles"),
    [
        (_DECAY, True),
        (-_DECAY, True),
        (0 * _DECAY, True),
        (_DECAY[:30], False),
        (-_DECAY[:30], False),
        (_DECAY + 0.9 * _ATOL, True),
        (_DECAY - 1.6 * _ATOL, False),
        (1e4 * _DECAY, True),
        (-1e4 * _DECAY * [1, 0, 1], True),
        (_DECAY * [1, 1, 0] + [0, 0, 1], False),
    ],
)
def test_outputs_settle_that_grow_alike(difference: Array, settles: bool) -> None:
    assert outputs.settles(difference) == settles
