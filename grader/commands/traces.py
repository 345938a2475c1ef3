"""`imugrade traces`: the ground truth that submissions are compared with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grader.base.text import printable
from grader.commands.common import LevelOption, RubricOption, SeedOption, say

if TYPE_CHECKING:
    from grader.engine.traces import Traces
    from grader.labs.imu.answers import Collection

app = typer.Typer(
    help="Record, list and plot the ground-truth traces.\n\n"
    "\b\nExamples:\n  imugrade traces list\n  imugrade traces plot -o plots\n"
    "  IMUGRADE_SEED=... imugrade traces record -o traces",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.command("list")
def list_(seed: SeedOption = None, rubric: RubricOption = None) -> int:
    """List the scenarios of the trace bundle."""
    from grader.report import truth  # noqa: PLC0415

    print(truth.listing(_obtained(seed, rubric)))
    return 0


@app.command()
def plot(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The output folder.")],
    mine: Annotated[
        Path | None,
        typer.Option("--mine", metavar="PATH", help="A submission, whose recording is drawn over the truth."),
    ] = None,
    seed: SeedOption = None,
    rubric: RubricOption = None,
    isolation_level: LevelOption = None,
) -> int:
    """Plot each motion as a PNG file.

    \b
    Example:
      imugrade traces plot -o plots --mine my_lab
    """
    from grader.labs.imu import motions  # noqa: PLC0415

    traces = _obtained(seed, rubric)
    own = None if mine is None else _recorded(mine, traces, rubric, isolation_level)
    for path in motions.plot(traces, out, own):
        print(path)
    return 0


def _recorded(path: Path, traces: Traces, rubric: Path | None, isolation_level: str | None) -> Mapping[str, Collection]:
    """Return what the submission's own `simulate_and_collect` records in a sandbox; print what could not be obtained."""
    from grader.base.errors import NoAnswer, RequestError  # noqa: PLC0415
    from grader.engine import rubric as rubrics  # noqa: PLC0415
    from grader.engine.findings import Missing, Raised, raised  # noqa: PLC0415
    from grader.engine.lab_sandbox import open_sandbox_for  # noqa: PLC0415
    from grader.intake import read_submission  # noqa: PLC0415
    from grader.labs.imu.data_collection import measure  # noqa: PLC0415
    from grader.labs.imu.lab import LAB  # noqa: PLC0415

    submission, limits = read_submission(path, LAB.files), asdict(rubrics.load(LAB, rubric).limits)
    own = {}
    with open_sandbox_for(LAB, submission.files, isolation_level) as sandbox:
        student = LAB.student(sandbox, LAB, submission.files, truth=traces, above=submission.above, **limits)
        for scenario in ("push", "push_dirty"):
            try:
                series = measure.asked(student, traces, scenario)  # type: ignore[arg-type] # this lab's own
                raised(series.error, "collecting data")
                own[scenario] = series
            except (Missing, NoAnswer, Raised) as why:
                say(f"{scenario}: {why}")
        student.close()
    if not own:
        raise RequestError(f"{printable(str(path), 500)} has no recording; imugrade check says why")
    return own


@app.command()
def record(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The output folder.")],
    seed: SeedOption = None,
    rubric: RubricOption = None,
) -> int:
    """Record a trace bundle: the public one, or the hidden one of a secret.

    \b
    Example:
      IMUGRADE_SEED=... imugrade traces record -o traces
    """
    from grader.report import truth  # noqa: PLC0415

    print(truth.save(_obtained(seed, rubric), out))
    return 0


def _obtained(seed: str | None, rubric: Path | None) -> Traces:
    """Obtain the traces of the robot that the rubric names."""
    from grader.engine import rubric as rubrics  # noqa: PLC0415
    from grader.engine.lab_registry import chosen_lab  # noqa: PLC0415

    lab = chosen_lab()
    return lab.truth(seed, rubrics.load(lab, rubric).settings)
