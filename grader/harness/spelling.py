"""Definitions under another name than the one that is asked for, where only one thing can be meant.

A function or a class is meant by a name that is a slip of the pen away. A method of a class that has its right name is meant by the
only one that takes as much and gives something back, whatever word it has: what the class is for is known.
"""

from __future__ import annotations

import ast
import difflib
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from . import stepping

_CLOSE = 0.9
"""Of the letters in common, as difflib counts: one in ten is lost, doubled or another. Other words for a thing have fewer."""


def slips(nodes: Sequence[ast.stmt], wanted: Collection[str]) -> Iterator[tuple[str, str]]:
    """The wanted names that these statements of a file do not bind, each with the one definition that must mean it."""
    missed = set(wanted).difference(*map(stepping.bound, nodes))
    for name in sorted(missed):
        kind = ast.ClassDef if name[0].isupper() else ast.FunctionDef
        near = {node.name for node in nodes if isinstance(node, kind) and _is_near(node.name, name)}
        if len(near) == 1:
            yield name, near.pop()


def _is_near(own: str, name: str) -> bool:
    own, name = (each.casefold().replace("_", "") for each in (own, name))
    return difflib.SequenceMatcher(None, own, name).ratio() >= _CLOSE


def constructors(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Let the one method of a class that must mean `__init__` be called so, as `Class.__init__`, and what it was called."""
    for kind in [node for node in tree.body if isinstance(node, ast.ClassDef)]:
        methods = [node for node in kind.body if isinstance(node, ast.FunctionDef)]
        near = [node for node in methods if _means_init(node)]
        if len(near) == 1 and all(node.name != "__init__" for node in methods):
            yield f"{kind.name}.__init__", near[0].name
            near[0].name = "__init__"


def _means_init(method: ast.FunctionDef) -> bool:
    """Whether it has nearly that name, and keeps what it is given."""
    plain = method.name.casefold().strip("_")
    keeps = any(isinstance(each, ast.Attribute) and isinstance(each.ctx, ast.Store) for each in ast.walk(method))
    near = sorted(plain) == sorted("init") or difflib.SequenceMatcher(None, plain, "init").ratio() >= _NEARLY_INIT
    return keeps and len(method.args.args) > 1 and near and (plain == "init" or method.name.startswith("_"))


_NEARLY_INIT = 0.85


# ---------------------------------------------------------------- methods


def other_methods(nodes: Sequence[ast.stmt], wanted: Mapping[str, int]) -> Iterator[tuple[str, str]]:
    """The wanted methods, as `Class.method`, of classes of these statements, each with the one that must mean it if there is none.

    Parameters
    ----------
    wanted : how many values each is given
    """
    classes = {node.name: node for node in nodes if isinstance(node, ast.ClassDef)}
    for name, values in wanted.items():
        kind, _, method = name.partition(".")
        members = _members(classes[kind], classes) if kind in classes else {}
        if not members or method in members or any(_speaks_of(node, method) for node in nodes):
            continue
        does = [own for own, node in members.items() if _does(node, values)]
        public = [own for own in does if not own.startswith("_")]
        alike = [own for own in public if method in own.casefold()]
        meant = alike or public or [own for own in does if own == "__call__"]
        if len(meant) == 1:
            yield name, meant[0]


def _speaks_of(node: ast.AST, method: str) -> bool:
    """Whether anything there sets such an attribute, or may do so by its name."""
    return any(
        (isinstance(each, ast.Attribute) and isinstance(each.ctx, ast.Store) and each.attr == method)
        or (isinstance(each, ast.Constant) and each.value == method)
        for each in ast.walk(node)
    )


def _members(kind: ast.ClassDef, classes: Mapping[str, ast.ClassDef]) -> dict[str, ast.FunctionDef]:
    """The methods of a class, with those of the bases that stand in the same file."""
    found: dict[str, ast.FunctionDef] = {}
    for base in kind.bases:
        if isinstance(base, ast.Name) and base.id in classes and base.id != kind.name:
            found |= {node.name: node for node in classes[base.id].body if isinstance(node, ast.FunctionDef)}
    return found | {node.name: node for node in kind.body if isinstance(node, ast.FunctionDef)}


def _does(method: ast.FunctionDef, values: int) -> bool:
    """Whether it is an ordinary method that has to be given so many values, and returns something."""
    given = [*method.args.posonlyargs, *method.args.args]
    needed = len(given) - 1 - len(method.args.defaults)
    returned = [each.value for each in ast.walk(method) if isinstance(each, ast.Return)]
    return not method.decorator_list and needed == values and any(value is not None for value in returned)


members_of = type.__dict__["__dict__"].__get__
"""What a class holds, whatever its own class would answer."""


def call_by_right_names(own: Any, name: str, meant: Mapping[str, str], known: dict[str, str]) -> None:
    """Let the methods of a class that has none of the right name be called by that, too; `known` says which."""
    for wanted in [each for each in known if each.partition(".")[0] == name]:
        del known[wanted]
    for wanted, method in meant.items():
        kind, _, right = wanted.partition(".")
        if kind == name and issubclass(type(own), type) and not _has(own, right):
            type.__setattr__(own, right, getattr(own, method))
            known[wanted] = method


def _has(own: type, method: str) -> bool:
    """Whether a class has a method, or may find one where it is asked for."""
    return any({method, "__getattr__"} & {*members_of(kind)} for kind in type.mro(own))
