"""The note beside a picture that was handed in and that no code draws."""

from __future__ import annotations

from unittest import mock

import pytest

from grader.engine.findings import CheckFailed
from grader.labs.imu.answers import Drawing
from grader.labs.imu.checks import handed_in, lost_pictures
from tests.judging.made import truth
from tests.judging.test_check_visualization import PICTURE_HANDED_IN, Plotted

pytestmark = pytest.mark.quick


def _notes(*, counts: bool) -> list[str]:
    student = Plotted(Drawing(()), **PICTURE_HANDED_IN)

    def counted(*given: object) -> bool:
        assert given == (student, truth())
        return counts

    with mock.patch.object(handed_in, "counts", counted), pytest.raises(CheckFailed):
        lost_pictures.none_saved(student, truth(), Drawing(()))
    return student.notes


def test_who_reads_the_note_may_look_at_the_picture() -> None:
    told = "imu_data.png was handed in, and no code draws it; an instructor may give more points for what it shows"
    assert _notes(counts=False) == [told]


def test_a_picture_that_counts_has_its_note_already() -> None:
    assert _notes(counts=True) == []
