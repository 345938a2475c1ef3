"""The content of the class page: table rows, statistics, common faults, checks, isolation levels. `pages` makes HTML of it."""

from __future__ import annotations

import itertools
import re
import statistics
import unicodedata
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from urllib.parse import quote

from grader.base.text import printable
from grader.engine.results import Result
from grader.people.final_grade import FinalGrade, Person, graded
from grader.report import words
from grader.report.adjusted import explained, is_composed
from grader.report.items import ItemAnalysis, items
from grader.report.similarity import Pair, pairs

_BINS = 10
"""Number of histogram bins. All have the same width; the last one includes the maximum."""
_SINGLE = ("grader", "rubric_sha256", "traces_sha256", "mujoco")  # comparable results have one of each
_LABELS = {
    "grader": "imugrade",
    "rubric_sha256": "rubrics",
    "traces_sha256": "trace bundles",
    "mujoco": "MuJoCo versions",
}


@dataclass(frozen=True)
class Cell:
    """Text of a cell of the class table, and the number by which the table sorts its column."""

    text: str
    key: float


_BLANK = Cell("–", -1.0)


@dataclass(frozen=True)
class Entry:
    """One row of the class table; `tags` are the filters that it matches. Most cells of a person without a submission are blank."""

    name: str
    section: str
    status: str
    tags: tuple[str, ...]
    criteria: tuple[Cell, ...]
    id: str = ""
    href: str = ""
    score: Cell = _BLANK
    bonus: Cell = _BLANK
    late: Cell = Cell("", -1.0)
    final: Cell = _BLANK
    explained: str = ""


@dataclass(frozen=True)
class Choice:
    """One choice of a filter: the tag of the rows that it shows, its text, and how many rows have this tag."""

    tag: str
    text: str
    count: int


@dataclass(frozen=True)
class Filter:
    """One drop-down list above the class table, which shows the rows that match the choices of all lists."""

    id: str
    title: str
    choices: tuple[Choice, ...]


@dataclass(frozen=True)
class HistogramBar:
    """One bar of the histogram of grades: its count, and its length in percent of the longest bar."""

    tag: str
    label: str
    count: int
    share: float


@dataclass(frozen=True)
class Link:
    text: str
    href: str


@dataclass(frozen=True)
class CommonFault:
    tag: str
    text: str
    who: tuple[Link, ...]


@dataclass(frozen=True)
class CheckRow:
    """A check's item analysis (how hard it is), its criterion's title, and the filter tag of submissions that lost points on it."""

    item: ItemAnalysis
    tag: str
    criterion: str
    title: str


@dataclass(frozen=True)
class ClassTable:
    """The table of a class with its filters, and the faults and checks that the filters name.

    Attributes
    ----------
    columns
        Titles of the criteria by id.
    top
        The maximum score.
    numbers
        A short number for each filter tag: with full names, the page of a class of thousands would be much larger.
    """

    entries: Sequence[Entry]
    columns: Mapping[str, str]
    top: float
    faults: Sequence[CommonFault]
    checks: Sequence[CheckRow]
    filters: Sequence[Filter]
    numbers: Mapping[str, int]

    @property
    def sections(self) -> bool:
        return any(entry.section for entry in self.entries)

    @property
    def bonuses(self) -> bool:
        return any(entry.bonus.key >= 0 for entry in self.entries)

    @property
    def lates(self) -> bool:
        return any(entry.late.text for entry in self.entries)

    @property
    def finals(self) -> bool:
        return any(entry.final != entry.score for entry in self.entries)


@dataclass(frozen=True)
class SimilarPair:
    first: Link
    second: Link
    pair: Pair


_PLAIN = str.maketrans({"ł": "l", "ø": "o", "đ": "d", "ı": "i", "æ": "ae", "œ": "oe", "ð": "d", "þ": "th"})
"""Letters that Unicode does not decompose into a base letter and an accent, and where they are sorted."""


def href(id_: str) -> str:
    return f"submissions/{quote(id_)}/report.html"


def link(final_grade: FinalGrade) -> Link:
    return Link(words.distinct(final_grade), href(final_grade.id))


def class_table(final_grades: Collection[FinalGrade], absent: Sequence[Person] = ()) -> ClassTable:
    """Return the table of a class: its submissions, and the people of the roster without one (`absent`)."""
    results = [each.result for each in final_grades]
    titles, top = columns(results), max((result.max_score for result in results), default=100.0)
    rows = entries(final_grades, absent, titles, top)
    faults, listed = common_faults(final_grades), checks(results, titles)
    numbers = {tag: number for number, tag in enumerate(dict.fromkeys(tag for each in rows for tag in each.tags))}
    return ClassTable(rows, titles, top, faults, listed, filters(rows, faults, listed), numbers)


def columns(results: Iterable[Result]) -> dict[str, str]:
    """Return the titles of the criteria, by id, which head the columns of the class table, in order of first appearance."""
    titles: dict[str, str] = {}
    for result in results:
        for criterion in result.criteria:
            titles.setdefault(criterion.id, printable(criterion.title, 80))
    return titles


def entries(
    final_grades: Iterable[FinalGrade], absent: Sequence[Person], criteria: Collection[str], top: float
) -> list[Entry]:
    """Return the rows of the class table, sorted by name: submissions, and people of the roster without one.

    `criteria` are the columns, and `top` is the maximum score, from which a row's bin in the histogram follows.
    """
    known = list(final_grades)
    names = words.absentees(absent, (each.hand_in for each in known))
    nobody, blank = words.NO_SUBMISSION, (_BLANK,) * len(criteria)
    rows = [
        Entry(printable(name, words.NAME_LIMIT), printable(person.section, 80), nobody, (f"status:{nobody}",), blank)
        for name, person in zip(names, absent, strict=True)
    ]
    rows += [_entry(each, criteria, top) for each in known]
    return sorted(rows, key=lambda each: (by_name(each.name), each.id))


def _entry(final_grade: FinalGrade, criteria: Iterable[str], top: float) -> Entry:
    result, late = final_grade.result, final_grade.late
    points = {criterion.id: final_grade.points(criterion) for criterion in result.criteria}
    open_ = result.status == "incomplete" or final_grade.unseen or final_grade.has_no_submission
    score = None if open_ else result.score
    changes = (["repaired"] if result.repairs else []) + (["adjusted"] if final_grade.adjustments else [])
    return Entry(
        id=final_grade.id,
        name=words.distinct(final_grade),
        section=printable(final_grade.section, 80),
        href=href(final_grade.id),
        criteria=tuple(_cell(points.get(criterion)) for criterion in criteria),
        score=_cell(score),
        bonus=_cell(None if result.extra_credit_cap is None else result.extra_credit),
        late=Cell(words.late(final_grade), -1.0 if late is None else float(late.seconds or 0)),
        final=_cell(final_grade.final),
        explained=explained(final_grade) if is_composed(final_grade) else "",
        status=", ".join([words.status(final_grade), *changes]),
        tags=(*_tags(final_grade), *(f"score:{_bin(grade, top)}" for grade in graded([final_grade]))),
    )


def _cell(points: float | None) -> Cell:
    return _BLANK if points is None else Cell(words.number(points), points)


def _tags(final_grade: FinalGrade) -> Iterable[str]:
    """Return the tags by which the filters of the class table find a submission; they contain no text from outside the grader."""
    yield f"status:{words.status(final_grade)}"
    if final_grade.late is not None:
        yield "status:late"
    if final_grade.result.repairs:
        yield "status:repaired"
    if final_grade.adjustments:
        yield "status:adjusted"
    if final_grade.outdated():
        yield "status:outdated"
    yield from (f"fault:{id_}" for id_ in deducting(final_grade.result))
    if final_grade.result.status in ("empty", "unreadable"):
        return  # no check was run
    for criterion in final_grade.result.criteria:
        yield from (f"lost:{c.id}" for c in criterion.checks if c.points is not None and c.points < c.max_points)


def deducting(result: Result) -> list[str]:
    """Return the ids of faults in a submission's criteria, for the class page. Those in extensions cost at most extra credit."""
    of_criteria = {id_ for part in result.criteria for check in part.checks for id_ in check.misconceptions}
    of_extensions = {id_ for part in result.extensions for check in part.checks for id_ in check.misconceptions}
    return [id_ for id_ in result.misconceptions if id_ in of_criteria or id_ not in of_extensions]


def by_name(name: str) -> list[tuple[str, int]]:
    """Return a key that sorts people's names as a reader expects: without case and accents, and with numbers by value."""
    plain = unicodedata.normalize("NFKD", name.casefold().translate(_PLAIN))
    plain = "".join(char for char in plain if not unicodedata.combining(char))
    return [(text, int(digits or 0)) for text, digits in re.findall(r"([^0-9]*)([0-9]*)", plain)]


def filters(entries: Iterable[Entry], faults: Iterable[CommonFault], checks: Iterable[CheckRow]) -> list[Filter]:
    """Return the filters of the class table (status, fault, check), without choices and filters that match no row."""
    counts = Counter(tag for each in entries for tag in each.tags)
    wanted = {
        ("status", "Status"): [
            (tag, tag.removeprefix("status:")) for tag in sorted(counts) if tag.startswith("status:")
        ],
        ("fault", "Fault"): [(each.tag, each.text) for each in faults],
        ("check", "Lost points on"): [(each.tag, each.title) for each in checks],
    }
    found = [
        Filter(id_, title, tuple(Choice(tag, text, counts[tag]) for tag, text in tags if counts[tag]))
        for (id_, title), tags in wanted.items()
    ]
    return [each for each in found if each.choices]


def figures(grades: list[float]) -> list[tuple[str, str]]:
    if not grades:
        return []
    return [
        ("mean of graded", words.number(round(statistics.fmean(grades), 1))),
        ("median", words.number(round(statistics.median(grades), 1))),
        ("lowest", words.number(min(grades))),
        ("highest", words.number(max(grades))),
    ]


def bars(grades: list[float], top: float) -> list[HistogramBar]:
    """Return the histogram of the grades in bins of equal width, highest first; grades beyond 0 or `top` are in the end bins."""
    counts = Counter(_bin(grade, top) for grade in grades)
    tallest = max(counts.values(), default=1)
    edges = [words.number(round(place * top / _BINS, 2)) for place in range(_BINS + 1)]
    labels = [f"{low}–{high}" for low, high in itertools.pairwise(edges)]
    return [
        HistogramBar(f"score:{i}", label, counts[i], round(100 * counts[i] / tallest, 1))
        for i, label in enumerate(labels)
    ][::-1]


def _bin(grade: float, top: float) -> int:
    """Return the index of a grade's bin. A grade on an edge belongs to the higher bin."""
    return min(max(int(_BINS * grade / (top or 1.0) + 1e-9), 0), _BINS - 1)


def common_faults(final_grades: Iterable[FinalGrade]) -> list[CommonFault]:
    """Return the faults of a class, the most frequent first, each with links to the submissions that have it."""
    who: dict[str, list[Link]] = {}
    for final_grade in final_grades:
        for id_ in deducting(final_grade.result):
            who.setdefault(id_, []).append(link(final_grade))
    ranked = sorted(who.items(), key=lambda item: (-len(item[1]), item[0]))
    return [CommonFault(f"fault:{id_}", words.fault_in_words(id_), tuple(links)) for id_, links in ranked]


def checks(results: list[Result], titles: Mapping[str, str]) -> list[CheckRow]:
    return [
        CheckRow(item, f"lost:{item.id}", titles.get(item.id.split(".")[0], ""), printable(item.title, 300))
        for item in items(results)
    ]


def similar_pairs(
    final_grades: Mapping[str, FinalGrade], fingerprints: Mapping[str, tuple[int, ...]], given: frozenset[int]
) -> list[SimilarPair]:
    known = {id_: hashes for id_, hashes in fingerprints.items() if id_ in final_grades}
    return [SimilarPair(link(final_grades[p.first]), link(final_grades[p.second]), p) for p in pairs(known, given)]


def isolation(final_grades: Iterable[FinalGrade]) -> list[tuple[str, int]]:
    """Return how safely the class's code ran: each isolation level with its number of submissions, the most frequent first.

    Submissions that are empty or unreadable do not count.
    """
    provenances = (each.result.provenance for each in final_grades if each.result.status not in ("empty", "unreadable"))
    return Counter(printable(str(each.get("isolation", "not known")), 40) for each in provenances).most_common()


def mixtures(results: Iterable[Result]) -> list[str]:
    """Return what makes results hard to compare, as ``2 rubrics``: unlike grader, rubric, traces or MuJoCo; [] if none is."""
    found: dict[str, set[object]] = {key: set() for key in _SINGLE}
    for result in results:
        for key in _SINGLE:
            if result.provenance.get(key):
                found[key].add(result.provenance[key])
    return [f"{len(values)} {_LABELS[key]}" for key, values in found.items() if len(values) > 1]
