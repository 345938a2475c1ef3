"""`imugrade doctor`: what this machine can do, and which packages a class needs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grader.base.text import printable
from grader.commands.common import console, say

if TYPE_CHECKING:
    from grader.commands.machine import DoctorFinding


def doctor(
    paths: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[SUBMISSIONS]", help="Submissions as for grade: check which packages they import."),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(
            "--report", metavar="OUT", help="Print what to report about faults of the grader in this graded class."
        ),
    ] = None,
) -> int:
    """Show the isolation levels and versions of this machine, and which packages of SUBMISSIONS are missing.

    With --report, print what to copy into a report about the grader: versions and its faults on record. It has no name, file, text
    or secret of the class.

    \b
    Examples:
      imugrade doctor
      imugrade doctor submissions
      imugrade doctor --report out
    """
    say("looking at this machine …" if not paths else "reading the submissions …")  # importing takes a second
    from grader.commands import machine  # noqa: PLC0415

    if report is not None:
        print("\n".join(printable(line, 500) for line in machine.report(report)))
        return 0
    _show(machine.examine(say) if not paths else [("Packages", machine.packages_of(paths))])
    return 0


def _show(sections: Sequence[tuple[str, Sequence[DoctorFinding]]]) -> None:
    """Print what `imugrade doctor` found: each section as a heading with a table of its findings."""
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    screen = console()
    for heading, findings in sections:
        screen.print(Text(heading, "bold"))
        table = Table.grid(expand=True, padding=(0, 1, 0, 0))
        table.add_column(width=3, no_wrap=True)
        table.add_column(width=14, no_wrap=True)
        table.add_column(ratio=1)
        for finding in findings:
            sign = {True: "✓", False: "✗", None: " "}[finding.good]
            table.add_row(Text(f" {sign}"), Text(finding.name), Text(printable(finding.text, 500)))
        screen.print(table)
