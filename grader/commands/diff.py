"""`imugrade diff`: two gradings of a class."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grader.base.errors import RequestError
from grader.commands.common import shown_path


def diff(
    first: Annotated[Path, typer.Argument(metavar="OUT1", help="A graded class.")],
    second: Annotated[
        Path | None, typer.Argument(metavar="OUT2", help="The same class, graded again.", show_default=False)
    ] = None,
) -> int:
    """Compare two gradings: whose scores changed, by which checks, and why.

    With one folder, it compares the grades now and before the last change of a setting, such as the rubric, that can change
    scores. If there was none, it refuses.

    \b
    Example:
      imugrade diff out-monday out-tuesday
    """
    from grader.course.publishing import differences  # noqa: PLC0415
    from grader.course.record.store import Store  # noqa: PLC0415

    with Store.existing(first) as old, Store.existing(second or first) as new:
        before = old.final_grades() if second is not None else old.former()
        if second is None and not before:
            raise RequestError(
                f"{shown_path(first)}: no change of the settings has changed a score; give two folders to compare"
            )
        for line in differences.lines_of(before, new.final_grades()):
            print(line)
    return 0
