"""What the sandbox notes of a figure that is saved, and then drawn or written on."""

from __future__ import annotations

from collections.abc import Iterator
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
