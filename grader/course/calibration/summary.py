"""Summary of a calibration: agreement, differences and proposal, for the terminal, the page and the review desk."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from grader.base.errors import RequestError
from grader.base.text import some
from grader.course.calibration import comparison
from grader.course.calibration.comparison import Agreement, ComparedCell
from grader.course.calibration.marks import Marks
from grader.course.calibration.proposal import FEWEST, Proposal, propose
from grader.engine.faults import catalogue
from grader.engine.results import Result
from grader.engine.rubric import Rubric
from grader.people.final_grade import FinalGrade
from grader.report import words
from grader.report.deductions import Deduction, deductions

SIDE = 360
"""Width and height of the picture of points against points, in SVG units."""
_MOST_LINES = 15
_DIGEST = 12
"""Characters of a rubric's digest that a file of marks keeps."""


@dataclass(frozen=True)
class Dot:
    """Dot of the chart of points against marks: all cells with the same points, and its size."""

    x: float
    y: float
    radius: float
    text: str


@dataclass(frozen=True)
class Difference:
    """A cell where we differ, with our deductions beside the markers' sentences."""

    cell: ComparedCell
    name: str
    ours: tuple[Deduction, ...]


@dataclass(frozen=True)
class Summary:
    """Comparison of a class's grades with marks given by people, for the page and the terminal.

    `proposal` holds other deductions, nearer to the marks; `moved` lists whom they would move: name, present grade, future grade.
    """

    criteria: tuple[Agreement, ...]
    faults: tuple[Agreement, ...]
    dots: tuple[Dot, ...]
    differences: tuple[Difference, ...]
    proposal: Proposal | None
    notes: tuple[str, ...]
    moved: tuple[tuple[str, float, float], ...]
    side: int = SIDE

    @property
    def headline(self) -> str:
        return f"The grades are {self.criteria[-1].distance:.2f} points a criterion from the marks"

    @property
    def sentence(self) -> str:
        """Return one sentence with the mean distance between points and marks of all cells."""
        whole = self.criteria[-1]
        told = [f"{whole.cells - len(self.differences)} of {words.counted(whole.cells, 'cell')} agree."]
        if whole.apart is not None:
            told.append(
                f"The markers are {whole.apart:.2f} points from each other, and we are {whole.distance:.2f} from their mean."
            )
        told.append(f"In {words.counted(whole.outside, 'cell')} no marker accepts our points.")
        return " ".join(told)


def short_digest(rubric: Rubric) -> str:
    """Return the short digest of a rubric that a file of marks keeps, to notice marks made under another rubric."""
    return rubric.sha256[:_DIGEST]


def summarize(rubric: Rubric, final_grades: Mapping[str, FinalGrade], marks: Sequence[Marks]) -> Summary:
    """Compare marks with a class that is graded by this rubric.

    Raises
    ------
    RequestError
        If nothing can be compared.
    """
    results = {id_: each.result for id_, each in final_grades.items()}
    cells = comparison.compare(results, marks)
    if not cells:
        raise RequestError(
            "the marks are all about submissions that are repaired or not graded; mark others, or grade the class again"
        )
    proposal, problem = None, ""
    try:
        proposal = propose(rubric, cells, final_grades)
    except RequestError as other_measurements:
        problem = f"no proposal: {other_measurements}"
    moved = () if proposal is None else proposal.moved
    return Summary(
        tuple(comparison.by_criterion(cells)),
        tuple(each for each in comparison.by_fault(cells) if each.distance > comparison.FULL),
        tuple(dots(cells)),
        tuple(_difference(cell, final_grades[cell.id], rubric) for cell in comparison.differing(cells)),
        proposal,
        tuple(filter(None, (*_notes(rubric, results, cells, marks), problem))),
        tuple((words.distinct(each.final_grade), each.before or 0.0, each.after or 0.0) for each in moved),
    )


def _notes(
    rubric: Rubric, results: Mapping[str, Result], cells: Sequence[ComparedCell], marks: Sequence[Marks]
) -> Iterator[str]:
    """Yield what a reader has to know about this comparison, a line each."""
    for each in marks:
        if each.rubrics - {short_digest(rubric)}:
            yield f"{each.marker}: marked under another rubric than the class has now; points are compared as they are"
    others = [cell.id for cell in cells if results[cell.id].provenance.get("rubric_sha256") != rubric.sha256]
    if others:
        yield f"graded by another rubric: {some([*dict.fromkeys(others)], 5)}; grade the class again before you change deductions"
    marked = {id_ for each in marks for id_, _ in each.cells}
    if left_out := sorted(marked - {cell.id for cell in cells}):
        yield f"not compared, as repaired or not graded: {some(left_out, 5)}"
    if (count := len({cell.id for cell in cells})) < FEWEST:
        yield f"no proposal: {words.counted(count, 'submission')} with marks; mark {FEWEST} or more"


def dots(cells: Sequence[ComparedCell]) -> list[Dot]:
    """Return the dots of the chart: the grader's points above the mean of the marks, in shares of the criterion; largest first."""
    counted = Counter(
        (round(each.mean / most, 3), round(each.criterion.points / most, 3))
        for each in cells
        if (most := each.criterion.max_points)
    )
    return [
        Dot(
            round(x * SIDE, 1), round((1 - y) * SIDE, 1), round(min(3.5 * count**0.5, 18), 1),
            f"{words.counted(count, 'cell')}: marks {100 * x:.0f} %, we {100 * y:.0f} %",
        )
        for (x, y), count in sorted(counted.items(), key=lambda item: -item[1])
    ]  # fmt: skip


def _difference(cell: ComparedCell, final_grade: FinalGrade, rubric: Rubric) -> Difference:
    ours = deductions(replace(final_grade.result, criteria=(cell.criterion,)), catalogue(rubric.lab))
    return Difference(cell, words.distinct(final_grade), tuple(ours))


def lines_of(found: Summary) -> Iterator[str]:
    """Yield the comparison with the marks as lines for a terminal."""
    yield from found.notes
    yield from comparison.table(found.criteria)
    for each in found.differences[:_MOST_LINES]:
        cell = each.cell
        told = " and ".join(words.number(mark.points) for mark in cell.marks)
        yield f"{cell.kind}: {each.name}, {cell.criterion.title}: we {words.number(cell.criterion.points)}, marks {told}"
    if (more := len(found.differences) - _MOST_LINES) > 0:
        yield f"and {more} more; the page has all"
    if found.proposal is not None:
        yield from found.proposal.sentences()
        yield from (
            f"  {name}  {words.number(before)} → {words.number(after)}"
            for name, before, after in found.moved[:_MOST_LINES]
        )
        yield from found.proposal.block()
