"""HTML pages: `report.html` for one submission, `index.html` for a class. Each is one file that loads nothing else."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from grader.base.package_data import beside
from grader.base.text import printable
from grader.engine.chart_data import Chart
from grader.engine.faults import FaultRow
from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, LabName, Result
from grader.people.final_grade import FinalGrade, Person, graded
from grader.report import adjusted, charts, overview, words
from grader.report.deductions import anchor, deductions

_TEMPLATES = beside(__package__, "templates")
AT_ONCE = 200
"""Rows of the class table that are shown before "Show all": laying out thousands takes a browser seconds."""
_TOLD = {  # without the seed and without a digest of traces, with which guesses of a secret could be tested
    "grader": "imugrade",
    "python": "Python",
    "mujoco": "MuJoCo",
    "numpy": "NumPy",
    "scipy": "SciPy",
    "matplotlib": "matplotlib",
    "isolation": "Isolation",
    "rubric_sha256": "Rubric",
    "submission_sha256": "Submission",
}
_LIBRARIES = ("Python", "MuJoCo", "NumPy", "SciPy", "matplotlib")


@dataclass(frozen=True)
class DrawnChart:
    """A chart laid out for the template: panels (`views`) to write as SVG, or a picture `png` in base64, "" if there are panels."""

    title: str
    caption: str
    width: int
    height: int
    views: tuple[charts.PanelView, ...]
    png: str


Rows = tuple[tuple[str, words.CheckText], ...]
"""Formatted checks, each with its anchor."""


@dataclass(frozen=True)
class PartOnPage:
    """A criterion or an extension on a student's report page; `share` is the percentage of its points that were earned.

    `folded` is the HTML of the closed lists: checks that were not graded, and checks that passed.
    """

    id: str
    title: str
    points: str
    share: float
    unjudged: bool
    rows: Rows
    folded: Markup
    figures: Markup


Drawn = Mapping[str, str]
"""HTML of the charts of each part, by the part's id."""


def drawn(shown: Iterable[Chart]) -> Drawn:
    """Return charts as HTML (SVG or an embedded PNG) by the id of their criterion or extension; ids without charts are left out."""
    macros: Any = _environment().get_template("charts.html.j2").module
    found: dict[str, str] = {}
    for chart in shown:
        if (views := charts.views(chart)) or chart.png:
            set_ = DrawnChart(chart.title, chart.caption, charts.WIDTH, charts.HEIGHT, views, chart.png)
            found[chart.part] = found.get(chart.part, Markup()) + macros.figure(set_)
    return found


def report_page(
    final_grade: FinalGrade, shown: tuple[Chart, ...] = (), catalogue: Mapping[str, FaultRow] | None = None
) -> str:
    """Return `report.html`, the report for one student.

    Parameters
    ----------
    final_grade
        The result, with overrides and lateness.
    shown
        Charts of what the submission did, without data of hidden scenarios, which students must not see; () for none.
    catalogue
        The lab's faults, by id, for titles and explanations; None: a fault's title is its id in words, without explanation.
    """
    figures = drawn(shown)
    result = final_grade.result
    extensions = [extension for extension in result.extensions if extension.checks]
    return rendered(
        "report.html.j2",
        "among.js",
        result.lab,
        name=words.person(final_grade),
        section=printable(final_grade.section, 80),
        total=adjusted.total(final_grade),
        automatic=words.total_points(result)
        if adjusted.is_changed(final_grade) and not final_grade.has_no_submission
        else "",
        explained=adjusted.explained(final_grade) if adjusted.is_composed(final_grade) else "",
        late=adjusted.late(final_grade),
        overrides=adjusted.overrides(final_grade),
        repairs=[adjusted.repaired_file(each) for each in result.repairs],
        score_before=words.number(result.repairs[0].score_before) if result.repairs else "",
        status=words.STATUS[result.status],
        parts=[_criterion(criterion, final_grade, figures) for criterion in result.criteria],
        extensions=[_extension(extension, result.lab, figures) for extension in extensions],
        deductions=deductions(result, catalogue or {}),
        marked=result.status not in ("empty", "unreadable"),
        charts=bool(figures),
        request_id=printable(final_grade.id, 200),  # a student's own `check` has none, and no form
        request_checks=[(c.id, printable(c.title, 120)) for part in result.criteria for c in part.checks],
        extra_credit=words.extra_credit(result),
        notes=[*words.notes(result), *_versions_of_errors(result)],
        guide=words.GUIDE,
        provenance=_provenance(result),
    )


def index_page(
    final_grades: Mapping[str, FinalGrade],
    fingerprints: Mapping[str, tuple[int, ...]] | None = None,
    given: frozenset[int] = frozenset(),
    absent: Sequence[Person] = (),
    contradictions: Sequence[str] = (),
) -> str:
    """Return `index.html`, the class page.

    Parameters
    ----------
    final_grades
        Every submission, by its id, which is its folder's name.
    fingerprints
        Code hashes of each submission, by id, for similarity.
    given
        Hashes of code that the lab hands out.
    absent
        People of the roster without a submission.
    contradictions
        A sentence on each grade that cannot be right as it stands, such as an override above its maximum.
    """
    results = [final_grade.result for final_grade in final_grades.values()]
    grades = graded(final_grades.values())
    table = overview.class_table(final_grades.values(), absent)
    return rendered(
        "index.html.j2",
        "table.js",
        next((result.lab for result in results), LabName()),
        count=words.submissions(final_grades.values()),
        figures=overview.figures(grades),
        bars=overview.bars(grades, table.top),
        table=table,
        at_once=AT_ONCE,
        alike=overview.similar_pairs(final_grades, fingerprints or {}, given),
        isolation=overview.isolation(final_grades.values()),
        mixtures=overview.mixtures(results),
        contradictions=contradictions,
        attention=[words.distinct(each) for each in final_grades.values() if each.result.status == "incomplete"],
        outdated=[words.distinct(each) for each in final_grades.values() if each.outdated()],
    )


def rendered(
    template: str, script: str | None, lab: LabName, *, more_style: str | None = None, **values: object
) -> str:
    """Return a page: the template filled with `values` and the names of `lab`; style and script are inside the page.

    `template`, `script` and `more_style` (added to the common style) are files in the folder of templates. The page's security
    policy forbids browsers to load anything else.
    """
    style, style_hash = _inlined("style.css", *([more_style] if more_style else []))
    text, script_hash = _inlined(script) if script else (Markup(), "")
    policy = f"default-src 'none'; style-src '{style_hash}'; img-src data:"
    policy += f"; script-src '{script_hash}'" if script else ""
    values |= {"policy": Markup(f"{policy}; base-uri 'none'; form-action 'none'"), "style": style, "script": text}
    return _environment().get_template(template).render(lab=lab.label, lab_title=lab.title, **values)


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
def _inlined(*names: str) -> tuple[Markup, str]:
    """Return template files as one text, and its hash for the page's Content-Security-Policy, which allows nothing else."""
    text = "".join((_TEMPLATES / name).read_text(encoding="utf-8") for name in names)
    digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
    return Markup(text), f"sha256-{digest}"


def _criterion(criterion: CriterionResult, final_grade: FinalGrade, figures: Drawn) -> PartOnPage:
    """Return what the report shows of a criterion: final points with overrides, its checks, and its charts."""
    points = final_grade.points(criterion)
    share = 100 * (criterion.points if points is None else points) / (criterion.max_points or 1.0)
    rows, folded = _rows(criterion.checks, criterion.id, final_grade.result.lab)
    shown_points = words.fraction(points, criterion.max_points)
    title = printable(criterion.title, 300)
    set_ = Markup(figures.get(criterion.id, ""))
    return PartOnPage(criterion.id, title, shown_points, round(share, 1), points is None, rows, folded, set_)


def _extension(extension: ExtensionResult, lab: LabName, figures: Drawn) -> PartOnPage:
    share = round(100 * extension.points / extension.max_points, 1) if extension.max_points else 0.0
    rows, folded = _rows(extension.checks, extension.id, lab)
    title = printable(extension.id.replace("_", " ").capitalize(), 300)
    set_ = Markup(figures.get(extension.id, ""))
    return PartOnPage(extension.id, title, words.extension_points(extension), share, False, rows, folded, set_)


def _rows(checks: Sequence[CheckResult], part: str, lab: LabName) -> tuple[Rows, Markup]:
    """Return what the report shows of checks: rows for those with feedback, and the HTML of folded lists for the others."""
    rows = [(check.outcome, (anchor(check), words.row(check, part, lab))) for check in checks]
    headings = {"skipped": "not graded", "passed": "passed"}
    folded = {said: tuple(row for outcome, row in rows if outcome == of) for of, said in headings.items()}
    telling = tuple(row for outcome, row in rows if outcome not in headings)
    return telling, Markup().join(
        _folded(f"{words.counted(len(of), 'check')} {said}", of) for said, of in folded.items() if of
    )


@lru_cache(maxsize=1024)
def _folded(heading: str, rows: Rows) -> Markup:
    """Render a folded list of checks. It is cached because most reports of a class contain the same ones."""
    macros: Any = _environment().get_template("checks.html.j2").module
    return Markup(macros.folded(heading, rows))


def _versions_of_errors(result: Result) -> list[str]:
    """Return a note with the versions under which code raised an error: it may run with others. [] if no code raised."""
    checks = [check for part in result.parts for check in part.checks]
    if not any(check.outcome == "error" or "does-not-import" in check.misconceptions for check in checks):
        return []
    told = ", ".join(f"{label} {value}" for label, value in _provenance(result) if label in _LIBRARIES)
    return [
        f"Code raised an error here with {told}. If it works on your computer, compare: imugrade doctor lists your versions."
    ]


def _provenance(result: Result) -> list[tuple[str, str]]:
    known = [(label, result.provenance[key]) for key, label in _TOLD.items() if result.provenance.get(key)]
    return [(label, printable(str(value), 80)[: 16 if len(str(value)) == 64 else None]) for label, value in known]
