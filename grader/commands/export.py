"""`imugrade export`: a graded class as a platform's upload."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from grader.base.errors import RequestError
from grader.base.text import enumerated
from grader.commands.common import OutArgument, one_of, say
from grader.platforms import registry


def export(
    out: OutArgument,
    *,
    format_: Annotated[
        str, typer.Option("--format", "-f", metavar="F", help=f"{enumerated(registry.names('fill', 'write'), 'or')}.")
    ],
    target: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="The output file. Default: in OUT.")
    ] = None,
    template: Annotated[
        Path | None,
        typer.Option(
            "--template",
            metavar="FILE",
            help=f"The file exported by the platform, to fill in: {enumerated(registry.names('fill'), 'or')}.",
        ),
    ] = None,
    column: Annotated[
        str | None, typer.Option("--column", metavar="TITLE", help="The column of the grades, if it is ambiguous.")
    ] = None,
    feedback: Annotated[
        Path | None, typer.Option("--feedback", metavar="ZIP", help="Write an archive of all reports for the platform.")
    ] = None,
    scale: Annotated[bool, typer.Option("--scale", help="Scale the points to the maximum on the platform.")] = False,
    unreadable: Annotated[
        str, typer.Option("--unreadable", metavar="HOW", help="Grade of an empty or unreadable submission: blank or 0.")
    ] = "blank",
    missing: Annotated[
        str, typer.Option("--missing", metavar="HOW", help="Grade of a person without a submission: blank or 0.")
    ] = "blank",
    anyway: Annotated[
        bool, typer.Option("--anyway", help="Write the file although grades in it contradict each other.")
    ] = False,
) -> int:
    """Write the final grades of a class in the format of a platform. No grade on record changes.

    With --template, the command fills the grades into the file that the platform exported and changes nothing else in it. It
    says how many get a grade, who stays blank, and which rows match nobody. A person without a submission stays blank, or gets
    0 with --missing 0. The command writes nothing if a graded submission has no row in the file, a grade is above its maximum,
    a person has two grades, or the grader failed to judge a submission, unless you allow it with --anyway, or with a yes on a
    terminal. The format csv is a plain table.

    \b
    Examples:
      imugrade export out --format csv -o marks.csv
      imugrade export out --format canvas --template gradebook.csv --column "Lab 04-01"
      imugrade export out --format moodle --template worksheet.csv --feedback reports.zip
    """
    from grader.course.publishing import exporting  # noqa: PLC0415

    platform = registry.platform(one_of("--format", format_, registry.names("fill", "write")))
    how = one_of("--unreadable", unreadable, exporting.BLANK_OR_ZERO)
    nobody = one_of("--missing", missing, exporting.BLANK_OR_ZERO)
    plan = exporting.plan(exporting.Export(out, platform, target, template, column, feedback, scale, how, nobody))
    for line in plan.lines():
        say(line)
    if plan.stops and not anyway and not (sys.stdin.isatty() and typer.confirm("Write the file anyway?")):
        raise RequestError(
            "grades contradict each other (see above); add --anyway to write the file. Nothing was written"
        )
    files, remarks = plan.write()
    for line in files:
        print(line)
    for line in remarks:
        say(line)
    return 0
