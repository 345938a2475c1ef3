"""The files of OUT, written from the record: pages and `result.json` of a submission, gradebook and index of the class."""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from grader import __version__
from grader.base.files import write_whole
from grader.course import class_settings
from grader.course.database import FILE_NAME
from grader.course.record import Store, charts
from grader.engine.faults import catalogue
from grader.engine.fingerprint import of_the_sheet
from grader.engine.lab import Lab
from grader.engine.processes import context, starting_processes
from grader.engine.results import to_json
from grader.people.final_grade import FinalGrade
from grader.platforms.gradebook import gradebook
from grader.report.pages import Drawn, drawn, drawn_in, index_page, report_around

_ALONE = 48
"""Number of outdated submissions up to which this process writes the files itself. Starting other processes takes longer."""
_BATCH = 8
_AHEAD = 8
"""Batches in the queue of each process: about ten megabytes."""


def publish_class(out: Path, store: Store, lab: Lab) -> dict[str, FinalGrade]:
    """Write the gradebook and the index of all submissions on record, and return their final grades."""
    final_grades = store.final_grades()
    write_class(out, final_grades, store, lab)
    return final_grades


def write_class(out: Path, final_grades: Mapping[str, FinalGrade], store: Store, lab: Lab) -> None:
    """Write the gradebook and the index of a class; `final_grades` holds every submission on record.

    The gradebook has a row for each person of the roster without a submission, and blank grades for empty submissions.
    """
    absent = class_settings.absent(store.settings(), {id_: each.hand_in for id_, each in final_grades.items()})
    write_whole(out / "gradebook.csv", gradebook(final_grades, absent))
    write_whole(out / "index.html", index_page(final_grades, store.fingerprints(), of_the_sheet(lab), absent))


def publish(out: Path, final_grade: FinalGrade, store: Store, lab: Lab, figures: Drawn | None = None) -> None:
    """Write the two files of one submission unless they are current. `figures` are its charts if they are already drawn."""
    with Publisher(out, store, lab) as publisher:
        publisher.put(final_grade, figures)


def publish_all(out: Path, final_grades: Iterable[FinalGrade], store: Store, lab: Lab) -> None:
    """Write the two files of each submission, unless they are current."""
    with Publisher(out, store, lab) as publisher:
        for final_grade in final_grades:
            publisher.put(final_grade)


def outdated_pages(out: Path, final_grades: Iterable[FinalGrade], store: Store) -> list[str]:
    """Return the ids of the submissions whose `result.json` or `report.html` is missing, changed or older than the record."""
    return [each.id for each in final_grades if not _Source.of(each, store).is_current(out)]


class Publisher:
    """Writes the two files of each submission that it is given, unless they are current; a context manager.

    `result.json` holds the automatic points only; the report shows the final grade. The record holds digests of both. Charts in an
    existing report are reused while they match the record.

    Parameters
    ----------
    processes
        Number of further processes that write, if many files are outdated.
    """

    def __init__(self, out: Path, store: Store, lab: Lab, processes: int = 0) -> None:
        self._out, self._store, self._lab, self._processes = out, store, lab, processes
        self._ids: set[str] = set()
        self._waiting: list[_Source] = []
        self._given: deque[tuple[list[_Source], Future[Digests]]] = deque()
        self._writers: ProcessPoolExecutor | None = None

    def __enter__(self) -> Publisher:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                self._finish()
        finally:
            if self._writers is not None:
                self._writers.shutdown(cancel_futures=True)

    def put(self, final_grade: FinalGrade, figures: Drawn | None = None) -> None:
        """Queue a submission whose files are outdated; write the queue when it holds a batch."""
        if final_grade.id in self._ids:  # the last of two final grades determines the files
            self._finish()
        source = _Source.of(final_grade, self._store, figures)
        if source.is_current(self._out):
            return
        self._ids.add(final_grade.id)
        self._waiting.append(source)
        if len(self._waiting) >= (_BATCH if self._writers else _ALONE):
            self._write()

    def _write(self) -> None:
        """Give the queue to the writer processes, or write it here if there are none."""
        if not self._processes:
            self._write_here()
            return
        self._writers = self._writers or _writers(self._processes)
        try:
            while batch := self._waiting[:_BATCH]:
                self._given.append((batch, self._writers.submit(_written, self._out, batch, self._lab)))
                del self._waiting[:_BATCH]
        except BrokenProcessPool:
            self._processes = 0
        while len(self._given) > _AHEAD * self._processes:
            self._take()

    def _finish(self) -> None:
        """Wait for the writer processes, write the rest here, and empty the queue."""
        while self._given:
            self._take()
        self._write_here()
        self._ids.clear()

    def _take(self) -> None:
        batch, written = self._given.popleft()
        try:
            self._store.keep_page_digests(written.result())
        except BrokenProcessPool:  # one of the processes was killed
            self._waiting += batch
            self._processes = 0

    def _write_here(self) -> None:
        if self._waiting:
            self._store.keep_page_digests(_written(self._out, self._waiting, self._lab))
            self._waiting = []


def _writers(processes: int) -> ProcessPoolExecutor:
    with starting_processes() as begin:
        executor = ProcessPoolExecutor(processes, context(), begin)
        for _ in range(processes):  # an executor starts a process only for a task
            executor.submit(int)
    return executor


@dataclass(frozen=True)
class _Source:
    """Data that the files of a submission are made from.

    `known` holds the digests recorded for the existing files, and `figures` the charts if they are already drawn.
    """

    final_grade: FinalGrade
    known: _Known
    result: str
    charts: bytes
    figures: Drawn | None

    @classmethod
    def of(cls, final_grade: FinalGrade, store: Store, figures: Drawn | None = None) -> _Source:
        """Collect the data for a submission: digests, packed charts and final grade."""
        id_ = final_grade.id
        return cls(final_grade, _Known.of(store.page_digest(id_)), store.digest(id_), store.packed_charts(id_), figures)

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


Digests = dict[str, str]
"""Digests to record for the files of submissions, by id."""


def _written(out: Path, sources: Sequence[_Source], lab: Lab) -> Digests:
    """Write the files of submissions, and return the digests to record."""
    digests = {}
    for source in sources:
        files, digests[source.final_grade.id] = _made(out, source, lab)
        for path, content in files.items():
            write_whole(path, content)
    return digests


def _made(out: Path, source: _Source, lab: Lab) -> tuple[dict[Path, bytes], str]:
    """Return the files of a submission to write, and the digests to record once they are written."""
    (record, report), final_grade, known = source.paths(out), source.final_grade, source.known
    files, made_from = {}, _digest(source.result, _bytes(record))
    if made_from != known.record:
        files[record] = to_json(final_grade.result).encode()
        made_from = _digest(source.result, files[record])
    figures, of_figures = drawn_in(_bytes(report).decode("utf-8", "replace")), known.figures
    drawn_anew = _of_figures(figures, source) != of_figures
    if drawn_anew:  # drawing takes ten times as long as the rest of a page
        figures = source.figures or drawn(charts(source.charts, out / FILE_NAME))
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
