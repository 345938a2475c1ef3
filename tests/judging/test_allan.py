"""Which curves over averaging times are Allan deviations, by curves that are computed by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from grader.labs.imu.bonuses import allan_variance as allan
from grader.labs.imu.compare import Array, thinned
from grader.labs.imu.statistics import allan_deviation

pytestmark = pytest.mark.quick
_N, _RATE = 4000, 100.0
_RECORDS = [np.random.default_rng(3).normal(size=_N), np.cumsum(np.random.default_rng(4).normal(size=_N))]
_WHITE = _RECORDS[0]
_SIZES = np.array([1, 2, 3, 5, 8, 13, 20, 30, 40, 100, 300])


def _means(x: Array, m: int, every: int = 1) -> Array:
    """Of the runs of `m` samples that begin at every so many-th one."""
    return np.asarray(np.lib.stride_tricks.sliding_window_view(x, m)[::every].mean(axis=1))


def _overlapping(x: Array, m: int) -> float:
    means = _means(x, m)
    return float(np.sqrt(np.mean((means[m:] - means[:-m]) ** 2) / 2))


def _separate(x: Array, m: int) -> float:
    return float(np.sqrt(np.mean(np.diff(_means(x, m, every=m)) ** 2) / 2))


def _spread(x: Array, m: int) -> float:
    return float(np.std(_means(x, m, every=m)))


def _curve(form: Callable[[Array, int], float] = _overlapping, x: Array = _WHITE, sizes: Array = _SIZES) -> Array:
    return np.array([form(x, int(m)) for m in sizes])


def test_the_estimate_is_the_handbooks() -> None:
    for m in (1, 2, 7, 600):
        assert allan_deviation(_WHITE, m) == pytest.approx(_overlapping(_WHITE, m))
    assert np.isnan(allan_deviation(_WHITE[:3], 2))
    both = np.column_stack([_WHITE, 2 * _WHITE])
    assert allan_deviation(both, 7) == pytest.approx(np.sqrt(2.5) * _overlapping(_WHITE, 7))


_SWAY = np.resize([1.0, -1.0], len(_SIZES))
_TRUE = _curve()
_ROOTS = np.sqrt(_N / _SIZES)


@pytest.mark.parametrize(
    ("sizes", "curve", "fits"),
    [
        (_SIZES, _curve(_separate, x=_WHITE[:-1]), True),
        (_SIZES, 1.07 * _TRUE, True),
        (_SIZES, 1.12 * _TRUE, False),
        (_SIZES, _TRUE * np.exp(4.9 * _SWAY / _ROOTS * (_SIZES >= 20)), True),
        (_SIZES, _TRUE * np.exp(5.1 * _SWAY / _ROOTS * (_SIZES == 20)), False),
        (_SIZES, _TRUE * np.where(_SIZES == 40, 3, 1), False),
        (_SIZES[:2], _TRUE[:2], False),
        (_SIZES[-3:], 1.01 * _TRUE[-3:], False),
    ],
)  # fmt: skip
def test_a_curve_is_an_allan_deviation_but_for_chance(sizes: Array, curve: Array, fits: bool) -> None:
    assert allan.fits(sizes, curve, _WHITE) == fits
    assert allan.fits(sizes, 2 * curve, _WHITE, lambda samples, m: 2 * allan_deviation(samples, m)) == fits


def _records(taus: Callable[[Array], Array], sizes: Array = _SIZES, rate: float = _RATE) -> list[allan.Record]:
    return [(taus(sizes / rate), _curve(x=x, sizes=sizes), x) for x in _RECORDS]


_INEXACT = np.array([57, 55, 58, 56, 113, 110, 114, 111, 115, 112, 116])
"""Of a hundredth of a second: their products with the rate are a rounding less or more than whole."""


@pytest.mark.parametrize("sizes", [_SIZES, _INEXACT], ids=["whole", "inexact"])
@pytest.mark.parametrize(
    ("taus", "seconds"),
    [
        (lambda t: t, True),
        (lambda t: t + np.resize([0.0, 0.8], len(t)) / _RATE, True),
        (lambda t: t * _RATE, False),
        (lambda t: t / _RATE, False),
        (lambda t: t * 3, None),
    ],
)  # fmt: skip
def test_averaging_times_are_seconds_or_something_else_that_fits_all_records(
    taus: Callable[[Array], Array], seconds: bool | None, sizes: Array
) -> None:
    records = _records(taus, sizes)
    found = allan.meaning(records, _RATE)
    assert (found.seconds if found.fault == "" else None) == seconds
    if found.fault == "":
        times, curve, samples = records[1]
        assert allan.fits(found.size(times, _RATE), curve, samples)


@pytest.mark.parametrize(("points", "left"), [(1, 1), (201, 200)])
def test_a_curve_is_thinned_to_two_hundred_points_the_first_and_last_among_them(points: int, left: int) -> None:
    chosen = thinned(points)
    assert (len(chosen), chosen[0], chosen[-1]) == (left, 0, points - 1)


def _mistaken(
    form: Callable[[Array, int], float], factor: float = 1.0, per: float = _RATE, sizes: Array = _SIZES
) -> list[allan.Record]:
    return [(sizes / per, factor * _curve(form, x, sizes), x) for x in _RECORDS]


@pytest.mark.parametrize(
    ("records", "told"),
    [
        (_mistaken(lambda x, m: _overlapping(x, m) ** 2), "returns-variance"),
        (_mistaken(_overlapping, 2**0.5, 1.0), "allan-factor-missing"),
        (_mistaken(_overlapping, 3), None),
        (_mistaken(_spread), "std-not-allan"),
        (_mistaken(_spread, 1.3), None),
        (_mistaken(_spread, sizes=_SIZES[4:7]), "std-not-allan"),
        ([_mistaken(_spread)[0], _mistaken(_overlapping, 2**0.5)[1]], None),
    ],
)
def test_what_every_curve_shows_is_told(records: list[allan.Record], told: str | None) -> None:
    assert allan.meaning(records, _RATE).fault == told
