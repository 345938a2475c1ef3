"""From the text of a file, or of a notebook's cell, to the statements that run and the names that they define."""

from __future__ import annotations

import ast
import contextlib
import importlib.util
import linecache
import re
from pathlib import Path

from . import completing, faults, gaps, mending, newer, notebooks, packages, returning, spelling, stepping
from .submission import STATE

_RELATIVE = re.compile(r"\bfrom[\s\\]*\.")


def units_in(source: bytes, path: str, *, flags: int = 0) -> list[stepping.Unit] | None:
    """The statements of a file or a cell; None where it is no Python, which is kept in mind."""
    try:
        return _compiled(source, path, flags)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as refused:
        STATE.unreadable[path] = faults.describe(refused)
        return None


def _compiled(source: bytes, path: str, flags: int) -> list[stepping.Unit]:
    text, own = _decoded(source), faults.own_name(path)
    _remember(own, text)
    try:
        return _units(text, path, flags)
    except SyntaxError as refused:
        found = completing.completed(text, refused, lambda tried: _read(tried, own, flags))
        if found is None:
            return gaps.units_around(text, own, STATE.stepper.wanted, refused, flags=flags)
    completed, said = found
    _remember(own, completed)
    tree = _parsed(completed, own)
    told = [(gaps.belongs_to(tree, each.lineno or 0, STATE.stepper.wanted), faults.describe(each)) for each in said]
    STATE.completed.setdefault(path.partition(":cell ")[0], []).extend(told)
    return _units(completed, path, flags)


def _remember(own: str, text: str) -> None:
    linecache.cache[own] = (len(text), None, text.splitlines(keepends=True), own)


def _read(text: str, own: str, flags: int) -> None:
    """Raise what Python refuses it for."""
    stepping.units_of(_parsed(text, own), own, flags=flags)


def _units(text: str, path: str, flags: int) -> list[stepping.Unit]:
    own = faults.own_name(path)
    tree = _parsed(text, own)
    STATE.begun.setdefault(path.partition(":cell ")[0], []).extend(spelling.constructors(tree))
    mending.mend(tree, path)
    if _RELATIVE.search(text):
        packages.without_dots(tree, path)  # let files that were written as a package import each other
    lacked = returning.completed(tree, STATE.furniture.get("returns", {}))
    STATE.unreturned.setdefault(path.partition(":cell ")[0], {}).update(lacked)
    return stepping.units_of(tree, own, flags=flags)


def _decoded(source: bytes) -> str:
    """Source text by its declared encoding; bytes that are not UTF-8 and declare nothing are taken for Latin-1."""
    try:
        return importlib.util.decode_source(source)
    except (UnicodeDecodeError, SyntaxError):
        if source.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\0" in source:
            raise SyntaxError("the file is not UTF-8 text (it looks like UTF-16): save it as UTF-8") from None
        return source.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n")


def _parsed(text: str, own: str) -> ast.Module:
    """What Python reads there, or what a later one would."""
    try:
        return ast.parse(text, own)
    except SyntaxError:
        later = newer.reworded(text)
        if later is None:
            raise
        with contextlib.suppress(SyntaxError):
            return ast.parse(later, own)
        raise


def defined(path: str) -> set[str]:
    """The names that a file or a notebook defines at its top level, read from its text; nothing of it runs."""
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
            names.update(name for node in parsed for name in stepping.bound(node))
            nodes += parsed
        except SyntaxError:
            names.update(gaps.names_in(text))
        except (ValueError, RecursionError, MemoryError):
            continue
    return names.union(name for name, _ in spelling.slips(nodes, STATE.at_home_in(path)))
