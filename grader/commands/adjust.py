"""`imugrade adjust`: points by hand, beside the automatic marks."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grader.ground.errors import RequestError


def adjust(
    out: Annotated[Path, typer.Argument(metavar="OUT", help="What `imugrade grade` wrote.")],
    id_: Annotated[str | None, typer.Argument(metavar="ID", help="Whose marks.", show_default=False)] = None,
    *,
    criterion: Annotated[str, typer.Option("--criterion", metavar="C", help="Which criterion.")] = "",
    points: Annotated[
        float | None, typer.Option("--points", metavar="P", help="What it gets in place of the automatic points.")
    ] = None,
    comment: Annotated[str, typer.Option("--comment", metavar="TEXT", help="Why; the student may read it.")] = "",
    withdraw: Annotated[
        bool, typer.Option("--withdraw", help="Give the criterion its automatic points again.")
    ] = False,
    table: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Many: columns id, criterion, points, comment.")
    ] = None,
    author: Annotated[
        str | None, typer.Option("--author", metavar="NAME", help="Who says so; by default who is logged in.")
    ] = None,
) -> int:
    """Give a criterion other points by hand, or list all that was ever given.

    The automatic marks stay as they are. An adjustment survives regrades; `grade` tells when the marks beneath it have changed.

    \b
    Examples:
      imugrade adjust out alice --criterion filtering --points 18 --comment "shown in the lab hour"
      imugrade adjust out alice --criterion filtering --withdraw --comment "was bob"
      imugrade adjust out --csv adjustments.csv
      imugrade adjust out
    """
    from grader.course import adjusting  # noqa: PLC0415
    from grader.labs.imu.lab import LAB  # noqa: PLC0415

    if table is not None:
        if id_ is not None:
            raise RequestError("adjust: give an ID or --csv, not both")
        wishes = adjusting.read_wishes(table)
    elif id_ is None:
        wishes = []
    elif withdraw == (points is not None):
        raise RequestError("adjust: give --points, or --withdraw")
    else:
        wishes = [adjusting.Wish(id_, criterion, "" if points is None else repr(points), comment)]
    lines = adjusting.adjust(LAB, out, wishes, author or _login()) if wishes else adjusting.listing(out)
    for line in lines:
        print(line)
    return 0


def _login() -> str:
    """Who is logged in; a machine need not know."""
    import getpass  # noqa: PLC0415

    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):
        return "unknown"
