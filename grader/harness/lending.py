"""What a file uses and nobody imports: a forgotten line, for which all else in the file would fail.

The library or the partner's function is lent to it. Whoever marks is told which definition it was lent to, as one fault.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Iterator, Sequence
from inspect import CO_COROUTINE
from types import CodeType
from typing import Any

from . import stepping

_BRING_NAMES = ("exec", "globals", "vars", "locals", "setattr", "get_ipython")  # unseen; so may a cell that waits


class Lending:
    """What one file or notebook may be lent, and when.

    A library is there from the beginning, or once the last star import is over, which may bring it along. What a partner defines
    is there once the last definition is, as the partner may import this file.

    Parameters
    ----------
    units : the file's statements
    libraries : those of the sheet, by the names that it imports them under
    wanted : the names that are asked for, of which the partners define some, and one of which each loan is told of
    lend : gives what a name stands for; None where nothing does
    """

    def __init__(
        self,
        units: Sequence[stepping.Unit],
        libraries: Collection[str],
        wanted: Collection[str],
        lend: Callable[[str], Any],
    ) -> None:
        self._nodes, self._wanted, self._lend = [unit.node for unit in units], wanted, lend
        spoken_of = {name for unit in units for name in _names(unit.code)}
        at_top = {name for node in self._nodes for name in (*stepping.bound(node), *_imported(node))}
        unsure = spoken_of.intersection(_BRING_NAMES) or any(unit.code.co_flags & CO_COROUTINE for unit in units)
        missed = set() if unsure else spoken_of - at_top
        self._libraries, self._partners = sorted(missed & set(libraries)), sorted(missed & set(wanted))
        self._definitions = [node for node in self._nodes if isinstance(node, stepping.DEFINITIONS)]
        self._stars = [node for node in self._nodes if isinstance(node, ast.ImportFrom) and node.names[0].name == "*"]
        self.lent: list[tuple[str, str]] = []

    def before(self, names: dict[str, Any]) -> None:
        if not self._stars:
            self._fill(self._libraries, names)

    def after(self, node: ast.stmt, names: dict[str, Any]) -> None:
        if self._stars and node is self._stars[-1]:
            self._fill(self._libraries, names)
        if self._definitions and node is self._definitions[-1]:
            self._fill(self._partners, names)

    def _fill(self, missed: Sequence[str], names: dict[str, Any]) -> None:
        for name in missed:
            if name not in names and self._is_lacking(name) and (found := self._lend(name)) is not None:
                names[name] = found
                self.lent.append((self._user_of(name), name))

    def _is_lacking(self, name: str) -> bool:
        """Whether the file uses it by this name, and binds it nowhere."""
        return name in _used(self._nodes) and all(name not in _bound(node) for node in self._nodes)

    def _user_of(self, name: str) -> str:
        """The definition that it is told of: the first wanted one that uses it, or that may use another that does; else none."""
        using = [node.name for node in self._definitions if name in _used([node])]
        wanted = [node.name for node in self._definitions if node.name in self._wanted]
        return next((user for user in wanted if user in using), wanted[0] if using and wanted else "")


def _names(code: CodeType) -> Iterator[str]:
    """What code speaks of by names: globals, and attributes among them."""
    yield from code.co_names
    for const in code.co_consts:
        if isinstance(const, CodeType):
            yield from _names(const)


def _imported(node: ast.AST) -> list[str]:
    if not isinstance(node, ast.Import | ast.ImportFrom):
        return []
    return [(alias.asname or alias.name).split(".")[0] for alias in node.names]


def _used(nodes: Sequence[ast.stmt]) -> set[str]:
    names = (each for node in nodes for each in ast.walk(node) if isinstance(each, ast.Name))
    return {each.id for each in names if isinstance(each.ctx, ast.Load)}


def _bound(node: ast.AST) -> Iterator[str]:
    """All names that anything in a statement binds, wherever."""
    for each in ast.walk(node):
        if isinstance(each, ast.Name) and not isinstance(each.ctx, ast.Load):
            yield each.id
        elif isinstance(each, ast.arg):
            yield each.arg
        elif isinstance(each, ast.Import | ast.ImportFrom):
            yield from _imported(each)
        elif isinstance(each, ast.Global | ast.Nonlocal):
            yield from each.names
        elif isinstance(each, (*stepping.DEFINITIONS, ast.ExceptHandler, ast.MatchAs, ast.MatchStar)):
            yield each.name or ""
