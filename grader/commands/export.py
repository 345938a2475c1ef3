"""`imugrade export`: a graded class as a platform's upload."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grader.commands.common import one_of, say


def export(
    out: Annotated[Path, typer.Argument(metavar="OUT", help="What `imugrade grade` wrote.")],
    *,
    format_: Annotated[str, typer.Option("--format", "-f", metavar="F", help="csv, canvas, moodle or gradescope.")],
    target: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="Where to; by default OUT/F.csv.")
    ] = None,
    template: Annotated[
        Path | None,
        typer.Option(
            "--template", metavar="FILE", help="Canvas: the exported gradebook; Moodle: the grading worksheet."
        ),
    ] = None,
    column: Annotated[
        str | None, typer.Option("--column", metavar="TITLE", help="The column of the grades, where it is not plain.")
    ] = None,
    feedback: Annotated[
        Path | None,
        typer.Option("--feedback", metavar="ZIP", help="Each student's report, for Canvas or Moodle to place."),
    ] = None,
) -> int:
    """Write the final points of a graded class as a platform's upload.

    Canvas and Moodle get back the file that they exported, with the grades filled in and nothing else changed. Who is not in both
    is told, and keeps what the file had.

    \b
    Examples:
      imugrade export out --format csv -o marks.csv
      imugrade export out --format canvas --template gradebook.csv --column "Lab 04-01"
      imugrade export out --format moodle --template worksheet.csv --feedback reports.zip
    """
    from grader.course import exporting  # noqa: PLC0415

    name = one_of("--format", format_, exporting.FORMATS)
    written = exporting.export(exporting.Export(out, name, target, template, column, feedback))
    for line in written.told:
        print(line)
    for line in written.remarks:
        say(line)
    return 0
