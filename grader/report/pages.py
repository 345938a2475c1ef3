"""The pages: `report.html` for one submission, `index.html` for a class. One file each, no script, nothing fetched."""

from __future__ import annotations

import base64
import hashlib
import statistics
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from urllib.parse import quote

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from grader import words
from grader.results import CriterionResult, ExtensionResult, Result
from grader.text import printable

_TEMPLATES = Path(__file__).parent / "templates"
_TOLD = {  # the seed is not among them: a report may be handed to a student
    "grader": "imugrade",
    "python": "Python",
    "mujoco": "MuJoCo",
    "numpy": "NumPy",
    "isolation": "Isolation",
    "rubric_sha256": "Rubric",
    "traces_sha256": "Traces",
    "submission_sha256": "Submission",
}


@dataclass(frozen=True)
class Part:
    """A criterion or an extension as a page shows it; `share` is the earned part in percent."""

    id: str
    title: str
    points: str
    share: float
    unjudged: bool
    rows: tuple[words.Row, ...]


@dataclass(frozen=True)
class Entry:
    """One row of the class table."""

    name: str
    href: str
    criteria: tuple[str, ...]
    total: str
    status: str


@dataclass(frozen=True)
class Bar:
    """One bar of the distribution, in the units of the drawing."""

    x: float
    y: float
    height: float
    count: int
    label: str


def report_page(result: Result) -> str:
    """`report.html`: everything that one student is told."""
    return _page(
        "report.html.j2",
        name=words.name(result),
        total=words.total_points(result).split(" / "),
        status=words.STATUS[result.status],
        parts=[_part(criterion) for criterion in result.criteria],
        extensions=[_part(extension) for extension in result.extensions if extension.checks],
        extra_credit=words.extra_credit(result),
        mistakes=words.mistakes(result),
        notes=words.notes(result),
        provenance=_provenance(result),
    )


def index_page(results: Mapping[str, Result]) -> str:
    """`index.html`: the class at a glance.

    Parameters
    ----------
    results
        The present result of each submission, by its id (which is its folder's name).
    """
    scores = [result.score for result in results.values() if result.status != "incomplete"]
    return _page(
        "index.html.j2",
        count=len(results),
        figures=_figures(scores),
        bars=_bars(scores, max((result.max_score for result in results.values()), default=100.0)),
        columns=_columns(results),
        entries=[_entry(id_, result, list(_columns(results))) for id_, result in results.items()],
        misconceptions=_misconceptions(results),
        attention=[words.name(result) for result in results.values() if result.status == "incomplete"],
    )


def _page(template: str, **values: object) -> str:
    style, digest = _style()
    return (
        _environment()
        .get_template(template)
        .render(style=style, style_hash=digest, lab=words.LAB, lab_title=words.LAB_TITLE, **values)
    )


@lru_cache(maxsize=1)
def _environment() -> Environment:
    return Environment(
        loader=FileSystemLoader(_TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


@lru_cache(maxsize=1)
def _style() -> tuple[Markup, str]:
    """The style sheet and its hash: the page's policy allows this sheet and nothing else."""
    text = (_TEMPLATES / "style.css").read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
    return Markup(text), f"sha256-{digest}"


def _part(part: CriterionResult | ExtensionResult) -> Part:
    rows = tuple(words.row(check, part.id) for check in part.checks)
    share = round(100 * part.points / part.max_points, 1) if part.max_points else 0.0
    if isinstance(part, CriterionResult):
        title, points, unjudged = part.title, words.criterion_points(part), words.unjudged(part)
    else:
        points = words.extension_points(part)
        title, unjudged = part.id.replace("_", " ").capitalize(), False
    return Part(part.id, printable(title, 300), points, share, unjudged, rows)


def _provenance(result: Result) -> list[tuple[str, str]]:
    known = [(label, result.provenance[key]) for key, label in _TOLD.items() if result.provenance.get(key)]
    return [(label, printable(str(value), 80)[: 16 if len(str(value)) == 64 else None]) for label, value in known]


def _columns(results: Mapping[str, Result]) -> dict[str, str]:
    """Titles of all criteria by id, in the order in which they are first met."""
    titles: dict[str, str] = {}
    for result in results.values():
        for criterion in result.criteria:
            titles.setdefault(criterion.id, printable(criterion.title, 80))
    return titles


def _entry(id_: str, result: Result, columns: list[str]) -> Entry:
    points = {c.id: "–" if words.unjudged(c) else words.number(c.points) for c in result.criteria}
    return Entry(
        name=words.name(result),
        href=f"submissions/{quote(id_)}/report.html",
        criteria=tuple(points.get(column, "–") for column in columns),
        total="–" if result.status == "incomplete" else words.number(result.score),
        status=result.status,
    )


def _figures(scores: list[float]) -> list[tuple[str, str]]:
    if not scores:
        return []
    return [
        ("mean", words.number(round(statistics.fmean(scores), 1))),
        ("median", words.number(round(statistics.median(scores), 1))),
        ("lowest", words.number(min(scores))),
        ("highest", words.number(max(scores))),
    ]


def _bars(scores: list[float], top: float) -> list[Bar]:
    """Ten bars over 0 … `top`, in a drawing 600 wide and 120 high above its base line."""
    width = top / 10 or 1.0
    counts = Counter(min(int(score / width), 9) for score in scores)
    tallest = max(counts.values(), default=1)
    heights = [round(120 * counts[i] / tallest, 1) for i in range(10)]
    labels = [f"{words.number(i * width)}–{words.number((i + 1) * width)}" for i in range(10)]
    return [Bar(60.0 * i, 120 - heights[i], heights[i], counts[i], labels[i]) for i in range(10)]


def _misconceptions(results: Mapping[str, Result]) -> list[tuple[str, int, list[tuple[str, str]]]]:
    """What was misunderstood, by how many (most first), and who."""
    who: dict[str, list[tuple[str, str]]] = {}
    for id_, result in results.items():
        for misconception in result.misconceptions:
            who.setdefault(misconception, []).append((words.name(result), f"submissions/{quote(id_)}/report.html"))
    ranked = sorted(who.items(), key=lambda item: (-len(item[1]), item[0]))
    return [(words.misconception(id_), len(names), names) for id_, names in ranked]
