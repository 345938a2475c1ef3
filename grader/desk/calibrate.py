"""Calibrate pages: mark a sample by hand without seeing grades, and compare the marks with the grades."""

from __future__ import annotations

from collections.abc import Mapping
from urllib.parse import quote

from starlette.responses import RedirectResponse, Response

from grader.base.errors import RequestError
from grader.base.files import write_whole
from grader.course.calibration import calibrating, sample
from grader.course.calibration.marks import Cell, Mark, as_table, parse_mark
from grader.desk.classbook import Classbook
from grader.desk.overviews import framed
from grader.desk.web_requests import WebRequest
from grader.intake.names import safe_id


def show(book: Classbook, web_request: WebRequest) -> Response:
    """Show the sample of submissions to mark by hand as a test of the grader; with `id` in the query, the form for that submission.

    With `compare` in the query, show instead how far the grades are from the marks by everybody who marked. An `id` outside the
    sample is ignored. RequestError if there is no submission to mark or to compare.
    """
    return _page(book, web_request, _Calibration(book, web_request.author), {})


def save(book: Classbook, web_request: WebRequest) -> Response:
    """Save a person's marks of a submission, to compare with its grade, and go on to the next one that this person has not marked.

    If none is left, go to the page with the whole sample. Each person's marks are in a CSV in the output folder. With `do=full`,
    blank fields get full points. If a field is wrong, the form is shown again and nothing is saved.
    """
    id_, known = web_request.text("id"), _Calibration(book, web_request.author)
    if id_ not in known.ids:
        raise RequestError("this submission is not in the sample; open Calibrate again")
    given, errors = dict(known.own), {}
    for part in known.results[id_].criteria:
        row = {name: web_request.text(f"{name}:{part.id}") for name in ("points", "comment")}
        if web_request.text("do") == "full":
            row["points"] = row["points"] or f"{part.max_points:g}"
        given.pop((id_, part.id), None)
        try:
            given |= {(id_, part.id): parse_mark(row, part.max_points)} if row["points"].strip() else {}
        except RequestError as problem:
            errors[part.id] = str(problem)
    if errors:
        return _page(book, web_request, known, errors)
    cells = [(each, part.id) for each in known.ids for part in known.results[id_].criteria]
    write_whole(known.file, as_table(cells, given, calibrating.short_digest(book.rubric)))
    marked = {each for each, _ in given}
    place = known.ids.index(id_) + 1
    left = next((each for each in [*known.ids[place:], *known.ids] if each not in marked), None)
    return RedirectResponse("/calibrate" if left is None else f"/calibrate?id={quote(left, safe='')}", 303)


class _Calibration:
    """Content of the Calibrate pages: results, people's tables of marks, and the sample. A sample that is partly marked stays."""

    def __init__(self, book: Classbook, author: str) -> None:
        folder = book.out / calibrating.FOLDER
        self.file = folder / f"marks-{safe_id(author)}.csv"
        self.results = {id_: each.result for id_, each in book.final_grades().items()}
        tables = {file: calibrating.read(book.store, file) for file in sorted(folder.glob("marks-*.csv"))}
        begun = dict.fromkeys(id_ for each in tables.values() for id_ in each.ids if id_ in self.results)
        self.ids = list(begun) or sample.draw(self.results, sample.DEFAULT_SIZE)
        self.own: Mapping[Cell, Mark] = tables[self.file].cells if self.file in tables else {}
        self.marks = [each for each in tables.values() if each.cells]


def _page(book: Classbook, web_request: WebRequest, known: _Calibration, errors: dict[str, str]) -> Response:
    id_ = web_request.text("id") if web_request.text("id") in known.ids else ""
    marked = {each for each, _ in known.own}
    return framed(
        book,
        web_request,
        "calibrate.html.j2",
        400 if errors else 200,
        sample=[(each, n, each in marked) for n, each in enumerate(known.ids, 1)],
        shown=sample.to_mark(book.store, book.lab, id_, known.results[id_]) if id_ else None,
        criteria=known.results[id_ or known.ids[0]].criteria,
        marks=known.own,
        errors=errors,
        found=calibrating.summarize(book.rubric, book.final_grades(), known.marks)
        if web_request.text("compare")
        else None,
        any_marks=bool(known.marks),
    )
