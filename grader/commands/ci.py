"""`imugrade ci`: grade one submission in a CI job, with the output that its platform reads, such as Gradescope or GitHub."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grader.base.text import enumerated
from grader.commands.common import LevelOption, RubricOption, as_points
from grader.platforms import registry


def ci(
    path: Annotated[
        Path | None,
        typer.Argument(
            metavar="PATH", help="A folder or archive. Default: where the platform puts it.", show_default=False
        ),
    ] = None,
    *,
    format_: Annotated[
        str,
        typer.Option(
            "--format", "-f", metavar="F", help=f"{enumerated((*registry.names('respond'), registry.AUTO), 'or')}."
        ),
    ] = registry.AUTO,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="The output file; - is standard output.")
    ] = None,
    min_score: Annotated[
        float | None,
        typer.Option("--min-score", parser=as_points, metavar="N", help="Exit with 1 if the score is below N."),
    ] = None,
    rubric: RubricOption = None,
    traces_: Annotated[
        Path | None, typer.Option("--traces", metavar="FILE", help="A trace bundle (.npz) that students cannot read.")
    ] = None,
    trust: Annotated[
        bool, typer.Option("--trust-submissions", help="Allow hidden scenarios without isolation.")
    ] = False,
    private: Annotated[
        bool, typer.Option("--private", help="Allow hidden scenarios: students cannot read this job.")
    ] = False,
    isolation_level: LevelOption = None,
) -> int:
    """Grade one submission in a CI job and write its platform's output.

    Hidden scenarios (--traces) need isolated code, or --trust-submissions; and a platform that keeps them secret, or --private.

    \b
    Examples:
      imugrade ci
      imugrade ci --format github --min-score 60
      imugrade ci lab -o junit.xml
      imugrade ci student --traces hidden.npz --private -o junit.xml
    """
    from grader.engine import rubric as rubrics  # noqa: PLC0415
    from grader.engine import traces  # noqa: PLC0415
    from grader.engine.lab_registry import chosen_lab  # noqa: PLC0415
    from grader.platforms import job  # noqa: PLC0415

    lab = chosen_lab()
    chosen = rubrics.load(lab, rubric)
    bundle = lab.truth(None, chosen.settings) if traces_ is None else traces.load(traces_)
    format_of = job.named(format_)
    order = job.CiJob(format_of, chosen, bundle, path, out, trust, min_score, isolation_level, private=private)
    result = job.run(order)
    if result.status == "incomplete":
        return 3
    return int(min_score is not None and result.score < min_score)
