"""Regrade requests, students' objections to grades: read from text, JSON or a table, matched to submission and check, listed."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import quote

from starlette.responses import RedirectResponse, Response

from grader.base.errors import RequestError
from grader.base.files import read_file
from grader.base.stamps import now
from grader.base.text import printable
from grader.course.record.decisions import RegradeRequest
from grader.course.regrading.adjusting import targets
from grader.desk.classbook import Classbook
from grader.desk.overviews import framed
from grader.desk.web_requests import MOST_BYTES, WebRequest
from grader.engine.rubric_nodes import guess_at
from grader.people.final_grade import FinalGrade
from grader.people.identity import PersonLookup

LONGEST = 8000
_MOST = 2000
_WHO = (
    "submission",
    "id",
    "student",
    "student id",
    "sid",
    "username",
    "login",
    "email",
    "e-mail",
    "email address",
    "name",
)
_ABOUT = ("check", "criterion", "about")
_FILES = (".json", ".csv", ".txt")
_TEXT = ("request", "appeal", "text", "message", "reason", "comment")


@dataclass(frozen=True)
class ReceivedRequest:
    """A regrade request as it was received, before it is matched to a submission: student, check and text, all unverified.

    `place` says where in the text the request stood, for error messages.
    """

    who: str
    about: str
    text: str
    place: str


def show(book: Classbook, web_request: WebRequest) -> Response:
    return _page(book, web_request)


def _page(book: Classbook, web_request: WebRequest, problem: str = "", code: int = 200) -> Response:
    """Return the page with the requests and a form for new ones; `problem` says what is wrong with the typed text, which stays."""
    requests = book.store.regrade_requests()
    final_grades = book.final_grades()
    return framed(
        book,
        web_request,
        "regrade_requests.html.j2",
        code,
        open=[each for each in requests if not each.answered and each.id in final_grades],
        answered=[each for each in reversed(requests) if each.answered and each.id in final_grades],
        about=_targets(book),
        unplaced=book.unplaced_requests,
        message=web_request.text("message"),
        typed={name: (web_request.form.get(name) or [""])[0] for name in ("text", "who", "about")},
        errors={_field(problem): problem.replace(_NOBODY, "Choose a student.")} if problem else {},
    )


def _targets(book: Classbook) -> dict[str, None]:
    """Return the ids of checks and criteria that a request may be about, in order, for the form; the values are None."""
    return dict.fromkeys(target for final_grade in book.final_grades().values() for target in targets(final_grade))


_NOBODY = "the request: no student is named"


def _field(problem: str) -> str:
    who = "no student" in problem or "is ambiguous" in problem
    return "about" if "no check" in problem else "who" if who else "text"


def add(book: Classbook, web_request: WebRequest) -> Response:
    """Store the regrade requests in a form's text (one request, JSON, or a CSV table), or show the form with its error."""
    try:
        received = list(read(web_request.text("text"), web_request.text("who"), web_request.text("about")))
        requests, unplaced = placed(received, book.final_grades())
        if unplaced:
            raise RequestError("\n".join(why for _, why in unplaced[:20]))
        new = book.store.keep_regrade_requests(requests)
        for each in received:  # the same text may wait for a second student
            waiting = next((other for other in book.unplaced_requests if other[0] == each.text), None)
            if waiting:
                book.unplaced_requests.remove(waiting)
    except RequestError as problem:
        return _page(book, web_request, str(problem), 400)
    return RedirectResponse(f"/regrade-requests?message={quote(added(new, len(received)))}", 303)


def added(new: int, read: int) -> str:
    """Return a line such as ``1 regrade request added``; it says how many of all `read` were stored already, if any."""
    known = f", {read - new} already on record" if read > new else ""
    return f"{new} regrade request{'' if new == 1 else 's'} added{known}"


def read_in(book: Classbook, path: Path) -> list[str]:
    """Read requests from a JSON, CSV or text file or a folder of these; return lines: how many were added, and why others were not.

    The desk offers those that name no known student or check, to be added by hand. RequestError if a folder has no such file.
    """
    files = sorted(each for each in path.iterdir() if each.suffix.lower() in _FILES) if path.is_dir() else [path]
    if not files:
        raise RequestError(f"--requests {printable(str(path), 500)}: contains no {', '.join(_FILES)} file")
    received: list[ReceivedRequest] = []
    problems = []
    for file in files:
        try:
            received += _read_file(file)
        except RequestError as problem:
            problems.append(str(problem))
    requests, unplaced = book.on_thread(lambda: placed(received, book.final_grades()))
    new = book.on_thread(lambda: book.store.keep_regrade_requests(requests))
    known = {
        each.text: each.id for each in book.on_thread(book.store.regrade_requests)
    }  # also assigned by hand, in an earlier run
    unplaced = [
        (each, f"{why} ({known[each.text]} has a request with this text on record)" if each.text in known else why)
        for each, why in unplaced
    ]
    checks = book.on_thread(lambda: _targets(book))
    book.unplaced_requests += [(each.text, each.about if each.about in checks else "", why) for each, why in unplaced]
    by_hand = [f"{why} (choose the student at the desk, under Regrade requests)" for _, why in unplaced]
    return [added(new, len(requests)), *problems, *by_hand]


def _read_file(path: Path) -> list[ReceivedRequest]:
    """Return the requests in a text, JSON or CSV file. Without a student in the text, the file's name is the student.

    RequestError if the file cannot be read or is not UTF-8.
    """
    advice = "give a text, .json or .csv in UTF-8"
    try:
        text = read_file(path, MOST_BYTES, advice).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise RequestError(f"{printable(str(path), 500)}: is not UTF-8; {advice}") from error
    name = printable(path.name, 120)
    return [replace(each, place=f"{name}, {each.place}") for each in read(text, path.stem, "")]


def read(text: str, who: str, about: str) -> Iterator[ReceivedRequest]:
    """Yield the regrade requests in a text. JSON objects or CSV rows without a request are left out.

    Parameters
    ----------
    text
        A JSON object or a list of objects, a CSV table with a column for people and one for the text, or plain text.
    who, about
        Defaults where the text names no student or check.

    Raises
    ------
    RequestError
        If the text is empty, holds more than 2000 records, or a request is too long.
    """
    if not text.strip():
        raise RequestError("The request is empty. Nothing was saved")
    records = _json(text) or _table(text)
    if records is None:
        yield _bounded(ReceivedRequest(who, about, text.strip(), "the request"))
        return
    if len(records) > _MOST:
        raise RequestError(f"{len(records)} requests at once; give at most {_MOST}. Nothing of them was saved")
    for place, record in records:
        said = {str(key).strip().casefold(): str(value).strip() for key, value in record.items() if value is not None}
        found = _first(said, _TEXT)
        if found:
            yield _bounded(ReceivedRequest(_first(said, _WHO) or who, _first(said, _ABOUT) or about, found, place))


def placed(
    received: Sequence[ReceivedRequest], final_grades: Mapping[str, FinalGrade]
) -> tuple[list[RegradeRequest], list[tuple[ReceivedRequest, str]]]:
    """Match each request to a submission and a check; return those to store, and those without a match, each with the reason."""
    lookup = PersonLookup({id_: final_grade.people for id_, final_grade in final_grades.items()})
    requests, others = [], []
    for each in received:
        try:
            id_ = lookup.by(each.who) if each.who else ""
        except RequestError as ambiguous:
            others.append((each, f"{each.place}: {ambiguous}"))
            continue
        known = targets(final_grades[id_]) if id_ in final_grades else []
        if not known:
            why = f"no student {printable(each.who) or 'is named'}{guess_at(each.who, final_grades)}"
            others.append((each, f"{each.place}: {why}"))
        elif each.about and each.about not in known:
            others.append(
                (each, f"{each.place}: there is no check {printable(each.about)}{guess_at(each.about, known)}")
            )
        else:
            requests.append(RegradeRequest(id_, each.about, each.text, now()))
    return requests, others


def _bounded(received: ReceivedRequest) -> ReceivedRequest:
    """Return a request without lone surrogates and control characters, so that it can be stored; RequestError if it is too long."""
    if len(received.text) > LONGEST:
        raise RequestError(f"{received.place}: is longer than {LONGEST} characters")
    who, about = printable(received.who, 500), printable(received.about, 500)
    return replace(received, who=who, about=about, text=printable(received.text, 2 * LONGEST, newlines=True))


def _json(text: str) -> list[tuple[str, Mapping[str, object]]] | None:
    """Return the records of a JSON text, each with a name for error messages; None if it is no JSON of records."""
    if text.lstrip()[:1] not in ("{", "["):
        return None
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        return None  # plain text that begins with a bracket
    records = data if isinstance(data, list) else [data]
    if not all(isinstance(record, dict) for record in records):
        return None
    return [(f"request {number}", record) for number, record in enumerate(records, 1)]


def _table(text: str) -> list[tuple[str, Mapping[str, object]]] | None:
    """Return the rows of a CSV, each with its line; None if its header does not name a student and a text column."""
    head = text.lstrip("\ufeff").partition("\n")[0]
    table = csv.DictReader(io.StringIO(text.lstrip("\ufeff"), newline=""), delimiter=max(",;\t", key=head.count))
    try:
        titles = {title.strip().casefold() for title in table.fieldnames or ()}
        if not titles.intersection(_WHO) or not titles.intersection(_TEXT):
            return None
        return [(f"line {table.line_num}", {str(k): v for k, v in row.items()}) for row in table]
    except csv.Error:
        return None


def _first(said: Mapping[str, str], names: Sequence[str]) -> str:
    return next((said[name] for name in names if said.get(name)), "")
