"""Recognise names that the lab sheet requires and a file spells differently: in other case, without underscores, one letter off."""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator, Sequence
from typing import Any

from . import statements


def misspelled(nodes: Sequence[ast.stmt], wanted: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yield (required name, its misspelling) for each `wanted` name that `nodes` lack and just one definition there resembles."""
    missed = set(wanted).difference(*map(statements.bound, nodes))
    for name in sorted(missed):
        kind = ast.ClassDef if name[0].isupper() else ast.FunctionDef
        near = {node.name for node in nodes if isinstance(node, kind) and is_near(node.name, name)}
        if len(near) == 1:
            yield name, near.pop()


def is_near(own: str, name: str) -> bool:
    """Return whether two names differ only in case, underscores and at most one letter, so that one counts as the other misspelled.

    The letter may be different, missing, additional or exchanged with its neighbour.
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


members_of = type.__dict__["__dict__"].__get__
"""Function that returns a class's own members; it asks `type`, not a metaclass of the student's."""


def alias_misspelled_method(own: Any, name: str, wanted: Collection[str], known: dict[str, str]) -> None:
    """Give class `own` its required methods under the right names, and add them to `known`, {``Class.method``: student's name}.

    A method gets its right name if the class lacks it and just one method's name is near it (`is_near`). `wanted` lists the
    required methods as ``Class.method``, where ``Class`` is `name` for those of this class.
    """
    for each in wanted:
        kind, _, method = each.partition(".")
        if kind == name:
            known.pop(each, None)
            members = _members(own)
            near = [member for member in members if is_near(member, method)]
            if len(near) == 1 and members.isdisjoint((method, "__getattr__")):
                type.__setattr__(own, method, getattr(own, near[0]))
                known[each] = near[0]


def _members(own: Any) -> set[str]:
    """Return the names that a class and its bases define; an empty set for anything that is no class."""
    kinds = type.mro(own) if issubclass(type(own), type) else ()
    return {member for kind in kinds for member in members_of(kind) if type(member) is str}
