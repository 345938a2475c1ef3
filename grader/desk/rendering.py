"""Templates of the review desk: one Jinja environment, which escapes hostile text, and its static files."""

from __future__ import annotations

from functools import cache
from urllib.parse import quote

from jinja2 import Environment, FileSystemLoader, StrictUndefined, pass_context
from jinja2.runtime import Context
from starlette.responses import HTMLResponse

from grader.base.package_data import beside
from grader.base.text import printable
from grader.people.final_grade import FinalGrade
from grader.people.late_policy import in_zone
from grader.report import words

STATIC = {
    "report.css": (beside("grader.report", "templates/style.css"), "text/css"),
    "desk.css": (beside(__package__, "static/desk.css"), "text/css"),
    "marking.css": (beside("grader.report", "templates/marking.css"), "text/css"),
    "table.js": (beside("grader.report", "templates/table.js"), "text/javascript"),
    "desk.js": (beside(__package__, "static/desk.js"), "text/javascript"),
}


def page(template: str, code: int = 200, /, **values: object) -> HTMLResponse:
    return HTMLResponse(environment().get_template(template).render(**values), code)


@cache
def environment() -> Environment:
    """Return the desk's only Jinja environment. It escapes all values, because pages show hostile text."""
    made = Environment(
        loader=FileSystemLoader([beside(__package__, "templates"), beside("grader.report", "templates")]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.globals["address"] = address
    made.filters |= {"points": points, "safe_text": safe_text, "address": address}
    made.filters |= {"person": words.distinct, "submissions": words.submissions}
    made.filters["instant"] = _instant
    return made


@pass_context
def _instant(context: Context, stamp: str) -> str:
    """Format a time by the clock of the class, which is that of its late policy, for a template."""
    return words.instant(in_zone(stamp, context.get("late_policy")))


def points(value: float | None) -> str:
    return "–" if value is None else words.number(value).replace("-", "−")


def safe_text(value: str, limit: int = 2000) -> str:
    """Return untrusted text without control characters, cut at `limit`. Jinja escapes it later."""
    return printable(value, limit, newlines=True)


def address(value: FinalGrade | str) -> str:
    """Return the address of the page of a submission, given by its grade or id."""
    return f"/submission/{quote(value if isinstance(value, str) else value.id, safe='')}"
