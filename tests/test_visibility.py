"""Tests of the visibility of curves: a random sound figure loses none, and a curve that is claimed but not drawn is not seen."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest

from grader.engine.figures import Curve, Figure, VisibleParts
from grader.labs.imu.visualization.visibility import Patience, looked_at
from tests.random_figures import every, told

T = np.linspace(0, 5, 500)


def test_no_curve_of_forty_sound_figures_is_told_to_be_hidden() -> None:
    """5,000 by ``python -m tests.benchmarks.pictures``."""
    assert [found.seed for found in every(range(40)) if any(sight.is_hidden for sight in found.sights)] == []


@pytest.fixture
def axes() -> Iterator[Any]:
    figure, drawn = plt.subplots(figsize=(8, 4))
    drawn.plot(T, np.sin(2 * T), color="C0")
    yield drawn
    plt.close(figure)


def curve_of(figure: Figure) -> Curve:
    """The first curve of a figure."""
    return figure.axes[0].curves[0]


def claiming(figure: Figure, **claims: Any) -> Figure:
    """The same picture, of whose first curve something else is claimed."""
    (panel,) = figure.axes
    return replace(figure, axes=(replace(panel, curves=(replace(panel.curves[0], **claims), *panel.curves[1:])),))


def first_sight(figure: Figure) -> VisibleParts:
    return curve_of(looked_at(figure, Patience())).visible_parts


def test_a_curve_in_the_open_is_seen_from_end_to_end(axes: Any) -> None:
    sight = first_sight(told(axes.figure))
    assert sight.inside.shape == sight.seen.shape == (100,)
    assert sight.inside.all()
    assert sight.seen.all()


def test_facts_beside_a_blank_picture_show_nothing(axes: Any) -> None:
    figure = told(axes.figure)
    assert first_sight(replace(figure, pixels=np.full_like(figure.pixels, 255))).is_hidden


def test_facts_of_another_curve_than_the_drawn_one_show_nothing(axes: Any) -> None:
    assert first_sight(claiming(told(axes.figure), y=np.cos(9 * T))).seen.mean() < 0.4


def test_which_part_lies_outside_is_told(axes: Any) -> None:
    axes.set_xlim(0, 1)
    sight = first_sight(told(axes.figure))
    assert np.flatnonzero(sight.inside)[[0, -1]].tolist() == pytest.approx([0, 20], abs=1)
    assert not sight.is_hidden


def test_a_sheet_over_half_of_a_curve_hides_that_half(axes: Any) -> None:
    axes.axvspan(2.5, 9, color="white", zorder=9)
    axes.set_xlim(0, 5)
    sight = first_sight(told(axes.figure))
    assert sight.inside.all()
    assert sight.seen[:48].all()
    assert not sight.seen[52:].any()


def test_a_sheet_in_the_curves_own_colour_hides_it(axes: Any) -> None:
    axes.axhspan(-2, 2, color="C0", zorder=9)
    assert first_sight(told(axes.figure)).is_hidden
