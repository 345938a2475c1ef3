"""Options and output shared by several commands."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from grader.base.errors import RequestError

if TYPE_CHECKING:
    from rich.console import Console

Word = TypeVar("Word", bound=str | None)

SECRET_VARIABLE = "IMUGRADE_SEED"
RubricOption = Annotated[
    Path | None,
    typer.Option(
        "--rubric", metavar="FILE", help="Use this rubric.yaml instead of the one on record or the shipped one."
    ),
]
SeedOption = Annotated[
    str | None,
    typer.Option(
        "--seed",
        envvar=SECRET_VARIABLE,
        show_envvar=False,
        metavar="TEXT",
        help="Secret for hidden scenarios. Prefer IMUGRADE_SEED: other users can see a command line.",
    ),
]
OutArgument = Annotated[
    Path, typer.Argument(metavar="OUT", resolve_path=True, help="The output folder of `imugrade grade`.")
]
StudentArgument = Annotated[
    str | None, typer.Argument(metavar="ID", help="The student: id, name or e-mail.", show_default=False)
]
CommentOption = Annotated[str, typer.Option("--comment", metavar="TEXT", help="The reason. The student can read it.")]
AuthorOption = Annotated[
    str | None, typer.Option("--author", metavar="NAME", help="The author. Default: the logged-in user.")
]
TrustOption = Annotated[bool, typer.Option("--trust-submissions", help="Grade without isolation.")]
WeakSecretOption = Annotated[bool, typer.Option("--weak-secret", help="Use a secret that can be guessed.")]
LevelOption = Annotated[str | None, typer.Option("--isolation", hidden=True)]


def as_points(text: object) -> float:
    """Return an option's points as a number, also with a decimal comma; raise `BadParameter` for other text."""
    from grader.base.text import decimal  # noqa: PLC0415

    value = decimal(str(text))
    if value is None:
        raise typer.BadParameter(f"{text!s:.40} is not a number. Write it like 2.5.")
    return value


def one_of(option: str, value: Word, known: Sequence[str]) -> Word:
    """Return the value of `option` if it is None or among the words `known`, else raise a RequestError that lists these."""
    from grader.base.text import printable  # noqa: PLC0415

    if value is not None and value not in known:
        raise RequestError(f"{option} {printable(value)}: unknown value; choose {', '.join(known)}")
    return value


def shown_path(path: Path) -> str:
    """Return a path as text for messages: relative to the working folder if the path lies in it, else unchanged."""
    folder = Path.cwd()
    return str(path.relative_to(folder) if path.is_relative_to(folder) else path)


def say(line: str) -> None:
    """Print one line for the user on stderr, with `imugrade:` in front, so that stdout holds only results."""
    from grader.base.text import printable  # noqa: PLC0415

    print(f"imugrade: {printable(line, 2000)}", file=sys.stderr, flush=True)


def console() -> Console:
    from rich.console import Console  # noqa: PLC0415

    return Console(highlight=False, markup=False, emoji=False)


def login() -> str:
    """Return the user's login name, which signs a decision without --author; "unknown" if the machine has none."""
    import getpass  # noqa: PLC0415

    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):
        return "unknown"
