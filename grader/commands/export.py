"""`imugrade export`: a graded class as a platform's upload."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grader.commands.common import either, one_of, say
from grader.ground.errors import RequestError
from grader.platforms import registry


def export(
    out: Annotated[Path, typer.Argument(metavar="OUT", resolve_path=True, help="What `imugrade grade` wrote.")],
    *,
    format_: Annotated[
        str, typer.Option("--format", "-f", metavar="F", help=f"{either(registry.names('fill', 'write'))}.")
    ],
    target: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="Where to; by default in OUT.")
    ] = None,
    template: Annotated[
        Path | None,
        typer.Option(
            "--template",
            metavar="FILE",
            help=f"The file that the platform exported, to be filled in: {either(registry.names('fill'))}.",
        ),
    ] = None,
    column: Annotated[
        str | None, typer.Option("--column", metavar="TITLE", help="The column of the grades, where it is not plain.")
    ] = None,
    feedback: Annotated[
        Path | None,
        typer.Option("--feedback", metavar="ZIP", help="Each student's report, for the platform to place."),
    ] = None,
    scale: Annotated[
        bool, typer.Option("--scale", help="Scale the points to what the platform's assignment is out of.")
    ] = False,
    unreadable: Annotated[
        str,
        typer.Option("--unreadable", metavar="HOW", help="What an empty or unreadable submission gets: blank or 0."),
    ] = "blank",
    allow_blank: Annotated[
        bool, typer.Option("--allow-blank", help="Write the file although somebody of the class has no grade in it.")
    ] = False,
) -> int:
    """Write the final points of a graded class as a platform's upload.

    A platform that exports a file for it gets that file back, with the grades filled in and nothing else changed. Rows of people
    who are not in the class stay as they were. What is graded, left blank, replaced and unmatched is told first; where somebody of
    the class or its roster would be left blank, nothing is written without --allow-blank. csv is a table for everything else.

    \b
    Examples:
      imugrade export out --format csv -o marks.csv
      imugrade export out --format canvas --template gradebook.csv --column "Lab 04-01"
      imugrade export out --format moodle --template worksheet.csv --feedback reports.zip
    """
    from grader.course import exporting  # noqa: PLC0415

    platform = registry.platform(one_of("--format", format_, registry.names("fill", "write")))
    how = one_of("--unreadable", unreadable, exporting.UNREADABLE)
    plan = exporting.plan(exporting.Export(out, platform, target, template, column, feedback, scale, how))
    for line in plan.lines():
        say(line)
    if plan.draft.blank and not allow_blank:
        raise RequestError(
            "somebody of the class would be left blank; add --allow-blank if that is meant. Nothing was written"
        )
    files, remarks = plan.write()
    for line in files:
        print(line)
    for line in remarks:
        say(line)
    return 0
