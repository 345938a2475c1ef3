"""The pages: `report.html` for one submission, `index.html` for a class. One file each; nothing is fetched."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from grader.engine.evidence import Chart
from grader.engine.mistakes import Mistake
from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, LabName, Result
from grader.ground.package_data import beside
from grader.ground.text import printable
from grader.people.standing import Standing
from grader.report import causes, charts, overview, words
from grader.report.causes import Cause, causes_of, part_of

_TEMPLATES = beside(__package__, "templates")
_AT_ONCE = 200  # rows of a class that are laid out before all are asked for
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


Rows = tuple[tuple[str, words.Row], ...]
"""Checks as they are set, each with its anchor."""


@dataclass(frozen=True)
class Part:
    """A criterion or an extension as a page shows it; `share` is the earned part in percent.

    `folded` are the rows that say nothing new, each group below its heading: what was not reached, and what was earned.
    """

    id: str
    title: str
    points: str
    share: float
    unjudged: bool
    rows: Rows
    folded: Markup
    figures: Markup


@dataclass(frozen=True)
class Told:
    """A check within its cause: with what it says that none before it has said."""

    anchor: str
    row: words.Row
    lines: tuple[words.Line, ...]


@dataclass(frozen=True)
class Loss:
    """What cost points, by its cause: what it is and why, each check that it cost, how to go on."""

    points: str
    title: str
    why: tuple[str, ...]
    checks: tuple[Told, ...]
    waiting: str
    going_on: tuple[words.Line, ...]


@dataclass(frozen=True)
class ByHand:
    """What a person gave, beside the automatic points, or said."""

    title: str
    points: str
    automatic: str
    comment: str
    author: str


Drawn = Mapping[str, str]
"""The charts of each part, by its id, as they stand in a page."""
_FIGURE, _FIGURE_ENDS, _SECTION = '<figure class="chart">', "</figure>\n", '<section id="'


def drawn(shown: Iterable[Chart]) -> Drawn:
    """Charts, set. By far the most of what a page costs."""
    macros: Any = _environment().get_template("charts.html.j2").module
    found: dict[str, str] = {}
    for chart in shown:
        if (views := charts.views(chart)) or chart.png:
            set_ = Figure(chart.title, chart.caption, charts.WIDTH, charts.HEIGHT, views, chart.png)
            found[chart.part] = found.get(chart.part, Markup()) + macros.figure(set_)
    return found


def drawn_in(page: str) -> Drawn:
    """The same, out of a page that has them. Words of a student hold no tag there."""
    found = {}
    for section in page.split(_SECTION)[1:]:
        starts, ends = section.find(_FIGURE), section.rfind(_FIGURE_ENDS)
        if 0 <= starts < ends:
            found[section.partition('"')[0]] = Markup(section[starts : ends + len(_FIGURE_ENDS)])
    return found


def report_page(
    standing: Standing, shown: tuple[Chart, ...] = (), catalogue: Mapping[str, Mistake] | None = None
) -> str:
    """`report.html`: everything that one student is told.

    Parameters
    ----------
    standing
        The result, and what stands beside it.
    shown
        Charts of what the submission answered; none of hidden scenarios.
    catalogue
        The lab's mistakes, to explain those that are named.
    """
    return report_around(drawn(shown), standing, catalogue)


def report_around(figures: Drawn, standing: Standing, catalogue: Mapping[str, Mistake] | None = None) -> str:
    """The same around charts that are drawn already."""
    result = standing.result
    extensions = [extension for extension in result.extensions if extension.checks]
    return _page(
        "report.html.j2",
        "among.js",
        result.lab,
        name=words.person(standing),
        section=printable(standing.section, 80),
        total=_total(standing),
        automatic=words.total_points(result) if _changed(standing) else "",
        late=_late(standing),
        by_hand=_by_hand(standing),
        status=words.STATUS[result.status],
        parts=[_criterion(criterion, standing, figures) for criterion in result.criteria],
        extensions=[_extension(extension, result.lab, figures) for extension in extensions],
        losses=_losses(result, catalogue or {}),
        marked=result.status not in ("empty", "unreadable"),
        charts=bool(figures),
        extra_credit=words.extra_credit(result),
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
    columns, top = overview.columns(results), max((result.max_score for result in results), default=100.0)
    entries = [overview.entry(standing, columns, top) for standing in standings.values()]
    mistakes = overview.mistakes(standings.values())
    checks = overview.checks(results, columns)
    return _page(
        "index.html.j2",
        "table.js",
        next((result.lab for result in results), LabName()),
        count=len(standings),
        figures=overview.figures(scores),
        bars=overview.bars(scores, top),
        columns=columns,
        entries=entries,
        at_once=_AT_ONCE,
        sections=any(entry.section for entry in entries),
        bonuses=any(result.extra_credit_cap is not None for result in results),
        finals=any(entry.final != entry.score for entry in entries),
        lates=any(entry.late.text for entry in entries),
        filters=overview.filters(entries, mistakes, checks),
        numbers=overview.numbers(entries),
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


def _criterion(criterion: CriterionResult, standing: Standing, figures: Drawn) -> Part:
    """With the points that count: those by hand, where a person gave some."""
    points = standing.points(criterion)
    share = 100 * (criterion.points if points is None else points) / (criterion.max_points or 1.0)
    rows, folded = _rows(criterion.checks, criterion.id, standing.result.lab)
    told = words.fraction(points, criterion.max_points)
    title = printable(criterion.title, 300)
    set_ = Markup(figures.get(criterion.id, ""))
    return Part(criterion.id, title, told, round(share, 1), points is None, rows, folded, set_)


def _extension(extension: ExtensionResult, lab: LabName, figures: Drawn) -> Part:
    share = round(100 * extension.points / extension.max_points, 1) if extension.max_points else 0.0
    rows, folded = _rows(extension.checks, extension.id, lab)
    title = printable(extension.id.replace("_", " ").capitalize(), 300)
    set_ = Markup(figures.get(extension.id, ""))
    return Part(extension.id, title, words.extension_points(extension), share, False, rows, folded, set_)


def _rows(checks: Sequence[CheckResult], part: str, lab: LabName) -> tuple[Rows, Markup]:
    """What has something to say, and what is folded below a heading."""

    rows = [(check.outcome, (_anchor(check), words.row(check, part, lab))) for check in checks]
    headings = {"skipped": "not reached", "passed": "earned"}
    folded = {said: tuple(row for outcome, row in rows if outcome == of) for of, said in headings.items()}
    telling = tuple(row for outcome, row in rows if outcome not in headings)
    return telling, Markup().join(_folded(f"{_many(len(of), 'check')} {said}", of) for said, of in folded.items() if of)


@lru_cache(maxsize=1024)
def _folded(heading: str, rows: Rows) -> Markup:
    """What was earned reads the same in most reports of a class."""
    macros: Any = _environment().get_template("checks.html.j2").module
    return Markup(macros.folded(heading, rows))


def _many(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _anchor(check: CheckResult) -> str:
    return check.id.replace(".", "-")


def _losses(result: Result, catalogue: Mapping[str, Mistake]) -> list[Loss]:
    """What cost points by its cause, the dearest first, each with the checks that it kept from being asked."""
    checks = [check for criterion in result.criteria for check in criterion.checks]
    found = causes_of(checks)
    waiting = _waiting(checks, found)
    dearest = sorted(found, key=lambda each: -words.points_lost((*each.checks, *waiting.get(each, ()))))
    losses = [_loss(cause, waiting.get(cause, []), result.lab, catalogue) for cause in dearest]
    alone = waiting.get(None, [])
    return [*losses, *([_unreached(alone)] if alone else [])]


def _waiting(checks: Iterable[CheckResult], found: Iterable[Cause]) -> dict[Cause | None, list[CheckResult]]:
    """What was not reached, by the first cause that its criterion lost points for; None where there is none."""
    first: dict[str, Cause] = {}
    for cause in found:
        for check in cause.checks:
            first.setdefault(part_of(check), cause)
    waiting: dict[Cause | None, list[CheckResult]] = {}
    for check in checks:
        if check.outcome == "skipped":
            waiting.setdefault(first.get(part_of(check)), []).append(check)
    return waiting


def _loss(cause: Cause, waiting: list[CheckResult], lab: LabName, catalogue: Mapping[str, Mistake]) -> Loss:
    named = [catalogue[each] for each in cause.mistakes if each in catalogue]
    title = _title(cause, named)
    told = tuple(
        Told(_anchor(check), words.row(check, part_of(check), lab), () if _says(title, lines) else tuple(lines))
        for check, lines in causes.told(cause)
    )
    return Loss(
        words.minus(words.points_lost((*cause.checks, *waiting))),
        title,
        tuple(mistake.explanation.strip() for mistake in named),
        told,
        _count(waiting),
        (*causes.going_on(cause, lab), causes.again(cause)),
    )


def _title(cause: Cause, named: Sequence[Mistake]) -> str:
    """What was done, where that has a name; where the name fits anywhere, what came in this submission."""
    if not named:
        known = [words.misconception(each) for each in cause.mistakes]
        return _sentence("; ".join(known)) if known else printable(cause.checks[0].title, 300)
    got = {line.text for check in cause.checks for line in words.row(check, "", LabName()).lines if line.label == "Got"}
    if all(mistake.group == "any" for mistake in named) and len(got) == 1 and got != {"none"}:
        return _sentence(got.pop().partition("\n")[0])
    return _sentence("; ".join(mistake.means for mistake in named))


def _says(title: str, lines: Iterable[words.Line]) -> bool:
    """Whether the title of a cause has said already what came: nobody has to read it twice."""
    return title in {_sentence(line.text) for line in lines if line.label == "Got"}


def _sentence(text: str) -> str:
    """With a capital, unless it begins with a name of the lab's."""
    return text[:1].upper() + text[1:] if text.partition(" ")[0].isalpha() else text


def _unreached(checks: list[CheckResult]) -> Loss:
    return Loss(words.minus(words.points_lost(checks)), "Not reached", (), (), _count(checks), ())


def _count(checks: Sequence[CheckResult]) -> str:
    """``5 checks, 14 points``"""
    points = words.number(round(words.points_lost(checks), 2))
    return f"{_many(len(checks), 'check')}, {points} points" if checks else ""


def _changed(standing: Standing) -> bool:
    """Whether what counts is not what was marked automatically."""
    return standing.final is not None and round(standing.final, 2) != round(standing.result.total, 2)


def _total(standing: Standing) -> tuple[str, str]:
    """What counts, and of how many: the final points where people or dates have changed them."""
    points, most = words.total_points(standing.result).split(" / ")
    return (words.number(standing.final or 0.0), most) if _changed(standing) else (points, most)


def _late(standing: Standing) -> tuple[str, str] | None:
    """What lateness takes off, and the instants that it follows from."""
    late = standing.late
    if late is None:
        return None
    facts = [
        words.late(standing),
        f"due {words.instant(late.due)}" if late.due else "",
        f"handed in {words.instant(standing.hand_in.submitted)}" if standing.hand_in.submitted else "",
        f"{_many(late.days, 'day')} begun" if late.days and not late.refused else "",
    ]
    return words.minus(standing.deduction) if standing.deduction else "0", "; ".join(filter(None, facts))


def _by_hand(standing: Standing) -> list[ByHand]:
    """Points and words of people, in the order in which they are on record."""
    titles = {
        criterion.id: (criterion.title, criterion.max_points, criterion.points)
        for criterion in standing.result.criteria
    }
    checks = [check for criterion in standing.result.criteria for check in criterion.checks]
    titles |= {check.id: (check.title, check.max_points, check.points or 0.0) for check in checks}
    found = []
    for given in standing.adjustments:
        title, most, automatic = titles.get(given.criterion, (given.criterion.capitalize(), 0.0, 0.0))
        points = "" if given.points is None else words.number(given.points)
        found.append(
            ByHand(
                printable(title, 300),
                f"{points} / {words.number(most)}" if points and most else points,
                words.number(automatic) if points and most else "",
                printable(given.comment, words.TEXT_LIMIT, newlines=True),
                printable(given.author, 80),
            )
        )
    return found


def _provenance(result: Result) -> list[tuple[str, str]]:
    known = [(label, result.provenance[key]) for key, label in _TOLD.items() if result.provenance.get(key)]
    return [(label, printable(str(value), 80)[: 16 if len(str(value)) == 64 else None]) for label, value in known]
