"""The grader agrees with two people who marked twenty submissions by hand: no worse than when this was first measured."""

from __future__ import annotations

from grader.course.calibration.comparison import agreement
from tests import calibrated
from tests.generated import differs

DISTANCE = 0.30
OUTSIDE = 3
"""Points a cell between us and the mean of both people, and cells that neither of them accepts. Lower them when the grader improves."""


def test_we_are_no_further_from_two_markers_than_before_and_take_nothing_from_sound_work() -> None:
    cells = calibrated.cells()
    found = agreement("All", cells)
    assert len(cells) == 100
    assert round(found.distance, 2) <= DISTANCE
    assert found.outside <= OUTSIDE
    assert [cell for cell in cells if cell.kind == "false deduction"] == []


def test_the_page_on_fairness_quotes_the_present_table() -> None:
    if calibrated.table() != calibrated.TABLE.read_text(encoding="utf-8"):
        differs(calibrated.TABLE, "the agreement with the twenty marked submissions has changed")
