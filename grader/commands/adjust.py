"""`imugrade adjust`: points by hand, beside the automatic marks."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grader.commands.common import login
from grader.ground.errors import RequestError


def adjust(
    out: Annotated[Path, typer.Argument(metavar="OUT", resolve_path=True, help="What `imugrade grade` wrote.")],
    id_: Annotated[
        str | None,
        typer.Argument(metavar="ID", help="Whose marks: id, name or e-mail.", show_default=False),
    ] = None,
    *,
    criterion: Annotated[
        str, typer.Option("--criterion", metavar="C", help="Which criterion, check (filtering.titles), total or bonus.")
    ] = "",
    points: Annotated[
        float | None, typer.Option("--points", metavar="P", help="What it gets in place of the automatic points.")
    ] = None,
    comment: Annotated[str, typer.Option("--comment", metavar="TEXT", help="Why; the student may read it.")] = "",
    withdraw: Annotated[
        bool, typer.Option("--withdraw", help="Give the criterion its automatic points again.")
    ] = False,
    undo: Annotated[
        bool, typer.Option("--undo", help="Take the last adjustment back: the one before it counts again.")
    ] = False,
    having: Annotated[
        str | None,
        typer.Option("--having", metavar="NAME", help="In place of ID: all who made this mistake, or lost this check."),
    ] = None,
    take_back: Annotated[
        int | None,
        typer.Option(
            "--take-back",
            metavar="N",
            help="Take back decision N, which was on several people; the list has the numbers.",
        ),
    ] = None,
    table: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Many: columns id, criterion, points, comment.")
    ] = None,
    author: Annotated[
        str | None, typer.Option("--author", metavar="NAME", help="Who says so; by default who is logged in.")
    ] = None,
) -> int:
    """Give a criterion, a check or the total other points by hand, add a bonus or a comment, or list all that was ever said.

    The automatic marks stay as they are. An adjustment survives regrades; `grade` tells when the marks beneath it have changed.
    Without points it is a comment alone.

    \b
    Examples:
      imugrade adjust out alice --criterion filtering --points 18 --comment "shown in the lab hour"
      imugrade adjust out alice --criterion filtering --withdraw --comment "was bob"
      imugrade adjust out alice --criterion bonus --points 2 --comment "found a slip in the sheet"
      imugrade adjust out --having data_collection.applies_push --criterion bonus --points 1 --comment "the sheet misled"
      imugrade adjust out --csv adjustments.csv
      imugrade adjust out
    """
    from grader.course import adjusting, groups  # noqa: PLC0415
    from grader.labs.imu.lab import LAB  # noqa: PLC0415

    if sum(each is not None for each in (id_, table, having, take_back)) > 1:
        raise RequestError("adjust: give an ID, --csv, --having or --take-back, one of them alone")
    what, wishes = "", []
    if table is not None:
        wishes = adjusting.read_wishes(table)
    elif take_back is not None:
        wishes = groups.taken_back(out, take_back)
    elif id_ is not None and undo:
        wishes = [adjusting.undone_in(out, id_, criterion)]
    elif id_ is not None or having is not None:
        alone = points is None and bool(comment) and not withdraw
        if not alone and withdraw == (points is not None):
            raise RequestError("adjust: give --points, or --withdraw")
        what, ids = ("", [id_]) if having is None else groups.having(out, having)
        said = "" if points is None else repr(points)
        wishes = [adjusting.Wish(each, criterion, said, comment, alone=alone) for each in ids if each]
    lines = (
        adjusting.adjust(LAB, out, adjusting.placed(out, wishes), author or login(), what)
        if wishes
        else adjusting.listing(out)
    )
    for line in lines:
        print(line)
    return 0
