"""Supply names that a file uses and forgot to import: libraries of the lab sheet, and what another required file defines.

On the sheet all code stands in one program, so a file that was cut out of it lacks both. The names are put among its globals;
nothing in the student's text is edited. The grader is told which names were supplied, and notes them in the report.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Sequence
from inspect import CO_COROUTINE
from types import FunctionType
from typing import Any

from . import name_analysis, statements

# Calls that may define names which the analysis misses.
_BRING_NAMES = ("exec", "globals", "vars", "locals", "setattr", "get_ipython")


class MissingImports:
    """Names that one file or notebook uses but does not import, supplied by calls of `before`, `after` and `at_end` while it runs.

    A library is supplied before the first statement, or after the last star import, which may bring it along. A name from another
    required file (a partner) is supplied after this file's last definition, because the partner may import this file in turn.

    Parameters
    ----------
    units : the file's statements
    libraries : libraries of the lab sheet, by the names that the sheet imports them under
    wanted : the names that the sheet asks for, some of which partners define
    find : returns the object of a missing name, which is a library or defined by a partner; None if it cannot be had
    """

    def __init__(
        self,
        units: Sequence[statements.Unit],
        libraries: Collection[str],
        wanted: Collection[str],
        find: Callable[[str], Any],
    ) -> None:
        self._wanted, self._find = wanted, find
        self._defined: dict[str, Any] = {}
        nodes = [unit.node for unit in units]
        used, imported = name_analysis.used(nodes), {name for node in nodes for name in name_analysis.imported(node)}
        missed = used.intersection([*libraries, *wanted]) - imported.union(*map(statements.bound, nodes))
        if used.intersection(_BRING_NAMES) or any(unit.code.co_flags & CO_COROUTINE for unit in units):
            missed.clear()
        if missed:  # few files miss anything, and to look for names at any depth takes long
            missed -= {name for node in nodes for name in name_analysis.bound(node)}
        self._libraries, self._partners = sorted(missed & set(libraries)), sorted(missed & set(wanted))
        self._renamed = sorted(imported & used & set(wanted))
        definitions = [node for node in nodes if isinstance(node, statements.DEFINITIONS)]
        stars = [node for node in nodes if isinstance(node, ast.ImportFrom) and node.names[0].name == "*"]
        self._last_definition = definitions[-1] if definitions else None
        self._last_star = stars[-1] if stars else None
        self.supplied: list[str] = []

    def before(self, names: dict[str, Any]) -> None:
        """Before a file without star imports runs, put libraries that it forgot to import into its namespace `names`."""
        if self._last_star is None:
            self._supply(self._libraries, names)

    def after(self, node: ast.stmt, names: dict[str, Any]) -> None:
        """Note the required name that statement `node` just defined, and supply missing names in the file's namespace `names`.

        Libraries are supplied after the last star import, names from other required files after the last definition.
        """
        if node is self._last_star:
            self._supply(self._libraries, names)
        if isinstance(node, statements.DEFINITIONS) and node.name in self._wanted:
            self._defined[node.name] = names.get(node.name)
        if node is self._last_definition:
            self._supply(self._partners, names)
            self._supply([name for name in self._renamed if name in names], names)

    def at_end(self, names: dict[str, Any]) -> None:
        """After the last statement, restore in `names` required functions and classes that the file deleted or made uncallable.

        They were noted by `after` when they were defined. Their names are added to `supplied`, which the report lists.
        """
        for name, made in self._defined.items():
            if isinstance(made, type | FunctionType) and not callable(names.get(name)):
                names[name] = made
                self.supplied.append(name)

    def _supply(self, missed: Sequence[str], names: dict[str, Any]) -> None:
        """Supply those of the `missed` names that are still not there, or whose import failed, and note them in `supplied`."""
        for name in missed:
            lacking = name not in names or isinstance(names[name], statements.MissingName)
            if lacking and (found := self._find(name)) is not None:
                names[name] = found
                self.supplied.append(name)
