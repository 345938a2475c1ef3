"""Definitions under a name that is a slip of the pen away from the one that is asked for."""

from __future__ import annotations

import ast
import difflib
from collections.abc import Collection, Iterator, Sequence

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
