"""`imugrade explain`: what a report means."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from grader.commands import completion
from grader.commands.common import console


def explain(
    id_: Annotated[
        str | None,
        typer.Argument(
            metavar="ID",
            help="A mistake, a check or a criterion; without one, all that there are.",
            autocompletion=completion.explained,
        ),
    ] = None,
) -> int:
    """Explain a mistake that a report names, or what a check asks for.

    \b
    Examples:
      imugrade explain
      imugrade explain sensor-id-as-address
      imugrade explain filtering.follows_recursion
    """
    from grader.handbook import entries  # noqa: PLC0415

    if id_ is None:
        print(entries.listing(), end="")
    else:
        _show_markdown(entries.explain(id_))
    return 0


def _show_markdown(text: str) -> None:
    """Set on a terminal, as it is in a pipe."""
    if sys.stdout.isatty():  # rich itself takes longer to import than all else that is done here
        from rich.markdown import Markdown  # noqa: PLC0415

        screen = console()
        screen.print(Markdown(text), width=min(screen.width, 100))
    else:
        print(text, end="")
