"""Supply names that a file of the submission uses and forgot to import: libraries of the sheet, and what a partner file defines.

On the sheet all code stands in one program, so a file that was cut out of it lacks both. The names are put among its globals;
nothing in the student's text is edited. The grader is told which names were supplied, and notes them.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from inspect import CO_COROUTINE
from types import CodeType, FunctionType, ModuleType
from typing import Any

from . import name_analysis, stepping

_BRING_NAMES = ("exec", "globals", "vars", "locals", "setattr", "get_ipython")  # unseen; so may a cell that waits


class MissingImports:
    """The names that one file or notebook lacks, and when each is supplied.

    A library is supplied before the first statement runs, or after the last star import, which may bring it along. What a partner
    defines is supplied after the last definition, as the partner may import this file.

    Parameters
    ----------
    units : the file's statements
    libraries : those of the sheet, by the names that it imports them under
    wanted : the names that the sheet asks for, some of which partner files define
    find : returns what a name stands for; None where nothing does
    """

    def __init__(
        self,
        units: Sequence[stepping.Unit],
        libraries: Collection[str],
        wanted: Collection[str],
        find: Callable[[str], Any],
    ) -> None:
        self._nodes, self._wanted, self._find = [unit.node for unit in units], wanted, find
        in_code = {name for unit in units for name in _names(unit.code)}
        imported = [node for node in self._nodes if not stepping.is_main_guard(node)]
        at_top = {name for node in imported for name in (*stepping.bound(node), *name_analysis.imported(node))}
        unsure = in_code.intersection(_BRING_NAMES) or any(unit.code.co_flags & CO_COROUTINE for unit in units)
        missed = set() if unsure else name_analysis.used(self._nodes).intersection(in_code) - at_top
        self._libraries, self._partners = sorted(missed & set(libraries)), sorted(missed & set(wanted))
        from_others = {name for node in self._nodes for name in name_analysis.imported(node)}
        self._renamed = sorted(from_others & set(wanted))
        self._brought = sorted(set(libraries) & (in_code if "*" in from_others else from_others))
        self._defined: dict[str, Any] = {}
        definitions = [node for node in self._nodes if isinstance(node, stepping.DEFINITIONS)]
        stars = [node for node in self._nodes if isinstance(node, ast.ImportFrom) and node.names[0].name == "*"]
        self._last_definition = definitions[-1] if definitions else None
        self._last_star = stars[-1] if stars else None
        self.supplied: list[str] = []

    def before(self, names: dict[str, Any]) -> None:
        """Supply libraries before a file without star imports runs."""
        if self._last_star is None:
            self._supply(self._libraries, names)

    def after(self, node: ast.stmt, names: dict[str, Any]) -> None:
        """Supply what is due after this statement."""
        if node is self._last_star:
            self._supply(self._libraries, names)
        if isinstance(node, stepping.DEFINITIONS) and node.name in self._wanted:
            self._defined[node.name] = names.get(node.name)
        if node is self._last_definition:
            self._supply(self._partners, names)
            self._supply([name for name in self._renamed if isinstance(names.get(name), stepping.NotThere)], names)

    def at_end(self, names: dict[str, Any]) -> None:
        """Restore libraries and definitions that the file's later lines bound to a value, such as ``plt = plt.figure()``."""
        for name in [name for name in self._brought if not isinstance(names.get(name), ModuleType | stepping.NotThere)]:
            if name in names and (library := self._find(name)) is not None:
                names[name] = library
                self.supplied.append(name)
        for name, made in self._defined.items():
            now = names.get(name)
            if isinstance(made, type | FunctionType) and now is not made and not callable(now):
                names[name] = made
                self.supplied.append(name)

    def _supply(self, missed: Sequence[str], names: dict[str, Any]) -> None:
        for name in missed:
            if self._is_lacking(name, names) and (found := self._find(name)) is not None:
                names[name] = found
                self.supplied.append(name)

    def _is_lacking(self, name: str, names: Mapping[str, Any]) -> bool:
        """Return whether the file uses the name and binds it nowhere, or imports it from where it is not."""
        if name in names:
            return isinstance(names[name], stepping.NotThere) and name in name_analysis.used(self._nodes)
        return name in name_analysis.used(self._nodes) and all(
            name not in name_analysis.bound(node) for node in self._nodes
        )


def _names(code: CodeType) -> Iterator[str]:
    """Yield the global names and attributes that code and its inner code use; variables of the code itself are left out."""
    own = {*code.co_varnames, *code.co_cellvars, *code.co_freevars}
    yield from (name for name in code.co_names if name not in own)
    for const in code.co_consts:
        if isinstance(const, CodeType):
            yield from _names(const)
