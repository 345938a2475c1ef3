"""`imugrade doctor`: what this machine can do, and which packages a class needs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grader.commands.common import console


def doctor(
    paths: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[SUBMISSIONS]", help="Submissions as for grade: check which packages they import."),
    ] = None,
) -> int:
    """Show the isolation levels and versions of this machine, and which packages of SUBMISSIONS are missing.

    \b
    Examples:
      imugrade doctor
      imugrade doctor submissions
    """
    from grader.commands import machine as doctors  # noqa: PLC0415
    from grader.report import terminal  # noqa: PLC0415

    found = doctors.examine() if not paths else [("Packages", doctors.packages_of(paths))]
    terminal.show_findings(found, console())
    return 0
