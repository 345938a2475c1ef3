"""What the sandbox notes of a figure that is saved, and then drawn or written on."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest

from grader.worker.recorder import Recorder

pytestmark = pytest.mark.quick
X = np.linspace(0, 1, 60)


@pytest.fixture
def figure() -> Iterator[Any]:
    made, axes = plt.subplots(2, 1)
    axes[0].plot(X, np.sin(9 * X), label="x")
    axes[0].set_title("Above")
    axes[0].legend()
    yield made
    plt.close("all")


def _told(figure: Any, folder: Path, change: Callable[[Any], Any], event: str = "closed") -> list[dict[str, Any]]:
    """The facts of a figure that was saved, changed, and met once more."""
    recorder = Recorder()
    target = folder / "imu_data.png"
    figure.savefig(target)
    recorder.note(figure, event="saved", target=str(target), kind="png")
    change(figure)
    recorder.note(figure, event=event)
    facts, arrays = recorder.take(str(folder), with_open=False)
    assert all(each["seen"] in arrays for each in facts["figures"])
    figures: list[dict[str, Any]] = facts["figures"]
    return figures


def _retitles(figure: Any) -> None:
    figure.axes[0].set_title("Another")


def _draws_in_place(figure: Any) -> None:
    figure.axes[0].lines[0].remove()
    figure.axes[0].plot(X, X)
    figure.axes[1].plot(X, X)


MORE: dict[str, Callable[[Any], Any]] = {
    "a curve": lambda figure: figure.axes[1].plot(X, X),
    "points": lambda figure: figure.axes[1].scatter(X, X),
    "stairs": lambda figure: figure.axes[1].stairs(X[1:], X),
    "a title": lambda figure: figure.axes[1].set_title("Below"),
    "a title on the left": lambda figure: figure.axes[1].set_title("Below", loc="left"),
    "a label": lambda figure: figure.axes[1].set_xlabel("Time (s)"),
    "a legend": lambda figure: figure.axes[1].legend(handles=figure.axes[0].lines),
    "a text": lambda figure: figure.axes[1].text(0, 0, "x"),
    "a legend of the figure": lambda figure: figure.legend(),
    "a title of the figure": lambda figure: figure.suptitle("IMU"),
    "a panel with a curve": lambda figure: figure.add_axes((0, 0, 1, 1)).plot(X, X),
}
NO_MORE: dict[str, Callable[[Any], Any]] = {
    "nothing": lambda _figure: None,
    "another layout": lambda figure: figure.tight_layout(),
    "limits": lambda figure: figure.axes[0].set_ylim(-9, 9),
    "a legend once more": lambda figure: figure.axes[0].legend(),
    "another title": _retitles,
    "other curves": _draws_in_place,
    "an empty panel": lambda figure: figure.add_axes((0, 0, 1, 1)),
}


@pytest.mark.parametrize("change", MORE.values(), ids=MORE)
def test_what_was_added_after_saving_is_told(figure: Any, tmp_path: Path, change: Callable[[Any], Any]) -> None:
    saved, finished = _told(figure, tmp_path, change)
    assert [saved["event"], finished["event"]] == ["saved", "finished"]
    assert finished["path"] == saved["path"]
    assert finished["size_px"] == saved["size_px"]
    assert {key: finished[key] for key in ("axes", "legends", "title")} != {
        key: saved[key] for key in ("axes", "legends", "title")
    }


@pytest.mark.parametrize("change", NO_MORE.values(), ids=NO_MORE)
def test_what_adds_nothing_or_takes_something_away_is_not_told(
    figure: Any, tmp_path: Path, change: Callable[[Any], Any]
) -> None:
    assert [each["event"] for each in _told(figure, tmp_path, change)] == ["saved"]


def test_no_curve_gets_the_memory_of_one_that_was_saved_and_removed(figure: Any, tmp_path: Path) -> None:
    """It would be taken for that one, and a figure for one that was only added to: now and then, as memory falls."""
    recorder = Recorder()
    figure.savefig(tmp_path / "imu_data.png")
    recorder.note(figure, event="saved", target=str(tmp_path / "imu_data.png"), kind="png")
    removed = weakref.ref(figure.axes[0].lines[0])
    figure.axes[0].lines[0].remove()
    gc.collect()
    assert removed() is not None
    recorder.note(figure, event="closed")
    gc.collect()
    assert removed() is None


@pytest.mark.parametrize(("event", "told"), [("closed", 2), ("open", 2), ("cleared", 2), ("shown", 1)])
def test_a_figure_is_at_its_end_when_it_is_closed_or_left_behind(
    figure: Any, tmp_path: Path, event: str, told: int
) -> None:
    """A live plot is shown a thousand times; it is closed once."""
    assert len(_told(figure, tmp_path, MORE["a title"], event)) == told


def test_a_figure_that_is_saved_once_more_at_its_end_is_not_told_of_again(figure: Any, tmp_path: Path) -> None:
    recorder = Recorder()
    for change in (lambda: None, lambda: figure.axes[1].plot(X, X)):
        change()
        figure.savefig(tmp_path / "imu_data.png")
        recorder.note(figure, event="saved", target=str(tmp_path / "imu_data.png"), kind="png")
    recorder.note(figure, event="closed")
    facts, _ = recorder.take(str(tmp_path), with_open=False)
    assert [each["event"] for each in facts["figures"]] == ["overwritten", "saved"]


def test_no_end_of_saved_figures_has_an_end(tmp_path: Path) -> None:
    recorder = Recorder()
    for number in range(12):
        made, axes = plt.subplots()
        axes.plot(X, X)
        target = str(tmp_path / f"{number}.png")
        made.savefig(target)
        recorder.note(made, event="saved", target=target, kind="png")
        axes.set_title("late")
        recorder.note(made, event="closed")
    facts, _ = recorder.take(str(tmp_path))
    assert len(facts["figures"]) == 16
    plt.close("all")
