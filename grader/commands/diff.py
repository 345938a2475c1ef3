"""`imugrade diff`: two gradings of a class."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def diff(
    first: Annotated[Path, typer.Argument(metavar="OUT1", help="A graded class.")],
    second: Annotated[Path, typer.Argument(metavar="OUT2", help="The same class, graded another time.")],
) -> int:
    """Tell whose marks moved from one grading to another, by which checks, and what had changed.

    \b
    Example:
      imugrade diff out-monday out-tuesday
    """
    from grader.course import differences  # noqa: PLC0415
    from grader.course.record import Store  # noqa: PLC0415

    with Store.existing(first) as old, Store.existing(second) as new:
        for line in differences.told(old.standings(), new.standings()):
            print(line)
    return 0
