"""Tests of handed-in pictures beside code that does not draw them, in a real sandbox."""

from __future__ import annotations

import io
import time
from typing import Any

import numpy as np
import pytest
from PIL import Image

from grader.engine.findings import NEEDS_REVIEW
from grader.engine.grader import Marker
from grader.worker.pictures import decode
from tests.corpus.pieces import lab
from tests.examples import FOLDER
from tests.single_faults import marked

DRAWN = Image.open(FOLDER / "s01-sheet-verbatim" / "imu_data.png").convert("RGB")
NOISE = Image.fromarray(np.random.default_rng(1).integers(0, 256, (600, 900, 3), np.uint8))


def content(picture: Any) -> bytes:
    stream = io.BytesIO()
    picture.save(stream, "PNG")
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
