"""Tests of handed-in pictures: which may be a plot, and when one counts, with fake students."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from grader.engine.figures import Picture
from grader.engine.findings import NEEDS_REVIEW, Charged, Missing
from grader.labs.imu.answers import Drawing
from grader.labs.imu.visualization.measure import _handed_in, measure
from tests.judging.fake_students import truth
from tests.judging.test_check_visualization import SHEET, Plotted

pytestmark = pytest.mark.quick
PREVIEW, PALETTE = np.zeros((60, 80), np.uint8), np.full((256, 3), 255, np.uint8)
SEEN = Picture((800, 600), 0.2, PREVIEW, PALETTE)
NOTHING = Drawing(())


class Handing(Plotted):
    """One that hands in a picture of that name beside its code."""

    def __init__(self, drawing: Drawing = NOTHING, *scripts: Drawing, picture: Picture | None = SEEN, raises: bool = False) -> None:  # fmt: skip
        super().__init__(drawing, scripts, {"imu_data.png": picture})
        self.files, self._raises = {"imu_data.png": b""}, raises

    def plot(self, *given: Any, **more: Any) -> Drawing:
        if self._raises:
            raise Missing("plot_imu_data", "name-missing", "nobody made it")
        return super().plot(*given, **more)


@pytest.mark.parametrize(
    ("picture", "something"),
    [
        (SEEN, True),
        (None, False),
        (replace(SEEN, ink=0.005), False),
        (replace(SEEN, ink=0.59), True),
        (replace(SEEN, size_px=(149, 600)), False),
    ],
)
def test_a_picture_that_may_be_a_plot_shows_something(picture: Picture | None, something: bool) -> None:
    assert _handed_in(Handing(picture=picture), "imu_data.png") is something
    assert not _handed_in(Handing(picture=picture), "another.png")


EMPTY = replace(SHEET, axes=())
BESIDE_CODE: dict[str, tuple[Handing, bool]] = {
    "no code": (Handing(), True),
    "code that is missing": (Handing(raises=True), True),
    "axes without curves": (Handing(Drawing((EMPTY,))), True),
    "a plot": (Handing(Drawing((SHEET,))), False),
    "a plot by a script alone": (Handing(NOTHING, Drawing((SHEET,))), True),
    "a blank picture": (Handing(picture=replace(SEEN, ink=0.001)), False),
    "no picture": (Handing(picture=None), False),
}


@pytest.mark.parametrize(("student", "counts"), BESIDE_CODE.values(), ids=BESIDE_CODE)
def test_a_picture_counts_where_plot_imu_data_draws_nothing(student: Handing, counts: bool) -> None:
    student.notes.clear()
    stopped = measure(student, truth()).stopped
    assert [type(each) for each in stopped.values()].count(Charged) == 6 * counts
    assert [NEEDS_REVIEW in note for note in student.notes] == [True] * counts
