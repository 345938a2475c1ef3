"""What a file's functions use and the file has not when it is imported: a forgotten line, for which all else in it would fail.

The library or the partner's function is lent to it; so is what the file imports within another function, and what it imports or
sets below its main guard, or as a global of another function, where a program that runs it finds it. Whoever marks is told which
definition it was lent to, as one fault.
"""

from __future__ import annotations

import ast
import contextlib
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from inspect import CO_COROUTINE
from types import CodeType, FunctionType, ModuleType
from typing import Any

from . import stepping, within

_BRING_NAMES = ("exec", "globals", "vars", "locals", "setattr", "get_ipython")  # unseen; so may a cell that waits


class Lending:
    """What one file or notebook may be lent, and when.

    A library is there from the beginning, or once the last star import is over, which may bring it along. What a partner defines
    is there once the last definition is, as the partner may import this file; so is what stands elsewhere in the file.

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
        imported = [node for node in self._nodes if not stepping.is_main_guard(node)]
        at_top = {name for node in imported for name in (*stepping.bound(node), *within.imported(node))}
        unsure = spoken_of.intersection(_BRING_NAMES) or any(unit.code.co_flags & CO_COROUTINE for unit in units)
        seen = within.look(self._nodes)
        missed = set() if unsure else seen.names.intersection(spoken_of) - at_top
        self._libraries, self._partners = sorted(missed & set(libraries)), sorted(missed & set(wanted))
        self._elsewhere = {name: line for name, line in within.elsewhere(self._nodes, seen) if name in missed}
        self._forgotten = dict(within.forgotten(self._nodes, missed - self._elsewhere.keys()))
        from_others = {name for node in self._nodes for name in within.imported(node)}
        self._renamed = sorted(from_others & set(wanted))
        self._brought = sorted(set(libraries) & (spoken_of if "*" in from_others else from_others))
        self._defined: dict[str, Any] = {}
        self._definitions = [node for node in self._nodes if isinstance(node, stepping.DEFINITIONS)]
        self._stars = [node for node in self._nodes if isinstance(node, ast.ImportFrom) and node.names[0].name == "*"]
        self.lent: list[tuple[str, str]] = []

    def before(self, names: dict[str, Any]) -> None:
        if not self._stars:
            self._begin(names)

    def after(self, node: ast.stmt, names: dict[str, Any]) -> None:
        if self._stars and node is self._stars[-1]:
            self._begin(names)
        if isinstance(node, stepping.DEFINITIONS) and node.name in self._wanted:
            self._defined[node.name] = names.get(node.name)
        if self._definitions and node is self._definitions[-1]:
            self._fill(self._partners, names)
            self._fill([name for name in self._renamed if isinstance(names.get(name), stepping.NotThere)], names)
            self._bring(self._elsewhere, names)

    def at_end(self, names: dict[str, Any]) -> None:
        """Give back what the file's last lines have put something else in the place of: a library, or a definition."""
        for name in [name for name in self._brought if not isinstance(names.get(name), ModuleType | stepping.NotThere)]:
            if name in names and (library := self._lend(name)) is not None:
                names[name] = library
                self.lent.append((self._user_of(name), name))
        for name, made in self._defined.items():
            now = names.get(name)
            if (
                isinstance(made, type | FunctionType)
                and now is not made
                and not isinstance(now, type)
                and not callable(now)
            ):
                names[name] = made
                self.lent.append((name, name))

    def _begin(self, names: dict[str, Any]) -> None:
        self._fill(self._libraries, names)
        self._bring(self._forgotten, names)

    def _bring(self, lines: Mapping[str, ast.stmt], names: dict[str, Any]) -> None:
        """Run the lines that bring names which are not there, and which a function, or how a definition is made, lacks."""
        for name, line in lines.items():
            if name not in names and within.lacking(name, self._nodes):
                with contextlib.suppress(Exception):
                    exec(compile(ast.Module([line], []), "<lent>", "exec"), names)
                    self.lent.append((self._user_of(name), name))

    def _fill(self, missed: Sequence[str], names: dict[str, Any]) -> None:
        for name in missed:
            if self._is_lacking(name, names) and (found := self._lend(name)) is not None:
                names[name] = found
                self.lent.append((self._user_of(name), name))

    def _is_lacking(self, name: str, names: Mapping[str, Any]) -> bool:
        """Whether the file uses it by this name, and binds it nowhere, or imports it from where it is not."""
        if name in names:
            return isinstance(names[name], stepping.NotThere) and name in within.used(self._nodes)
        return name in within.used(self._nodes) and all(name not in within.bound(node) for node in self._nodes)

    def _user_of(self, name: str) -> str:
        """The definition that it is told of: the first wanted one that uses it, or what does; else any wanted one; else none."""
        using, wanted = [name], [node.name for node in self._definitions if node.name in self._wanted]
        while wanted:
            users = [node.name for node in self._definitions if within.used([node]).intersection(using)]
            if found := [user for user in wanted if user in users]:
                return found[0]
            if set(users) <= set(using):
                return wanted[0] if users else ""
            using += users
        return ""


def _names(code: CodeType) -> Iterator[str]:
    """What code speaks of by names: globals, and attributes among them; a variable's own name is an attribute's there."""
    own = {*code.co_varnames, *code.co_cellvars, *code.co_freevars}
    yield from (name for name in code.co_names if name not in own)
    for const in code.co_consts:
        if isinstance(const, CodeType):
            yield from _names(const)
