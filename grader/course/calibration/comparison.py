"""Comparison of the grader's points with marks given by hand: how far apart, where, and in which direction."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from scipy import stats

from grader.course.calibration.marks import Cell, Mark, Marks
from grader.engine.results import CriterionResult, Result

FULL = 1e-6
"""Points within this of the maximum are the maximum."""


@dataclass(frozen=True)
class ComparedCell:
    """One criterion of one submission: the grader's points, and the mark of each person who gave one."""

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
        """Our points less the mean of the marks: positive where we are milder."""
        return self.criterion.points - self.mean

    @property
    def distance(self) -> float:
        return abs(self.difference)

    @property
    def apart(self) -> float | None:
        """The mean distance between two markers; None with one marker."""
        pairs = [abs(a.points - b.points) for a, b in combinations(self.marks, 2)]
        return statistics.fmean(pairs) if pairs else None

    @property
    def is_outside(self) -> bool:
        """Whether no marker accepts our points."""
        return not any(mark.accepts(self.criterion.points) for mark in self.marks)

    @property
    def kind(self) -> str:
        """Name of the difference between points and marks, such as "missed fault" or "too hard"; "" up to a distance of `FULL`."""
        if self.distance <= FULL:
            return ""
        most = self.criterion.max_points - FULL
        if self.criterion.points < most <= min(mark.points for mark in self.marks):
            return "false deduction"
        if self.criterion.points >= most > max(mark.points for mark in self.marks):
            return "missed fault"
        return "too mild" if self.difference > 0 else "too hard"

    @property
    def faults(self) -> tuple[str, ...]:
        """The faults that we name in this criterion."""
        return tuple(dict.fromkeys(id_ for check in self.criterion.checks for id_ in check.misconceptions))


_FIRST = ("false deduction", "missed fault")
"""The kinds of differences that a person should look at first."""


@dataclass(frozen=True)
class Agreement:
    """How far the grader's points are from the marks, over some cells (criteria of submissions).

    Attributes
    ----------
    apart
        Mean distance between two markers, in points; None with one marker.
    distance, uncertainty
        Mean distance between us and the mean of the markers, and half of its 95 % confidence interval (Student's t over the
        submissions, as the cells of one submission are not independent); None below three submissions.
    difference
        Mean of our points less the markers': positive where we are milder.
    outside
        Cells in which no marker accepts our points.
    """

    title: str
    cells: int
    apart: float | None
    distance: float
    uncertainty: float | None
    difference: float
    outside: int


def compare(results: Mapping[str, Result], marks: Sequence[Marks]) -> list[ComparedCell]:
    """Return every marked cell of a submission that was graded as it was handed in, in the order of the class.

    A repaired one is left out: the marker saw the files before the repair.
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
    """Return the maximum points of every cell (criterion of a submission) of a class."""
    return {(id_, part.id): part.max_points for id_, result in results.items() for part in result.criteria}


def agreement(title: str, cells: Sequence[ComparedCell]) -> Agreement:
    """Summarize how far points and marks of these cells are apart; there must be at least one cell."""
    apart = [each.apart for each in cells if each.apart is not None]
    return Agreement(
        title,
        len(cells),
        statistics.fmean(apart) if apart else None,
        statistics.fmean(each.distance for each in cells),
        _uncertainty(cells),
        statistics.fmean(each.difference for each in cells),
        sum(each.is_outside for each in cells),
    )


def _uncertainty(cells: Sequence[ComparedCell]) -> float | None:
    means = [
        statistics.fmean(each.distance for each in its) for its in _grouped(cells, lambda cell: [cell.id]).values()
    ]
    if len(means) < 3:
        return None
    return float(stats.t.ppf(0.975, len(means) - 1)) * statistics.stdev(means) / math.sqrt(len(means))


def by_criterion(cells: Sequence[ComparedCell]) -> list[Agreement]:
    """Return the agreement in each criterion, then in all of them."""
    groups = _grouped(cells, lambda cell: [cell.criterion.title])
    return [*(agreement(title, its) for title, its in groups.items()), agreement("All", cells)]


def by_fault(cells: Sequence[ComparedCell]) -> list[Agreement]:
    """Return the agreement in the cells where we name a fault, for each fault, the largest distance first."""
    groups = _grouped(cells, lambda cell: cell.faults)
    return sorted((agreement(id_, its) for id_, its in groups.items()), key=lambda each: (-each.distance, each.title))


def differing(cells: Iterable[ComparedCell]) -> list[ComparedCell]:
    """Return the cells where we differ: false deductions, then missed faults, then the others, the largest difference first."""

    def place(cell: ComparedCell) -> tuple[int, float, str]:
        first = _FIRST.index(cell.kind) if cell.kind in _FIRST else len(_FIRST)
        return first, -cell.distance, cell.id

    return sorted((cell for cell in cells if cell.kind), key=place)


def _grouped(
    cells: Iterable[ComparedCell], names: Callable[[ComparedCell], Iterable[str]]
) -> dict[str, list[ComparedCell]]:
    groups: dict[str, list[ComparedCell]] = {}
    for cell in cells:
        for name in names(cell):
            groups.setdefault(name, []).append(cell)
    return groups


def table(rows: Sequence[Agreement]) -> list[str]:
    """Return the lines of a Markdown table, which also reads well on a terminal."""
    body = [
        (
            each.title, str(each.cells), "–" if each.apart is None else f"{each.apart:.2f}",
            f"{each.distance:.2f}" + ("" if each.uncertainty is None else f" ± {each.uncertainty:.2f}"),
            f"{each.difference:+.2f}".replace("-", "−"), str(each.outside),
        )
        for each in rows
    ]  # fmt: skip
    head = ("", "Cells", "Markers apart", "We from their mean", "We give more (+)", "No marker accepts")
    widths = [max(len(row[i]) for row in (head, *body)) for i in range(len(head))]
    lines = [
        "| " + " | ".join(f"{text:{'<' if not i else '>'}{widths[i]}}" for i, text in enumerate(row)) + " |"
        for row in (head, *body)
    ]
    rule = "| " + " | ".join("-" * width if not i else "-" * (width - 1) + ":" for i, width in enumerate(widths)) + " |"
    return [lines[0], rule, *lines[1:]]
