"""Proposal of new deductions that bring the grades closer to marks given by hand. Nothing here changes a grade.

Only marks of criteria in which the grader names one fault alone change this fault's deduction. The proposed value is the mean of
what these marks deduct and of the present value, which counts as two marks, rounded to half points.
"""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from grader.course.calibration.comparison import ComparedCell
from grader.course.regrading.regrade import regraded
from grader.engine.faults import rows
from grader.engine.rubric import Rubric
from grader.people.final_grade import FinalGrade, grade_changes
from grader.report import words

FEWEST = 5
"""Submissions with marks, below which nothing is proposed."""
_PRESENT = 2
"""Marks that the present value of a deduction counts as, so that one or two marks do not move it far."""
_STEP = 0.5
"""Points: the step of a proposed deduction, its smallest change, and its least value, so that no fault becomes free."""


@dataclass(frozen=True)
class ChangedDeduction:
    """A fault's deduction in points, at present and as proposed; `cells` counts the hand-marked criteria that it rests on."""

    fault: str
    before: float
    after: float
    cells: int


@dataclass(frozen=True)
class Proposal:
    """Deductions that would fit marks given by hand better, with their effect; a person may copy them into the rubric.

    Attributes
    ----------
    changes
        Empty if no change would fit better.
    rubric
        The rubric with the changes.
    before, after
        Mean distance in points from the marks, with the present and with the proposed deductions.
    unseen
        `after` by leave-one-out, each submission measured by a proposal from the others: what to expect of work that nobody marked.
    unnamed
        The part of `after` in criteria where the grader names no fault, which no deduction can change.
    moved
        Each person whose final grade would change, the largest change first: name, present grade, future grade.
    """

    changes: tuple[ChangedDeduction, ...]
    rubric: Rubric
    before: float
    after: float
    unseen: float
    unnamed: float
    moved: tuple[tuple[str, float, float], ...]

    def sentences(self) -> list[str]:
        """Return sentences on the effect: distance from marks before and after, the part that no change reduces, changed grades."""
        rest = f"{self.unnamed:.2f} of it lies in cells where no fault is named. No deduction reaches them; read them one by one."
        remains = [rest] if self.unnamed >= 0.005 else []
        if not self.changes:
            return [f"The present deductions fit: no change brings the marks nearer than {self.before:.2f}.", *remains]
        return [
            f"The proposal brings the marked cells from {self.before:.2f} to {self.after:.2f} points. For submissions that nobody "
            f"marked, expect {self.unseen:.2f}: the distance when each marked one is predicted from the others.",
            *remains,
            f"{words.counted(len(self.moved), 'final grade')} of the class would change.",
        ]

    def block(self) -> list[str]:
        """Return the changed deductions as lines to paste into `rubric.yaml`; empty if nothing changes."""
        lines = [
            f"  {each.fault}: {each.after:g} # {each.before:g} at present; {words.counted(each.cells, 'mark')}"
            for each in self.changes
        ]
        return ["faults:", *lines] if lines else []


def propose(rubric: Rubric, cells: Sequence[ComparedCell], final_grades: Mapping[str, FinalGrade]) -> Proposal | None:
    """Propose deductions that fit the marks in `cells` better than `rubric` does; None for fewer than `FEWEST` marked submissions.

    A cell is one criterion of one submission. `final_grades` are those of the whole class, to tell whose grade would change.

    Raises
    ------
    RequestError
        If the class cannot be regraded by this rubric without running the submissions again.
    """
    marked = dict.fromkeys(cell.id for cell in cells)
    if len(marked) < FEWEST:
        return None
    now = regraded(final_grades, rubric)
    changes = _changes(rubric, cells)
    proposed = _with(rubric, changes)
    after = regraded(now, proposed)
    unseen: dict[str, FinalGrade] = {}
    for id_ in marked:
        others = _changes(rubric, [cell for cell in cells if cell.id != id_])
        unseen |= regraded({id_: now[id_]}, _with(rubric, others))
    return Proposal(
        tuple(changes),
        proposed,
        _distance(cells, now) / len(cells),
        _distance(cells, after) / len(cells),
        _distance(cells, unseen) / len(cells),
        _distance([cell for cell in cells if not cell.faults], after) / len(cells),
        tuple((words.distinct(c.final_grade), c.before or 0.0, c.after or 0.0) for c in grade_changes(now, after)),
    )


def _with(rubric: Rubric, changes: Sequence[ChangedDeduction]) -> Rubric:
    return replace(rubric, faults={**rubric.faults, **{each.fault: each.after for each in changes}})


def _distance(cells: Sequence[ComparedCell], final_grades: Mapping[str, FinalGrade]) -> float:
    """Return the sum of the distances, in points, between final grades and mean marks, over these criteria of submissions."""
    results = {id_: each.result for id_, each in final_grades.items()}
    points = {(id_, part.id): part.points for id_, result in results.items() for part in result.criteria}
    return sum(abs(points[cell.key] - cell.mean) for cell in cells)


def _changes(rubric: Rubric, cells: Sequence[ComparedCell]) -> list[ChangedDeduction]:
    """Return the deductions that change, each by the marks of criteria in which the grader names this fault and no other.

    A fault that any file can have, such as one that does not run, keeps its deduction: it costs whatever needs the file.
    """
    table = rows(rubric.lab)
    alone: dict[str, list[ComparedCell]] = {}
    for cell in cells:
        if len(cell.faults) == 1 and cell.faults[0] in table and table[cell.faults[0]].group == cell.criterion.id:
            alone.setdefault(cell.faults[0], []).append(cell)
    return [change for fault, its in alone.items() if (change := _change(rubric, fault, its))]


def _change(rubric: Rubric, fault: str, cells: Sequence[ComparedCell]) -> ChangedDeduction | None:
    """Return the changed deduction of a fault by the marks in `cells`, criteria in which it is the only fault.

    None where it moves by less than half a point, and for a fault that deducts more in one submission than in another, such as a
    fault of one sensor: one number for all would be wrong for some.
    """
    checks = [[check for check in cell.criterion.checks if fault in check.misconceptions] for cell in cells]
    deducted = [words.points_lost(its) for its in checks]
    if max(deducted) - min(deducted) >= _STEP:
        return None
    most = min(sum(check.max_points for check in its) for its in checks)
    before = min(rubric.faults.get(fault, round(statistics.median(deducted), 2)), most)
    wanted = before + sum(cell.difference for cell in cells) / (len(cells) + _PRESENT)
    after = min(max(round(wanted / _STEP) * _STEP, min(_STEP, before)), most)
    return (
        ChangedDeduction(fault, before, after, len(cells))
        if min(abs(wanted - before), abs(after - before)) >= _STEP
        else None
    )
