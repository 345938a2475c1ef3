"""The files of OUT, written from the record: pages and `result.json` of a submission, gradebook and index of the class."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from grader import __version__
from grader.base.files import write_whole
from grader.course.publishing.contradictions import contradictions, untimed
from grader.course.record import class_settings
from grader.course.record.store import Store
from grader.engine.faults import catalogue
from grader.engine.fingerprint import of_the_sheet
from grader.engine.lab import Lab
from grader.engine.results import to_json
from grader.people.final_grade import FinalGrade
from grader.platforms.gradebook import gradebook
from grader.report.pages import Drawn, drawn, drawn_in, index_page, report_around


def publish_class(out: Path, store: Store, lab: Lab) -> dict[str, FinalGrade]:
    """Write the gradebook and the index of all submissions on record, and return their final grades."""
    final_grades = store.final_grades()
    write_class(out, final_grades, store, lab)
    return final_grades


def write_class(out: Path, final_grades: Mapping[str, FinalGrade], store: Store, lab: Lab) -> None:
    """Write the gradebook and the index of a class; `final_grades` holds every submission on record.

    The gradebook has a row for each person of the roster without a submission, and blank grades for empty submissions.
    """
    settings = store.settings()
    absent = class_settings.absent(settings, {id_: each.hand_in for id_, each in final_grades.items()})
    has_policy = settings is not None and settings.has_late_policy
    unknown = untimed(final_grades, settings) if has_policy else None
    write_whole(out / "gradebook.csv", gradebook(final_grades, absent, unknown))
    unjudged = "not judged"  # the page names these in a sentence of its own
    found = [each.text for each in contradictions(final_grades, settings) if each.kind != unjudged]
    write_whole(out / "index.html", index_page(final_grades, store.fingerprints(), of_the_sheet(lab), absent, found))


def publish(out: Path, final_grade: FinalGrade, store: Store, lab: Lab, figures: Drawn | None = None) -> None:
    """Write `result.json` and `report.html` of a submission unless they are current. `figures`: its charts, if drawn already.

    `result.json` holds the automatic points only; the report shows the final grade. The record holds digests of both. Charts in an
    existing report are reused while they match the record.
    """
    source = _Source.of(final_grade, store)
    if source.is_current(out):
        return
    files, digests = _made(out, source, store, lab, figures)
    for path, content in files.items():
        write_whole(path, content)
    store.keep_page_digest(final_grade.id, digests)


def publish_all(out: Path, final_grades: Iterable[FinalGrade], store: Store, lab: Lab) -> None:
    """Write `result.json` and `report.html` of each submission, unless they are current."""
    for final_grade in final_grades:
        publish(out, final_grade, store, lab)


def outdated_pages(out: Path, final_grades: Iterable[FinalGrade], store: Store) -> list[str]:
    """Return the ids of the submissions whose `result.json` or `report.html` is missing, changed or older than the record."""
    return [each.id for each in final_grades if not _Source.of(each, store).is_current(out)]


@dataclass(frozen=True)
class _Source:
    """Data that the files of a submission are made from; `known` holds the digests recorded for the existing files."""

    final_grade: FinalGrade
    known: _Known
    result: str
    charts: bytes

    @classmethod
    def of(cls, final_grade: FinalGrade, store: Store) -> _Source:
        """Collect the data for a submission: digests, packed charts and final grade."""
        id_ = final_grade.id
        return cls(final_grade, _Known.of(store.page_digest(id_)), store.digest(id_), store.packed_charts(id_))

    def paths(self, out: Path) -> tuple[Path, Path]:
        folder = out / "submissions" / self.final_grade.id
        return folder / "result.json", folder / "report.html"

    def is_current(self, out: Path) -> bool:
        """Return whether both files are unchanged since they were written, and were made from the present record."""
        record, report = self.paths(out)
        made_from = _digest(self.result, _bytes(record))
        return made_from == self.known.record and self.facts(made_from, _bytes(report)) == self.known.report

    def facts(self, made_from: str, page: bytes) -> str:
        """Return a digest of the report and of the data that it is made from."""
        final_grade = self.final_grade
        return _digest(made_from, page, repr((final_grade.hand_in, final_grade.adjustments, final_grade.unseen)))


def _made(out: Path, source: _Source, store: Store, lab: Lab, given: Drawn | None) -> tuple[dict[Path, bytes], str]:
    """Return the files of a submission to write, and the digests to record once they are written."""
    (record, report), final_grade, known = source.paths(out), source.final_grade, source.known
    files, made_from = {}, _digest(source.result, _bytes(record))
    if made_from != known.record:
        files[record] = to_json(final_grade.result).encode()
        made_from = _digest(source.result, files[record])
    figures, of_figures = drawn_in(_bytes(report).decode("utf-8", "replace")), known.figures
    drawn_anew = _of_figures(figures, source) != of_figures
    if drawn_anew:  # drawing takes ten times as long as the rest of a page
        figures = given or drawn(store.charts(final_grade.id))
    page = report_around(figures, final_grade, catalogue(lab))
    if drawn_anew:
        of_figures = _of_figures(drawn_in(page), source)
    files[report] = page.encode("utf-8", "replace")
    return files, f"{made_from} {source.facts(made_from, files[report])} {of_figures}"


@dataclass(frozen=True)
class _Known:
    """Digests of what the files of a submission were made from, and of the charts in its report; "" if none is on record."""

    record: str = ""
    report: str = ""
    figures: str = ""

    @classmethod
    def of(cls, text: str) -> _Known:
        digests = text.split()
        return cls(*digests) if len(digests) == 3 else cls()


def _of_figures(figures: Drawn, source: _Source) -> str:
    """Return a digest of the drawn charts, their data, the parts of the result and the version of imugrade."""
    parts = [part.id for part in source.final_grade.result.parts if part.checks]
    return _digest(__version__, repr(parts), source.charts, *(figures[part] for part in parts if part in figures))


def _digest(*facts: str | bytes) -> str:
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
