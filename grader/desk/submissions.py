"""One submission: its report and its code side by side, what people said of it, and their points by hand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from urllib.parse import quote

from starlette.responses import RedirectResponse, Response

from grader.course import adjusting
from grader.course.adjusting import ALONE, Wish
from grader.course.record import Appeal
from grader.desk.asking import Ask
from grader.desk.classbook import Classbook, now
from grader.desk.code import Shelf, defined, named_lines, shelf, unshowable
from grader.desk.overviews import all_looks, framed
from grader.desk.review_queue import Look
from grader.engine.evidence import Chart
from grader.engine.results import CheckResult, CriterionResult, ExtensionResult
from grader.ground.errors import RequestError
from grader.ground.text import printable
from grader.people.standing import BONUS, TOTAL, Adjustment, Standing, summed, under, worth
from grader.report import charts, words
from grader.report.pages import Figure


@dataclass(frozen=True)
class Said:
    """What stands by hand on one thing: `points` in place of `automatic`, or words alone; and who said so."""

    target: str
    most: float
    automatic: float | None
    points: Adjustment | None
    comment: Adjustment | None
    covered: str = ""
    appeals: tuple[Appeal, ...] = ()

    @property
    def anchor(self) -> str:
        return self.target.replace(".", "-")


@dataclass(frozen=True)
class Place:
    """A line of a file that is shown."""

    path: str
    anchor: str
    line: int


@dataclass(frozen=True)
class Row:
    """One check: what was found, what stands by hand, and where in the code it points."""

    row: words.Row
    said: Said | None
    places: tuple[Place, ...]


@dataclass(frozen=True)
class Part:
    id: str
    title: str
    points: str
    said: Said | None
    rows: tuple[Row, ...]
    figures: tuple[Figure, ...]


def show(book: Classbook, ask: Ask) -> Response:
    standing = one(book, ask)
    looks = all_looks(book)
    history = book.history(standing.id)
    appeals = [each for each in book.appeals() if each.id == standing.id]
    kept = book.kept(standing)
    result = standing.result
    marked = result.status not in ("empty", "unreadable")
    parts: Sequence[CriterionResult | ExtensionResult] = [*result.criteria, *(e for e in result.extensions if e.checks)]
    named = named_lines((check for part in parts for check in part.checks), kept.files)
    files = shelf(kept, named)
    definitions = {each.id: list(defined(kept, each.names)) for each in (*book.lab.parts, *book.lab.bonuses)}
    code = _Code(files, named, definitions)
    shown = book.store.charts(standing.id)
    shown_parts = [_part(standing, part, code, shown, appeals) for part in parts]
    return framed(
        book,
        ask,
        "submission.html.j2",
        standing=standing,
        status=words.STATUS[result.status],
        late=words.late(standing),
        notes=words.notes(result),
        mistakes=[words.misconception(id_) for id_ in result.misconceptions],
        parts=shown_parts,
        keys=_keys(shown_parts if marked else (), appeals),
        marked=marked,
        whole=[_said(standing, target, appeals) for target in (TOTAL, BONUS)],
        files=files,
        looks=[each for each in looks if standing.id in each.ids],
        history=list(reversed(history)),
        told=adjusting.said,
        decisions=book.store.decisions(),
        seen=max((each.number for each in history), default=0),
        way=_way(list(book.standings()), standing.id, looks),
    )


def by_hand(book: Classbook, ask: Ask) -> Response:
    """Points, words alone, or the last word on something taken back."""
    standing = one(book, ask)
    target, points, comment = ask.text("target"), ask.text("points").replace(",", "."), ask.text("comment")
    if ask.text("do") in ("undo", "undo-comment"):
        wish = adjusting.undone(book.store, standing.id, target, alone=ask.text("do") == "undo-comment")
    elif ask.text("do") == "withdraw":
        wish = Wish(standing.id, target, "", comment or "withdrawn", place=standing.id)
    else:
        wish = Wish(standing.id, target, points or ALONE, comment, place=standing.id, alone=not points)
        if not comment:
            raise RequestError("Say why in a comment: nothing was recorded")
    book.decide([wish], ask.author, ask.number("seen"))
    if answers := ask.number("answers"):
        book.store.answer(answers, comment, ask.author, now())
    return RedirectResponse(f"/submission/{quote(standing.id, safe='')}#by-hand-{target.replace('.', '-')}", 303)


def picture(book: Classbook, ask: Ask) -> Response:
    """One of the pictures that were handed in: a PNG by its own first bytes, and nothing that a browser could run."""
    kept = book.kept(one(book, ask))
    place = int(ask.path["place"])
    contents = list(kept.files.values())
    if place >= len(contents) or unshowable(contents[place]):
        raise RequestError("There is no such picture")
    return Response(contents[place], media_type="image/png")


def one(book: Classbook, ask: Ask) -> Standing:
    standing = book.standings().get(ask.path["id"])
    if standing is None:
        raise RequestError("There is no such submission")
    return standing


@dataclass(frozen=True)
class _Code:
    """Where the code is that a row is about: the lines that checks name, and the definitions of each part."""

    shelf: Shelf
    named: Mapping[str, set[int]]
    defined: Mapping[str, Sequence[tuple[str, int]]]

    def places(self, check: CheckResult, part: str) -> tuple[Place, ...]:
        """Lines that the check names, or else the definition that the check is of."""
        mine = [(path, line) for path, lines in named_lines([check], self.named).items() for line in sorted(lines)]
        return tuple(
            Place(printable(path), anchor, line)
            for path, line in mine or self.defined.get(part, ())
            if (anchor := self.shelf.anchor(path))
        )


def _part(
    standing: Standing,
    part: CriterionResult | ExtensionResult,
    code: _Code,
    shown: Sequence[Chart],
    appeals: Sequence[Appeal],
) -> Part:
    lab = standing.result.lab
    figures = tuple(
        Figure(chart.title, chart.caption, charts.WIDTH, charts.HEIGHT, views, chart.png)
        for chart in shown
        if chart.part == part.id and ((views := charts.views(chart)) or chart.png)
    )
    by_hand = isinstance(part, CriterionResult)
    rows = tuple(
        Row(
            words.row(each, part.id, lab),
            _said(standing, each.id, appeals) if by_hand else None,
            code.places(each, part.id),
        )
        for each in part.checks
    )
    if isinstance(part, CriterionResult):
        points = words.fraction(standing.points(part), part.max_points)
        return Part(part.id, part.title, points, _said(standing, part.id, appeals), rows, figures)
    title = f"Extension: {part.id.replace('_', ' ')}"
    return Part(part.id, title, words.extension_points(part), None, rows, figures)


def _said(standing: Standing, target: str, appeals: Sequence[Appeal]) -> Said:
    comments = (each for each in standing.adjustments if each.alone and each.criterion == target)
    return Said(
        target,
        worth(standing.result, target) or 0.0,
        None if target == BONUS else summed(under(standing.result, target) or {}),
        standing.adjustment(target),
        next(comments, None),
        adjusting.covering(standing, target),
        tuple(each for each in appeals if (each.about or TOTAL) == target),
    )


def _keys(parts: Sequence[Part], appeals: Sequence[Appeal]) -> dict[str, str]:
    """The key that opens each form: ``m`` the total, ``o`` the bonus, ``b`` what most likely is decided on.

    That is what an appeal is about that nobody has answered, or else the first check that lost points, or else the total.
    """
    asked = [each.about or TOTAL for each in appeals if not each.answered]
    lost = [row.said.target for part in parts for row in part.rows if row.said and row.row.outcome.kind != "earned"]
    keys = {TOTAL: "m", BONUS: "o"}
    return keys | {first: f"b {keys.get(first, '')}".strip() for first in [*asked, *lost, TOTAL][:1]}


@dataclass(frozen=True)
class Way:
    """Whom to look at before and after this one, and next of those who need a look; "" where there is nobody."""

    place: int
    of: int
    previous: str
    next: str
    next_look: str


def _way(ids: Sequence[str], id_: str, looks: Sequence[Look]) -> Way:
    here = ids.index(id_)
    waiting = {id_ for each in looks if each.tick is None for id_ in each.ids}
    later = [each for each in (*ids[here + 1 :], *ids[:here]) if each in waiting]
    previous = ids[here - 1] if here else ""
    following = ids[here + 1] if here + 1 < len(ids) else ""
    return Way(here + 1, len(ids), previous, following, later[0] if later else "")
