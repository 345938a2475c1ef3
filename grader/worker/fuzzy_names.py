"""Required names that a file spells differently: in other case, without underscores, or one letter off."""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from . import stepping


def misspelled(nodes: Sequence[ast.stmt], wanted: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yield each wanted name that these statements do not bind, with the one definition whose name is nearly that."""
    missed = set(wanted).difference(*map(stepping.bound, nodes))
    for name in sorted(missed):
        kind = ast.ClassDef if name[0].isupper() else ast.FunctionDef
        near = {node.name for node in nodes if isinstance(node, kind) and is_near(node.name, name)}
        if len(near) == 1:
            yield name, near.pop()


def is_near(own: str, name: str) -> bool:
    """Return whether two names differ in case and underscores, and in one letter beyond that.

    One letter is another, missing, too many, or exchanged with its neighbour.
    """
    own, name = (each.casefold().replace("_", "") for each in (own, name))
    shorter, longer = sorted((own, name), key=len)
    if len(longer) - len(shorter) > 1:
        return False
    same = next((at for at, (a, b) in enumerate(zip(shorter, longer, strict=False)) if a != b), len(shorter))
    left, right = shorter[same:], longer[same:]
    if len(left) < len(right):
        return left == right[1:]
    return left[1:] == right[1:] or (left[:2] == right[1::-1] and left[2:] == right[2:])


def misspelled_methods(nodes: Sequence[ast.stmt], wanted: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yield each wanted ``Class.method`` that a class of these statements lacks, with the one method whose name is nearly that."""
    classes = {node.name: node for node in nodes if isinstance(node, ast.ClassDef)}
    for name in wanted:
        kind, _, method = name.partition(".")
        members = _methods(classes[kind], classes) if kind in classes else set()
        near = [own for own in members if is_near(own, method)]
        if method not in members and len(near) == 1:
            yield name, near[0]


def _methods(kind: ast.ClassDef, classes: Mapping[str, ast.ClassDef]) -> set[str]:
    """Return the names of a class's methods, with those of its bases in the same file."""
    bases = [base.id for base in kind.bases if isinstance(base, ast.Name) and base.id != kind.name]
    bodies = [kind.body, *(classes[base].body for base in bases if base in classes)]
    return {node.name for body in bodies for node in body if isinstance(node, ast.FunctionDef)}


members_of = type.__dict__["__dict__"].__get__
"""The members of a class, whatever its own class would answer."""


def call_by_right_names(own: Any, name: str, meant: Mapping[str, str], known: dict[str, str]) -> None:
    """Let misspelled methods of a class be called by their right names, too; `known` collects which."""
    for wanted in [each for each in known if each.partition(".")[0] == name]:
        del known[wanted]
    for wanted, method in meant.items():
        kind, _, right = wanted.partition(".")
        if kind == name and issubclass(type(own), type) and not _has(own, right):
            type.__setattr__(own, right, getattr(own, method))
            known[wanted] = method


def _has(own: type, method: str) -> bool:
    """Return whether a class has a method, or may find one when it is asked for."""
    return any({method, "__getattr__"} & {*members_of(kind)} for kind in type.mro(own))
