"""`imugrade traces`: the ground truth that submissions are compared with."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grader.commands.common import RubricOption, SeedOption

if TYPE_CHECKING:
    from grader.engine.traces import Traces

app = typer.Typer(
    help="Ground-truth traces: what submissions are compared with.\n\n"
    "\b\nExamples:\n  imugrade traces list\n  imugrade traces plot -o plots\n"
    "  IMUGRADE_SEED=... imugrade traces record -o traces",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.command("list")
def list_(seed: SeedOption = None, rubric: RubricOption = None) -> int:
    """What the bundle in use holds."""
    from grader.report import truth  # noqa: PLC0415

    print(truth.listing(_obtained(seed, rubric)))
    return 0


@app.command()
def plot(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Where the pictures go.")],
    seed: SeedOption = None,
    rubric: RubricOption = None,
) -> int:
    """Draw every scenario that is a motion over time, one PNG each."""
    from grader.report import truth  # noqa: PLC0415

    for path in truth.plot(_obtained(seed, rubric), out):
        print(path)
    return 0


@app.command()
def record(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Where the bundle goes.")],
    seed: SeedOption = None,
    rubric: RubricOption = None,
) -> int:
    """Write a bundle for this machine's MuJoCo: the public one, or the hidden one of a seed.

    \b
    Example:
      IMUGRADE_SEED=... imugrade traces record -o traces
    """
    from grader.report import truth  # noqa: PLC0415

    print(truth.save(_obtained(seed, rubric), out))
    return 0


def _obtained(seed: str | None, rubric: Path | None) -> Traces:
    """For the robot that the rubric names."""
    from grader.engine import rubric as rubrics  # noqa: PLC0415
    from grader.engine import traces  # noqa: PLC0415
    from grader.labs.imu.lab import LAB  # noqa: PLC0415

    return traces.obtain(seed, None, rubrics.load(LAB, rubric).model)
