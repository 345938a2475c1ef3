"""The review queue (what a person should look at), the page of the whole class, and marking items as reviewed."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from urllib.parse import quote

from starlette.responses import RedirectResponse, Response

from grader.base.errors import RequestError
from grader.base.text import printable
from grader.course.publishing.contradictions import contradictions
from grader.course.repairs import making
from grader.desk import drafts
from grader.desk import review_queue as queue_of
from grader.desk.classbook import Classbook
from grader.desk.rendering import address, page
from grader.desk.review_queue import KINDS, Item
from grader.desk.web_requests import WebRequest
from grader.report import overview
from grader.report.pages import AT_ONCE


def queue(book: Classbook) -> list[Item]:
    """Return the review queue, open items and reviewed ones, cached until grades, reviews or other facts behind it change."""
    facts = (
        book.final_grades(),
        book.similar().groups,
        book.store.notices(),
        book.store.regrade_requests(),
        book.store.reviews(),
        contradictions(book.final_grades(), book.store.settings()),
        making.lapsed(book.store, book.final_grades()),
    )
    return book.once("queue", facts, lambda: queue_of.items(*facts, book.lab, book.rubric.late))


def review_queue(book: Classbook, web_request: WebRequest) -> Response:
    """Return the first page: what a person should review, then what is reviewed already. A `kind` in the address filters both."""
    found = queue(book)
    kind = web_request.text("kind") if web_request.text("kind") in KINDS else ""
    open_ = [each for each in found if each.review is None]
    return framed(
        book,
        web_request,
        "review_queue.html.j2",
        open=[each for each in open_ if kind in ("", each.reason.kind)],
        done=[each for each in found if each.review is not None and kind in ("", each.reason.kind)],
        kind=kind,
        kinds=KINDS,
        counts=Counter(each.reason.kind for each in open_),
        absent=list(book.absent().values()),
        unsaved=drafts.unsaved(book, web_request),
        no_repairs=book.no_repairs,
    )


def class_page(book: Classbook, web_request: WebRequest) -> Response:
    """Return the desk's page of all submissions, and of people without a submission, with search, filters and sorting."""
    waiting = Counter(id_ for each in queue(book) if each.review is None for id_ in each.ids)
    table = overview.class_table([*book.final_grades().values(), *book.absent().values()])
    return framed(
        book,
        web_request,
        "class.html.j2",
        table=replace(table, entries=[replace(each, href=address(each.id)) for each in table.entries]),
        at_once=AT_ONCE,
        waiting=waiting,
        find=printable(web_request.text("find"), 200),
        contradictions=contradictions(book.final_grades(), book.store.settings()),
    )


def find(book: Classbook, web_request: WebRequest) -> Response:
    """Redirect to the page of the submission or person with the id in the field `who`; else to the class page, searched for it."""
    who = web_request.text("who")
    if who in book.final_grades() or who in book.absent():
        return RedirectResponse(f"/submission/{quote(who, safe='')}", 303)
    return RedirectResponse(f"/class?find={quote(who, safe='')}", 303)


def mark_reviewed(book: Classbook, web_request: WebRequest) -> Response:
    """Mark items of the queue as reviewed, or open them again; RequestError if an item has left the queue."""
    known = {each.key: each for each in queue(book)}
    looked = [known.get(key) for key in web_request.all("look")]
    found = [(each.id, each.reason.kind, each.reason.about) for each in looked if each]
    if not found or len(found) < len(looked):
        raise RequestError("This item is no longer in the queue because the record has changed. Reload the page")
    book.mark_reviewed(found, web_request.author, done=web_request.text("done") == "yes")
    if web_request.text("back") in book.final_grades():
        return RedirectResponse(f"/submission/{quote(web_request.text('back'), safe='')}", 303)
    return RedirectResponse(f"/?kind={web_request.text('kind')}" if web_request.text("kind") in KINDS else "/", 303)


def framed(book: Classbook, web_request: WebRequest, template: str, code: int = 200, /, **values: object) -> Response:
    """Return a page with HTTP status `code`: `template` with `values` and what all pages need, such as typed text not yet sent."""
    final_grades = book.final_grades()
    lab = next((each.result.lab for each in final_grades.values()), None)
    frame = {
        "final_grades": final_grades,
        "everybody": [*final_grades.values(), *book.absent().values()],
        "lab": lab.label if lab else "",
        "author": web_request.author,
        "trouble": book.trouble,
        "late_policy": book.rubric.late,
        "drafts": drafts.of_page(book, web_request),
    }
    return page(template, code, **(frame | values))
