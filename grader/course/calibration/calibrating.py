"""Calibration of a graded class: write a sample for people to mark by hand, and compare their marks with the grades."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from grader.base.errors import RequestError
from grader.base.files import write_whole
from grader.base.text import some
from grader.course.calibration import comparison, sample
from grader.course.calibration.comparison import Agreement, ComparedCell
from grader.course.calibration.marks import COLUMNS, Marks, as_table, read_marks
from grader.course.calibration.proposal import FEWEST, Proposal, propose
from grader.course.record import class_settings
from grader.course.record.store import Store
from grader.course.regrading import adjusting
from grader.engine.faults import catalogue
from grader.engine.lab import Lab
from grader.engine.results import LabName
from grader.engine.rubric import Rubric
from grader.people.final_grade import FinalGrade
from grader.report import words
from grader.report.deductions import Deduction, deductions
from grader.report.pages import rendered

FOLDER = "calibration"
"""Folder below OUT for the pages, and for the marks that people give in the review desk."""
MARKING, BLANK, COMPARISON = "marking.html", "marks-blank.csv", "comparison.html"
_DIGEST = 12
"""Characters of a rubric's digest that a file of marks keeps."""


@dataclass(frozen=True)
class Summary:
    """Result of a calibration, which page, terminal and review desk show: how far the grades agree with people's marks.

    Attributes
    ----------
    criteria
        The agreement in each criterion, and in all together.
    faults
        The agreement for each fault (diagnosed mistake) that is named where points and marks differ.
    dots
        Points of a diagram: mean mark and grader's points of a criterion, in percent, and how often they occur; most frequent
        first.
    differences
        Each criterion of a submission where points and marks differ, with the submission's name and the grader's deductions.
    proposal
        Deductions that fit the marks better; None with too few marks, or if they cannot be computed.
    notes
        Warnings: marks under another rubric, submissions left out, why there is no proposal.
    """

    criteria: tuple[Agreement, ...]
    faults: tuple[Agreement, ...]
    dots: tuple[tuple[tuple[float, float], int], ...]
    differences: tuple[tuple[ComparedCell, str, Sequence[Deduction]], ...]
    proposal: Proposal | None
    notes: tuple[str, ...]
    head: tuple[str, ...] = comparison.HEAD


def write_sample(lab: Lab, out: Path, folder: Path, size: int) -> list[str]:
    """Write a page and a table into `folder` to mark up to `size` submissions by hand, chosen for many faults; return next steps.

    Raises
    ------
    RequestError
        If no class was graded in `out`, or no submission was graded without a repair.
    """
    with Store.existing(out) as store:
        results = store.present()
        ids = sample.draw(results, size)
        rubric = short_digest(class_settings.rubric_of(lab, store.settings()))
        criteria = results[ids[0]].criteria
        unmarked = [sample.to_mark(store, lab, id_, results[id_]) for id_ in ids]
    page = rendered(
        "marking.html.j2", "marking.js", LabName(lab.label, lab.title), more_style="marking.css",
        sample=unmarked, criteria=criteria, rubric=rubric, columns=",".join(COLUMNS),
    )  # fmt: skip
    write_whole(folder / MARKING, page)
    write_whole(folder / BLANK, as_table([(id_, part.id) for id_ in ids for part in criteria], {}, rubric))
    return [
        f"{len(ids)} submissions to mark: open {MARKING} in a browser, or fill in {BLANK}",
        "then: imugrade calibrate OUT --marks FILE, and once more --marks FILE for a second person",
    ]


def write_comparison(lab: Lab, out: Path, folder: Path, files: Sequence[Path]) -> list[str]:
    """Compare the grades in `out` with the marks in `files`, one file per person; write a page into `folder`, return lines to show.

    Raises
    ------
    RequestError
        If no class was graded in `out`, a file has a wrong row or no marks, or all marked submissions are repaired or not graded.
    """
    with Store.existing(out) as store:
        given = [read(store, file) for file in files]
        if empty := [str(file) for file, marks in zip(files, given, strict=True) if not marks.cells]:
            raise RequestError(f"{empty[0]}: no row has points; fill in the column points")
        found = summarize(class_settings.rubric_of(lab, store.settings()), store.final_grades(), given)
    page = rendered("calibration.html.j2", None, LabName(lab.label, lab.title), more_style="marking.css", found=found)
    write_whole(folder / COMPARISON, page)
    proposal = found.proposal
    told = [*proposal.sentences(), *proposal.block()] if proposal else []
    return [*found.notes, *comparison.table(found.criteria), *told]


def read(store: Store, file: Path) -> Marks:
    """Read one person's table of marks, with submissions found by name in `store`; raise RequestError for a wrong row."""
    return read_marks(file, adjusting.person_lookup(store).by, comparison.maxima(store.present()))


def short_digest(rubric: Rubric) -> str:
    """Return the start of a rubric's digest; tables of marks hold it, to notice marks made under another rubric."""
    return rubric.sha256[:_DIGEST]


def summarize(rubric: Rubric, final_grades: Mapping[str, FinalGrade], marks: Sequence[Marks]) -> Summary:
    """Compare marks, one `Marks` per person, with the final grades (by submission id) of a class that was graded by `rubric`.

    Raises
    ------
    RequestError
        If no submission can be compared, because all that are marked are repaired or not graded.
    """
    cells = comparison.compare({id_: each.result for id_, each in final_grades.items()}, marks)
    if not cells:
        raise RequestError(
            "the marks are all about submissions that are repaired or not graded; mark others, or grade the class again"
        )
    notes = [*_notes(rubric, final_grades, cells, marks)]
    proposal = None
    try:
        proposal = propose(rubric, cells, final_grades)
    except RequestError as other_measurements:
        notes.append(f"no proposal: {other_measurements}")
    dots = Counter(
        (100 * c.mean / most, 100 * c.criterion.points / most) for c in cells if (most := c.criterion.max_points)
    )
    differences = []
    for cell in comparison.differing(cells):
        ours = replace(final_grades[cell.id].result, criteria=(cell.criterion,))
        told = deductions(ours, catalogue(rubric.lab))
        differences.append((cell, words.distinct(final_grades[cell.id]), told))
    return Summary(
        tuple(comparison.by_criterion(cells)),
        tuple(comparison.by_fault(cells)),
        tuple(dots.most_common()),
        tuple(differences),
        proposal,
        tuple(notes),
    )


def _notes(
    rubric: Rubric, final_grades: Mapping[str, FinalGrade], cells: Sequence[ComparedCell], marks: Sequence[Marks]
) -> Iterator[str]:
    """Yield warnings for a reader of the comparison: another rubric, submissions left out, too few marks for a proposal."""
    for each in marks:
        if each.rubrics - {short_digest(rubric)}:
            yield f"{each.marker}: marked under another rubric than the class has now; points are compared as they are"
    compared = dict.fromkeys(cell.id for cell in cells)
    others = [id_ for id_ in compared if final_grades[id_].result.provenance.get("rubric_sha256") != rubric.sha256]
    if others:
        yield f"graded by another rubric: {some(others, 5)}; grade the class again before you change deductions"
    if left_out := sorted({id_ for each in marks for id_, _ in each.cells} - compared.keys()):
        yield f"not compared, as repaired or not graded: {some(left_out, 5)}"
    if len(compared) < FEWEST:
        yield f"no proposal: {words.counted(len(compared), 'submission')} with marks; mark {FEWEST} or more"
