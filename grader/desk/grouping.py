"""Group pages: one decision for all submissions with the same fault or failed check, which can be undone as one."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

from starlette.responses import RedirectResponse, Response

from grader.base.errors import RequestError
from grader.course.regrading import adjusting
from grader.course.regrading.adjusting import OverrideRequest
from grader.course.regrading.groups import CHECK, FAULT, Group, decisions, groups, similar_group
from grader.desk.classbook import Classbook
from grader.desk.overviews import framed, queue
from grader.desk.review_queue import address
from grader.desk.submissions import refused
from grader.desk.web_requests import WebRequest
from grader.people.final_grade import BONUS, TOTAL


def show_all(book: Classbook, web_request: WebRequest) -> Response:
    """Return the page with all groups of submissions that can be decided on together, and the decisions already made."""
    found = groups(book.final_grades())
    kinds = {FAULT: "Same fault", CHECK: "Same failed check"}
    listed = {title: [group for group in found if group.kind == kind] for kind, title in kinds.items()}
    return framed(
        book,
        web_request,
        "groups.html.j2",
        address=address,
        listed=listed,
        decisions=decisions(book.store, book.final_grades()),
    )


def show(book: Classbook, web_request: WebRequest) -> Response:
    return _page(book, web_request, _requested_group(book, web_request))


def _page(book: Classbook, web_request: WebRequest, group: Group, errors: Mapping[str, str] | None = None) -> Response:
    """Return the page of a group; after a refused form, also its errors by field and the text that was typed."""
    final_grades = book.final_grades()
    members = [final_grades[id_] for id_ in group.ids]
    criteria = dict.fromkeys(c.id for s in members for c in s.result.criteria)
    targets = [*group.checks, *criteria, TOTAL, BONUS] if group.checks else [TOTAL, BONUS, *criteria]
    return framed(
        book,
        web_request,
        "group.html.j2",
        400 if errors else 200,
        group=group,
        errors=errors or {},
        typed=web_request.text,
        selected=set(web_request.all("id")) if errors else None,
        address=address,
        members=members,
        targets=targets,
        covering=adjusting.covering,
        checks_of=lambda final_grade: {c.id: c for part in final_grade.result.criteria for c in part.checks},
        seen=book.store.last_adjustment(),
        decisions=[each for each in decisions(book.store, final_grades) if each.what == group.what],
    )


def decide(book: Classbook, web_request: WebRequest) -> Response:
    """Store an override or comment for the selected submissions of a group, such as all with one fault, or show what is wrong."""
    group = _requested_group(book, web_request)
    chosen = [id_ for id_ in group.ids if id_ in set(web_request.all("id"))]
    target, points, comment = map(web_request.text, ("target", "points", "comment"))
    final_grades = book.final_grades()
    errors = refused([final_grades[id_] for id_ in chosen], target, points, comment)
    if not chosen:
        errors["id"] = "Select at least one submission."
    if errors:
        return _page(book, web_request, group, errors)
    requests = [OverrideRequest(id_, target, points, comment, place=id_, alone=not points) for id_ in chosen]
    book.decide(requests, web_request.author, web_request.number("seen"), group.what)
    return RedirectResponse(f"{address(group)}#decisions", 303)


def take_back(book: Classbook, web_request: WebRequest) -> Response:
    """Undo a decision that a person made on a group, except for submissions where a later override has replaced it."""
    requests = adjusting.undoing_requests(book.store, web_request.number("number") or 0)
    book.decide(requests, web_request.author, web_request.number("seen"))
    return RedirectResponse("/groups#decisions", 303)


def _requested_group(book: Classbook, web_request: WebRequest) -> Group:
    """Return the group in the address; RequestError if it does not exist any more."""
    wanted = (web_request.path["kind"], web_request.path["key"])
    together = (similar_group(each.ids) for each in queue(book) if each.others)
    every = itertools.chain(groups(book.final_grades()), together)
    found = next((group for group in every if (group.kind, group.key) == wanted), None)
    if found is None:
        raise RequestError("This group does not exist: the record has changed, or it has only one member left")
    return found
