"""Which run a plot is asked to draw, and under which name a report finds what came of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from grader.labs.imu.answers import Array, Drawing
from grader.labs.imu.checks import plot_runs
from tests.judging.made import truth
from tests.judging.test_check_visualization import Plotted, Sheet

pytestmark = pytest.mark.quick


class Asked(Plotted):
    """One that keeps what its plot was given."""

    def plot(self, *, data: Mapping[str, Array], sheet: Mapping[str, Array], ids: Any, called: str) -> Drawing:  # type: ignore[override]
        self.given = data, sheet, ids, called
        return Sheet().drawing()


@pytest.mark.parametrize(("run", "name"), [("tumbling", "plot"), ("push", "")])
def test_the_drawing_of_the_hidden_run_alone_has_a_name(run: str, name: str) -> None:
    student = Asked(Drawing(()))
    plot_runs.drawing_of_data(student, truth(), run)
    data, sheet, ids, called = student.given
    assert (called, ids) == (name, tuple(truth()["reading_lab"]["pairs"][0]))
    for key in ("time", "acceleration", "angular_velocity"):
        assert np.array_equal(data[key], truth()[run][key])
        assert np.array_equal(sheet[key], truth()[run][key])
