"""Group pages: one decision for all submissions with the same fault or failed check, undone as one."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

from starlette.responses import RedirectResponse, Response

from grader.base.errors import RequestError
from grader.course import adjusting
from grader.course.adjusting import OverrideRequest
from grader.course.groups import CHECK, MISTAKE, SAME, Group, alike, decisions, groups
from grader.desk.asking import Ask
from grader.desk.classbook import Classbook
from grader.desk.overviews import framed, queue
from grader.desk.review_queue import address
from grader.desk.submissions import refused
from grader.people.final_grade import BONUS, TOTAL


def show_all(book: Classbook, ask: Ask) -> Response:
    found = groups(book.final_grades())
    kinds = {MISTAKE: "Same fault", CHECK: "Same failed check", SAME: "Same set of failed checks"}
    listed = {title: [group for group in found if group.kind == kind] for kind, title in kinds.items()}
    return framed(
        book,
        ask,
        "groups.html.j2",
        address=address,
        listed=listed,
        decisions=decisions(book.store, book.final_grades()),
    )


def show(book: Classbook, ask: Ask) -> Response:
    return _page(book, ask, _one(book, ask))


def _page(book: Classbook, ask: Ask, group: Group, errors: Mapping[str, str] | None = None) -> Response:
    """Show a group; after a refused form, also its errors by field and the text that was typed."""
    final_grades = book.final_grades()
    members = [final_grades[id_] for id_ in group.ids]
    criteria = dict.fromkeys(c.id for s in members for c in s.result.criteria)
    targets = [*group.checks, *criteria, TOTAL, BONUS] if group.checks else [TOTAL, BONUS, *criteria]
    return framed(
        book,
        ask,
        "group.html.j2",
        400 if errors else 200,
        group=group,
        errors=errors or {},
        typed=ask.text,
        selected=set(ask.all("id")) if errors else None,
        address=address,
        members=members,
        targets=targets,
        covering=adjusting.covering,
        checks_of=lambda final_grade: {c.id: c for part in final_grade.result.criteria for c in part.checks},
        seen=book.last_number(),
        decisions=[each for each in decisions(book.store, final_grades) if each.what == group.what],
    )


def decide(book: Classbook, ask: Ask) -> Response:
    """Record one decision for the selected submissions of a group."""
    group = _one(book, ask)
    chosen = [id_ for id_ in group.ids if id_ in set(ask.all("id"))]
    target, points, comment = ask.text("target"), ask.text("points").replace(",", "."), ask.text("comment")
    final_grades = book.final_grades()
    errors = refused([final_grades[id_] for id_ in chosen], target, points, comment)
    if not chosen:
        errors["id"] = "Select at least one submission."
    if errors:
        return _page(book, ask, group, errors)
    requests = [OverrideRequest(id_, target, points, comment, place=id_, alone=not points) for id_ in chosen]
    book.decide(requests, ask.author, ask.number("seen"), group.what)
    return RedirectResponse(f"{address(group)}#decisions", 303)


def take_back(book: Classbook, ask: Ask) -> Response:
    """Undo the parts of a decision that no later override has replaced."""
    requests = adjusting.undone_decision(book.store, ask.number("number") or 0)
    book.decide(requests, ask.author, ask.number("seen"))
    return RedirectResponse("/groups#decisions", 303)


def _one(book: Classbook, ask: Ask) -> Group:
    wanted = (ask.path["kind"], ask.path["key"])
    together = (alike(each.ids) for each in queue(book) if each.others)
    every = itertools.chain(groups(book.final_grades()), together)
    found = next((group for group in every if (group.kind, group.key) == wanted), None)
    if found is None:
        raise RequestError("This group does not exist: the record has changed, or it has only one member left")
    return found
