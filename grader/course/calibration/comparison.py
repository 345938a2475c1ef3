"""Comparison of the grader's points with marks that people gave by hand: how far apart, where, and in which direction."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from scipy import special

from grader.course.calibration.marks import Cell, Mark, Marks
from grader.engine.results import CriterionResult, Result

_FULL = 1e-6
"""Points within this of the maximum are the maximum."""
_FIRST = {"false deduction": 0, "missed fault": 1}
"""The kinds of differences that a person should look at first."""
HEAD = ("Cells", "Markers apart", "We from their mean", "We give more (+)", "No marker accepts")


@dataclass(frozen=True)
class ComparedCell:
    """One criterion of one submission, as calibration compares it: the grader's result, and the marks of at least one person."""

    id: str
    criterion: CriterionResult
    marks: tuple[Mark, ...]

    @property
    def key(self) -> Cell:
        return self.id, self.criterion.id

    @property
    def mean(self) -> float:
        return statistics.fmean(mark.points for mark in self.marks)

    @property
    def difference(self) -> float:
        """The grader's points minus the mean of the marks: positive where the grader is milder, negative where it is harder."""
        return self.criterion.points - self.mean

    @property
    def apart(self) -> float | None:
        """The mean distance in points between any two marks, to judge the grader's distance by; None if only one person marked."""
        pairs = [abs(a.points - b.points) for a, b in combinations(self.marks, 2)]
        return statistics.fmean(pairs) if pairs else None

    @property
    def is_outside(self) -> bool:
        """Whether no marker accepts the grader's points: each mark has its own range, `low` to `high`, and they lie in none."""
        return not any(mark.accepts(self.criterion.points) for mark in self.marks)

    @property
    def kind(self) -> str:
        """How the grader's points differ from the mean of the marks; "" if they are equal.

        "false deduction": the grader deducts, and no person does; "missed fault": the grader does not, and every person does;
        else "too mild" (above the mean) or "too hard" (below it).
        """
        if abs(self.difference) <= _FULL:
            return ""
        most = self.criterion.max_points - _FULL
        if self.criterion.points < most <= min(mark.points for mark in self.marks):
            return "false deduction"
        if self.criterion.points >= most > max(mark.points for mark in self.marks):
            return "missed fault"
        return "too mild" if self.difference > 0 else "too hard"

    @property
    def faults(self) -> tuple[str, ...]:
        """The ids of the faults (diagnosed mistakes) that the grader names in this criterion, each once; empty if none."""
        return tuple(dict.fromkeys(id_ for check in self.criterion.checks for id_ in check.misconceptions))


@dataclass(frozen=True)
class Agreement:
    """One row of the comparison table: how far the grader's points are from people's marks in some cells.

    A cell is one criterion of one submission.

    Attributes
    ----------
    title, cells
        The criterion or fault that the row is about, and the number of its cells.
    apart
        Mean distance between the marks of two people, in points; None if one person marked.
    distance, uncertainty
        Mean distance between the grader's points and the mean of the marks, and half of its 95 % interval (Student's t over
        submissions, whose cells are not independent). `uncertainty` is None below three submissions.
    difference
        Mean of the grader's points minus the marks: positive where the grader is milder.
    outside
        Number of cells in which no person accepts the grader's points.
    """

    title: str
    cells: int
    apart: float | None
    distance: float
    uncertainty: float | None
    difference: float
    outside: int

    @property
    def texts(self) -> tuple[str, ...]:
        """This row's numbers as text, in the order of the column titles `HEAD`; "–" for no `apart`, no "±" for no `uncertainty`."""
        return (
            str(self.cells),
            "–" if self.apart is None else f"{self.apart:.2f}",
            f"{self.distance:.2f}" + ("" if self.uncertainty is None else f" ± {self.uncertainty:.2f}"),
            f"{self.difference:+.2f}".replace("-", "−"),
            str(self.outside),
        )


def compare(results: Mapping[str, Result], marks: Sequence[Marks]) -> list[ComparedCell]:
    """Pair the grader's result of each criterion with its marks, in the order of `results` (by id); `marks` has a table per person.

    Left out are criteria that nobody marked, submissions without a grade, and repaired ones, which people marked unrepaired.
    """
    return [
        ComparedCell(id_, part, given)
        for id_, result in results.items()
        for part in result.criteria
        if is_comparable(result)
        and (given := tuple(each.cells[id_, part.id] for each in marks if (id_, part.id) in each.cells))
    ]


def is_comparable(result: Result) -> bool:
    return result.status == "graded" and not result.repairs


def maxima(results: Mapping[str, Result]) -> dict[Cell, float]:
    """Return the maximum points by submission id and criterion id, for `read_marks` to refuse a mark above the maximum."""
    return {(id_, part.id): part.max_points for id_, result in results.items() for part in result.criteria}


def agreement(title: str, cells: Sequence[ComparedCell]) -> Agreement:
    """Return row `title` of the comparison table: how far grader and people are apart in `cells`.

    Each cell is one criterion of one submission; at least one is needed.
    """
    apart = [each.apart for each in cells if each.apart is not None]
    distances: dict[str, list[float]] = {}
    for each in cells:
        distances.setdefault(each.id, []).append(abs(each.difference))
    means, few = [statistics.fmean(its) for its in distances.values()], len(distances) < 3
    return Agreement(
        title,
        len(cells),
        statistics.fmean(apart) if apart else None,
        statistics.fmean(abs(each.difference) for each in cells),
        None if few else special.stdtrit(len(means) - 1, 0.975) * statistics.stdev(means) / math.sqrt(len(means)),
        statistics.fmean(each.difference for each in cells),
        sum(each.is_outside for each in cells),
    )


def by_criterion(cells: Sequence[ComparedCell]) -> list[Agreement]:
    """Return the rows of the comparison table: one per criterion, then all together. A cell is one criterion of one submission."""
    titles = dict.fromkeys(cell.criterion.title for cell in cells)
    each = [agreement(title, [cell for cell in cells if cell.criterion.title == title]) for title in titles]
    return [*each, agreement("All", cells)]


def by_fault(cells: Sequence[ComparedCell]) -> list[Agreement]:
    """Return the agreement for each fault (diagnosed mistake) in a criterion where points and marks differ, largest distance first.

    A row covers all `cells` (one criterion of one submission each) with this fault, also those where points and marks agree.
    """
    named = dict.fromkeys(fault for cell in cells if cell.kind for fault in cell.faults)
    each = [agreement(fault, [cell for cell in cells if fault in cell.faults]) for fault in named]
    return sorted(each, key=lambda agreed: (-agreed.distance, agreed.title))


def differing(cells: Iterable[ComparedCell]) -> list[ComparedCell]:
    """Return the criteria where points and marks differ, for a person to read: false deductions, missed faults, then the rest."""
    return sorted(
        (cell for cell in cells if cell.kind),
        key=lambda cell: (_FIRST.get(cell.kind, len(_FIRST)), -abs(cell.difference), cell.id),
    )


def table(rows: Sequence[Agreement]) -> list[str]:
    """Format agreements as the lines of a Markdown table with aligned columns, which also reads well on a terminal."""
    cells = [("", *HEAD), *((each.title, *each.texts) for each in rows)]
    first, *others = (max(map(len, column)) for column in zip(*cells, strict=True))
    rule = [f"| {'-' * first} |", *(f" {'-' * (width - 1)}: |" for width in others)]
    lines = [
        f"| {title:{first}} |" + "".join(f" {text:>{width}} |" for text, width in zip(texts, others, strict=True))
        for title, *texts in cells
    ]
    return [lines[0], "".join(rule), *lines[1:]]
