"""What an instructor sees of a class: rows, figures, mistakes, checks, machines and times; no rendering."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from urllib.parse import quote

from grader.engine.results import Result
from grader.ground.text import printable
from grader.people.standing import Standing
from grader.report import words
from grader.report.items import Item, items
from grader.report.similarity import Pair, pairs

_SLOWEST = 5
_SINGLE = ("grader", "rubric_sha256", "traces_sha256", "mujoco")  # one run has one of each
_LABELS = {
    "grader": "imugrade",
    "rubric_sha256": "rubrics",
    "traces_sha256": "trace bundles",
    "mujoco": "MuJoCo versions",
}


@dataclass(frozen=True)
class Cell:
    """What is shown and what it is sorted by."""

    text: str
    key: float


@dataclass(frozen=True)
class Entry:
    """One row of the class table; `tags` are what it can be filtered by."""

    name: str
    section: str
    href: str
    criteria: tuple[Cell, ...]
    score: Cell
    final: Cell
    late: Cell
    status: str
    tags: tuple[str, ...]


@dataclass(frozen=True)
class Choice:
    """One way to filter: the tag, how it is called, how many rows have it."""

    tag: str
    text: str
    count: int


@dataclass(frozen=True)
class Bar:
    """One bar of the distribution, in the units of the drawing; 600 wide, 120 high."""

    x: float
    y: float
    height: float
    count: int
    label: str


@dataclass(frozen=True)
class Link:
    text: str
    href: str


@dataclass(frozen=True)
class Mistake:
    tag: str
    text: str
    who: tuple[Link, ...]


@dataclass(frozen=True)
class CheckRow:
    """An item with the criterion's title and the tag of those who lost it."""

    item: Item
    tag: str
    criterion: str
    title: str


@dataclass(frozen=True)
class Alike:
    first: Link
    second: Link
    pair: Pair


@dataclass(frozen=True)
class Timing:
    """Seconds a submission, and where they were marked."""

    median_s: float
    most_s: float
    total_s: float
    slowest: tuple[tuple[Link, float], ...]
    isolation: tuple[tuple[str, int], ...]


def href(id_: str) -> str:
    return f"submissions/{quote(id_)}/report.html"


def link(standing: Standing) -> Link:
    return Link(words.person(standing), href(standing.id))


def columns(results: Iterable[Result]) -> dict[str, str]:
    """Titles of all criteria by id, in the order in which they are first met."""
    titles: dict[str, str] = {}
    for result in results:
        for criterion in result.criteria:
            titles.setdefault(criterion.id, printable(criterion.title, 80))
    return titles


def entry(standing: Standing, criteria: Iterable[str]) -> Entry:
    points = {criterion.id: standing.points(criterion) for criterion in standing.result.criteria}
    late = standing.late
    return Entry(
        name=words.person(standing),
        section=printable(standing.section, 80),
        href=href(standing.id),
        criteria=tuple(_cell(points.get(criterion)) for criterion in criteria),
        score=_cell(None if standing.result.status == "incomplete" else standing.result.score),
        final=_cell(standing.final),
        late=Cell(words.late(standing), -1.0 if late is None else float(late.seconds or 0)),
        status=", ".join([standing.result.status, *(["adjusted"] if standing.adjustments else [])]),
        tags=tuple(_tags(standing)),
    )


def _cell(points: float | None) -> Cell:
    return Cell("–", -1.0) if points is None else Cell(words.number(points), points)


def _tags(standing: Standing) -> Iterable[str]:
    """Neither names nor other words of strangers are tags, but for sections, which are numbered by the page."""
    yield f"status:{standing.result.status}"
    if standing.late is not None:
        yield "status:late"
    if standing.adjustments:
        yield "status:adjusted"
    if standing.outdated():
        yield "status:outdated"
    yield from (f"mistake:{id_}" for id_ in standing.result.misconceptions)
    for criterion in standing.result.criteria:
        yield from (f"lost:{c.id}" for c in criterion.checks if c.points is not None and c.points < c.max_points)


def choices(
    entries: Iterable[Entry], mistakes: Iterable[Mistake], checks: Iterable[CheckRow]
) -> dict[str, list[Choice]]:
    """The groups of the filter, each with those of its tags that any row has."""
    counts = Counter(tag for each in entries for tag in each.tags)
    groups = {
        "Status": [(tag, tag.removeprefix("status:")) for tag in sorted(counts) if tag.startswith("status:")],
        "Made the mistake": [(each.tag, each.text) for each in mistakes],
        "Lost points on": [(each.tag, each.title) for each in checks],
    }
    filled = {
        group: [Choice(tag, text, counts[tag]) for tag, text in tags if counts[tag]] for group, tags in groups.items()
    }
    return {group: found for group, found in filled.items() if found}


def figures(scores: list[float]) -> list[tuple[str, str]]:
    if not scores:
        return []
    return [
        ("mean", words.number(round(statistics.fmean(scores), 1))),
        ("median", words.number(round(statistics.median(scores), 1))),
        ("lowest", words.number(min(scores))),
        ("highest", words.number(max(scores))),
    ]


def bars(scores: list[float], top: float) -> list[Bar]:
    """Ten bars over 0 … `top`."""
    width = top / 10 or 1.0
    counts = Counter(min(int(score / width), 9) for score in scores)
    tallest = max(counts.values(), default=1)
    heights = [round(120 * counts[i] / tallest, 1) for i in range(10)]
    labels = [f"{words.number(i * width)}–{words.number((i + 1) * width)}" for i in range(10)]
    return [Bar(60.0 * i, 120 - heights[i], heights[i], counts[i], labels[i]) for i in range(10)]


def mistakes(standings: Iterable[Standing]) -> list[Mistake]:
    """What was misunderstood, by how many (most first), and who."""
    who: dict[str, list[Link]] = {}
    for standing in standings:
        for id_ in standing.result.misconceptions:
            who.setdefault(id_, []).append(link(standing))
    ranked = sorted(who.items(), key=lambda item: (-len(item[1]), item[0]))
    return [Mistake(f"mistake:{id_}", words.misconception(id_), tuple(links)) for id_, links in ranked]


def checks(results: list[Result], titles: Mapping[str, str]) -> list[CheckRow]:
    return [
        CheckRow(item, f"lost:{item.id}", titles.get(item.id.split(".")[0], ""), printable(item.title, 300))
        for item in items(results)
    ]


def alike(
    standings: Mapping[str, Standing], fingerprints: Mapping[str, tuple[int, ...]], given: frozenset[int]
) -> list[Alike]:
    known = {id_: hashes for id_, hashes in fingerprints.items() if id_ in standings}
    return [Alike(link(standings[p.first]), link(standings[p.second]), p) for p in pairs(known, given)]


def timing(standings: Iterable[Standing]) -> Timing | None:
    marked = [each for each in standings if each.result.status not in ("empty", "unreadable")]
    if not marked:
        return None
    seconds = [each.result.duration_s for each in marked]
    slowest = sorted(marked, key=lambda each: (-each.result.duration_s, each.id))[:_SLOWEST]
    isolation = Counter(printable(str(each.result.provenance.get("isolation", "not known")), 40) for each in marked)
    return Timing(
        statistics.median(seconds),
        max(seconds),
        sum(seconds),
        tuple((link(each), each.result.duration_s) for each in slowest),
        tuple(isolation.most_common()),
    )


def mixtures(results: Iterable[Result]) -> list[str]:
    """What the marks of one class should not differ in, and do."""
    found: dict[str, set[object]] = {key: set() for key in _SINGLE}
    for result in results:
        for key in _SINGLE:
            if result.provenance.get(key):
                found[key].add(result.provenance[key])
    return [f"{len(values)} {_LABELS[key]}" for key, values in found.items() if len(values) > 1]
