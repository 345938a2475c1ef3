"""Handed-in pictures that no code draws: the sheet's figure is recognised however it was saved, and nothing else is."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import mujoco
import numpy as np
import pytest
from PIL import Image

from grader.engine import rubric
from grader.engine.findings import A_PERSON_MAY
from grader.engine.marking import Marker
from grader.harness.pictures import decode
from grader.intake import Submission
from grader.labs.imu import bundles
from grader.labs.imu.checks.handed_in import _INK
from grader.labs.imu.diagnosis.handed_in import sensors_shown
from grader.labs.imu.lab import LAB
from reference.imu_reader import MODEL_PATH, simulate_and_collect
from tests.corpus.pieces import lab

BOTH, NONE = {0, 1}, set[int]()


@pytest.fixture(scope="module")
def recording() -> dict[str, Any]:
    model = mujoco.MjModel.from_xml_path(str(MODEL_PATH))
    return simulate_and_collect(model, mujoco.MjData(model), duration_seconds=5.0)


def drawn(recording: dict[str, Any], style: str = "default", dpi: int = 100) -> Any:
    """The sheet's own figure as a picture."""
    with mpl.rc_context():
        plt.style.use(style)
        figure, axes = plt.subplots(2, 1, figsize=(12, 8), sharex=True)
        for panel, key, label in zip(axes, ("acceleration", "angular_velocity"), ("m/s²", "rad/s"), strict=True):
            panel.plot(recording["time"], recording[key], label=["X", "Y", "Z"])
            panel.set(title=key, ylabel=label)
            panel.legend()
            panel.grid(True)
        axes[0].axhline(-9.81, color="k", linestyle="--", alpha=0.3, label="Gravity")
        figure.tight_layout()
        stream = io.BytesIO()
        figure.savefig(stream, dpi=dpi)
        plt.close(figure)
    return Image.open(stream).convert("RGB")


def content(picture: Any, form: str = "PNG") -> bytes:
    stream = io.BytesIO()
    picture.save(stream, form)
    return stream.getvalue()


def shown(picture: bytes) -> set[int]:
    """Which sensors a reader of the picture recognises; none where it is no plot."""
    facts, arrays = decode({}, {"bytes": np.frombuffer(picture, np.uint8)})
    if not _INK[0] < facts["ink"] < _INK[1]:
        return NONE
    push = bundles.shipped()["push"]
    series = {key: push[key] for key in ("time", "acceleration", "angular_velocity")}
    return sensors_shown(arrays["preview"], arrays["palette"], series)


def in_a_window(picture: Any) -> Any:
    width, height = picture.size
    window = Image.new("RGB", (width + 120, height + 180), (40, 44, 52))
    window.paste((220, 70, 60), (0, 0, width + 120, 40))
    window.paste(picture, (60, 100))
    return window


@pytest.mark.parametrize("dpi", [50, 200])
def test_the_sheets_figure_is_recognised_at_any_size(recording: dict[str, Any], dpi: int) -> None:
    assert shown(content(drawn(recording, dpi=dpi))) == BOTH


@pytest.mark.parametrize("style", ["dark_background", "ggplot"])
def test_the_sheets_figure_is_recognised_in_other_styles(recording: dict[str, Any], style: str) -> None:
    assert shown(content(drawn(recording, style))) == BOTH


def test_the_sheets_figure_is_recognised_on_a_screenshot(recording: dict[str, Any]) -> None:
    assert shown(content(in_a_window(drawn(recording)))) == BOTH


def test_the_sheets_figure_is_recognised_in_the_bytes_of_a_jpeg(recording: dict[str, Any]) -> None:
    assert shown(content(drawn(recording), "JPEG")) == BOTH


def _sines(recording: dict[str, Any]) -> Any:
    waves = np.sin(np.outer(recording["time"], [2.0, 3.0, 5.0]))
    return drawn(recording | {"acceleration": waves - [0, 0, 9.81], "angular_velocity": waves})


@pytest.mark.parametrize(
    "other",
    [
        _sines,
        lambda recording: drawn(recording | {"angular_velocity": recording["acceleration"]}),
        lambda recording: drawn({key: values[:1] for key, values in recording.items()}),
        lambda _: Image.fromarray(np.random.default_rng(1).integers(0, 256, (600, 900, 3), np.uint8)),
        lambda _: Image.new("RGB", (900, 600), "white"),
    ],
    ids=["sines", "one sensor twice", "empty axes", "noise", "a blank sheet"],
)
def test_other_pictures_do_not_show_both_sensors(
    recording: dict[str, Any], other: Callable[[dict[str, Any]], Any]
) -> None:
    assert shown(content(other(recording))) != BOTH


@pytest.fixture(scope="module")
def marker() -> Iterator[Marker]:
    with Marker(rubric.load(LAB), bundles.shipped()) as opened:
        yield opened


def test_it_earns_half_of_the_criterion_and_a_person_is_asked_to_look(
    recording: dict[str, Any], marker: Marker
) -> None:
    files = {name: text.encode() for name, text in lab(plot="", compare="").items()}
    picture = {"imu_data.png": content(drawn(recording))}
    result = marker.mark(Submission("s", "s", files | picture, (), "ready", ""), only="visualization")
    checks = {check.id.partition(".")[2]: check for check in result.criteria[0].checks}
    earned = sum(check.points or 0.0 for name, check in checks.items() if name != "comparison_plot")
    assert earned == pytest.approx(8.0)
    assert [note for note in result.notes if "imu_data.png" in note and A_PERSON_MAY in note]
