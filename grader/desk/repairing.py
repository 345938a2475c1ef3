"""The repair editor of the submission page: edit a file, preview the grade, save the repair with a deduction and a comment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from urllib.parse import quote

from starlette.responses import RedirectResponse, Response

from grader.base.errors import RequestError
from grader.base.text import decimal
from grader.course.record.decisions import OvertakenError
from grader.course.record.patches import diff_of
from grader.course.record.repair_log import MAX_COMMENT, apply_repairs, sha256_of
from grader.course.repairs import making
from grader.course.repairs.making import Grading, RepairPreview, RepairRequest
from grader.course.repairs.suggestions import MOST
from grader.desk.classbook import Classbook
from grader.desk.editing import as_bytes, editable
from grader.desk.repair_jobs import Job, RepairForm
from grader.desk.web_requests import WebRequest
from grader.engine.results import Result
from grader.people.final_grade import FinalGrade
from grader.report.adjusted import diff_lines
from grader.report.causes import Stop, stops


@dataclass(frozen=True)
class Compared:
    """One line of a preview, such as a criterion: points `now`, `then` (with the edit), and maximum `of`, None for a deduction."""

    title: str
    now: float
    then: float
    of: float | None = None

    @property
    def change(self) -> float:
        return round(self.then - self.now, 2)


@dataclass(frozen=True)
class Editor:
    """The repair editor as its template shows it: one submitted file, the form, and the outcome of the last job.

    Attributes
    ----------
    form
        What the form holds: the text of the file or the edited one, deduction, comment, and who else is repaired.
    note, why
        Warning that the file is not UTF-8, and reason why it cannot be edited; "" if not.
    stops
        Where code of this submission does not run.
    marked
        Lines to mark: where this file stops.
    base
        Digest of the file before the edit, to find out whether somebody else has repaired it meanwhile.
    earlier
        Points that the repairs in force deduct, shown beside the new deduction.
    job
        The background job that was asked for last; None if there was none.
    rows, still, diff
        Of a preview: the comparison of grades, where the edited copy still does not run, and the change.
    alike
        Other submissions with the same file and the same error.
    errors
        What is wrong with each field.
    running
        Whether the job was still running when the editor was made; it may end while the page is written.
    """

    file: str
    form: RepairForm
    note: str
    why: str
    stops: Sequence[Stop]
    marked: frozenset[int]
    base: str
    earlier: float
    job: Job | None = None
    rows: Sequence[Compared] = ()
    still: Sequence[Stop] = ()
    diff: Sequence[tuple[str, str]] = ()
    alike: Sequence[FinalGrade] = ()
    errors: Mapping[str, str] = field(default_factory=dict)
    running: bool = False

    @property
    def lines(self) -> int:
        return self.form.text.count("\n") + 1


def editor(
    book: Classbook, final_grade: FinalGrade, web_request: WebRequest, errors: Mapping[str, str] | None = None
) -> Editor | None:
    """Return the editor of the file that a request's job, form or address names; None without a file, or after a saved repair.

    If there are `errors`, by field, the editor shows the fields of the refused form with them.
    """
    job = book.jobs.get(web_request.number("job") or web_request.number("seen"))
    if job is not None and job.id != final_grade.id:
        job = None
    ended = job is not None and job.done
    file = job.file if job else web_request.text("file") if web_request.form else web_request.text("edit")
    files = repaired_files(book, final_grade)
    if file not in files or (job and ended and not job.problem and job.records):
        return None
    content = files[file]
    original = editable(file, content)
    form = _form(web_request) if errors is not None else job.form if job else RepairForm(original.text)
    found = stops(final_grade.result, book.lab)
    here = [each.line for each in found if each.file == file and each.line]
    shown = Editor(
        file,
        replace(form, deduct=form.deduct or f"{book.rubric.repairs.deduct:g}"),
        original.note,
        original.why,
        found,
        frozenset(here if form.text == original.text else ()),
        sha256_of(content),
        sum(each.deduction for each in final_grade.result.repairs),
        job,
        errors=errors or {},
        running=job is not None and not ended,
    )
    grades = job.grades if job and ended and not job.problem and job.form.text == form.text else None
    if grades is None:
        return shown
    return replace(
        shown,
        rows=compared(grades),
        still=stops(grades.after, book.lab),
        diff=diff_lines(diff_of(file, content, as_bytes(content, form.text))),
        alike=same_error_in(book, final_grade, file),
    )


def compared(grades: RepairPreview) -> list[Compared]:
    """Return the lines of a preview, each with the points now and with the edit: the criteria and their sum.

    If `grades.before` has repairs, their deduction follows, then the score: the sum less that, at least the score as handed in.
    No line holds the deduction for the edit itself, which the person sets when saving it.
    """
    after = {part.id: part for part in grades.after.criteria}
    rows = [
        Compared(part.title, part.points, after[part.id].points, part.max_points)
        for part in grades.before.criteria
        if part.id in after
    ]
    now, then = (round(sum(points), 2) for points in zip(*((row.now, row.then) for row in rows), strict=True))
    rows.append(Compared("Sum", now, then, grades.before.max_score))
    if earlier := grades.before.repairs:
        deducted = round(sum(each.deduction for each in earlier), 2)
        score = max(round(then - deducted, 2), earlier[0].score_before)
        rows.append(Compared("Deduction of the repairs before", -deducted, -deducted))
        rows.append(Compared("Score", grades.before.score, score, grades.before.max_score))
    return rows


def repaired_files(book: Classbook, final_grade: FinalGrade) -> dict[str, bytes]:
    """Return the files of a submission with its repairs; all as handed in if a repair's patch does not apply."""
    kept = book.kept(final_grade)
    try:
        return apply_repairs(kept.files, final_grade.result.repairs)
    except (RequestError, KeyError):
        return dict(kept.files)


def same_error_in(book: Classbook, final_grade: FinalGrade, file: str) -> list[FinalGrade]:
    """Return the other submissions in which `file` has the same content and the same error, to offer them the same repair.

    Empty if the file runs or the submission has a repair. Others that have a repair are left out.
    """
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
    """Start the background job that a form asks for (preview, suggest, save, undo) and return it; else return errors by field.

    OvertakenError if somebody repaired the file after the page was loaded.
    """
    do, file, id_ = web_request.text("do"), web_request.text("file"), final_grade.id
    if do == "undo":
        if web_request.number("repairs") != len(final_grade.result.repairs):
            raise OvertakenError("Somebody has saved or undone a repair since you opened the page")
        return book.jobs.start(UndoJob(id=id_, file=file, book=book, author=web_request.author))
    content = repaired_files(book, final_grade).get(file)
    if content is None:
        raise RequestError("This file does not exist")
    if web_request.text("base") != sha256_of(content):
        raise OvertakenError(f"Somebody has repaired {file} since you opened it")
    form = _form(web_request)
    request = RepairRequest(id_, file, as_bytes(content, form.text), seen_sha256=sha256_of(content))
    if do == "suggest":
        return book.jobs.start(SuggestJob(id=id_, file=file, form=form, out=book.out))
    if request.fixed == content:
        return {"text": "Nothing in the file has changed."}
    if do == "preview":
        return book.jobs.start(PreviewJob(id=id_, file=file, form=form, out=book.out, request=request))
    if do != "save":
        raise RequestError("The form does not say what to do. Nothing was saved")
    if wrong := _form_errors(book, form, book.jobs.get(web_request.number("seen"))):
        return wrong
    known = {each.id for each in same_error_in(book, final_grade, file)}
    ids = [id_, *(each for each in form.also if each in known)]
    author = web_request.author
    return book.jobs.start(SaveJob(id=id_, file=file, form=form, book=book, request=request, ids=ids, author=author))


def _form(web_request: WebRequest) -> RepairForm:
    text = (web_request.form.get("text") or [""])[0].replace("\r\n", "\n").replace("\r", "\n")
    return RepairForm(text, web_request.text("deduct"), web_request.text("comment"), tuple(web_request.all("also")))


def _form_errors(book: Classbook, form: RepairForm, seen: Job | None) -> dict[str, str]:
    """Return the errors of a form to save, by field: a text whose grade nobody has seen, a wrong deduction, a missing comment."""
    found = {}
    if seen is None or seen.grades is None or seen.form.text != form.text:
        found["text"] = "Not saved: the text has changed since the preview. Preview its grade, then save."
    most = max((each.result.max_score for each in book.final_grades().values()), default=0.0)
    points = decimal(form.deduct)
    if points is None or not 0 <= points <= most or round(points, 2) != points:
        found["deduct"] = f"Enter points from 0 to {most:g}, with at most two decimals."
    if not form.comment:
        found["comment"] = "Say what you changed. The student reads this."
    elif len(form.comment) > MAX_COMMENT:
        found["comment"] = f"At most {MAX_COMMENT} characters."
    return found


@dataclass(kw_only=True)
class PreviewJob(Job):
    """Job that grades a submission with the edited file and puts the result into `grades`. Nothing is stored."""

    out: Path
    request: RepairRequest

    def run(self, grading: Grading) -> None:
        self.grades = making.preview(self.out, self.request, grading)


@dataclass(kw_only=True)
class SuggestJob(Job):
    """Job that puts an edit by which the code runs, and its grades, into the editor; fails if it finds none. Nothing is stored."""

    out: Path
    tried: int = 0

    def grading_step(self) -> str:
        self.tried += 1
        return f"Grading edit {self.tried} of at most {MOST} in the sandbox"

    def run(self, grading: Grading) -> None:
        self.step = "Trying edits of the line that fails"
        grades, found = making.suggestion(self.out, self.id, grading)
        if found is None:
            raise RequestError(
                "No repair to suggest: no edit of one place makes the code run, or several do with different grades."
            )
        text = editable(found.file, found.content).text
        self.file, self.form, self.grades = found.file, replace(self.form, text=text), grades


@dataclass(kw_only=True)
class SaveJob(Job):
    """Job that stores `request` for submissions `ids`, each outcome in `lines`; fails, storing none, if the first is refused."""

    records = True
    book: Classbook
    request: RepairRequest
    ids: Sequence[str]
    author: str

    def run(self, grading: Grading) -> None:
        points = decimal(self.form.deduct) or 0.0
        for place, id_ in enumerate(self.ids):
            one = replace(self.request, id=id_, deduction=points, comment=self.form.comment)
            try:
                self.lines.append(making.record(self.book.out, one, self.author, grading))
            except RequestError as problem:
                if place == 0:
                    raise
                self.lines.append(str(problem))
            self.book.changed([id_])


@dataclass(kw_only=True)
class UndoJob(Job):
    """Job that takes back the last repair of a file, or of the submission if `file` is ""."""

    records = True
    book: Classbook
    author: str

    def run(self, grading: Grading) -> None:
        self.lines.append(making.take_back(self.book.out, self.id, self.file, self.author, grading))
        self.book.changed([self.id])


def answer(final_grade: FinalGrade, job: Job) -> Response:
    """Redirect to the page of the submission, which shows how far the job is."""
    return RedirectResponse(f"/submission/{quote(final_grade.id, safe='')}?job={job.number}#edit", 303)
