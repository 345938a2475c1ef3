"""Proposal of deductions and weights that come closest to marks given by hand: a bounded least-squares problem.

Each criterion is solved alone. The unknowns are the deductions of the faults named in a marked cell and the weights of the checks
that lost points there. The residuals are our points less the mean of the marks, and a pull towards the present values. Nothing
here changes a grade.
"""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from urllib.parse import urlencode

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from grader.course.calibration.comparison import ComparedCell
from grader.course.calibration.marks import Cell
from grader.course.regrading.regrade import regraded
from grader.engine.faults import rows
from grader.engine.marks import earned
from grader.engine.results import CriterionResult
from grader.engine.rubric import Criterion, Rubric
from grader.engine.rubric_sections import divided
from grader.people.final_grade import FinalGrade, GradeChange, grade_changes
from grader.report import words

FEWEST = 5
"""Submissions with marks, below which nothing is proposed."""
_PULL = {"fault": 2.0, "check": 8.0}
"""How many marks the present value counts as. Two marks of a fault outweigh half of it. A weight concerns every fault of its
check, so it moves last."""
_LEAST = 0.5
"""Points: the smallest deduction of a fault, so that none becomes free, the step that is proposed, and the smallest change."""
_FACTOR = 2.0
"""A weight stays between its half and its double."""
_STEP = 0.1
"""Points for the derivative: larger than the hundredths that points are rounded to."""

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Unknown:
    """Unknown of the fit: a deduction (`kind` "fault") or weight ("check"), with its present, least and largest value."""

    kind: str
    id: str
    now: float
    least: float
    most: float


@dataclass(frozen=True)
class Change:
    """A deduction or weight that the proposal changes, before and after, and the number of marked cells that it rests on."""

    kind: str
    id: str
    before: float
    after: float
    cells: int


@dataclass(frozen=True)
class Proposal:
    """Changed deductions and weights, and what they do.

    Attributes
    ----------
    changes
        Empty if the present values are as good.
    rubric
        The rubric with the changes.
    before, after
        Mean distance from the marks in all compared cells, with the present and the proposed values.
    unseen
        The same where each cell is measured with a proposal made without its submission. It is what to expect in cells that
        nobody marked.
    why
        Sentences on what remains.
    moved
        Submissions of the class whose final grade would change, largest change first, with the grade before and after.
    """

    changes: tuple[Change, ...]
    rubric: Rubric
    before: float
    after: float
    unseen: float
    why: tuple[str, ...]
    moved: tuple[GradeChange, ...]

    def sentences(self) -> list[str]:
        """Return what the proposal does to the distance, and what remains and why."""
        if not self.changes:
            return [f"The present deductions fit: no change brings the marks nearer than {self.before:.2f}.", *self.why]
        told = (
            f"The proposal brings the marked cells from {self.before:.2f} to {self.after:.2f} points. For submissions that nobody "
            f"marked, expect {self.unseen:.2f}: the distance when each marked one is predicted from the others."
        )
        return [told, *self.why, f"{words.counted(len(self.moved), 'final grade')} of the class would change."]

    def query(self) -> str:
        """Return the fields of the review desk's what-if that preview the proposal."""
        fields = {"fault": "price", "check": "weight"}
        return urlencode({f"{fields[each.kind]}:{each.id}": f"{each.after:g}" for each in self.changes})

    def block(self) -> list[str]:
        """Return the lines to paste into `rubric.yaml`."""
        faults = [each for each in self.changes if each.kind == "fault"]
        lines = ["faults:"] if faults else []
        lines += [
            f"  {each.id}: {each.after:g} # {each.before:g} at present; {words.counted(each.cells, 'mark')}"
            for each in faults
        ]
        for each in self.changes:
            if each.kind == "check":
                criterion, _, name = each.id.partition(".")
                lines.append(f"# weight in {criterion}:  {name}: {each.after:g} # {each.before:g} at present")
        return lines


def propose(rubric: Rubric, cells: Sequence[ComparedCell], final_grades: Mapping[str, FinalGrade]) -> Proposal | None:
    """Return the proposal that the compared cells support; None with fewer than `FEWEST` submissions.

    Raises
    ------
    RequestError
        If the class cannot be marked again by this rubric without running it.
    """
    if len({cell.id for cell in cells}) < FEWEST:
        return None
    now = regraded(final_grades, rubric)
    problems = [_Problem.of(rubric, criterion, cells, now) for criterion in rubric.criteria]
    changes = tuple(change for each in problems for change in each.changes())
    proposed = _with(rubric, {(each.kind, each.id): each.after for each in changes})
    after = regraded(now, proposed)
    unseen = {key: points for each in problems for key, points in each.unseen().items()}
    return Proposal(
        changes,
        proposed,
        _distance(cells, _points(now)),
        _distance(cells, _points(after)),
        _distance(cells, {**_points(now), **unseen}),
        tuple(_why(cells, _points(after))),
        tuple(grade_changes(now, after)),
    )


def _points(final_grades: Mapping[str, FinalGrade]) -> dict[Cell, float]:
    return {(id_, part.id): part.points for id_, each in final_grades.items() for part in each.result.criteria}


def _distance(cells: Sequence[ComparedCell], points: Mapping[Cell, float]) -> float:
    return statistics.fmean(abs(points[cell.key] - cell.mean) for cell in cells)


def _with(rubric: Rubric, values: Mapping[tuple[str, str], float]) -> Rubric:
    """Return the rubric with these deductions and weights, by kind and id."""
    faults = {id_: value for (kind, id_), value in values.items() if kind == "fault"}
    weights = {id_: value for (kind, id_), value in values.items() if kind == "check"}
    return replace(
        rubric,
        faults={**rubric.faults, **faults},
        criteria=tuple(_reweighted(criterion, weights) for criterion in rubric.criteria),
    )


def _reweighted(criterion: Criterion, weights: Mapping[str, float]) -> Criterion:
    if not any(check.id in weights for check in criterion.checks):
        return criterion
    checks = [replace(check, weight=weights.get(check.id, check.weight)) for check in criterion.checks]
    shares = divided(criterion.points, [check.weight for check in checks])
    return replace(
        criterion, checks=tuple(replace(check, max_points=most) for check, most in zip(checks, shares, strict=True))
    )


@dataclass(frozen=True)
class _Problem:
    """The problem of one criterion: its marked cells that lost points, what the class's rubric gives them, and the unknowns."""

    rubric: Rubric
    criterion: Criterion
    cells: tuple[ComparedCell, ...]
    parts: tuple[CriterionResult, ...]
    unknowns: tuple[Unknown, ...]

    @classmethod
    def of(
        cls, rubric: Rubric, criterion: Criterion, cells: Sequence[ComparedCell], now: Mapping[str, FinalGrade]
    ) -> _Problem:
        by_part = {(id_, part.id): part for id_, each in now.items() for part in each.result.criteria}
        lost = [c for c in cells if c.criterion.id == criterion.id and by_part[c.key].points < criterion.points]
        parts = tuple(by_part[cell.key] for cell in lost)
        unknowns = (*_deductions(rubric, criterion, parts), *_weights(criterion, parts))
        return cls(rubric, criterion, tuple(lost), parts, unknowns)

    def points(self, values: Vector) -> Vector:
        """Return the points of the cells with these values of the unknowns."""
        given = {each.id: float(value) for each, value in zip(self.unknowns, values, strict=True)}
        weights = {check.id: given.get(check.id, check.weight) for check in self.criterion.checks}
        worth = self.criterion.points / sum(weights.values())

        def points(part: CriterionResult) -> float:
            deductions = {**self.rubric.faults, **given}
            return sum(earned(check, weights[check.id] * worth, deductions) or 0.0 for check in part.checks)

        return np.array([points(part) for part in self.parts])

    def solved(self, without: str = "") -> Vector | None:
        """Return the values, rounded as they are proposed, that fit best the cells of all submissions but one.

        None where rounded values come no closer than the present points do.
        """
        now = np.array([each.now for each in self.unknowns])
        used = np.array([cell.id != without for cell in self.cells], dtype=bool)
        if not len(now) or not used.any():
            return None
        wanted = np.array([cell.mean for cell in self.cells])
        pull = np.sqrt([_PULL[each.kind] for each in self.unknowns])

        def residuals(values: Vector) -> Vector:
            return np.concatenate([(self.points(values) - wanted)[used], pull * (values - now)])

        def slopes(values: Vector) -> Vector:
            steps = _STEP * np.eye(len(values))
            return np.stack(
                [(residuals(values + step) - residuals(values - step)) / (2 * _STEP) for step in steps], axis=1
            )

        bounds = [each.least for each in self.unknowns], [each.most for each in self.unknowns]
        found: Vector = optimize.least_squares(residuals, now, jac=slopes, bounds=bounds, xtol=1e-3, ftol=1e-3).x
        rounded = np.array([_rounded(value, each) for value, each in zip(found, self.unknowns, strict=True)])
        errors = [np.sum((points - wanted)[used] ** 2) for points in (self.points(rounded), self.present)]
        return rounded if errors[0] < errors[1] else None

    @property
    def present(self) -> Vector:
        return np.array([part.points for part in self.parts])

    def changes(self) -> list[Change]:
        """Return the values that change, and the deductions of faults that share a check with one that does: a check by whose
        faults one has no deduction in the rubric keeps its own points."""
        if (solved := self.solved()) is None:
            return []
        values = dict(zip(self.unknowns, solved, strict=True))
        changed = {each.id for each, value in values.items() if value != each.now}
        together = [set(check.misconceptions) for part in self.parts for check in part.checks]
        beside = {id_ for names in together if names & changed for id_ in names}
        return [
            Change(each.kind, each.id, each.now, float(value), self._speaking_of(each))
            for each, value in values.items()
            if each.id in changed | beside
        ]

    def _speaking_of(self, unknown: Unknown) -> int:
        return sum(unknown.id in each.faults or unknown.id in _lost_in(each.criterion) for each in self.cells)

    def unseen(self) -> dict[Cell, float]:
        """Return the points of each cell by the values that fit the other submissions."""
        found = {}
        for at, cell in enumerate(self.cells):
            values = self.solved(without=cell.id)
            found[cell.key] = float((self.present if values is None else self.points(values))[at])
        return found


def _deductions(rubric: Rubric, criterion: Criterion, parts: Sequence[CriterionResult]) -> list[Unknown]:
    """Return the faults of a criterion's own that are named in these results, with what they deduct.

    Left out is a fault of any file, such as one that does not run: it costs whatever needs the file. So is a fault that deducts
    more in one submission than in another, such as one of a single sensor: one number for all would be wrong for some.
    """
    table = rows(rubric.lab)
    alone: dict[str, list[float]] = {}
    shared: dict[str, list[float]] = {}
    most: dict[str, float] = {}
    for part in parts:
        named = dict.fromkeys(id_ for check in part.checks for id_ in check.misconceptions)
        for id_ in (id_ for id_ in named if id_ in table and table[id_].group == criterion.id):
            its = [check for check in part.checks if id_ in check.misconceptions]
            taken = sum((check.max_points - (check.points or 0.0)) / len(check.misconceptions) for check in its)
            (alone if all(len(check.misconceptions) == 1 for check in its) else shared).setdefault(id_, []).append(
                taken
            )
            most[id_] = max(most.get(id_, 0.0), sum(check.max_points for check in its))
    found = []
    for id_, limit in most.items():
        deducted = alone.get(id_) or shared[id_]
        now = min(rubric.faults.get(id_, round(statistics.median(deducted), 2)), limit)
        least = min(_LEAST, now)
        if least < limit and max(deducted) - min(deducted) < _LEAST:
            found.append(Unknown("fault", id_, now, least, limit))
    return found


def _weights(criterion: Criterion, parts: Sequence[CriterionResult]) -> list[Unknown]:
    """Return the weights of the checks that lose points in these results."""
    lost = {id_ for part in parts for id_ in _lost_in(part)}
    return [
        Unknown("check", each.id, each.weight, each.weight / _FACTOR, each.weight * _FACTOR)
        for each in criterion.checks
        if each.id in lost and each.weight > 0
    ]


def _lost_in(part: CriterionResult) -> list[str]:
    return [check.id for check in part.checks if (check.points or 0.0) < check.max_points]


def _rounded(value: float, unknown: Unknown) -> float:
    """Return a value in steps of half a point, or the present one if it is nearer than such a step."""
    if abs(value - unknown.now) < _LEAST:
        return unknown.now
    return min(max(_in_steps(value), unknown.least), unknown.most)


def _in_steps(value: float) -> float:
    return round(value / _LEAST) * _LEAST


def _why(cells: Sequence[ComparedCell], points: Mapping[Cell, float]) -> list[str]:
    """Return sentences that say where the remaining distance lies."""
    often = {
        id_ for id_, count in Counter(id_ for cell in cells for id_ in cell.faults).items() if count > _PULL["fault"]
    }
    reasons = {
        "in cells where no fault is named. No deduction reaches them; read them one by one": 0.0,
        "in faults with one or two marks: the present value counts as two. Mark more submissions that have them": 0.0,
        "in faults with more marks: they differ from each other, or the fault already takes all points of its checks": 0.0,
    }
    for cell in cells:
        kind = 0 if not cell.faults else 2 if often.intersection(cell.faults) else 1
        reasons[list(reasons)[kind]] += abs(points[cell.key] - cell.mean) / len(cells)
    return [f"{share:.2f} of it lies {where}." for where, share in reasons.items() if share >= 0.005]
