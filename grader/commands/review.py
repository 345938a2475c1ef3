"""`imugrade review`: the review desk over a graded class."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Annotated

import typer

from grader.base.errors import RequestError
from grader.commands.common import AuthorOption, OutArgument, RubricOption, SeedOption, TrustOption, login


def review(
    out: OutArgument,
    *,
    port: Annotated[
        int, typer.Option("--port", min=0, max=65535, metavar="N", help="The port. Default: a free one.")
    ] = 0,
    rubric: RubricOption = None,
    read_in: Annotated[
        list[Path] | None,
        typer.Option(
            "--requests",
            metavar="PATH",
            help="Regrade requests to add: a .json, .csv or .txt file, or a folder of them.",
        ),
    ] = None,
    seed: SeedOption = None,
    trust: TrustOption = False,
    author: AuthorOption = None,
) -> int:
    """Review a graded class in a browser: review queue, code beside reports, repairs, overrides, regrade requests.

    The web page is there until Ctrl-C, on this machine only. Open the address that the command prints.

    \b
    Example:
      imugrade review out
    """
    try:
        from grader.desk import classbook, regrade_requests, serving  # noqa: PLC0415
    except ModuleNotFoundError as missing:
        raise RequestError(f"review needs {missing.name}, which comes with: pip install 'imugrade[desk]'") from missing
    from grader.course.run.classroom import lab_on_record  # noqa: PLC0415

    with closing(classbook.Classbook(lab_on_record(out), out, rubric, seed, trusted=trust)) as book:
        for file in read_in or ():
            for line in regrade_requests.read_in(book, file):
                print(f"{file}: {line}")
        serving.serve(book, author or login(), port, lambda address: print(address, flush=True))
    return 0
