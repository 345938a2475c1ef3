"""Compile the source text of a student's file or notebook cell to single statements, and find the names that they define."""

from __future__ import annotations

import ast
import importlib.util
import linecache
import re
from pathlib import Path
from typing import Any

from . import faults, fuzzy_names, notebooks, packages, statements
from .submission import STATE

_RELATIVE = re.compile(r"\bfrom[\s\\]*\.")
# Most statements of a file that are blanked because they do not parse; each costs a parse of the file.
_MOST_LEFT_OUT = 8
_CONTINUES = re.compile(r"[\s)\]}#]|(?:elif|else|except|finally)\b")  # a line that does not begin a statement
_CONFLICT = ("<<<<<<< ", "=======", ">>>>>>> ")  # the lines that `git merge` leaves begin with these
_DEFINES = re.compile(r"^(?:async[ \t]+)?(?:def|class)[ \t]+(\w+)", re.MULTILINE)


def units_in(source: bytes, path: str, *, flags: int = 0) -> list[statements.Unit] | None:
    """Return the compiled statements of a file or a cell; None if it does not parse, with the error in `STATE.unreadable[path]`.

    `flags` are those of `compile`, such as the one that allows a cell a top-level `await`.
    """
    try:
        return _units(_decoded(source), path, flags)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as refused:
        STATE.unreadable[path] = faults.describe(refused) | merge_conflict(source, path)
        return None


def merge_conflict(source: bytes, path: str) -> dict[str, Any]:
    """Return a file's first unresolved merge conflict as an error, in the form of `faults.describe`; an empty dict without one."""
    lines = source.decode("utf-8", "replace").splitlines()
    at = [next((n for n, line in enumerate(lines) if line.startswith(marker)), -1) for marker in _CONFLICT]
    if not -1 < at[0] < at[1] < at[2]:
        return {}
    told = faults.fault_at(path, at[0] + 1, "unresolved merge conflict")
    return told | {"type": "SyntaxError", "text": lines[at[0]][:200]}


def units_that_parse(source: bytes, path: str) -> list[statements.Unit]:
    """Return those statements of a file with syntax errors that parse, so that its plots are drawn; [] if eight or more fail to."""
    own = faults.own_name(path)
    try:
        lines = _decoded(source).splitlines()
        for _ in range(_MOST_LEFT_OUT):
            try:
                return statements.units_of(ast.parse("\n".join(lines), own), own)
            except SyntaxError as refused:
                _leave_out(lines, refused)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        pass
    return []


def _leave_out(lines: list[str], refused: SyntaxError) -> None:
    """Blank in `lines` the top-level statement that does not parse, with its decorators; the error `refused` says where it is."""
    at = min(refused.lineno or 1, len(lines)) - 1
    starts = [n for n, line in enumerate(lines) if line and not _CONTINUES.match(line)]
    if isinstance(refused, IndentationError) and at in starts:
        at -= 1  # the statement before this one lacks its block
    first = max((n for n in starts if n <= at), default=0)
    last = min((n for n in starts if n > at), default=len(lines))
    while first and lines[first - 1].startswith("@"):
        first -= 1
    lines[first:last] = [""] * (last - first)


def _units(text: str, path: str, flags: int) -> list[statements.Unit]:
    own = faults.own_name(path)
    linecache.cache[own] = (len(text), None, text.splitlines(keepends=True), own)
    tree = ast.parse(text, own)
    if _RELATIVE.search(text):
        packages.make_imports_absolute(tree, path)  # let files that were written as a package import each other
    if ".ndarray(" in text:
        _make_ndarrays_empty(tree)
    return statements.units_of(tree, own, flags=flags)


def _make_ndarrays_empty(tree: ast.Module) -> None:
    """Replace calls `np.ndarray(shape)` by `np.empty(shape)`, which `repeatability` fills, so that unwritten values are found."""
    for call in ast.walk(tree):
        if isinstance(call, ast.Call) and ast.unparse(call.func) in ("np.ndarray", "numpy.ndarray"):
            named = {keyword.arg for keyword in call.keywords}
            if len(call.args) <= 2 and named <= {"shape", "dtype", "order"}:  # no buffer
                vars(call.func)["attr"] = "empty"


def _decoded(source: bytes) -> str:
    """Decode source text as declared, as UTF-8, or else as Latin-1; raise SyntaxError for UTF-16, which Python cannot read."""
    try:
        return importlib.util.decode_source(source)
    except (UnicodeDecodeError, SyntaxError):
        if source.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\0" in source:
            raise SyntaxError("the file is not UTF-8 text (it looks like UTF-16): save it as UTF-8") from None
        return source.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n")


def defined(path: str) -> set[str]:
    """Return the names that a file or notebook defines at top level; for a misspelled one, the required name too. No code runs.

    Of text that does not parse, only names after ``def`` or ``class`` at a line's start are found; of an undecodable file, none.
    """
    content = Path(STATE.folder, path).read_bytes()
    try:
        texts = notebooks.code_cells(content) if path.endswith(".ipynb") else [_decoded(content)]
    except (ValueError, SyntaxError, RecursionError):
        return set()
    names: set[str] = set()
    nodes: list[ast.stmt] = []
    for text in texts:
        try:
            parsed = ast.parse(text).body
            names.update(name for node in parsed for name in statements.bound(node))
            nodes += parsed
        except SyntaxError:
            names.update(_DEFINES.findall(text))
        except (ValueError, RecursionError, MemoryError):
            continue
    return names.union(name for name, _ in fuzzy_names.misspelled(nodes, STATE.names_expected_in(path)))
