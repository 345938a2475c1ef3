"""The grader agrees with two independent markers of twenty submissions: no worse than when this was first measured."""

from __future__ import annotations

from grader.course.calibration.comparison import agreement, compare
from grader.course.calibration.proposal import propose
from grader.course.regrading.regrade import regraded
from grader.people.final_grade import FinalGrade
from tests import calibrated
from tests.generated import differs
from tests.recordings.marker import without_charts

DISTANCE = 0.04
OUTSIDE = 0
"""Points a cell between us and the mean of both markers, and cells that neither of them accepts. Lower them when the grader improves."""


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


def test_the_first_markers_points_alone_bring_the_grades_closer_to_the_seconds() -> None:
    results = calibrated.results()
    first, second = calibrated.marks(results)
    final_grades = {id_: FinalGrade(id_, result) for id_, result in results.items()}
    proposal = propose(without_charts(), compare(results, [first]), final_grades)
    assert proposal is not None
    after = {id_: each.result for id_, each in regraded(final_grades, proposal.rubric).items()}
    distances = [agreement("", compare(graded, [second])).distance for graded in (results, after)]
    assert distances[1] <= distances[0]
    assert proposal.after <= proposal.before
    sound = [id_ for id_, result in results.items() if result.score == result.max_score]
    assert [id_ for id_ in sound if after[id_].score != 100] == []
