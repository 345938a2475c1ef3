"""The pages: `report.html` for one submission, `index.html` for a class. One file each; nothing is fetched."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from grader.engine.evidence import Chart
from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, LabName, Result
from grader.ground.package_data import beside
from grader.ground.text import printable
from grader.people.standing import Standing
from grader.report import charts, overview, words

_TEMPLATES = beside(__package__, "templates")
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
class Figure:
    """A chart, ready to be set."""

    title: str
    caption: str
    width: int
    height: int
    views: tuple[charts.View, ...]
    png: str


@dataclass(frozen=True)
class Part:
    """A criterion or an extension as a page shows it; `share` is the earned part in percent."""

    id: str
    title: str
    points: str
    share: float
    unjudged: bool
    rows: tuple[tuple[str, words.Row], ...]
    figures: tuple[Figure, ...] = ()


@dataclass(frozen=True)
class Loss:
    """A check that lost points, for the list at the head of a report."""

    anchor: str
    title: str
    points: str
    hint: str


@dataclass(frozen=True)
class ByHand:
    """Points that a person gave, beside the automatic ones."""

    title: str
    points: str
    automatic: str
    comment: str
    author: str


def report_page(standing: Standing, shown: tuple[Chart, ...] = ()) -> str:
    """`report.html`: everything that one student is told.

    Parameters
    ----------
    standing
        The result, and what stands beside it.
    shown
        Charts of what the submission answered; none of hidden scenarios.
    """
    result = standing.result
    return _page(
        "report.html.j2",
        None,
        result.lab,
        name=words.person(standing),
        section=printable(standing.section, 80),
        total=words.total_points(result).split(" / "),
        final=_final(standing),
        late=words.late(standing),
        deduction=words.number(standing.deduction),
        by_hand=_by_hand(standing),
        status=words.STATUS[result.status],
        parts=[_part(criterion, shown, result.lab) for criterion in result.criteria],
        extensions=[_part(extension, shown, result.lab) for extension in result.extensions if extension.checks],
        losses=_losses(result),
        asked=any(check.outcome != "skipped" for criterion in result.criteria for check in criterion.checks),
        charts=bool(shown),
        extra_credit=words.extra_credit(result),
        mistakes=words.mistakes(result),
        notes=words.notes(result),
        provenance=_provenance(result),
    )


def index_page(
    standings: Mapping[str, Standing],
    fingerprints: Mapping[str, tuple[int, ...]] | None = None,
    given: frozenset[int] = frozenset(),
) -> str:
    """`index.html`: the class at a glance.

    Parameters
    ----------
    standings
        Of each submission, by its id (which is its folder's name).
    fingerprints
        Hashes of the code of each, by id, to tell which are alike.
    given
        Hashes of what the lab itself gives, which anyone may hand in.
    """
    results = [standing.result for standing in standings.values()]
    scores = [result.score for result in results if result.status != "incomplete"]
    columns = overview.columns(results)
    entries = [overview.entry(standing, columns) for standing in standings.values()]
    mistakes = overview.mistakes(standings.values())
    checks = overview.checks(results, columns)
    return _page(
        "index.html.j2",
        "table.js",
        next((result.lab for result in results), LabName()),
        count=len(standings),
        figures=overview.figures(scores),
        bars=overview.bars(scores, max((result.max_score for result in results), default=100.0)),
        columns=columns,
        entries=entries,
        sections=any(entry.section for entry in entries),
        finals=any(entry.final != entry.score for entry in entries),
        lates=any(entry.late.text for entry in entries),
        choices=overview.choices(entries, mistakes, checks),
        mistakes=mistakes,
        checks=checks,
        alike=overview.alike(standings, fingerprints or {}, given),
        timing=overview.timing(standings.values()),
        mixtures=overview.mixtures(results),
        attention=[words.person(each) for each in standings.values() if each.result.status == "incomplete"],
        outdated=[words.person(each) for each in standings.values() if each.outdated()],
    )


def _page(template: str, script: str | None, lab: LabName, **values: object) -> str:
    style, style_hash = _inlined("style.css")
    text, script_hash = _inlined(script) if script else (Markup(), "")
    policy = f"default-src 'none'; style-src '{style_hash}'; img-src data:"
    policy += f"; script-src '{script_hash}'" if script else ""
    return (
        _environment()
        .get_template(template)
        .render(
            style=style,
            script=text,
            policy=Markup(f"{policy}; base-uri 'none'; form-action 'none'"),
            lab=lab.label,
            lab_title=lab.title,
            **values,
        )
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


@lru_cache
def _inlined(name: str) -> tuple[Markup, str]:
    """One of our own files and its hash: a page's policy allows these and nothing else."""
    text = (_TEMPLATES / name).read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
    return Markup(text), f"sha256-{digest}"


def _part(part: CriterionResult | ExtensionResult, shown: tuple[Chart, ...], lab: LabName) -> Part:
    rows = tuple((_anchor(check), words.row(check, part.id, lab)) for check in part.checks)
    share = round(100 * part.points / part.max_points, 1) if part.max_points else 0.0
    if isinstance(part, CriterionResult):
        title, points, unjudged = part.title, words.criterion_points(part), words.unjudged(part)
    else:
        points = words.extension_points(part)
        title, unjudged = part.id.replace("_", " ").capitalize(), False
    figures = tuple(
        Figure(chart.title, chart.caption, charts.WIDTH, charts.HEIGHT, views, chart.png)
        for chart in shown
        if chart.part == part.id and ((views := charts.views(chart)) or chart.png)
    )
    return Part(part.id, printable(title, 300), points, share, unjudged, rows, figures)


def _anchor(check: CheckResult) -> str:
    return check.id.replace(".", "-")


def _losses(result: Result) -> list[Loss]:
    """What cost points, the dearest first; what was skipped comes last."""
    lost = [
        (check.max_points - check.points, check, words.row(check, criterion.id, result.lab))
        for criterion in result.criteria
        for check in criterion.checks
        if check.points is not None and check.points < check.max_points and check.outcome != "skipped"
    ]
    lost.sort(key=lambda each: -each[0])
    return [
        *(Loss(_anchor(check), row.title, _minus(points), _hint(row)) for points, check, row in lost),
        *_skipped(result),
    ]


def _skipped(result: Result) -> list[Loss]:
    """What could not be asked, in one line: it comes back with what it waits for."""
    checks = [check for criterion in result.criteria for check in criterion.checks if check.outcome == "skipped"]
    if not checks:
        return []
    points = sum(check.max_points for check in checks)
    count = f"{len(checks)} check{'s' * (len(checks) > 1)}"
    return [Loss(_anchor(checks[0]), f"{count} not reached", _minus(points), "Each names what it needs.")]


def _minus(points: float) -> str:
    return f"−{words.number(round(points, 2))}"


def _hint(row: words.Row) -> str:
    return next((line.text for line in row.lines if line.label == "Try"), "")


def _final(standing: Standing) -> str:
    """Empty where nothing but the automatic marks counts."""
    if standing.final is None or not (standing.adjustments or standing.late):
        return ""
    return words.fraction(standing.final, standing.result.max_score)


def _by_hand(standing: Standing) -> list[ByHand]:
    found = [(criterion, standing.adjustment(criterion.id)) for criterion in standing.result.criteria]
    return [
        ByHand(
            printable(criterion.title, 80),
            words.fraction(given.points, criterion.max_points),
            words.number(criterion.points),
            printable(given.comment, words.TEXT_LIMIT, newlines=True),
            printable(given.author, 80),
        )
        for criterion, given in found
        if given is not None and given.points is not None
    ]


def _provenance(result: Result) -> list[tuple[str, str]]:
    known = [(label, result.provenance[key]) for key, label in _TOLD.items() if result.provenance.get(key)]
    return [(label, printable(str(value), 80)[: 16 if len(str(value)) == 64 else None]) for label, value in known]
