"""Search a sandbox from inside for any copy of the grader or of the reference."""

from __future__ import annotations

import ast
import contextlib
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from . import rootfs, surroundings
from .isolation_levels import IsolationLevel
from .plan import Contents
from .sandbox import Sandbox

_WORKER_CODE = Path(__file__).parent / "searching"
_PACKAGE = Path(__file__).parents[1]
_SECRETS = (("reference", "*.py"), (f"{_PACKAGE.name}/labs", "*/standins/*.txt"))
_WITHIN_CPU_S = 300.0


@dataclass(frozen=True)
class Search:
    """The number of files that could be opened in a sandbox, and those of the grader (a hundred at most)."""

    opened: int
    found: tuple[str, ...]


def search(isolation_level: IsolationLevel) -> Search:
    """Open whatever a submission could open on this isolation level, and look for our names and for lines of ours in it.

    Raises
    ------
    GraderError
        If the isolation level cannot be had here.
    """
    with Sandbox(Contents(_WORKER_CODE), isolation_level=isolation_level.name) as sandbox, sandbox.worker() as worker:
        fields = {"roots": _roots(), "phrases": sorted(_phrases()), "own": _own()}
        answer = worker.ask("search", fields, cpu_s=_WITHIN_CPU_S).fields
    return Search(int(answer["opened"]), tuple(map(str, answer["found"])))


def _roots() -> list[str]:
    """Return the folders to start from: on an isolation level with the host's root, / itself cannot be listed."""
    shown = surroundings.visible()
    return list(dict.fromkeys(["/", str(_PACKAGE.parent), os.getcwd(), *filter(None, sys.path), *shown]))


def _own() -> list[str]:
    """Return the grader's files that every sandbox needs."""
    return [rootfs.SANDBOX, rootfs.WORKER_CODE, str(_WORKER_CODE), *surroundings.code()]


def _phrases() -> Iterator[str]:
    """Lines that no file holds by chance, of each file that a submission must not read."""
    for folder, pattern in _SECRETS:
        for path in (_PACKAGE.parent / folder).glob(pattern):
            text = path.read_text(encoding="utf-8")
            yield from filter(None, [_longest(text), _first_sentence(text)])


def _longest(text: str) -> str:
    return max(map(str.strip, text.splitlines()), key=len, default="")


def _first_sentence(text: str) -> str:
    """Return the first line of a module's docstring, which its compiled file holds, too."""
    with contextlib.suppress(SyntaxError):
        return (ast.get_docstring(ast.parse(text)) or "").partition("\n")[0]
    return ""
