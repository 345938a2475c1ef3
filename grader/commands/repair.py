"""`imugrade repair`: patches on submitted files, each with a deduction and a comment."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grader.base.errors import RequestError
from grader.commands.common import (
    AuthorOption,
    CommentOption,
    OutArgument,
    SeedOption,
    StudentArgument,
    TrustOption,
    as_points,
    login,
)


def repair(
    out: OutArgument,
    id_: StudentArgument = None,
    file: Annotated[str | None, typer.Argument(metavar="FILE", help="The submitted file.", show_default=False)] = None,
    *,
    fixed: Annotated[Path | None, typer.Option("--with", metavar="FIXED", help="The whole repaired file.")] = None,
    patch: Annotated[
        Path | None, typer.Option("--patch", metavar="DIFF", help="The change, as a unified diff of this file.")
    ] = None,
    deduct: Annotated[
        float, typer.Option("--deduct", parser=as_points, metavar="N", help="The deduction, in points.")
    ] = 0.0,
    comment: CommentOption = "",
    undo: Annotated[bool, typer.Option("--undo", help="Undo the last repair of ID, or of FILE.")] = False,
    suggest: Annotated[
        bool, typer.Option("--suggest", help="Propose a small edit that makes the code run. Nothing is recorded.")
    ] = False,
    list_: Annotated[bool, typer.Option("--list", help="List all repairs with their diffs.")] = False,
    seed: SeedOption = None,
    trust: TrustOption = False,
    author: AuthorOption = None,
) -> int:
    """Repair a submitted file, grade the repaired copy, and deduct points for that.

    The final grade is the repaired grade minus the deduction, and never below the grade of the original. The record keeps the
    original. The student sees the change and the comment. A regrade keeps the repair while the student's file is the same.

    \b
    Examples:
      imugrade repair out alice filters.py --with fixed.py --deduct 5 --comment "a colon was missing in line 12"
      imugrade repair out alice filters.py --patch fix.diff --deduct 5 --comment "a colon was missing in line 12"
      imugrade repair out alice --suggest
      imugrade repair out alice --undo
      imugrade repair out --list
    """
    from grader.course.repairs import making  # noqa: PLC0415
    from grader.course.run import class_grading  # noqa: PLC0415
    from grader.course.run.classroom import lab_on_record  # noqa: PLC0415

    if list_ or id_ is None:
        for line in making.listing(out):
            print(line)
        return 0
    if not (undo or suggest) and file is None:
        raise RequestError("repair: say which FILE; the report of the submission names it")
    with class_grading.settings_on_record(lab_on_record(out), out, seed, trusted=trust).opened() as by:
        if undo:
            print(making.take_back(out, id_, file or "", author or login(), by))
            making.publish(out, id_, by)
            return 0
        if suggest:
            for line in making.suggested(out, id_, by):
                print(line)
            return 0
        request = making.RepairRequest(id_, file or "", _read(fixed), _text(patch), deduct, comment)
        print(making.record(out, request, author or login(), by))
        making.publish(out, id_, by)
    return 0


def _read(path: Path | None) -> bytes | None:
    from grader.base.files import read_file  # noqa: PLC0415
    from grader.course.record.patches import LARGEST  # noqa: PLC0415

    return None if path is None else read_file(path, LARGEST, "give the path of a repaired file or of a diff")


def _text(path: Path | None) -> str | None:
    content = _read(path)
    return None if content is None else content.decode("utf-8", "surrogateescape")
