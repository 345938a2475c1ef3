"""`imugrade explain`: explain a fault, a check or a criterion."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from grader.commands.common import console


def explain(
    id_: Annotated[
        str | None, typer.Argument(metavar="ID", help="A fault, a check or a criterion. Without it: list them all.")
    ] = None,
) -> int:
    """Explain a fault that a report names, or what a check tests.

    \b
    Examples:
      imugrade explain
      imugrade explain sensor-id-as-address
      imugrade explain filtering.follows_recursion
    """
    from grader.engine.lab_registry import chosen_lab  # noqa: PLC0415
    from grader.report import explanations  # noqa: PLC0415

    if id_ is None:
        print(explanations.listing(chosen_lab()), end="")
    else:
        _show_markdown(explanations.explain(chosen_lab(), id_))
    return 0


def _show_markdown(text: str) -> None:
    """Print an explanation in Markdown: rendered on a terminal, as it is in a pipe."""
    if sys.stdout.isatty():  # importing rich takes longer than everything else here
        from rich.markdown import Markdown  # noqa: PLC0415

        screen = console()
        screen.print(Markdown(text), width=min(screen.width, 100))
    else:
        print(text, end="")
