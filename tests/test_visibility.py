"""Tests of the visibility of curves: a random sound figure loses none, and a curve that is claimed but not drawn is not seen."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest

from grader.engine.figures import Figure, VisibleParts
from grader.labs.imu.visualization.visibility import Patience, looked_at
from tests.random_figures import made, told

T = np.linspace(0, 5, 500)


def test_no_curve_of_forty_sound_figures_is_told_to_be_hidden() -> None:
    """5,000 by ``python -m tests.benchmarks.pictures``."""
    assert [seed for seed in range(40) if any(parts.is_hidden for parts in made(seed).values())] == []


@pytest.fixture
def axes() -> Iterator[Any]:
    figure, drawn = plt.subplots(figsize=(8, 4))
    drawn.plot(T, np.sin(2 * T), color="C0")
    yield drawn
    plt.close(figure)


def first_sight(figure: Figure) -> VisibleParts:
    return looked_at(figure, Patience()).axes[0].curves[0].visible_parts


def test_a_curve_is_seen_where_it_is_drawn_and_not_where_it_is_only_claimed(axes: Any) -> None:
    figure = told(axes.figure)
    sight = first_sight(figure)
    assert sight.inside.shape == sight.seen.shape == (100,)
    assert sight.inside.all()
    assert sight.seen.all()
    assert first_sight(replace(figure, pixels=np.full_like(figure.pixels, 255))).is_hidden
    (panel,) = figure.axes
    another = replace(panel, curves=(replace(panel.curves[0], y=np.cos(9 * T)), *panel.curves[1:]))
    assert first_sight(replace(figure, axes=(another,))).seen.mean() < 0.4


def test_a_part_outside_the_limits_or_under_a_sheet_is_not_seen(axes: Any) -> None:
    axes.axvspan(2.5, 9, color="white", zorder=9)
    axes.set_xlim(0, 5)
    covered = first_sight(told(axes.figure))
    assert covered.inside.all()
    assert covered.seen[:48].all()
    assert not covered.seen[52:].any()
    axes.set_xlim(0, 1)
    cut_off = first_sight(told(axes.figure))
    assert np.flatnonzero(cut_off.inside)[[0, -1]].tolist() == pytest.approx([0, 20], abs=1)
    assert not cut_off.is_hidden
    axes.axhspan(-2, 2, color="C0", zorder=9)
    assert first_sight(told(axes.figure)).is_hidden  # under a sheet in its own colour
