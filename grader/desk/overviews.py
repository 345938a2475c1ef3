"""The page of what needs a look, the page of everybody, and ticks."""

from __future__ import annotations

from collections import Counter
from urllib.parse import quote

from starlette.responses import RedirectResponse, Response

from grader.desk.asking import Ask
from grader.desk.classbook import Classbook
from grader.desk.rendering import page
from grader.desk.review_queue import KINDS, Look, looks
from grader.ground.errors import RequestError


def all_looks(book: Classbook) -> list[Look]:
    """Every reason to look, made anew only when what it follows from has changed."""
    facts = (book.standings(), book.alikes().cliques, book.store.told(), book.appeals(), book.store.ticks())
    return book.once("looks", facts, lambda: looks(*facts))


def needs_a_look(book: Classbook, ask: Ask) -> Response:
    """The first page: every reason that nobody has ticked, and below it those that somebody has."""
    found = all_looks(book)
    kind = ask.text("kind") if ask.text("kind") in KINDS else ""
    open_ = [each for each in found if each.tick is None]
    return framed(
        book,
        ask,
        "looks.html.j2",
        open=[each for each in open_ if kind in ("", each.reason.kind)],
        done=[each for each in found if each.tick is not None and kind in ("", each.reason.kind)],
        kind=kind,
        kinds=KINDS,
        counts=Counter(each.reason.kind for each in open_),
        absent=book.store.told().get("absent", []),
    )


def everybody(book: Classbook, ask: Ask) -> Response:
    waiting = Counter(id_ for each in all_looks(book) if each.tick is None for id_ in each.ids)
    return framed(book, ask, "class.html.j2", waiting=waiting)


def tick(book: Classbook, ask: Ask) -> Response:
    """Somebody has looked at one reason or at several, or takes that back."""
    known = {each.key: each for each in all_looks(book)}
    looked = [known.get(key) for key in ask.all("look")]
    found = [(each.id, each.reason.kind, each.reason.about) for each in looked if each]
    if not found or len(found) < len(looked):
        raise RequestError("That is no longer a reason to look: the record has changed. Load the page again")
    book.tick(found, ask.author, done=ask.text("done") == "yes")
    if ask.text("back") in book.standings():
        return RedirectResponse(f"/submission/{quote(ask.text('back'), safe='')}", 303)
    return RedirectResponse(f"/?kind={ask.text('kind')}" if ask.text("kind") in KINDS else "/", 303)


def framed(book: Classbook, ask: Ask, template: str, **values: object) -> Response:
    """A page with what stands around all of them."""
    standings = book.standings()
    lab = next((each.result.lab for each in standings.values()), None)
    frame = {"standings": standings, "lab": lab.label if lab else "", "author": ask.author, "trouble": book.trouble}
    return page(template, 200, **(frame | values))
