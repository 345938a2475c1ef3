"""A figure that is saved without being drawn raises what drawing it would have raised, and is drawn where that matters."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.backend_bases import FigureCanvasBase
from matplotlib.ticker import FuncFormatter, MultipleLocator, ScalarFormatter
from PIL import Image

from grader.harness import drawing

really_print = FigureCanvasBase.print_figure


@pytest.fixture
def figure() -> Iterator[Any]:
    drawn, panels = plt.subplots(2, 1, figsize=(10, 6), sharex=True)
    for axes in panels:
        axes.plot(np.linspace(0, 3, 50), np.linspace(-1, 1, 50), label="$a_x$")
        axes.legend()
    yield drawn
    plt.close(drawn)


def saved(figure: Any, **options: Any) -> tuple[bool, Any]:
    """Whether the figure was bare, and the picture that was written."""
    bare = drawing.save(really_print, figure.canvas, target := io.BytesIO(), None, options)
    return bare, Image.open(target)


def unbalanced(figure: Any) -> None:
    figure.axes[0].set_title("$a_{x$")


def of_different_lengths(figure: Any) -> None:
    figure.axes[0].lines[0].set_data([1, 2, 3], [1, 2])


def tells_no_tick(figure: Any) -> None:
    figure.axes[1].xaxis.set_major_formatter(FuncFormatter(lambda value, _: str(1 / (value - value))))


def bends_shared_axes(figure: Any) -> None:
    figure.axes[0].sharey(figure.axes[1])
    for axes in figure.axes:
        axes.set_aspect("equal", adjustable="datalim")


@pytest.mark.parametrize("spoil", [unbalanced, of_different_lengths, tells_no_tick, bends_shared_axes])
def test_what_drawing_raises_is_raised(figure: Any, spoil: Callable[[Any], None]) -> None:
    spoil(figure)
    with pytest.raises(Exception) as drawn:  # noqa: PT011 - whatever matplotlib raises
        really_print(figure.canvas, io.BytesIO(), format="png")
    with pytest.raises(drawn.type):
        saved(figure)
    assert "draw" not in vars(figure)


def test_a_bare_figure_is_examined_and_a_small_picture_written(figure: Any) -> None:
    bare, picture = saved(figure, bbox_inches="tight", format="png")
    assert bare
    assert min(picture.size) <= drawing._SHORT_SIDE + 1


def test_a_figure_like_a_ribbon_is_written_too(figure: Any) -> None:
    figure.set_size_inches(600, 0.5)
    assert saved(figure)[1].size == (60_000, 50)


@pytest.mark.parametrize("form", ["png", "pdf", "svg"])
def test_every_form_of_picture_is_written(figure: Any, form: str) -> None:
    target = io.BytesIO()
    assert drawing.save(really_print, figure.canvas, target, 200, {"format": form})
    assert target.getvalue()


def spans(axes: Any) -> None:
    axes.axhspan(-2, 2, color="white", zorder=9)


def thick(axes: Any) -> None:
    axes.lines[0].set_linewidth(40)


def boxed(axes: Any) -> None:
    axes.text(0, 0, "words", bbox={"fc": "white"})


def arrowed(axes: Any) -> None:
    axes.annotate("here", (1, 0), (2, 0), arrowprops={"arrowstyle": "->"})


def scaled(axes: Any) -> None:
    axes.set_yscale("function", functions=(np.exp, np.log))


class Formatter(ScalarFormatter):
    def get_offset(self) -> str:
        raise RuntimeError("a formatter of the student's own")


def told_otherwise(axes: Any) -> None:
    axes.yaxis.set_major_formatter(Formatter())


def marked_now_and_then(axes: Any) -> None:
    axes.lines[0].set_markevery([0, 5])


def in_other_coordinates(axes: Any) -> None:
    axes.plot(np.linspace(0, 1, 50), np.linspace(0, 1, 50), transform=axes.transAxes)


def listened_to(axes: Any) -> None:
    axes.figure.canvas.mpl_connect("draw_event", print)


@pytest.mark.parametrize(
    "change",
    [spans, thick, boxed, arrowed, scaled, told_otherwise, marked_now_and_then, in_other_coordinates, listened_to],
)
def test_whatever_may_cover_a_curve_or_fail_is_drawn(figure: Any, change: Callable[[Any], None]) -> None:
    assert drawing.nothing_covers(figure)
    figure.axes[1].yaxis.set_major_locator(MultipleLocator(0.5))  # as usual
    assert drawing.nothing_covers(figure)
    change(figure.axes[0])
    assert not drawing.nothing_covers(figure)


def test_a_single_stroke_across_a_panel_covers_nothing(figure: Any) -> None:
    figure.axes[0].axhline(-0.5, color="k", linestyle="--", label="gravity")
    figure.axes[1].axvline(1.0)
    assert drawing.nothing_covers(figure)


def test_a_figure_that_may_cover_a_curve_is_drawn_in_full(figure: Any) -> None:
    spans(figure.axes[0])
    bare, picture = saved(figure)
    assert not bare
    assert np.ptp(np.asarray(picture)) > 100


def test_a_layout_waits_until_the_figure_has_to_be_drawn(figure: Any) -> None:
    lay_out = drawing.laying_out_late(type(figure).tight_layout)
    before = figure.axes[0].get_position().bounds
    lay_out(figure)
    assert figure.axes[0].get_position().bounds == before
    saved(figure)
    assert figure.axes[0].get_position().bounds == before
    spans(figure.axes[0])
    saved(figure)
    after = figure.axes[0].get_position().bounds
    assert after != before
    lay_out(figure, pad=3.0)
    assert figure.axes[0].get_position().bounds[0] > after[0]


@pytest.mark.parametrize(
    ("source", "wanted"),
    [
        (b"img = plt.imread('imu_data.png')\nassert img.std() > 0\n", True),
        (b"assert os.path.getsize('imu_data.png') > 10_000\n", True),
        (b"fig.savefig('imu_data.png')\n", False),
    ],
)
def test_a_submission_that_reads_pictures_back_is_recognised(source: bytes, wanted: bool) -> None:
    assert drawing.reads_pictures_back([b"import numpy", source]) is wanted


def test_a_picture_that_is_read_back_is_drawn_as_asked(figure: Any) -> None:
    target = io.BytesIO()
    assert drawing.save_as_asked(really_print, figure.canvas, target, 200, {})
    picture = Image.open(target)
    assert picture.size == (2000, 1200)
    assert np.ptp(np.asarray(picture)) > 100
    drawing.save_as_asked(really_print, figure.canvas, target := io.BytesIO(), 20_000, {})
    assert max(Image.open(target).size) == drawing._LONG_SIDE


@pytest.mark.parametrize("dpi", [0, -3, float("nan")])
@pytest.mark.parametrize("save", [drawing.save, drawing.save_as_asked])
def test_a_dpi_that_means_nothing_is_refused(figure: Any, save: Callable[..., bool], dpi: float) -> None:
    with pytest.raises(ValueError, match="dpi"):
        save(really_print, figure.canvas, io.BytesIO(), dpi, {})
