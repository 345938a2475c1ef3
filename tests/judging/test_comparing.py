"""Raw and filtered: which pairs of curves are a series and a smoother version of it, by series that are made by hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from grader.engine.figures import Curve, Figure
from grader.labs.imu.returned import Array
from grader.labs.imu.visualization import comparing
from grader.labs.imu.visualization.comparing import Compared
from tests.judging import test_check_visualization as made
from tests.judging.test_check_visualization import SHEET, figure_of, slow, smooth, visible, with_curves

pytestmark = pytest.mark.quick
N = 600
TIME = np.linspace(0, 1.2, N)
CLEAN = 9.81 + np.sin(5 * TIME)
NOISY = CLEAN + np.random.default_rng(1).normal(0, 0.3, N)
OTHER = np.cos(9 * TIME) + np.random.default_rng(2).normal(0, 0.3, N)
FILTERED = smooth(NOISY)
PAIR = Compared("raw", "filtered", True)


def curve(y: Array, label: str = "", x: Array = TIME, **words: object) -> Curve:
    return replace(made.curve(x, y, label, {"raw": "#111111", "filtered": "#222222"}.get(label, "#333333")), **words)  # type: ignore[arg-type]


def figure(*curves: Curve, ylabel: str = "m/s²") -> Figure:
    return figure_of(replace(with_curves(SHEET.axes[0], *curves), ylabel=ylabel))


def found(raw: Array, filtered: Array) -> list[Compared]:
    return comparing.comparisons(figure(curve(raw, "raw"), curve(filtered, "filtered")))


SMOOTHER: dict[str, Array] = {
    "by alpha": FILTERED,
    "not from the start": np.where(np.arange(N) < 50, np.nan, FILTERED),
    "by a running mean, late": np.append(
        np.full(20, NOISY[0]), np.convolve(NOISY, np.full(15, 1 / 15), mode="same")[:-20]
    ),
    "as it was without the noise": CLEAN,
}
NO_SMOOTHER: dict[str, Array] = {
    "the same": NOISY,
    "another": smooth(OTHER),
    "upside down": 2 * 9.81 - FILTERED,
    "far below": FILTERED - 9,
    "much smaller": 9.81 + 0.05 * (FILTERED - 9.81),
    "hardly less noisy": CLEAN + 0.9 * (NOISY - CLEAN),
    "earlier": np.append(FILTERED[150:], np.full(150, FILTERED[-1])),
}


@pytest.mark.parametrize("scale", [1e-7, 1e4])
@pytest.mark.parametrize("name", [*SMOOTHER, *NO_SMOOTHER])
def test_a_smoother_version_is_one_in_any_unit(name: str, scale: float) -> None:
    assert found(scale * NOISY, scale * (SMOOTHER | NO_SMOOTHER)[name]) == [PAIR] * (name in SMOOTHER)


@pytest.mark.parametrize(
    ("raw", "filtered", "there"),
    [
        (slice(None), slice(None, None, 12), True),
        (slice(None), slice(None, None, 13), False),
        (slice(None, None, 5), slice(None), True),
        (slice(None), slice(400), True),
        (slice(None), slice(200, None), True),
    ],
)
def test_curves_may_be_thinned_to_fifty_points_and_begin_later_or_end_sooner(
    raw: slice, filtered: slice, there: bool
) -> None:
    curves = curve(NOISY[raw], "raw", TIME[raw]), curve(CLEAN[filtered], "filtered", TIME[filtered])
    assert [(pair.raw, pair.smooth) for pair in comparing.comparisons(figure(*curves))] == [("raw", "filtered")] * there


def test_straight_lines_between_thinned_points_are_no_filter() -> None:
    thinned = curve(NOISY[::3], "filtered", TIME[::3])
    assert comparing.comparisons(figure(curve(NOISY, "raw"), thinned)) == []


# --- which curves are compared -------------------------------------------------------------------------------------------

RAW, SMOOTH, UNSEEN = curve(NOISY, "raw"), curve(FILTERED, "filtered"), visible(seen=slice(0))


@pytest.mark.parametrize(
    ("raw", "filtered", "pairs"),
    [
        (replace(RAW, visible_parts=visible(seen=slice(12))), SMOOTH, 1),
        (replace(RAW, visible_parts=visible(seen=slice(11))), SMOOTH, 0),
        (RAW, replace(SMOOTH, visible_parts=UNSEEN), 0),
        (RAW, replace(SMOOTH, kind="nothing"), 0),
        (curve(NOISY[:49], "raw", TIME[:49]), SMOOTH, 0),
    ],
)
def test_curves_that_are_seen_are_compared(raw: Curve, filtered: Curve, pairs: int) -> None:
    assert len(comparing.comparisons(figure(raw, filtered))) == pairs
    assert len(comparing.comparisons(figure(filtered, raw))) == pairs


@pytest.mark.parametrize(
    ("above", "below", "pairs"),
    [("m/s²", "Acceleration (m/s²)", 1), ("m/s²", "rad/s", 0), ("", "filtered", 1), ("m/s²", "", 1), ("", "g", 1)],
)
def test_curves_of_two_panels_are_compared_where_both_may_be_in_one_unit(above: str, below: str, pairs: int) -> None:
    upper, lower = figure(RAW, ylabel=above).axes[0], figure(SMOOTH, ylabel=below).axes[0]
    assert len(comparing.comparisons(figure_of(upper, lower))) == pairs
    assert comparing.comparisons(figure_of(upper, replace(lower, visible=False))) == []


@pytest.mark.parametrize(("noise", "names", "pairs"), [(1.0, "ab", 1), (0.0, "ab", 0), (0.0, ("raw", "filtered"), 1)])
def test_without_noise_curves_of_two_panels_are_compared_by_their_names_only(
    noise: float, names: Sequence[str], pairs: int
) -> None:
    (drawn,) = made.compared(*names, noise=noise, other=smooth if noise else slow).figures
    assert len(comparing.comparisons(drawn)) == 1
    panels = (with_curves(drawn.axes[0], each) for each in drawn.axes[0].curves)
    assert len(comparing.comparisons(figure_of(*panels))) == pairs


def test_six_channels_have_six_comparisons_and_no_end_of_curves_has_an_end() -> None:
    curves = [curve(y + 100 * n, name) for n in range(6) for name, y in (("raw", NOISY), ("filtered", FILTERED))]
    assert comparing.comparisons(figure(*curves)) == [PAIR] * 6
    assert comparing.comparisons(figure(*(replace(RAW) for _ in range(40)), SMOOTH)) == [PAIR] * 25


def test_curves_of_these_names_are_compared_whatever_the_filter_has_made() -> None:
    zeros = curve(0.01 * TIME, "filtered")
    assert comparing.named_comparisons(figure(curve(OTHER, "one"), RAW, zeros)) == [PAIR]
    assert comparing.named_comparisons(figure(curve(CLEAN, "raw"), zeros)) == [replace(PAIR, noisy=False)]
    assert comparing.named_comparisons(figure(RAW)) == []
    assert comparing.named_comparisons(figure(RAW, replace(zeros, visible_parts=UNSEEN))) == []


# --- noise and words -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("raw", "noisy"),
    [
        (NOISY, True), (CLEAN + 1e-3 * (NOISY - CLEAN), True), (CLEAN, False), (CLEAN + 1e-5 * (NOISY - CLEAN), False),
        (slow(NOISY), False),
    ],
)  # fmt: skip
def test_noise_goes_up_and_down_from_value_to_value(raw: Array, noisy: bool) -> None:
    assert comparing._has_noise(raw) is noisy


@pytest.mark.parametrize(
    ("raw", "filtered", "exchanged", "in_order"),
    [
        ("raw", "filtered", False, True), ("filtered", "raw", True, False), ("one", "two", False, False), ("raw", "", False, True),
        ("", "filtered", False, True), ("filtered", "two", False, False), ("one", "raw", False, False),
    ],
)  # fmt: skip
def test_names_are_exchanged_where_both_are(raw: str, filtered: str, exchanged: bool, in_order: bool) -> None:
    compared = Compared(raw, filtered, True)
    assert (compared.exchanged, compared.in_order) == (exchanged, in_order)


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
    said = "a plot on which a curve cannot be seen"
    assert comparing.in_words(figure(RAW, replace(SMOOTH, visible_parts=UNSEEN))) == (2, said)
