"""`imugrade traces`: the ground truth that submissions are compared with."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grader.commands.common import SeedOption

app = typer.Typer(
    help="Ground-truth traces: what submissions are compared with.\n\n"
    "\b\nExamples:\n  imugrade traces list\n  imugrade traces plot -o plots\n"
    "  IMUGRADE_SEED=... imugrade traces record -o traces",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.command("list")
def list_(seed: SeedOption = None) -> int:
    """What the bundle in use holds."""
    from grader import traces  # noqa: PLC0415
    from grader.report import truth  # noqa: PLC0415

    print(truth.listing(traces.obtain(seed, None)))
    return 0


@app.command()
def plot(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Where the pictures go.")],
    seed: SeedOption = None,
) -> int:
    """Draw every scenario that is a motion over time, one PNG each."""
    from grader import traces  # noqa: PLC0415
    from grader.report import truth  # noqa: PLC0415

    for path in truth.plot(traces.obtain(seed, None), out):
        print(path)
    return 0


@app.command()
def record(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Where the bundle goes.")],
    seed: SeedOption = None,
) -> int:
    """Write a bundle for this machine's MuJoCo: the public one, or the hidden one of a seed.

    \b
    Example:
      IMUGRADE_SEED=... imugrade traces record -o traces
    """
    from grader import traces  # noqa: PLC0415
    from grader.report import truth  # noqa: PLC0415

    print(truth.save(traces.obtain(seed, None), out))
    return 0
