"""Search a sandbox from inside for copies of the grader or of the reference (the model solution), for `imugrade doctor`."""

from __future__ import annotations

import ast
import os
import sys
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
    """Result of `search`: how many files could be opened, and up to 100 paths of grader files among them: there should be none."""

    opened: int
    found: tuple[str, ...]


def search(isolation_level: IsolationLevel, libraries: tuple[str, ...] = ()) -> Search:
    """Find out which files a submission could open on this isolation level, and whether copies of the grader are among them.

    Used by `imugrade doctor`. `libraries` are the lab's packages, which a sandbox shows. Raise GraderError on a refused level.
    """
    # On an isolation level with the host's root, / itself cannot be listed.
    roots = ["/", str(_PACKAGE.parent), os.getcwd(), *filter(None, sys.path), *surroundings.visible((), libraries)]
    own = [rootfs.SANDBOX, rootfs.WORKER_CODE, str(_WORKER_CODE), *surroundings.code()]  # every sandbox needs these
    fields = {"roots": list(dict.fromkeys(roots)), "phrases": _phrases(), "own": own}
    contents = Contents(_WORKER_CODE, packages=libraries)
    with Sandbox(contents, isolation_level=isolation_level.name) as sandbox, sandbox.worker() as worker:
        answer = worker.ask("search", fields, cpu_s=_WITHIN_CPU_S).fields
    return Search(int(answer["opened"]), tuple(map(str, answer["found"])))


def _phrases() -> list[str]:
    """Return, of each file that a submission must not read (reference, stand-ins), a line by which its copies are recognised."""
    paths = (path for folder, pattern in _SECRETS for path in (_PACKAGE.parent / folder).glob(pattern))
    return sorted({_telling_line(path.read_text(encoding="utf-8")) for path in paths} - {""})


def _telling_line(source: str) -> str:
    """Return the first line of a module's docstring, which its compiled file holds, too, or else the longest line; "" if empty."""
    docstring = ast.get_docstring(ast.parse(source))
    return docstring.partition("\n")[0] if docstring else max(map(str.strip, source.splitlines()), key=len, default="")
