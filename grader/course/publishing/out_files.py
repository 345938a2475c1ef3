"""Files of the output folder, written from the class database: result and report of each submission, gradebook, index page."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from pathlib import Path

from grader.base.files import write_whole
from grader.course.publishing.contradictions import contradictions
from grader.course.record import class_settings
from grader.course.record.store import Store
from grader.engine.faults import catalogue
from grader.engine.fingerprint import of_the_sheet
from grader.engine.lab import Lab
from grader.engine.results import to_json
from grader.people.final_grade import FinalGrade
from grader.platforms.gradebook import gradebook
from grader.report.pages import index_page, report_page


def publish_class(out: Path, store: Store, lab: Lab) -> dict[str, FinalGrade]:
    """Write the gradebook and the index page of a class into `out`; return the final grades, read from the database, by id."""
    final_grades = store.final_grades()
    write_class(out, final_grades, store, lab)
    return final_grades


def write_class(out: Path, final_grades: Mapping[str, FinalGrade], store: Store, lab: Lab) -> None:
    """Write the gradebook and the index page of a class; `final_grades` holds every submission in the database.

    The gradebook has a row for each person of the roster without a submission, and blank grades for empty submissions.
    """
    settings = store.settings()
    absent = class_settings.absent(settings, {id_: each.hand_in for id_, each in final_grades.items()})
    has_policy = settings is not None and settings.has_late_policy
    write_whole(out / "gradebook.csv", gradebook(final_grades, absent, has_late_policy=has_policy))
    unjudged = "not judged"  # the page names these in a sentence of its own
    found = [each.text for each in contradictions(final_grades, settings) if each.kind != unjudged]
    write_whole(out / "index.html", index_page(final_grades, store.fingerprints(), of_the_sheet(lab), absent, found))


def publish(out: Path, final_grade: FinalGrade, store: Store, lab: Lab) -> None:
    """Write `result.json` and the report of one submission, unless a stored digest says that both are current.

    `result.json` holds the automatic points only; the report shows the final grade.
    """
    if _is_current(out, final_grade, store):
        return
    record, report = paths = _paths(out, final_grade)
    page = report_page(final_grade, store.charts(final_grade.id), catalogue(lab))
    for path, text in ((record, to_json(final_grade.result)), (report, page)):
        if (content := text.encode("utf-8", "replace")) != _bytes(path):
            write_whole(path, content)
    store.keep_page_digest(final_grade.id, _source_digest(paths, final_grade, store))


def publish_all(out: Path, final_grades: Iterable[FinalGrade], store: Store, lab: Lab) -> None:
    """Write `result.json` and the report of each of these submissions, as `publish` does: current files are left alone."""
    for final_grade in final_grades:
        publish(out, final_grade, store, lab)


def outdated_pages(out: Path, final_grades: Iterable[FinalGrade], store: Store) -> list[str]:
    """Return ids of submissions whose `result.json` or report is missing, edited or outdated, for which an export is refused."""
    return [each.id for each in final_grades if not _is_current(out, each, store)]


def _paths(out: Path, final_grade: FinalGrade) -> tuple[Path, Path]:
    folder = out / "submissions" / final_grade.id
    return folder / "result.json", folder / "report.html"


def _is_current(out: Path, final_grade: FinalGrade, store: Store) -> bool:
    """Return whether a submission's files are as they were written and fit the database, so that they need not be written again."""
    return store.page_digest(final_grade.id) == _source_digest(_paths(out, final_grade), final_grade, store)


def _source_digest(files: Iterable[Path], final_grade: FinalGrade, store: Store) -> str:
    """Return a digest of a submission's files and of the data behind them; if any of it changes, the files are outdated."""
    id_, decided = final_grade.id, (final_grade.hand_in, final_grade.adjustments, final_grade.unseen)
    facts: tuple[str | bytes, ...] = (store.digest(id_), repr(decided), store.packed_charts(id_), *map(_bytes, files))
    digest = hashlib.sha256()
    for fact in facts:
        content = fact if isinstance(fact, bytes) else fact.encode("utf-8", "replace")
        digest.update(len(content).to_bytes(8, "little") + content)
    return digest.hexdigest()


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""
