"""`imugrade repro`: the calls of a check as a program that does not need the grader."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grader.commands.common import LevelOption, RubricOption


def repro(
    check: Annotated[str, typer.Argument(metavar="CHECK", help="The id of a check, as in the report.")],
    path: Annotated[
        Path, typer.Argument(metavar="PATH", help="A folder. Default: the working folder.", show_default=False)
    ] = Path(),
    *,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="DIR", help="The output folder. Default: PATH/.imugrade.")
    ] = None,
    rubric: RubricOption = None,
    isolation_level: LevelOption = None,
) -> int:
    """Write a program that calls your code with the public input of a check.

    The program is repro.py; its input is repro.npz beside it. It needs your files and the packages that they import.
    Run it, change it, set a breakpoint in it.

    \b
    Example:
      imugrade repro sensor_access.follows_address
      python .imugrade/repro.py
    """
    from grader.base.files import seen_from  # noqa: PLC0415
    from grader.commands import repeating  # noqa: PLC0415
    from grader.engine import rubric as rubrics  # noqa: PLC0415
    from grader.engine.lab_registry import chosen_lab  # noqa: PLC0415

    folder = repeating.folder_in(path) if out is None else out
    written = repeating.write(rubrics.load(chosen_lab(), rubric), check, path, folder, isolation_level)
    print(f"{written} written; run it with: python {seen_from(Path(), written)}")
    return 0
