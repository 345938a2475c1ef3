"""Export page: grades in the format of a platform, such as Canvas, and a zip of all reports, as downloads."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path

from starlette.responses import Response

from grader.base.errors import RequestError
from grader.course.publishing import exporting
from grader.course.publishing.contradictions import contradictions
from grader.course.publishing.exporting import Export, ExportPlan
from grader.course.record import class_settings
from grader.desk.classbook import Classbook
from grader.desk.overviews import framed
from grader.desk.web_requests import WebRequest
from grader.platforms import registry

_TEMPLATE = "template.csv"


def show(book: Classbook, web_request: WebRequest) -> Response:
    return _page(book, web_request)


def send(book: Classbook, web_request: WebRequest) -> Response:
    """Send the grades or, with `do=feedback`, the reports as a download.

    Show the form with errors if a field is wrong. Before grades are sent, show it also if some cannot be right, such as one above
    its maximum or without a row in the template, unless the person has ticked `anyway` to get the file all the same.
    """
    feedback = web_request.text("do") == "feedback"
    try:
        with tempfile.TemporaryDirectory() as folder:
            plan = exporting.plan(_order(book, web_request, Path(folder), feedback=feedback))
            if feedback:
                plan.write()
                return _download((Path(folder) / "reports.zip").read_bytes(), "reports.zip", "application/zip")
    except RequestError as problem:
        return _page(book, web_request, _errors_by_field(problem), code=400)
    if plan.stops and not web_request.text("anyway"):
        return _page(book, web_request, plan=plan, code=400)
    return _download(plan.draft.data, plan.order.platform.gradebook, "text/csv; charset=utf-8")


def _order(book: Classbook, web_request: WebRequest, folder: Path, *, feedback: bool) -> Export:
    """Return the export that a form asks for. Without an uploaded template, the stored roster serves as the template."""
    name = web_request.text("format") if not feedback else "csv"
    if name not in registry.names("fill", "write"):
        raise RequestError("Choose a format")
    platform = registry.platform(name)
    target = folder / (platform.gradebook or "grades.csv")
    if feedback:
        return Export(book.out, platform, target, feedback=folder / "reports.zip")
    text = web_request.text("template") or _roster(book)
    template = folder / _TEMPLATE if platform.fill is not None and text else None
    if template is not None:
        template.write_bytes(text.encode("utf-8", "surrogateescape"))
    unreadable, missing = ("0" if web_request.text(name) else "blank" for name in ("unreadable", "missing"))
    return Export(
        book.out,
        platform,
        target,
        template,
        web_request.text("column") or None,
        None,
        bool(web_request.text("scale")),
        unreadable,
        missing,
    )


def _roster(book: Classbook) -> str:
    settings = book.store.settings()
    return settings.roster if settings else ""


def _errors_by_field(problem: RequestError) -> dict[str, str]:
    """Return the problem by form field, to show it there. One that names the template file belongs to the template's field."""
    place, found, rest = problem.why.partition(f"/{_TEMPLATE}")
    if found and " " not in place:
        return {"template": f"the template{rest}"}
    return {problem.option or "format": problem.why}


def _download(data: bytes, name: str, kind: str) -> Response:
    return Response(data, media_type=kind, headers={"Content-Disposition": f'attachment; filename="{name}"'})


def _page(
    book: Classbook,
    web_request: WebRequest,
    errors: Mapping[str, str] | None = None,
    plan: ExportPlan | None = None,
    code: int = 200,
) -> Response:
    """Return the export page; after a refused form with its errors, and with a `plan` that stops with what it would do."""
    settings = book.store.settings()
    everybody = book.final_grades().values()
    people = (person for each in everybody for person in each.people)
    return framed(
        book,
        web_request,
        "export.html.j2",
        code,
        platforms=[registry.platform(name) for name in registry.names("fill", "write")],
        roster=settings.roster_source if settings and settings.roster else "",
        chosen=web_request.text("format") or next((person.platform for person in people if person.platform), ""),
        typed=web_request.text,
        empty=sum(each.unseen for each in everybody),
        absent=len(class_settings.absent(settings, {each.id: each.hand_in for each in everybody})),
        contradictions=contradictions(book.final_grades(), settings),
        lines=list(plan.lines()) if plan else [],
        errors=errors or {},
    )
