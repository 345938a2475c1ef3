"""`imugrade check`: a student looks at their own work."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grader.commands.common import RubricOption, RungOption, console

if TYPE_CHECKING:
    from grader.results import Result


def check(
    path: Annotated[
        Path,
        typer.Argument(metavar="PATH", help="A folder or archive; the working folder by default.", show_default=False),
    ] = Path(),
    *,
    html: Annotated[Path | None, typer.Option("--html", metavar="FILE", help="Write the report as a page.")] = None,
    json: Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Write the result as JSON.")] = None,
    only: Annotated[str | None, typer.Option("--only", metavar="CRITERION", help="Check one criterion.")] = None,
    watch: Annotated[bool, typer.Option("--watch", help="Check again whenever a file is saved.")] = False,
    rubric: RubricOption = None,
    rung: RungOption = None,
) -> int:
    """Check one submission against the public scenarios.

    \b
    Examples:
      imugrade check
      imugrade check my_lab --only filtering --watch
      imugrade check my_lab.zip --html report.html
    """
    from grader.intake import read_submission  # noqa: PLC0415
    from grader.lab_box import open_box_for  # noqa: PLC0415

    if watch:
        return _watch(path, rubric, only, html, json, rung)
    submission = read_submission(path)
    with open_box_for(submission.files, rung) as box:
        from grader import opening  # noqa: PLC0415 - this and the next while the box warms up
        from grader import rubric as rubrics  # noqa: PLC0415

        chosen = rubrics.load(rubric)
        rubrics.know_part(chosen, only)
        ready = submission.status == "ready"
        if ready:
            print(opening.found(submission), flush=True)  # at once: the rest takes seconds on a cold machine
        from grader import selfcheck, traces  # noqa: PLC0415
        from grader.report import terminal  # noqa: F401, PLC0415

        bundle = traces.obtain(None, None)
        if ready:
            print(opening.waiting(submission, chosen, bundle, only) + "\n", flush=True)
        result = selfcheck.check(submission, chosen, bundle, box, only=only)
    _show(result, html, json, only)
    return 3 if result.status == "incomplete" else 0


def _watch(
    path: Path, rubric: Path | None, only: str | None, html: Path | None, json: Path | None, rung: str | None
) -> int:
    from grader import opening, selfcheck, traces  # noqa: PLC0415
    from grader import rubric as rubrics  # noqa: PLC0415
    from grader.intake import read_submission  # noqa: PLC0415

    chosen = rubrics.load(rubric)
    rubrics.know_part(chosen, only)
    bundle = traces.obtain(None, None)
    waiting = opening.waiting(read_submission(path), chosen, bundle, only) + "\n"
    written = [each for each in (html, json) if each is not None]
    for result in selfcheck.check_on_save(path, chosen, bundle, only=only, rung=rung, written=written):
        console().clear()
        print(waiting)
        _show(result, html, json, only)
        print("\nWatching for changes; Ctrl-C ends.", flush=True)
    return 0


def _show(result: Result, html: Path | None, json: Path | None, only: str | None) -> None:
    from grader.files import write_whole  # noqa: PLC0415
    from grader.report import terminal  # noqa: PLC0415

    terminal.show(result, console(), only=only)
    if html is not None:
        from grader.evidence import unpacked  # noqa: PLC0415
        from grader.people.standing import Standing  # noqa: PLC0415
        from grader.report.pages import report_page  # noqa: PLC0415

        write_whole(html, report_page(Standing("", result), unpacked(result.evidence.charts)))
    if json is not None:
        from grader.results import to_json  # noqa: PLC0415

        write_whole(json, to_json(result))
