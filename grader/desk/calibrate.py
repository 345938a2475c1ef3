"""Calibrate: mark a sample by hand at the desk, blind, and compare the marks with the grades."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote

from starlette.responses import RedirectResponse, Response

from grader.base.errors import RequestError
from grader.base.files import write_whole
from grader.course.calibration import calibrating, sample
from grader.course.calibration.marks import Cell, Mark, Marks, mark_of
from grader.course.calibration.summary import short_digest, summarize
from grader.desk.classbook import Classbook
from grader.desk.overviews import framed
from grader.desk.web_requests import WebRequest
from grader.engine.results import Result
from grader.intake.names import safe_id


def show(book: Classbook, web_request: WebRequest) -> Response:
    """Show the sample; with `id`, one submission to mark; with `compare`, how far the grades are from all marks."""
    return _page(book, web_request, {})


def save(book: Classbook, web_request: WebRequest) -> Response:
    """Save the marks of one submission in the author's table below OUT, and go on to the next without marks."""
    id_ = web_request.text("id")
    ids, marks = _own(book, web_request.author)
    if id_ not in ids:
        raise RequestError("this submission is not in the sample; open Calibrate again")
    like = _results(book)[id_]
    given, errors = dict(marks), {}
    for part in like.criteria:
        row = {name: web_request.text(f"{name}:{part.id}") for name in ("points", "comment")}
        given.pop((id_, part.id), None)
        try:
            mark = mark_of(row, part.max_points)
        except RequestError as problem:
            errors[part.id] = str(problem)
        else:
            given |= {} if mark is None else {(id_, part.id): mark}
    if errors:
        return _page(book, web_request, errors)
    table = calibrating.as_table(ids, like, given, short_digest(book.rubric))
    write_whole(_table_of(book, web_request.author), table)
    after = [*ids[ids.index(id_) + 1 :], *ids]
    left = next((each for each in after if not _is_marked(each, like, given)), None)
    return RedirectResponse("/calibrate" if left is None else f"/calibrate?id={quote(left, safe='')}", 303)


def _page(book: Classbook, web_request: WebRequest, errors: dict[str, str]) -> Response:
    ids, marks = _own(book, web_request.author)
    results = _results(book)
    id_ = web_request.text("id") if web_request.text("id") in ids else ""
    return framed(
        book,
        web_request,
        "calibrate.html.j2",
        400 if errors else 200,
        sample=[(each, n, _is_marked(each, results[each], marks)) for n, each in enumerate(ids, 1)],
        shown=sample.to_mark(book.store, book.lab, results, [id_])[0] if id_ else None,
        criteria=results[id_ or ids[0]].criteria,
        marks=marks,
        errors=errors,
        found=summarize(book.rubric, book.final_grades(), _all(book)) if web_request.text("compare") else None,
        any_marks=bool(_all(book)),
    )


def _own(book: Classbook, author: str) -> tuple[list[str], dict[Cell, Mark]]:
    """Return the sample and what this author has marked. A sample that somebody has begun to mark stays."""
    path = _table_of(book, author)
    own = calibrating.read(book.store, path).cells if path.is_file() else {}
    results = _results(book)
    begun = (id_ for file in _tables(book) for id_ in calibrating.read(book.store, file).ids if id_ in results)
    return list(dict.fromkeys(begun)) or calibrating.drawn(results, sample.DEFAULT_SIZE), dict(own)


def _results(book: Classbook) -> dict[str, Result]:
    return {id_: each.result for id_, each in book.final_grades().items()}


def _all(book: Classbook) -> list[Marks]:
    return [marks for file in _tables(book) if (marks := calibrating.read(book.store, file)).cells]


def _tables(book: Classbook) -> list[Path]:
    return sorted((book.out / calibrating.FOLDER).glob("marks-*.csv"))


def _table_of(book: Classbook, author: str) -> Path:
    return book.out / calibrating.FOLDER / f"marks-{safe_id(author)}.csv"


def _is_marked(id_: str, like: Result, marks: dict[Cell, Mark]) -> bool:
    return any((id_, part.id) in marks for part in like.criteria)
