"""What the sandbox tells of figures becomes records: of what its rule has looked at, and of nothing else."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from grader.engine import replies
from grader.engine.figures import Axes, Curve, Entry, Figure, Placed, VisibleParts, figures_of, picture_of
from grader.sandbox.wire import Frame
from tests.random_figures import figure_of, frame_of

pytestmark = pytest.mark.quick


@pytest.fixture
def frame() -> Frame:
    with figure_of(0) as figure:
        return frame_of(figure)


def facts_of(frame: Frame) -> Any:
    """The facts of its one figure."""
    return frame.fields["figures"][0]


RULES = {
    Entry: replies._entry.of[0].keys(),
    Placed: replies._placed.of[0].keys(),
    Curve: replies._CURVE.keys() | {"x", "y"},
    Axes: replies._AXES.keys() | {"curves"},
    Figure: replies._FIGURE.keys() - {"legends"} | {"event", "path", "format", "size_px", "axes", "legend"},
}
OURS = {"visible_parts", "pixels"}
"""What no rule names: the first is found out here, the second is looked at as an array, the third is a figure by itself."""


@pytest.mark.parametrize("kind", RULES)
def test_every_field_of_a_record_is_one_that_the_rule_has_looked_at(kind: Any) -> None:
    assert {field.name for field in fields(kind)} - OURS == RULES[kind]


def test_what_the_box_says_to_be_seen_is_not_believed(frame: Frame) -> None:
    for axes in facts_of(frame)["axes"]:
        for curve in axes["curves"]:
            curve.update(visible=True, visible_parts="all of it")
    (figure,) = figures_of(frame)
    curves = [curve for axes in figure.axes for curve in axes.curves]
    assert curves
    assert not any(curve.visible for curve in curves)


def test_of_a_figure_that_cannot_be_read_only_the_file_is_told(frame: Frame) -> None:
    facts_of(frame).update(unreadable="ValueError", title=5, axes=[])
    (figure,) = figures_of(frame)
    assert (figure.event, figure.path, figure.size_px) == ("saved", "imu_data.png", (640, 480))
    assert (figure.title, figure.axes, figure.texts, figure.legend) == ("", (), (), ())
    assert (figure.extent, figure.dots, figure.pixels.shape) == ((0.0, 0.0), 0.0, (0, 0, 3))


@pytest.mark.parametrize(
    ("inside", "seen", "hidden"), [(100, 0, True), (100, 11, True), (100, 12, False), (50, 6, False), (0, 0, False)]
)
def test_a_curve_is_hidden_where_hardly_an_eighth_of_it_is_seen(inside: int, seen: int, hidden: bool) -> None:
    parts = np.arange(100)
    assert VisibleParts(parts < inside, parts < seen).is_hidden is hidden


def test_a_picture_that_cannot_be_read_is_none() -> None:
    assert picture_of(Frame({"readable": False, "reason": "no picture"}, {})) is None
