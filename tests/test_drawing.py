"""A figure is drawn small as the witness of what it shows: what raises still raises, and what may hide a curve is drawn."""

from __future__ import annotations

import io
import time
from collections.abc import Callable, Iterator
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.backend_bases import FigureCanvasBase
from matplotlib.ticker import FuncFormatter
from PIL import Image

from grader.engine.findings import NEEDS_REVIEW
from grader.engine.grader import Marker
from grader.worker import drawing
from grader.worker.pictures import decode
from tests.corpus.pieces import lab
from tests.examples import FOLDER
from tests.random_figures import made
from tests.single_faults import marked

really_print = FigureCanvasBase.print_figure


@pytest.fixture
def figure() -> Iterator[Any]:
    drawn, panels = plt.subplots(2, 1, figsize=(10, 6), sharex=True)
    for axes in panels:
        axes.plot(np.linspace(0, 3, 50), np.linspace(-1, 1, 50), label="$a_x$")
        axes.legend()
    yield drawn
    plt.close(drawn)


def saved(figure: Any, **options: Any) -> tuple[drawing.Preview, Any]:
    """What was seen of the figure, and the picture that was written."""
    seen = drawing.save(really_print, figure.canvas, target := io.BytesIO(), None, options)
    return seen, Image.open(target)


def bends_shared_axes(figure: Any) -> None:
    figure.axes[0].sharey(figure.axes[1])
    for axes in figure.axes:
        axes.set_aspect("equal", adjustable="datalim")


SPOILT: dict[str, Callable[[Any], object]] = {
    "unbalanced": lambda figure: figure.axes[0].set_title("$a_{x$"),
    "of different lengths": lambda figure: figure.axes[0].lines[0].set_data([1, 2, 3], [1, 2]),
    "tells no tick": lambda figure: figure.axes[1].xaxis.set_major_formatter(FuncFormatter(lambda _, __: str(1 / 0))),
    "bends shared axes": bends_shared_axes,
}


@pytest.mark.parametrize("spoil", SPOILT.values(), ids=SPOILT)
def test_what_drawing_raises_is_raised(figure: Any, spoil: Callable[[Any], object]) -> None:
    spoil(figure)
    with pytest.raises(Exception) as drawn:  # noqa: PT011 - whatever matplotlib raises
        really_print(figure.canvas, io.BytesIO(), format="png")
    with pytest.raises(drawn.type):
        saved(figure)
    assert "draw" not in vars(figure)


def test_looking_shows_what_saving_shows_and_leaves_the_figure_as_it_was(figure: Any) -> None:
    before = figure.dpi
    assert np.array_equal(drawing.draw_preview(figure).pixels, saved(figure)[0].pixels)
    assert figure.dpi == before


@pytest.mark.parametrize("form", ["png", "pdf", "svg"])
def test_every_form_of_picture_is_written(figure: Any, form: str) -> None:
    target = io.BytesIO()
    seen = drawing.save(really_print, figure.canvas, target, 200, {"format": form})
    assert target.getvalue()
    assert np.ptp(seen.pixels) > 100


@pytest.mark.parametrize("shape", [(3.0, 2.0), (10.0, 6.0), (40.0, 25.0)])
def test_curves_stand_where_matplotlib_puts_them(figure: Any, shape: tuple[float, float]) -> None:
    """The same pixels as in matplotlib's own picture, but for what stands beside the curves."""
    figure.set_size_inches(*shape)
    seen = drawing.draw_preview(figure)
    figure.savefig(target := io.BytesIO(), dpi=seen.dots)
    own = np.asarray(Image.open(target))[:, :, :3].astype(int)
    blue = (own[:, :, 2] > own[:, :, 0] + 40) & (seen.pixels.shape[:2] == own.shape[:2])
    legend = np.abs(seen.pixels.astype(int) - own).max(axis=2) > 8
    assert np.count_nonzero(blue & legend) < 0.2 * np.count_nonzero(blue)


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


@pytest.mark.parametrize("figures", [10, pytest.param(400, marks=pytest.mark.weekly)])
def test_no_curve_of_a_sound_figure_is_told_to_be_hidden_and_most_that_are_only_claimed_are(figures: int) -> None:
    assert [seed for seed in range(figures) if any(parts.is_hidden for parts in made(seed).values())] == []
    claimed = [made(seed, left_out="a")["a"].is_hidden for seed in range(0, figures, 5)]
    assert sum(claimed) >= 0.75 * len(claimed), "curves of the same colour may pass for it"


# --- pictures that were handed in beside code that does not draw them ---

DRAWN = Image.open(FOLDER / "s01-sheet-verbatim" / "imu_data.png").convert("RGB")
NOISE = Image.fromarray(np.random.default_rng(1).integers(0, 256, (600, 900, 3), np.uint8))


def content(picture: Any) -> bytes:
    picture.save(stream := io.BytesIO(), "PNG")
    return stream.getvalue()


@pytest.mark.parametrize(
    ("picture", "earned"), [(DRAWN, 1.0), (NOISE, 0.0), (Image.new("RGB", (900, 600), "white"), 0.0)]
)
def test_a_plot_without_code_earns_its_form_and_is_for_a_person(picture: Any, earned: float, marker: Marker) -> None:
    files = {**lab(plot="", compare=""), "imu_data.png": content(picture)}
    result = marked(marker, files, "visualization")
    points = [check.points or 0.0 for check in result.criteria[0].checks if not check.id.endswith("comparison_plot")]
    assert sum(points) == pytest.approx(earned)
    assert any(NEEDS_REVIEW in note for note in result.notes) is bool(earned)


def test_a_picture_of_any_colours_is_reduced_quickly() -> None:
    """Noise took 27 times as long as a figure; its own reading and shrinking take 2 to 4 times as long."""
    took = []
    for picture in (DRAWN, NOISE):
        handed, begun = np.frombuffer(content(picture), np.uint8), time.process_time()
        decode({}, {"bytes": handed})
        took.append(time.process_time() - begun)
    assert took[1] < 10 * took[0]
