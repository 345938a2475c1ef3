"""Raw and filtered: which pairs of curves are a series and a smoother version of it, by series that are made by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from grader.engine.figures import Curve, Figure, VisibleParts
from grader.labs.imu.answers import Array
from grader.labs.imu.visualization import comparing
from grader.labs.imu.visualization.comparing import Compared
from tests.judging.test_check_visualization import Sheet, _curve, _figure, _slow, _smooth, _with_curves

pytestmark = pytest.mark.quick
N = 600
TIME = np.linspace(0, 1.2, N)
CLEAN = 9.81 + np.sin(5 * TIME)
NOISY = CLEAN + np.random.default_rng(1).normal(0, 0.3, N)
OTHER = np.cos(9 * TIME) + np.random.default_rng(2).normal(0, 0.3, N)
FILTERED = _smooth(NOISY)


def curve(y: Array, label: str = "", x: Array = TIME, **words: object) -> Curve:
    return replace(_curve(x, y, label, {"raw": "#111111", "filtered": "#222222"}.get(label, "#333333")), **words)  # type: ignore[arg-type]


def figure(*curves: Curve, ylabel: str = "m/s²", **words: object) -> Figure:
    return _figure(replace(_with_curves(Sheet().panels[0], *curves), ylabel=ylabel, **words))  # type: ignore[arg-type]


def seen(parts: int) -> VisibleParts:
    return VisibleParts(np.ones(100, bool), np.arange(100) < parts)


def _averaged(window: int) -> Callable[[Array], Array]:
    return lambda y: np.convolve(y, np.full(window, 1 / window), mode="same")


def _late(y: Array) -> Array:
    return np.concatenate([np.full(20, y[0]), _averaged(15)(y)[:-20]])


SMOOTHER: dict[str, Array] = {
    "by alpha": FILTERED,
    "by alpha, twice": _smooth(FILTERED),
    "from zero": FILTERED * np.minimum(1, np.arange(N) / 60),
    "by a running mean": _averaged(9)(NOISY),
    "by a long running mean": _averaged(61)(NOISY),
    "by a running mean, late": _late(NOISY),
    "a little weaker": 9.81 + 0.6 * (_averaged(15)(NOISY) - 9.81),
    "as it was without the noise": CLEAN,
    "with a small offset": FILTERED + 0.5,
}
NO_SMOOTHER: dict[str, Array] = {
    "the same": NOISY,
    "another": _smooth(OTHER),
    "another that is as noisy": OTHER,
    "upside down": 2 * 9.81 - FILTERED,
    "far below": FILTERED - 9,
    "far above": FILTERED + 9,
    "much larger": 9.81 + 9 * (FILTERED - 9.81),
    "much smaller": 9.81 + 0.05 * (FILTERED - 9.81),
    "a straight line": TIME,
    "hardly less noisy": CLEAN + 0.9 * (NOISY - CLEAN),
    "earlier": np.append(FILTERED[150:], np.full(150, FILTERED[-1])),
}


@pytest.mark.parametrize("smooth", SMOOTHER.values(), ids=SMOOTHER)
def test_a_smoother_version_is_one(smooth: Array) -> None:
    assert comparing.comparisons(figure(curve(NOISY, "raw"), curve(smooth, "filtered"))) == [Compared("raw", "filtered", True)]  # fmt: skip


@pytest.mark.parametrize("scale", [1e-7, 1e-3, 0.1, 9.81, 1e4])
@pytest.mark.parametrize(
    ("smooth", "found"), [(FILTERED, True), (NO_SMOOTHER["far below"], False), (NO_SMOOTHER["much smaller"], False)]
)
def test_a_unit_does_not_matter(scale: float, smooth: Array, found: bool) -> None:
    assert bool(comparing.comparisons(figure(curve(scale * NOISY, "raw"), curve(scale * smooth, "filtered")))) is found


@pytest.mark.parametrize("smooth", NO_SMOOTHER.values(), ids=NO_SMOOTHER)
def test_anything_else_is_none(smooth: Array) -> None:
    assert comparing.comparisons(figure(curve(NOISY, "raw"), curve(smooth, "filtered"))) == []


@pytest.mark.parametrize(
    ("raw_every", "smooth_every", "found"),
    [
        (1, 2, True),
        (1, 5, True),
        (2, 1, True),
        (5, 1, True),
        (3, 3, True),
        (1, 12, True),
        (1, 13, False),
        (13, 1, False),
    ],
)
def test_curves_may_be_thinned_to_fifty_points(raw_every: int, smooth_every: int, found: bool) -> None:
    raw = curve(NOISY[::raw_every], "raw", TIME[::raw_every])
    smooth = curve(CLEAN[::smooth_every], "filtered", TIME[::smooth_every])
    pairs = [(pair.raw, pair.smooth) for pair in comparing.comparisons(figure(raw, smooth))]
    assert pairs == ([("raw", "filtered")] if found else [])


def test_straight_lines_between_thinned_points_are_no_filter() -> None:
    thinned = curve(NOISY[::3], "filtered", TIME[::3])
    assert comparing.comparisons(figure(curve(NOISY, "raw"), thinned)) == []


def test_a_filtered_curve_may_begin_later_or_end_sooner() -> None:
    smooth = FILTERED.copy()
    smooth[:50] = np.nan
    assert comparing.comparisons(figure(curve(NOISY, "raw"), curve(smooth, "filtered")))
    assert comparing.comparisons(figure(curve(NOISY, "raw"), curve(FILTERED[:400], "filtered", TIME[:400])))
    assert comparing.comparisons(figure(curve(NOISY, "raw"), curve(FILTERED[200:], "filtered", TIME[200:])))


# --- which curves are held against each other ----------------------------------------------------------------------------

RAW, SMOOTH = curve(NOISY, "raw"), curve(FILTERED, "filtered")


@pytest.mark.parametrize(
    ("raw", "smooth", "pairs"),
    [
        (RAW, SMOOTH, 1),
        (replace(RAW, visible_parts=seen(12)), SMOOTH, 1),
        (replace(RAW, visible_parts=seen(11)), SMOOTH, 0),
        (RAW, replace(SMOOTH, visible_parts=seen(0)), 0),
        (replace(RAW, visible_parts=VisibleParts(np.arange(100) < 6, np.arange(100) < 5)), SMOOTH, 1),
        (replace(RAW, visible_parts=VisibleParts(np.arange(100) < 6, np.arange(100) < 4)), SMOOTH, 0),
        (RAW, replace(SMOOTH, kind="nothing"), 0),
        (replace(RAW, kind="points"), SMOOTH, 1),
        (curve(NOISY[:49], "raw", TIME[:49]), SMOOTH, 0),
    ],
)
def test_curves_that_are_seen_are_compared(raw: Curve, smooth: Curve, pairs: int) -> None:
    assert len(comparing.comparisons(figure(raw, smooth))) == pairs
    assert len(comparing.comparisons(figure(smooth, raw))) == pairs


@pytest.mark.parametrize(
    ("above", "below", "pairs"), [("m/s²", "Acceleration (m/s²)", 1), ("m/s²", "rad/s", 0), ("", "filtered", 1), ("m/s²", "", 1), ("", "g", 1)]
)  # fmt: skip
def test_curves_of_two_panels_are_compared_where_both_may_be_in_one_unit(above: str, below: str, pairs: int) -> None:
    upper, lower = figure(RAW, ylabel=above).axes[0], figure(SMOOTH, ylabel=below).axes[0]
    assert len(comparing.comparisons(_figure(upper, lower))) == pairs
    assert comparing.comparisons(_figure(upper, replace(lower, visible=False))) == []


def test_six_channels_have_six_comparisons_and_no_end_of_curves_has_an_end() -> None:
    curves = [curve(NOISY + 100 * number, "raw") for number in range(6)]
    filtered = [curve(FILTERED + 100 * number, "filtered") for number in range(6)]
    assert comparing.comparisons(figure(*curves, *filtered)) == [Compared("raw", "filtered", True)] * 6
    many = [curve(NOISY, "raw", kind="line") for _ in range(40)]
    assert comparing.comparisons(figure(*many, SMOOTH)) == [Compared("raw", "filtered", True)] * 25


# --- noise ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("raw", "noisy"),
    [
        (NOISY, True),
        (CLEAN + 1e-3 * (NOISY - CLEAN), True),
        (CLEAN, False),
        (CLEAN + 1e-5 * (NOISY - CLEAN), False),
        (_slow(NOISY), False),
    ],
)
def test_noise_goes_up_and_down_from_value_to_value(raw: Array, noisy: bool) -> None:
    assert comparing._has_noise(raw) is noisy


@pytest.mark.parametrize(
    ("raw", "smooth", "exchanged", "in_order"),
    [
        ("raw", "filtered", False, True),
        ("filtered", "raw", True, False),
        ("one", "two", False, False),
        ("raw", "", False, True),
        ("", "filtered", False, True),
        ("filtered", "two", False, False),
        ("one", "raw", False, False),
    ],
)
def test_names_are_exchanged_where_both_are(raw: str, smooth: str, exchanged: bool, in_order: bool) -> None:
    compared = Compared(raw, smooth, True)
    assert (compared.exchanged, compared.in_order) == (exchanged, in_order)


# --- by name -------------------------------------------------------------------------------------------------------------


def test_curves_of_these_names_are_compared_whatever_the_filter_has_made() -> None:
    zeros = curve(0.01 * TIME, "filtered")
    found = comparing.named_comparisons(figure(curve(OTHER, "one"), RAW, zeros))
    assert found == [Compared("raw", "filtered", True)]
    assert comparing.named_comparisons(figure(curve(CLEAN, "raw"), zeros)) == [Compared("raw", "filtered", False)]
    assert comparing.named_comparisons(figure(RAW)) == []
    assert comparing.named_comparisons(figure(RAW, replace(zeros, visible_parts=seen(0)))) == []


@pytest.mark.parametrize(
    ("curves", "said"),
    [
        ([], "no curve that changes"),
        ([NOISY], "only one curve"),
        ([NOISY, NOISY], "the same numbers"),
        ([NOISY[:20], FILTERED[:20]], "2 curves, none of which"),
        ([NOISY, CLEAN], "2 curves, none of which"),
    ],
)
def test_a_figure_that_compares_nothing_is_described_by_its_curves(curves: list[Array], said: str) -> None:
    drawn = [curve(y, str(number), TIME[: len(y)]) for number, y in enumerate(curves)]
    count, words = comparing.in_words(figure(*drawn))
    assert (count, said in words) == (len(curves), True)


def test_a_figure_with_a_curve_that_nobody_sees_says_so() -> None:
    hidden = replace(curve(FILTERED, "filtered"), visible_parts=seen(0))
    assert comparing.in_words(figure(curve(NOISY, "raw"), hidden)) == (2, "a plot on which a curve cannot be seen")
