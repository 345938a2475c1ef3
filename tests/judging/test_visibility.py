"""Tests of the visibility of a curve, in pictures that are painted pixel by pixel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grader.engine.figures import Axes, Curve, Figure, VisibleParts
from grader.labs.imu.returned import Array
from grader.labs.imu.visualization import visibility
from grader.labs.imu.visualization.visibility import Patience

pytestmark = pytest.mark.quick
WIDTH, HEIGHT = 300, 200
LEFT, LOW, RIGHT, HIGH = 0.1, 0.2, 0.9, 0.95
X = np.linspace(0, 1, 400)
Y = 0.5 + 0.4 * np.sin(9 * X)
LOWER = 0.05 + 0.1 * X
RED, BLUE, WHITE, DARK = (255, 0, 0), (0, 0, 255), (255, 255, 255), (40, 44, 52)


def code(colour: tuple[int, ...]) -> str:
    return "#" + "".join(f"{channel:02x}" for channel in colour)


def curve(y: Array = Y, colour: tuple[int, ...] = RED, x: Array = X, **words: object) -> Curve:
    nothing = VisibleParts(np.ones(100, bool), np.zeros(100, bool))
    made = Curve("", code(colour), "line", len(y), x, y, "-", "None", "", 1.0, (code(colour) + "ff",), 1.5, nothing)
    return replace(made, **words)  # type: ignore[arg-type]


class Canvas:
    """A picture of one panel, from 0 to 1 in both directions."""

    def __init__(self, ground: tuple[int, ...] = WHITE, *, log: bool = False) -> None:
        self.pixels = np.full((HEIGHT, WIDTH, 3), ground, np.uint8)
        self.log = log

    def place(self, x: Array, y: Array) -> tuple[np.ndarray, np.ndarray]:
        if self.log:
            x, y = (1 + np.log10(values) / 3 for values in (x, y))
        rows = HEIGHT - (LOW + y * (HIGH - LOW)) * HEIGHT
        return rows.astype(int), ((LEFT + x * (RIGHT - LEFT)) * WIDTH).astype(int)

    def draw(self, y: Array = Y, colour: tuple[int, ...] = RED, x: Array = X, opacity: float = 1.0, thick: int = 2) -> Canvas:  # fmt: skip
        fine = np.linspace(0, len(x) - 1, 20 * len(x))
        way = (np.interp(fine, np.arange(len(x)), values) for values in (x, y))
        mask = np.zeros((HEIGHT, WIDTH), bool)
        rows, columns = self.place(*way)
        for down in range(thick):
            mask[rows - down, columns] = True
        self.pixels[mask] = np.rint(opacity * np.array(colour) + (1 - opacity) * self.pixels[mask])
        return self

    def fill(self, colour: tuple[int, ...], left: float = 0.0, right: float = 1.0, low: float = 0.0, high: float = 1.0) -> Canvas:  # fmt: skip
        (bottom, top), (first, last) = self.place(np.array([left, right]), np.array([low, high]))
        self.pixels[top : bottom + 1, first : last + 1] = colour
        return self

    def figure(self, *curves: Curve, **words: object) -> Figure:
        limits = ((1e-3, 1.0),) * 2 if self.log else ((0.0, 1.0),) * 2
        scales = ("log", "log") if self.log else ("linear", "linear")
        axes = Axes(True, (LEFT, LOW, RIGHT, HIGH), "", "", "", (), (), curves, *limits, scales, own_ticks=False)  # type: ignore[arg-type]
        size = (float(WIDTH), float(HEIGHT))
        return Figure("saved", None, "png", (WIDTH, HEIGHT), (replace(axes, **words),), extent=size, dots=72, pixels=self.pixels)  # type: ignore[arg-type] # fmt: skip


def looked(figure: Figure, pixels: int = 60_000_000) -> list[VisibleParts]:
    axes = visibility.looked_at(figure, Patience(pixels)).axes
    assert len(axes) == 1
    assert len(axes[0].curves) == len(figure.axes[0].curves)
    return [each.visible_parts for each in axes[0].curves]


def seen(figure: Figure) -> float:
    """Share of the first curve that is seen."""
    return float(looked(figure)[0].seen.mean())


# --- in the open ---------------------------------------------------------------------------------------------------------

GREY, PALE = (128, 128, 128), (230, 230, 230)
IN_THE_OPEN: dict[str, Figure] = {
    "on a dark ground": Canvas(DARK).draw().figure(curve()),
    "faint": Canvas().draw(colour=(244, 244, 244)).figure(curve(colour=(244, 244, 244))),
    "on a half that is tinted": Canvas().fill((255, 140, 140), 0.55).draw().figure(curve()),
    "as tiny points": Canvas().draw(opacity=0.05, thick=1).figure(curve(kind="points", marker="o", width=0.5)),
    "as tiny markers": Canvas().draw(opacity=0.05, thick=1).figure(curve(style="None", marker="o", width=0.5)),
    "nearly through by its colour": Canvas().draw(opacity=0.2).figure(curve(inks=("#ff000033",))),
    "of a thin stroke": Canvas().draw(opacity=0.2, thick=1).figure(curve(width=0.5)),
    "of too many colours to tell": Canvas().draw().figure(curve(inks=())),
    "of a colour that is none": Canvas().draw().figure(curve(inks=("red",))),
    "of two colours": Canvas().draw(colour=BLUE).figure(curve(inks=("#00ff00ff", "#0000ffff"))),
    "on logarithmic scales": Canvas(log=True).draw(0.01 + X**2 * 0.9, x=0.002 + 0.9 * X).figure(curve(0.01 + X**2 * 0.9, x=0.002 + 0.9 * X)),
    "from the right": Canvas().draw(x=1 - X).figure(curve(), x_limits=(1.0, 0.0)),
    "a pixel beside": Canvas().draw(Y + 1 / 150).figure(curve()),
    "with gaps in its numbers": Canvas().draw().figure(curve(np.where(np.arange(400) % 9 == 0, np.nan, Y))),
    "in a panel that is turned around": Canvas().draw(x=1 - X).figure(curve(), position=(RIGHT, LOW, LEFT, HIGH)),
    "in a panel that is on its head": Canvas().draw(1 - Y).figure(curve(), position=(LEFT, HIGH, RIGHT, LOW)),
}  # fmt: skip


@pytest.mark.parametrize("figure", IN_THE_OPEN.values(), ids=IN_THE_OPEN)
def test_a_curve_in_the_open_is_seen(figure: Figure) -> None:
    assert looked(figure)[0].inside.all()
    assert seen(figure) > 0.93


NOT_THERE: dict[str, Figure] = {
    "of another colour": Canvas().draw(colour=BLUE).figure(curve()),
    "elsewhere": Canvas().draw(LOWER).figure(curve(0.3 + Y / 2)),
    "behind another curve": Canvas().draw().draw(colour=BLUE, thick=4).figure(curve(), curve(colour=BLUE)),
    "in the colour of its ground": Canvas().draw(colour=(250, 250, 250)).figure(curve(colour=(250, 250, 250))),
    "all but through, over something of its colour": Canvas().draw().figure(curve(alpha=0.02)),
    "fainter than anyone sees": Canvas().draw(opacity=0.02, thick=1).figure(curve(width=0.05)),
    "grey, and fainter than anyone sees": Canvas().draw(colour=PALE, opacity=0.2, thick=1).figure(curve(colour=PALE, width=0.5)),
    "too faint for its stroke": Canvas().draw(opacity=0.2).figure(curve()),
    "behind a tint of its colour": Canvas().draw().fill(WHITE).fill((255, 140, 140), 0.55).figure(curve()),
    "behind a picture of its colours": Canvas().draw().fill(WHITE).fill((255, 200, 200), 0.4, 0.9, 0.2, 0.7).figure(curve()),
    "in a panel that is switched off": Canvas().draw().figure(curve(), visible=False),
    "in a panel that is no wider than a stroke": Canvas().draw().figure(curve(), position=(LEFT, LOW, LEFT + 0.029, HIGH)),
    "in a panel that is no higher than a stroke": Canvas().draw().figure(curve(), position=(LEFT, LOW, RIGHT, LOW + 0.029)),
    "in a panel beyond the picture": Canvas().draw().figure(curve(), position=(1.1, LOW, 1.9, HIGH)),
    "of no points": Canvas().draw().figure(curve(Y[:0], x=X[:0])),
    "of too many colours to tell, on a blank picture": Canvas().figure(curve(inks=())),
}  # fmt: skip


@pytest.mark.parametrize("figure", NOT_THERE.values(), ids=NOT_THERE)
def test_a_curve_that_is_not_in_the_picture_is_not_seen(figure: Figure) -> None:
    assert seen(figure) < 0.12


@pytest.mark.parametrize(("half", "parts"), [((0.0, 0.5), slice(52, 100)), ((0.5, 1.0), slice(0, 48))])
def test_of_a_curve_half_of_which_is_covered_half_is_seen(half: tuple[float, float], parts: slice) -> None:
    (found,) = looked(Canvas().draw().fill(WHITE, *half).figure(curve()))
    assert found.inside.all()
    assert found.seen[parts].all()
    assert found.seen.mean() == pytest.approx(0.5, abs=0.04)


def test_a_curve_is_seen_through_another_one_that_lets_it_through() -> None:
    through = Canvas().draw(thick=3).draw(colour=BLUE, opacity=0.5, thick=5)
    figure = through.figure(curve(), curve(colour=BLUE, inks=("#0000ff80",), alpha=0.5))
    first, second = looked(figure)
    assert first.seen.mean() > 0.9
    assert second.seen.mean() > 0.9
    panel = round((RIGHT - LEFT) * WIDTH) * round((HIGH - LOW) * HEIGHT)
    assert looked(figure, 4 * panel)[0].seen.mean() > 0.9
    assert not looked(figure, 4 * panel - 1)[0].seen.any()


@pytest.mark.parametrize(
    ("limits", "inside"), [((0.5, 1.0), range(50, 100)), ((-1.0, 0.3), range(30)), ((7.0, 8.0), range(0))]
)
def test_a_part_beyond_the_limits_is_outside(limits: tuple[float, float], inside: range) -> None:
    (found,) = looked(Canvas().figure(curve(), x_limits=limits))
    assert len(set(np.flatnonzero(found.inside)) ^ set(inside)) <= 1


@pytest.mark.parametrize(
    ("y", "share"), [(2 * X, 0.5), (2 * X - 1, 0.5), (X, 1.0), (0 * X, 1.0), (X + 1.001, 0.0), (X - 1.001, 0.0)]
)
def test_what_is_above_or_below_the_limits_is_outside(y: Array, share: float) -> None:
    (found,) = looked(Canvas().figure(curve(y)))
    assert found.inside.mean() == pytest.approx(share, abs=0.02)
    assert not found.seen.any()


@pytest.mark.parametrize(
    ("position", "x", "marks"),
    [
        ((LEFT, 0.5, RIGHT, 1.5), X, np.s_[:3, :]),
        ((LEFT, -0.5, RIGHT, 0.5), X, np.s_[-3:, :]),
        ((-0.5, LOW, 0.5, HIGH), 0.4 * X, np.s_[:, :3]),
        ((0.5, LOW, 1.5, HIGH), 0.6 + 0.4 * X, np.s_[:, -3:]),
    ],
)
def test_what_is_beyond_the_picture_is_not_seen_at_its_edge(
    position: tuple[float, float, float, float], x: Array, marks: tuple[slice, slice]
) -> None:
    canvas = Canvas()
    canvas.pixels[marks] = RED
    height = 0.1 if position[1] < 0 else 0.9
    (found,) = looked(canvas.figure(curve(np.full(400, height), x=x), position=position))
    assert found.inside.all()
    assert not found.seen.any()


@pytest.mark.parametrize("position", [(-0.5, LOW, 0.5, HIGH), (0.5, LOW, 1.5, HIGH), (-0.5, LOW, 1.5, 1.5)])
def test_of_a_panel_that_goes_beyond_the_picture_what_is_in_it_is_seen(
    position: tuple[float, float, float, float],
) -> None:
    left, low, right, high = position
    columns, row = (left + X * (right - left)) * WIDTH, round(HEIGHT * (1 - low - 0.3 * (high - low)))
    there = (columns >= 0) & (columns < WIDTH)
    canvas = Canvas()
    canvas.pixels[row - 1 : row + 1, columns[there].astype(int)] = RED
    (found,) = looked(canvas.figure(curve(np.full(400, 0.3)), position=position))
    assert found.inside.all()
    assert found.seen.mean() == pytest.approx(there.mean(), abs=0.03)


@pytest.mark.parametrize(("marks", "shown"), [(1, 1.0), (0, 0.0)])
def test_on_scales_that_are_not_foreseen_a_pixel_of_a_colour_is_the_curve(marks: int, shown: float) -> None:
    canvas = Canvas()
    canvas.pixels[100, 100 : 100 + marks] = RED
    (found,) = looked(canvas.figure(curve(), scales=("linear", "symlog")))
    assert (found.inside.mean(), found.seen.mean()) == (1.0, shown)


@pytest.mark.parametrize(
    ("words", "off", "shown"),
    [
        ({}, 1, True), ({}, 2, False), ({"marker": "o"}, 2, True), ({"kind": "points", "width": 1.5}, 3, False),
        ({"marker": "o", "width": 6.0}, 5, True), ({"marker": "o", "width": 6.0}, 6, False),
        ({"marker": "o", "width": 60.0}, 6, False), ({"marker": ""}, 2, False),
        ({"marker": "none"}, 2, False), ({"marker": " "}, 2, False),
    ],
)  # fmt: skip
def test_a_marker_leaves_its_colour_around_its_point(words: dict[str, object], off: int, shown: bool) -> None:
    canvas = Canvas()
    rows, columns = canvas.place(X, Y)
    canvas.pixels[rows[200], columns[200] + off] = RED
    canvas.pixels[rows[200] - 1, columns[200] + off] = RED
    (found,) = looked(canvas.figure(curve(Y[200:201], x=X[200:201], **words)))
    assert bool(found.seen.any()) is shown


# --- parts of it ---------------------------------------------------------------------------------------------------------


OFF = -np.array([0.0, 0.8, 0.8])


@pytest.mark.parametrize(
    ("off", "share"),
    [
        (OFF, 1.0), (OFF / 2, 0.5), (0 * OFF, 0.0), (2 * OFF, 1.0), (-OFF, 0.0), (OFF / 2 + np.array([0.09, 0, 0]), 0.5),
        (OFF / 2 + np.array([0.11, 0, 0]), 0.0), (OFF + np.array([0.14, 0, 0]), 1.0), (OFF + np.array([0.16, 0, 0]), 0.0),
    ],
)  # fmt: skip
def test_a_pixel_is_on_the_way_to_a_colour_or_beside_it(off: Array, share: float) -> None:
    assert visibility.share_of_way(off[:, None].astype(np.float32), OFF).tolist() == pytest.approx([share])


@pytest.mark.parametrize(
    ("x", "seen_points", "parts"),
    [
        ([0.0, 0.5, 1.0], [True, False, True], [0, *range(50, 100)]),
        ([1.0, 0.0, 0.5], [True, True, False], [0, *range(50, 100)]),
        ([0.0, 0.5, 1.0], [False, True, False], range(51)),
        ([0.0, 0.999, 1.0], [False, True, False], range(100)),
        ([3.0], [True], range(100)),
        ([3.0, 3.0], [False, True], range(1)),
        ([-1e308, 1e308], [False, True], range(100)),
        (np.linspace(0, 1, 1000), np.arange(1000) > 994, [99]),
        (np.linspace(-5, 5, 1000), np.arange(1000) % 100 == 50, range(5, 100, 10)),
    ],
)
def test_a_part_is_seen_where_a_point_in_it_or_the_next_one_is(
    x: list[float], seen_points: list[bool], parts: list[int]
) -> None:
    points = np.array(x), np.ones(len(x), bool), np.array(seen_points)
    with np.errstate(all="ignore"):
        found = visibility._by_parts(*points)
        nothing = visibility._by_parts(points[0], ~points[1], points[2])
    assert found.inside.all()
    assert np.flatnonzero(found.seen).tolist() == list(parts)
    assert not nothing.inside.any()
    assert not nothing.seen.any()
