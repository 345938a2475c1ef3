"""What the sandbox tells of figures becomes records: of what its rule has looked at, and of nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest

from grader.engine.figures import VisibleParts, figures_of, picture_of
from grader.engine.replies import Answer, Drawings, Wrong, drawings
from grader.sandbox.wire import Frame
from grader.worker.recorder import Recorder
from tests.random_figures import figure_of, frame_of

pytestmark = pytest.mark.quick


@pytest.fixture
def frame() -> Frame:
    with figure_of(0) as figure:
        return frame_of(figure)


def facts_of(frame: Frame) -> Any:
    """The facts of its one figure."""
    return frame.fields["figures"][0]


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


def test_a_figure_whose_facts_are_of_another_type_is_no_figure(frame: Frame) -> None:
    """msgspec says so by an exception that is a ValueError from 0.23 on."""
    facts_of(frame).update(event=7)
    with pytest.raises(Wrong, match="no figure: Expected `str`, got `int`"):
        drawings(Answer(frame, {}, {}), Drawings(figures=[]))


@pytest.mark.parametrize(
    ("inside", "seen", "hidden"), [(100, 0, True), (100, 11, True), (100, 12, False), (50, 6, False), (0, 0, False)]
)
def test_a_curve_is_hidden_where_hardly_an_eighth_of_it_is_seen(inside: int, seen: int, hidden: bool) -> None:
    parts = np.arange(100)
    assert VisibleParts(parts < inside, parts < seen).is_hidden is hidden


def test_a_picture_that_cannot_be_read_is_none() -> None:
    assert picture_of(Frame({"readable": False, "reason": "no picture"}, {})) is None


# --- what the sandbox notes of a figure that is saved, and then drawn or written on ---

X = np.linspace(0, 1, 60)


@pytest.fixture
def figure() -> Iterator[Any]:
    made, axes = plt.subplots(2, 1)
    axes[0].plot(X, np.sin(9 * X), label="x")
    axes[0].set_title("Above")
    axes[0].legend()
    yield made
    plt.close("all")


def save(recorder: Recorder, figure: Any, folder: Path) -> None:
    figure.savefig(folder / "imu_data.png")
    recorder.note(figure, event="saved", target=str(folder / "imu_data.png"), kind="png")


@pytest.mark.parametrize("event", ["closed", "open", "cleared", "shown"])
def test_what_is_added_after_saving_does_not_count(figure: Any, tmp_path: Path, event: str) -> None:
    recorder = Recorder()
    save(recorder, figure, tmp_path)
    figure.axes[1].plot(X, X)
    figure.axes[1].set_title("late")
    recorder.note(figure, event=event)
    (saved,) = recorder.take(str(tmp_path), with_open=False)[0]["figures"]
    assert saved["event"] == "saved"
    assert [(axes["title"], len(axes["curves"])) for axes in saved["axes"]] == [("Above", 1), ("", 0)]


def test_a_figure_that_is_saved_once_more_at_its_end_is_not_told_of_again(figure: Any, tmp_path: Path) -> None:
    recorder = Recorder()
    save(recorder, figure, tmp_path)
    figure.axes[1].plot(X, X)
    save(recorder, figure, tmp_path)
    recorder.note(figure, event="closed")
    facts, _ = recorder.take(str(tmp_path), with_open=False)
    assert [each["event"] for each in facts["figures"]] == ["overwritten", "saved"]
