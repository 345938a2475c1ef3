"""`imugrade ci`: one submission, in the words of a platform."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grader.commands.common import RubricOption, RungOption


def ci(
    path: Annotated[
        Path | None,
        typer.Argument(
            metavar="PATH", help="A folder or archive; by default where the platform puts it.", show_default=False
        ),
    ] = None,
    *,
    format_: Annotated[
        str,
        typer.Option(
            "--format", "-f", metavar="F", help="github, gradescope, classroom50, junit, prairielearn, json or auto."
        ),
    ] = "auto",
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FILE", help="Where the answer goes; - is standard output."),
    ] = None,
    min_score: Annotated[
        float | None, typer.Option("--min-score", metavar="N", help="Exit with 1 if there are fewer points.")
    ] = None,
    rubric: RubricOption = None,
    traces_: Annotated[
        Path | None,
        typer.Option("--traces", metavar="FILE", help="A recorded bundle (.npz), where students cannot read it."),
    ] = None,
    visibility: Annotated[
        str,
        typer.Option(metavar="WHEN", help="Gradescope: visible, after_due_date, after_published or hidden."),
    ] = "visible",
    trust: Annotated[
        bool, typer.Option("--trust-submissions", help="Hidden scenarios where nothing isolates students' code.")
    ] = False,
    rung: RungOption = None,
) -> int:
    """Grade one submission in a CI job, in the words of its platform.

    \b
    Examples:
      imugrade ci
      imugrade ci --format github --min-score 60
      imugrade ci lab --format junit -o junit.xml
    """
    from grader import rubric as rubrics  # noqa: PLC0415
    from grader import traces  # noqa: PLC0415
    from grader.formats import job, platforms  # noqa: PLC0415

    bundle = traces.obtain(None, None) if traces_ is None else traces.load(traces_)
    order = job.Job(
        platforms.named(format_), rubrics.load(rubric), bundle, path, out,
        job.visible(visibility), trust, rung,
    )  # fmt: skip
    job.refuse_limit(order, min_score)
    result = job.run(order)
    if result.status == "incomplete":
        return 3
    return int(min_score is not None and result.score < min_score)
