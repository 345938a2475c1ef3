"""`imugrade traces`: the ground truth that submissions are compared with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from grader.base.text import printable
from grader.commands.common import LevelOption, RubricOption, SeedOption, WeakSecretOption, say

if TYPE_CHECKING:
    from grader.engine.lab import Lab
    from grader.engine.traces import Traces

app = typer.Typer(
    help="Record, list and plot the ground-truth traces.\n\n"
    "\b\nExamples:\n  imugrade traces list\n  imugrade traces plot -o plots\n"
    "  IMUGRADE_SEED=... imugrade traces record -o traces",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.command("list")
def list_(seed: SeedOption = None, rubric: RubricOption = None) -> int:
    """List the scenarios of the traces, the true motions that grading compares with.

    They are the public scenarios, or with --seed the hidden ones. With --rubric, they use the robot that the rubric names.
    """
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
    """Plot each true motion as a PNG file.

    \b
    Example:
      imugrade traces plot -o plots --mine my_lab
    """
    from grader.base.errors import RequestError  # noqa: PLC0415
    from grader.engine.lab_registry import chosen_lab  # noqa: PLC0415

    lab = chosen_lab()
    if lab.plot is None:
        raise RequestError(f"there is nothing to plot in {lab.label}")
    traces = _obtained(seed, rubric)
    own = None if mine is None else _recorded(lab, mine, traces, rubric, isolation_level)
    for path in lab.plot(traces, out, own):
        print(path)
    return 0


def _recorded(
    lab: Lab, path: Path, traces: Traces, rubric: Path | None, isolation_level: str | None
) -> Mapping[str, Any]:
    """Return what the submission's own code records, to plot it over the truth; raise RequestError if it records nothing."""
    from grader.base.errors import RequestError  # noqa: PLC0415
    from grader.engine import rubric as rubrics  # noqa: PLC0415
    from grader.engine.lab_sandbox import open_sandbox_for  # noqa: PLC0415
    from grader.intake import read_submission  # noqa: PLC0415

    submission, limits = read_submission(path, lab.files), asdict(rubrics.load(lab, rubric).limits)
    own: Mapping[str, Any] = {}
    if lab.recordings is not None:
        with open_sandbox_for(lab, submission.files, isolation_level) as sandbox:
            student = lab.student(sandbox, lab, submission.files, truth=traces, above=submission.above, **limits)
            own = lab.recordings(student, traces, say)
            student.close()
    if not own:
        raise RequestError(f"{printable(str(path), 500)} has no recording; imugrade check says why")
    return own


@app.command()
def record(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The output folder.")],
    seed: SeedOption = None,
    rubric: RubricOption = None,
    weak_secret: WeakSecretOption = False,
) -> int:
    """Write the traces (true motions) as .npz and .json: the public ones, or with --seed the hidden ones.

    \b
    Example:
      IMUGRADE_SEED=... imugrade traces record -o traces
    """
    from grader.course.run import secret_strength  # noqa: PLC0415
    from grader.report import truth  # noqa: PLC0415

    if not weak_secret:
        secret_strength.refuse_guessable(seed)
    print(truth.save(_obtained(seed, rubric), out))
    return 0


def _obtained(seed: str | None, rubric: Path | None) -> Traces:
    """Return the traces of the robot that the rubric names: the public ones, or with a seed the hidden ones."""
    from grader.engine import rubric as rubrics  # noqa: PLC0415
    from grader.engine.lab_registry import chosen_lab  # noqa: PLC0415

    lab = chosen_lab()
    return lab.truth(seed, rubrics.load(lab, rubric).settings)
