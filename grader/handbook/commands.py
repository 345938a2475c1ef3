"""The page of the commands, from the command line's own words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import typer

_EXIT_CODES = """## Exit codes

| Code | Means |
| --- | --- |
| 0 | done, and at least `--min-score` |
| 1 | done, but below `--min-score` |
| 2 | the request was wrong: one line that names it |
| 3 | the grader itself failed; what could not be judged is open, never zero |
| 130 | interrupted |
| 141 | nobody read on, as after `\\| head` |

A student's code can never cause 2 or 3.
"""


def page(app: typer.Typer) -> str:
    """Every command that is not hidden, with its arguments, options and examples."""
    root: Any = typer.main.get_command(app)
    return "\n".join(["# Commands\n", _text(root.help), "", *_commands("imugrade", root), _EXIT_CODES])


def _commands(prefix: str, group: Any) -> Iterator[str]:
    for name, command in sorted(group.commands.items()):
        if hasattr(command, "commands"):
            yield from _commands(f"{prefix} {name}", command)
        elif not command.hidden:
            yield _entry(f"{prefix} {name}", command)


def _entry(name: str, command: Any) -> str:
    shown = [each for each in command.params if not getattr(each, "hidden", False) and each.name != "help"]
    arguments = [each.metavar for each in shown if each.param_type_name == "argument"]
    rows = [f"| {_words(each)} | {each.help or ''} |" for each in shown]
    table = ["| | |", "| --- | --- |", *rows, ""] if rows else []
    return "\n".join([f"## `{' '.join([name, *arguments])}`\n", _text(command.help), "", *table])


def _words(parameter: Any) -> str:
    if parameter.param_type_name == "argument":
        return f"`{parameter.metavar}`"
    metavar = f" {parameter.metavar}" if parameter.metavar else ""
    return ", ".join(f"`{word}{metavar}`" for word in parameter.opts)


def _text(text: str) -> str:
    """Help as Markdown: blocks that keep their lines become code."""
    blocks = [_block(block) for block in text.strip().split("\n\n")]
    return "\n\n".join(blocks)


def _block(block: str) -> str:
    lines = [line for line in block.split("\n") if line.strip() != "\b"]
    if len(lines) == len(block.split("\n")):
        return " ".join(line.strip() for line in lines)
    return "\n".join(["```text", *lines, "```"])
