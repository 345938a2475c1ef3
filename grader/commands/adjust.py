"""`imugrade adjust`: change points by hand, add a bonus or a comment; the automatic points stay on record."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from grader.base.errors import RequestError
from grader.commands.common import AuthorOption, CommentOption, OutArgument, StudentArgument, as_points, login


def adjust(
    out: OutArgument,
    id_: StudentArgument = None,
    *,
    criterion: Annotated[
        str,
        typer.Option("--criterion", metavar="C", help="A criterion, a check (visualization.titles), total or bonus."),
    ] = "",
    points: Annotated[
        float | None,
        typer.Option("--points", parser=as_points, metavar="P", help="Points that replace the automatic points."),
    ] = None,
    comment: CommentOption = "",
    withdraw: Annotated[bool, typer.Option("--withdraw", help="Remove the override.")] = False,
    undo: Annotated[bool, typer.Option("--undo", help="Undo the last change of this criterion.")] = False,
    having: Annotated[
        str | None,
        typer.Option("--having", metavar="NAME", help="Instead of ID: all students with this fault or failed check."),
    ] = None,
    take_back: Annotated[
        int | None,
        typer.Option(
            "--take-back", metavar="N", help="Undo decision N for several students; the list has the numbers."
        ),
    ] = None,
    table: Annotated[
        Path | None,
        typer.Option("--csv", metavar="FILE", help="Import a table with the columns id, criterion, points, comment."),
    ] = None,
    author: AuthorOption = None,
) -> int:
    """Override points, add a bonus or a comment, or list all of them.

    An override of the total is final: lateness and repairs are not deducted from it. A person of the roster without a
    submission can get points, too. The automatic points stay in the record. An override survives regrades. `grade` lists
    overrides whose automatic points have changed since. Without --points it is only a comment.

    \b
    Examples:
      imugrade adjust out alice --criterion filtering --points 18 --comment "shown in the lab hour"
      imugrade adjust out alice --criterion filtering --withdraw --comment "was bob"
      imugrade adjust out alice --criterion bonus --points 2 --comment "found an error in the sheet"
      imugrade adjust out --having data_collection.applies_push --criterion bonus --points 1 --comment "the sheet misled"
      imugrade adjust out --csv adjustments.csv
      imugrade adjust out
    """
    from grader.course.record.store import Store  # noqa: PLC0415
    from grader.course.regrading import adjusting, groups  # noqa: PLC0415
    from grader.course.run.classroom import lab_on_record  # noqa: PLC0415

    if sum(each is not None for each in (id_, table, having, take_back)) > 1:
        raise RequestError("adjust: give exactly one of ID, --csv, --having and --take-back")
    with Store.existing(out) as store:
        who, what, requests = adjusting.person_lookup(store), "", []
        if table is not None:
            requests = [replace(each, id=who.by(each.id)) for each in adjusting.read_overrides(table)]
        elif take_back is not None:
            requests = adjusting.undoing_requests(store, take_back)
        elif id_ is not None and undo:
            requests = [adjusting.undone(store, who.by(id_), criterion)]
        elif id_ is not None or having is not None:
            alone = points is None and bool(comment) and not withdraw
            if not alone and withdraw == (points is not None):
                raise RequestError("adjust: give --points or --withdraw")
            what, ids = ("", (who.by(id_ or ""),)) if having is None else groups.members_of(store, having)
            said = "" if points is None else repr(points)
            requests = [adjusting.OverrideRequest(each, criterion, said, comment, alone=alone) for each in ids]
        lines = (
            adjusting.adjust(lab_on_record(out), out, store, requests, author or login(), what)
            if requests
            else adjusting.listing(store)
        )
        for line in lines:
            print(line)
    return 0
