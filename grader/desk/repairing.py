"""The editor of the submission page: edit a file, preview the grade, save the repair with a deduction and a comment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from urllib.parse import quote

from starlette.responses import RedirectResponse, Response

from grader.base.errors import RequestError
from grader.base.text import decimal
from grader.course import repairs
from grader.course.decisions import OvertakenError
from grader.course.patches import diff_of
from grader.course.repair_log import MAX_COMMENT, patched, sha256_of
from grader.course.repairs import Grading, Preview, RepairRequest
from grader.desk.classbook import Classbook
from grader.desk.editing import as_bytes, editable
from grader.desk.repair_jobs import Job, Kind
from grader.desk.web_requests import WebRequest
from grader.engine.results import Result
from grader.people.final_grade import FinalGrade
from grader.report.adjusted import diff_lines
from grader.report.causes import Stop, stops


@dataclass(frozen=True)
class Compared:
    """One line of the comparison: a criterion or the sum, now and with the edit."""

    title: str
    now: float
    then: float
    of: float

    @property
    def change(self) -> float:
        return round(self.then - self.now, 2)


@dataclass(frozen=True)
class Editor:
    """The editor of one file.

    Attributes
    ----------
    text, note, why
        See `editing.Editable`; the text is the edited one where there is one.
    stops
        Where code of this submission does not run.
    marked
        Lines to mark: where this file stops.
    base
        Digest of the file that is edited.
    job
        What was asked last; None if nothing was.
    rows, still, diff
        The comparison, where the edited copy still does not run, and the change.
    alike
        Other submissions with the same file and the same error.
    errors
        What is wrong with each field.
    running
        Whether the job had not ended when this was made: it may end while the page is written.
    """

    file: str
    text: str
    note: str
    why: str
    stops: Sequence[Stop]
    marked: frozenset[int]
    base: str
    deduct: str
    comment: str
    job: Job | None = None
    rows: Sequence[Compared] = ()
    still: Sequence[Stop] = ()
    diff: Sequence[tuple[str, str]] = ()
    alike: Sequence[FinalGrade] = ()
    also: tuple[str, ...] = ()
    errors: Mapping[str, str] = field(default_factory=dict)
    running: bool = False

    @property
    def lines(self) -> int:
        return self.text.count("\n") + 1


def editor(
    book: Classbook, final_grade: FinalGrade, web_request: WebRequest, errors: Mapping[str, str] | None = None
) -> Editor | None:
    """Return the editor for the job, refused form or file of a request; None if there is nothing to edit."""
    job = book.jobs.get(web_request.number("job") or web_request.number("seen"))
    if job is not None and job.id != final_grade.id:
        job = None
    ended = job is not None and job.done
    file = job.file if job else web_request.text("file") if web_request.form else web_request.text("edit")
    files = repaired_files(book, final_grade)
    if file not in files or (job and ended and not job.problem and job.kind in ("save", "undo")):
        return None
    content = files[file]
    original = editable(file, content)
    if errors is not None:
        text, deduct, comment, also = (
            _typed(web_request),
            web_request.text("deduct"),
            web_request.text("comment"),
            tuple(web_request.all("also")),
        )
    elif job:
        text, deduct, comment, also = job.text, job.deduct, job.comment, job.also
    else:
        text, deduct, comment, also = original.text, "", "", ()
    found = stops(final_grade.result, book.lab)
    grades = job.grades if job and ended and not job.problem else None
    shown = Editor(
        file,
        text,
        original.note,
        original.why,
        found,
        frozenset(each.line for each in found if each.file == file and each.line)
        if text == original.text
        else frozenset(),
        sha256_of(content),
        deduct or f"{book.repair_deduction:g}",
        comment,
        job,
        also=also,
        errors=errors or {},
        running=job is not None and not ended,
    )
    if grades is None:
        return shown
    edited = as_bytes(content, text)
    return replace(
        shown,
        rows=compared(grades),
        still=stops(grades.after, book.lab),
        diff=diff_lines(diff_of(file, content, edited)),
        alike=same_error_in(book, final_grade, file),
    )


def compared(grades: Preview) -> list[Compared]:
    """Return each criterion now and with the edit, and the sum before any deduction for this edit."""
    after = {part.id: part for part in grades.after.criteria}
    rows = [
        Compared(part.title, part.points, after[part.id].points, part.max_points)
        for part in grades.before.criteria
        if part.id in after
    ]
    now, then = (round(sum(points), 2) for points in zip(*((row.now, row.then) for row in rows), strict=True))
    return [*rows, Compared("Sum", now, then, grades.before.max_score)]


def repaired_files(book: Classbook, final_grade: FinalGrade) -> dict[str, bytes]:
    """Return the files of a submission with its repairs; all files as they were handed in if one repair does not fit."""
    kept = book.kept(final_grade)
    try:
        return patched(kept.files, final_grade.result.repairs)
    except (RequestError, KeyError):
        return dict(kept.files)


def same_error_in(book: Classbook, final_grade: FinalGrade, file: str) -> list[FinalGrade]:
    """Return the other submissions that hold the same file and stop in it with the same error, and have no repair yet."""
    mine = _errors(final_grade.result, book, file)
    if not mine or final_grade.result.repairs:
        return []
    content = book.kept(final_grade).files.get(file)
    return [
        each
        for each in book.final_grades().values()
        if each.id != final_grade.id
        and not each.result.repairs
        and _errors(each.result, book, file) == mine
        and book.kept(each).files.get(file) == content
    ]


def _errors(result: Result, book: Classbook, file: str) -> list[tuple[int | None, str]]:
    return [(each.line, each.error) for each in stops(result, book.lab) if each.file == file]


def change(book: Classbook, web_request: WebRequest, final_grade: FinalGrade) -> Job | Mapping[str, str]:
    """Start the job of a form: preview, suggest, save or undo. Return the job, or the errors by field."""
    do = web_request.text("do")
    if do == "undo":
        job = Job("undo", final_grade.id, web_request.text("file"))
        return book.jobs.start(job, partial(_undo, book, job, web_request.author))
    content = repaired_files(book, final_grade).get(web_request.text("file"))
    if content is None:
        raise RequestError("This file does not exist")
    if web_request.text("base") != sha256_of(content):
        raise OvertakenError(f"Somebody has repaired {web_request.text('file')} since you opened it")
    seen = book.jobs.get(web_request.number("seen"))
    kind: Kind = "suggest" if do == "suggest" else "save" if do == "save" else "preview"
    if kind == "save" and (seen is None or seen.text != _typed(web_request)):
        kind = "preview"  # a repair is saved only after a preview of its grade
    wrong = _wrong(book, web_request) if kind == "save" else {}
    if wrong:
        return wrong
    job = Job(
        kind,
        final_grade.id,
        web_request.text("file"),
        _typed(web_request),
        web_request.text("deduct"),
        web_request.text("comment"),
        tuple(web_request.all("also")),
    )
    edited = as_bytes(content, job.text)
    if kind != "suggest" and edited == content:
        return {"text": "Nothing in the file has changed."}
    request = RepairRequest(final_grade.id, job.file, edited, seen_sha256=sha256_of(content))
    if kind == "save":
        known = {each.id for each in same_error_in(book, final_grade, job.file)}
        ids = [final_grade.id, *(each for each in job.also if each in known)]
        return book.jobs.start(job, partial(_save, book, job, request, ids, web_request.author))
    return book.jobs.start(job, partial(_suggest if kind == "suggest" else _preview, book, job, request))


def _typed(web_request: WebRequest) -> str:
    return (web_request.form.get("text") or [""])[0].replace("\r\n", "\n").replace("\r", "\n")


def _wrong(book: Classbook, web_request: WebRequest) -> dict[str, str]:
    """Return the errors of the form by field: deduction and comment."""
    found = {}
    most = max((each.result.max_score for each in book.final_grades().values()), default=0.0)
    points = decimal(web_request.text("deduct"))
    if points is None or not 0 <= points <= most or round(points, 2) != points:
        found["deduct"] = f"Enter points from 0 to {most:g}, with at most two decimals."
    if not web_request.text("comment"):
        found["comment"] = "Say what you changed. The student reads this."
    elif len(web_request.text("comment")) > MAX_COMMENT:
        found["comment"] = f"At most {MAX_COMMENT} characters."
    return found


def _preview(book: Classbook, job: Job, request: RepairRequest, grading: Grading) -> None:
    job.grades = repairs.preview(book.out, request, grading)


def _suggest(book: Classbook, job: Job, request: RepairRequest, grading: Grading) -> None:
    """Search for a suggestion and put it, with its grade, into the job."""
    job.step = "Trying edits of the line that fails"
    _, found = repairs.suggestion(book.out, job.id, grading)
    if found is None:
        raise RequestError(
            "No repair to suggest: no edit of one place makes the code run, or several do with different grades."
        )
    job.file = found.file
    job.text = editable(found.file, found.content).text
    job.grades = repairs.preview(book.out, RepairRequest(job.id, found.file, found.content), grading)


def _save(book: Classbook, job: Job, request: RepairRequest, ids: Sequence[str], author: str, grading: Grading) -> None:
    """Record the repair for each submission. A failure for the first one raises; later failures are reported and skipped."""
    points = decimal(job.deduct) or 0.0
    for place, id_ in enumerate(ids):
        job.step = f"Grading submission {place + 1} of {len(ids)}"
        one = RepairRequest(id_, request.file, request.fixed, None, points, job.comment, request.seen_sha256)
        try:
            job.lines.append(repairs.record(book.out, one, author, grading))
        except RequestError as problem:
            if place == 0:
                raise
            job.lines.append(str(problem))
        book.changed([id_])


def _undo(book: Classbook, job: Job, author: str, grading: Grading) -> None:
    job.lines.append(repairs.take_back(book.out, job.id, job.file, author, grading))
    book.changed([job.id])


def answer(final_grade: FinalGrade, job: Job) -> Response:
    """Redirect to the page that shows the job, after a moment in which a quick one ends."""
    return RedirectResponse(f"/submission/{quote(final_grade.id, safe='')}?job={job.number}#edit", 303)
