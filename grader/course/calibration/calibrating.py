"""Calibration of a class on record: write a sample to mark, and write the comparison with the marks."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path

from grader.base.errors import RequestError
from grader.base.files import write_whole
from grader.base.text import csv_cell
from grader.course.calibration import comparison, sample
from grader.course.calibration.marks import Cell, Mark, Marks, as_rows, read_marks
from grader.course.calibration.pages import comparison_page, marking_page
from grader.course.calibration.summary import lines_of, short_digest, summarize
from grader.course.record import class_settings
from grader.course.record.store import Store
from grader.course.regrading import adjusting
from grader.engine.lab import Lab
from grader.engine.results import Result

FOLDER = "calibration"
"""Folder below OUT for the pages, and for the marks that people give in the review desk."""
MARKING, BLANK, COMPARISON = "marking.html", "marks-blank.csv", "comparison.html"


def write_sample(lab: Lab, out: Path, folder: Path, size: int) -> list[str]:
    """Draw a sample, write its page and its blank table into `folder`, and return lines on what to do next.

    Raises
    ------
    RequestError
        If nothing is graded.
    """
    with Store.existing(out) as store:
        results = store.present()
        ids = drawn(results, size)
        rubric = short_digest(class_settings.rubric_of(lab, store.settings()))
        like = results[ids[0]]
        page = marking_page(like.lab, sample.to_mark(store, lab, results, ids), like, rubric)
    write_whole(folder / MARKING, page)
    write_whole(folder / BLANK, as_table(ids, like, {}, rubric))
    return [
        f"{len(ids)} submissions to mark: open {MARKING} in a browser, or fill in {BLANK}",
        "then: imugrade calibrate OUT --marks FILE, and once more --marks FILE for a second person",
    ]


def drawn(results: Mapping[str, Result], size: int) -> list[str]:
    """Draw a sample of the submissions that can be compared with marks, and return their ids."""
    able = {id_: result for id_, result in results.items() if comparison.is_comparable(result)}
    if not able:
        raise RequestError("the class has no submission that is graded as it was handed in; grade it first")
    return sample.draw(able, size)


def as_table(ids: Sequence[str], like: Result, marks: Mapping[Cell, Mark], rubric: str) -> str:
    """Return the CSV of a person's marks of a sample, with blank points where there are none yet."""
    stream = io.StringIO()
    cells = [(id_, criterion.id) for id_ in ids for criterion in like.criteria]
    csv.writer(stream).writerows([csv_cell(text) for text in row] for row in as_rows(cells, marks, rubric))
    return stream.getvalue()


def write_comparison(lab: Lab, out: Path, folder: Path, files: Sequence[Path], rubric: Path | None) -> list[str]:
    """Compare marks with the grades, write the page into `folder`, and return the lines for the terminal.

    Raises
    ------
    RequestError
        If a file has a problem, or nothing can be compared.
    """
    with Store.existing(out) as store:
        given = [read(store, file) for file in files]
        if empty := [str(file) for file, marks in zip(files, given, strict=True) if not marks.cells]:
            raise RequestError(f"{empty[0]}: no row has points; fill in the column points")
        found = summarize(class_settings.rubric_of(lab, store.settings(), rubric), store.final_grades(), given)
        lab_name = next(result.lab for result in store.present().values())
    write_whole(folder / COMPARISON, comparison_page(lab_name, found))
    return list(lines_of(found))


def read(store: Store, file: Path) -> Marks:
    """Read the file with a person's marks for a class on record."""
    return read_marks(file, adjusting.person_lookup(store).by, comparison.maxima(store.present()))
