"""All who made the same mistake or lost the same checks: decided once, for all of them, and taken back in one go."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from urllib.parse import quote

from starlette.responses import RedirectResponse, Response

from grader.course import adjusting
from grader.course.adjusting import Wish
from grader.desk.asking import Ask
from grader.desk.classbook import Classbook
from grader.desk.overviews import framed
from grader.engine.results import CheckResult, Result
from grader.ground.errors import RequestError
from grader.ground.text import printable
from grader.people.standing import Adjustment, Standing
from grader.report import words

MISTAKE, CHECK, SAME = "mistake", "check", "same"


@dataclass(frozen=True)
class Group:
    """Who has something in common. `checks` are the lost ones that it is about, by id with their titles."""

    kind: str
    key: str
    title: str
    ids: tuple[str, ...]
    checks: Mapping[str, str]

    @property
    def address(self) -> str:
        return f"/groups/{self.kind}/{quote(self.key, safe='')}"

    @property
    def what(self) -> str:
        """What a decision on it is on."""
        return f"{ {MISTAKE: 'mistake', CHECK: 'lost', SAME: 'the same lost checks'}[self.kind] }: {self.title}"


@dataclass(frozen=True)
class Decision:
    """One decision on several: what on, what was said, and for how many of them it still is the last word."""

    number: int
    what: str
    said: str
    author: str
    at: str
    comment: str
    made: int
    in_force: int


def groups(standings: Mapping[str, Standing]) -> list[Group]:
    """Mistakes by how many made them, then checks, then those who lost exactly the same ones; each with two members or more."""
    mistakes: dict[str, dict[str, list[CheckResult]]] = {}
    checks: dict[str, dict[str, list[CheckResult]]] = {}
    same: dict[tuple[str, ...], dict[str, list[CheckResult]]] = {}
    for id_, standing in standings.items():
        lost = _lost(standing.result)
        for check in lost:
            checks.setdefault(check.id, {})[id_] = [check]
            for mistake in check.misconceptions:
                mistakes.setdefault(mistake, {}).setdefault(id_, []).append(check)
        if len(lost) > 1:
            same.setdefault(tuple(check.id for check in lost), {})[id_] = lost
    found = [
        *(_group(MISTAKE, id_, words.misconception(id_), members) for id_, members in mistakes.items()),
        *(_group(CHECK, id_, _titles(members), members) for id_, members in checks.items()),
        *(_group(SAME, _digest(ids), f"{len(ids)} checks: {', '.join(ids)}", members) for ids, members in same.items()),
    ]
    order = (MISTAKE, CHECK, SAME)
    several = [group for group in found if len(group.ids) > 1]
    return sorted(several, key=lambda group: (order.index(group.kind), -len(group.ids), group.title))


def show_all(book: Classbook, ask: Ask) -> Response:
    found = groups(book.standings())
    kinds = {MISTAKE: "The same mistake", CHECK: "The same lost check", SAME: "Exactly the same lost checks"}
    listed = {title: [group for group in found if group.kind == kind] for kind, title in kinds.items()}
    return framed(book, ask, "groups.html.j2", listed=listed, decisions=decisions(book))


def show(book: Classbook, ask: Ask) -> Response:
    group = _one(book, ask)
    standings = book.standings()
    members = [standings[id_] for id_ in group.ids]
    targets = [*group.checks, *dict.fromkeys(c.id for s in members for c in s.result.criteria), "total", "bonus"]
    return framed(
        book,
        ask,
        "group.html.j2",
        group=group,
        members=members,
        targets=targets,
        covering=adjusting.covering,
        checks_of=lambda standing: {c.id: c for part in standing.result.criteria for c in part.checks},
        seen=book.last_number(),
        decisions=[each for each in decisions(book) if each.what == printable(group.what, 200)],
    )


def decide(book: Classbook, ask: Ask) -> Response:
    """One decision for those of a group that were chosen."""
    group = _one(book, ask)
    chosen = [id_ for id_ in group.ids if id_ in set(ask.all("id"))]
    points, comment = ask.text("points").replace(",", "."), ask.text("comment")
    if not chosen or not comment:
        raise RequestError("Choose at least one of them and say why: nothing was recorded")
    wishes = [Wish(id_, ask.text("target"), points, comment, place=id_, alone=not points) for id_ in chosen]
    book.decide(wishes, ask.author, ask.number("seen"), printable(group.what, 200))
    return RedirectResponse(f"{group.address}#decisions", 303)


def take_back(book: Classbook, ask: Ask) -> Response:
    """All of one decision that is still the last word."""
    wishes = adjusting.undone_decision(book.store, ask.number("number") or 0)
    book.decide(wishes, ask.author, ask.number("seen"))
    return RedirectResponse("/groups#decisions", 303)


def decisions(book: Classbook) -> list[Decision]:
    """Every one that was made, the latest first."""
    made: dict[int, list[Adjustment]] = {}
    for _, each in book.store.history():
        if each.decision:
            made.setdefault(each.decision, []).append(each)
    in_force = [each.decision for standing in book.standings().values() for each in standing.adjustments]
    what = book.store.decisions()
    found = [
        Decision(
            number,
            what.get(number, ""),
            f"{rows[0].criterion} {adjusting.said(rows[0])}",
            rows[0].author,
            rows[0].at,
            rows[0].comment,
            len(rows),
            in_force.count(number),
        )
        for number, rows in made.items()
    ]
    return found[::-1]


def _one(book: Classbook, ask: Ask) -> Group:
    wanted = (ask.path["kind"], ask.path["key"])
    found = next((group for group in groups(book.standings()) if (group.kind, group.key) == wanted), None)
    if found is None:
        raise RequestError("There is no such group: the record has changed, or nobody else is in it any more")
    return found


def _lost(result: Result) -> list[CheckResult]:
    rows = (check for criterion in result.criteria for check in criterion.checks)
    return [check for check in rows if check.points is not None and check.points < check.max_points]


def _group(kind: str, key: str, title: str, members: Mapping[str, Sequence[CheckResult]]) -> Group:
    checks = {check.id: printable(check.title, 300) for lost in members.values() for check in lost}
    return Group(kind, key, title, tuple(members), checks)


def _titles(members: Mapping[str, Sequence[CheckResult]]) -> str:
    return next(printable(lost[0].title, 300) for lost in members.values())


def _digest(ids: Iterable[str]) -> str:
    return hashlib.sha256(" ".join(ids).encode()).hexdigest()[:16]
