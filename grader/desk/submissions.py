"""Submission page of the review desk: report beside code, regrade requests, and forms to override points or repair a file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from urllib.parse import quote

from markupsafe import Markup
from starlette.responses import RedirectResponse, Response

from grader.base.errors import RequestError
from grader.base.stamps import now
from grader.base.text import printable
from grader.course.record.decisions import RegradeRequest
from grader.course.record.submission_archive import unshowable
from grader.course.regrading import adjusting
from grader.course.regrading.adjusting import ALONE, OverrideRequest
from grader.desk import repairing
from grader.desk.classbook import Classbook
from grader.desk.code import SubmittedFiles, defined, named_lines, submitted_files
from grader.desk.editing import editable
from grader.desk.overviews import framed, queue
from grader.desk.repair_jobs import Job
from grader.desk.repairing import Editor
from grader.desk.review_queue import Item
from grader.desk.web_requests import WebRequest
from grader.engine.results import CheckResult, CriterionResult, ExtensionResult
from grader.people.final_grade import BONUS, TOTAL, Adjustment, FinalGrade, automatic_points, maximum_points, summed
from grader.report import words
from grader.report.adjusted import explained, is_composed, repaired_file
from grader.report.pages import Drawn, drawn

_MOST_COMMENTS = 30
_WITHOUT = (
    "No submission. Points that you give here, for example for an oral exam, are the grade. Without them it is blank."
)


@dataclass(frozen=True)
class Typed:
    """Refused form for an override of `target` (a check, a criterion, the total or the bonus): typed text, and errors by field."""

    target: str
    points: str
    comment: str
    errors: Mapping[str, str]


@dataclass(frozen=True)
class _PageExtras:
    """Content of a submission's page beside the result: regrade requests, and a refused form, None if there is none."""

    requests: Sequence[RegradeRequest]
    typed: Typed | None = None


@dataclass(frozen=True)
class Overrides:
    """Content of the page about one target (a check, a criterion, the total or the bonus): override, comment, regrade requests.

    `most` and `automatic` are its maximum and automatic points. `covered` is the criterion or total whose own override replaces
    these points, "" if none. `effect` tells, before an override is saved, how it changes the final grade.
    """

    target: str
    most: float
    automatic: float | None
    points: Adjustment | None
    comment: Adjustment | None
    covered: str = ""
    requests: tuple[RegradeRequest, ...] = ()
    typed: Typed | None = None
    effect: str = ""

    @property
    def asked(self) -> bool:
        """Return whether there is an override, comment, regrade request or refused form; even a passed check is then shown open."""
        return bool(self.points or self.comment or self.requests or self.typed)

    @property
    def anchor(self) -> str:
        return self.target.replace(".", "-")


@dataclass(frozen=True)
class Place:
    """A line of a submitted file for a link beside a check; `anchor` is the file's id on the page."""

    path: str
    anchor: str
    line: int


@dataclass(frozen=True)
class Row:
    """One check on the page: its feedback, its overrides (None: extensions take none), and the lines of code that it is about."""

    row: words.CheckText
    overrides: Overrides | None
    places: tuple[Place, ...]

    @property
    def folded(self) -> bool:
        """Return whether to show the check folded: it passed and has no override, comment, regrade request or form with errors."""
        return self.row.outcome.kind == "passed" and not (self.overrides and self.overrides.asked)


@dataclass(frozen=True)
class PartView:
    id: str
    title: str
    points: str
    overrides: Overrides | None
    rows: tuple[Row, ...]
    figures: Markup


def show(book: Classbook, web_request: WebRequest) -> Response:
    final_grade = one(book, web_request)
    return _page(book, web_request, final_grade, repairing.editor(book, final_grade, web_request))


def repair(book: Classbook, web_request: WebRequest) -> Response:
    """Start a preview, suggestion, saving or undoing of a repair; show its progress, or the form again with its errors."""
    final_grade = one(book, web_request)
    found = repairing.change(book, web_request, final_grade)
    if isinstance(found, Job):
        return repairing.answer(final_grade, found)
    return _page(book, web_request, final_grade, repairing.editor(book, final_grade, web_request, found), 422)


def _page(
    book: Classbook,
    web_request: WebRequest,
    final_grade: FinalGrade,
    editor: Editor | None,
    code_: int = 200,
    typed: Typed | None = None,
) -> Response:
    """Return the page of a submission: report, code, history and forms; `typed` is a refused form, `editor` an open repair."""
    items = queue(book)
    history = book.history(final_grade.id)
    requests = [each for each in book.store.regrade_requests() if each.id == final_grade.id]
    extras = _PageExtras(requests, typed)
    kept = replace(book.kept(final_grade), files=repairing.repaired_files(book, final_grade))
    result = final_grade.result
    job = book.jobs.get(web_request.number("job"))
    marked = result.status not in ("empty", "unreadable")
    parts: Sequence[CriterionResult | ExtensionResult] = [*result.criteria, *(e for e in result.extensions if e.checks)]
    named = named_lines((check for part in parts for check in part.checks), kept.files)
    files = submitted_files(kept, named)
    definitions = {each.id: list(defined(kept, each.names)) for each in (*book.lab.parts, *book.lab.bonuses)}
    code = _Code(files, named, definitions)
    shown = drawn(book.store.charts(final_grade.id))
    shown_parts = [_part(final_grade, part, code, shown, extras) for part in parts]
    shown_parts.sort(key=lambda part: all(row.folded for row in part.rows))  # criteria with deductions first
    places = [place.path for part in shown_parts for row in part.rows if not row.folded for place in row.places]
    listings = tuple(
        sorted(files.listings, key=lambda each: each.path not in places[:1])
    )  # the first lost check's file first
    return framed(
        book,
        web_request,
        "submission.html.j2",
        code_,
        editor=editor,
        no_repairs=book.no_repairs,
        job=job if job is not None and job.id == final_grade.id else None,
        repairs=[repaired_file(each) for each in result.repairs],
        editable=[path for path in kept.files if not editable(path, kept.files[path]).why],
        final_grade=final_grade,
        explained=explained(final_grade) if is_composed(final_grade) else "",
        status=_WITHOUT if final_grade.has_no_submission else words.STATUS[result.status],
        late=words.late(final_grade),
        notes=words.notes(result),
        faults=[words.fault_in_words(id_) for id_ in result.misconceptions],
        parts=shown_parts,
        comments=_comments(book),
        keys=_keys(shown_parts if marked else (), requests),
        marked=marked,
        whole=[_overrides(final_grade, target, extras) for target in (TOTAL, BONUS)],
        files=replace(files, listings=listings),
        items=[each for each in items if final_grade.id in each.ids],
        history=list(reversed(history)),
        describe=adjusting.said,
        decisions=book.store.decisions(),
        seen=max((each.number for each in history), default=0),
        neighbours=_neighbours(
            list(book.final_grades() if final_grade.id in book.final_grades() else book.absent()), final_grade.id, items
        ),
    )


def override(book: Classbook, web_request: WebRequest) -> Response:
    """Store the override or comment of a form, undo the last one (the one before counts again), or withdraw it (none counts).

    The comment answers the regrade request that the form names, if any. A refused form is shown again with its errors.
    """
    final_grade = one(book, web_request)
    target, points, comment = map(web_request.text, ("target", "points", "comment"))
    if web_request.text("do") in ("", "give") and (wrong := refused([final_grade], target, points, comment)):
        return _page(book, web_request, final_grade, None, 400, Typed(target, points, comment, wrong))
    if web_request.text("do") in ("undo", "undo-comment"):
        override = adjusting.undone(book.store, final_grade.id, target, alone=web_request.text("do") == "undo-comment")
    elif web_request.text("do") == "withdraw":
        override = OverrideRequest(final_grade.id, target, "", comment or "withdrawn", place=final_grade.id)
    else:
        override = OverrideRequest(
            final_grade.id, target, points or ALONE, comment, place=final_grade.id, alone=not points
        )
    book.decide([override], web_request.author, web_request.number("seen"))
    if answers := web_request.number("answers"):
        book.store.answer(answers, comment, web_request.author, now())
    return RedirectResponse(f"/submission/{quote(final_grade.id, safe='')}#override-{target.replace('.', '-')}", 303)


def refused(final_grades: Sequence[FinalGrade], target: str, points: str, comment: str) -> dict[str, str]:
    """Return by form field why an override, as typed, is refused for any of the submissions; empty if it is for none.

    `target` is the id of a check or criterion, "total" or "bonus"; `points` "" makes it a comment only.
    """
    errors = {} if comment else {"comment": "say why in a comment"}
    for each in final_grades:
        request = OverrideRequest(each.id, target, points, comment, alone=not points)
        errors = {**adjusting.objections(request, each), **errors}
    return {field: f"{why[0].upper()}{why[1:]}." for field, why in errors.items()}


def picture(book: Classbook, web_request: WebRequest) -> Response:
    """Serve a submitted picture. RequestError if it is no PNG by its header (a browser could run it) or is too large."""
    kept = book.kept(one(book, web_request))
    place = int(web_request.path["place"])
    contents = list(kept.files.values())
    if place >= len(contents) or unshowable(contents[place]):
        raise RequestError("This picture does not exist")
    return Response(contents[place], media_type="image/png")


def _comments(book: Classbook) -> list[str]:
    """Return the comments used before in this class, most frequent first, for the forms to suggest; empty if there are none."""
    used = Counter(each.comment for _, each in book.store.history() if each.comment not in ("", "undone", "withdrawn"))
    return [printable(comment, 300) for comment, _ in used.most_common(_MOST_COMMENTS)]


def one(book: Classbook, web_request: WebRequest) -> FinalGrade:
    """Return the final grade of the id in the address, blank for a person without a submission; RequestError for an unknown id."""
    id_ = web_request.path["id"]
    final_grade = book.final_grades().get(id_) or book.absent().get(id_)
    if final_grade is None:
        raise RequestError("This submission does not exist")
    return final_grade


@dataclass(frozen=True)
class _Code:
    """Finds the code that a check is about, for links on the page: the lines its feedback names, or its criterion's functions."""

    submitted_files: SubmittedFiles
    named: Mapping[str, set[int]]
    defined: Mapping[str, Sequence[tuple[str, int]]]

    def places(self, check: CheckResult, part: str) -> tuple[Place, ...]:
        """Return the lines that the check's feedback names, or else the definitions of the criterion `part`; empty if not shown."""
        mine = [(path, line) for path, lines in named_lines([check], self.named).items() for line in sorted(lines)]
        return tuple(
            Place(printable(path), anchor, line)
            for path, line in mine or self.defined.get(part, ())
            if (anchor := self.submitted_files.anchor(path))
        )


def _part(
    final_grade: FinalGrade,
    part: CriterionResult | ExtensionResult,
    code: _Code,
    shown: Drawn,
    extras: _PageExtras,
) -> PartView:
    """Return one criterion or extension as the page shows it: checks, charts and overrides; an extension cannot be overridden."""
    lab = final_grade.result.lab
    figures = Markup(shown.get(part.id, ""))
    by_hand = isinstance(part, CriterionResult)
    rows = tuple(
        Row(
            words.row(each, part.id, lab),
            _overrides(final_grade, each.id, extras) if by_hand else None,
            code.places(each, part.id),
        )
        for each in part.checks
    )
    if isinstance(part, CriterionResult):
        points = words.fraction(final_grade.points(part), part.max_points)
        return PartView(part.id, part.title, points, _overrides(final_grade, part.id, extras), rows, figures)
    title = f"Extension: {part.id.replace('_', ' ')}"
    return PartView(part.id, title, words.extension_points(part), None, rows, figures)


def _overrides(final_grade: FinalGrade, target: str, extras: _PageExtras) -> Overrides:
    """Return what the form for overriding `target` shows: maximum, automatic points, override in force, comment, requests."""
    comments = (each for each in final_grade.adjustments if each.alone and each.criterion == target)
    return Overrides(
        target,
        maximum_points(final_grade.result, target) or 0.0,
        None if target == BONUS else summed(automatic_points(final_grade.result, target) or {}),
        final_grade.adjustment(target),
        next(comments, None),
        adjusting.covering(final_grade, target),
        tuple(each for each in extras.requests if (each.about or TOTAL) == target),
        extras.typed if extras.typed and extras.typed.target == target else None,
        _effect(final_grade, target),
    )


def _effect(final_grade: FinalGrade, target: str) -> str:
    """Return a sentence on how an override of `target` changes the final grade, with the numbers that a total leaves out."""
    if target == BONUS:
        return "A bonus is added to the final grade, also to a total."
    if target != TOTAL:
        return "Points replace the automatic points and change the final grade."
    rest = replace(final_grade, adjustments=tuple(each for each in final_grade.adjustments if each.criterion != TOTAL))
    left_out = [f"{each.name} {words.number(each.points)}" for each in rest.terms[1:] if each.name != BONUS]
    said = f" (here: {', '.join(left_out).replace('-', '−')})" if left_out else ""
    return f"A total is final: nothing automatic is added to it or deducted from it{said}."


def _keys(parts: Sequence[PartView], requests: Sequence[RegradeRequest]) -> dict[str, str]:
    """Return the keyboard shortcut of each form: ``m`` the total, ``o`` the bonus, ``b`` the most likely target.

    That is the target of an open regrade request, else the first check that lost points, else the total.
    """
    asked = [each.about or TOTAL for each in requests if not each.answered]
    lost = [
        row.overrides.target
        for part in parts
        for row in part.rows
        if row.overrides and row.row.outcome.kind != "passed"
    ]
    keys = {TOTAL: "m", BONUS: "o"}
    return keys | {first: f"b {keys.get(first, '')}".strip() for first in [*asked, *lost, TOTAL][:1]}


@dataclass(frozen=True)
class Neighbours:
    """Ids around the shown submission, by id: the one before, the one after, the next that waits for a review; "" if there is none.

    `place` counts from 1 among `of`. After the last submission, the search for the next review goes on with the first.
    """

    place: int
    of: int
    previous: str
    next: str
    next_open: str


def _neighbours(ids: Sequence[str], id_: str, items: Sequence[Item]) -> Neighbours:
    here = ids.index(id_)
    waiting = {id_ for each in items if each.review is None for id_ in each.ids}
    later = [each for each in (*ids[here + 1 :], *ids[:here]) if each in waiting]
    previous = ids[here - 1] if here else ""
    following = ids[here + 1] if here + 1 < len(ids) else ""
    return Neighbours(here + 1, len(ids), previous, following, later[0] if later else "")
