"""A definition that stops while it is made, at something that is evaluated then: the same without that, so that the rest counts."""

from __future__ import annotations

import ast
import copy
import itertools
from collections.abc import Iterator

_MOST = 24
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


def lessened(node: ast.stmt, raised: Exception) -> Iterator[tuple[str, ast.stmt]]:
    """A definition without its type ``hints``, then ``less`` one other thing at a time, and how it is told.

    Without a base of a package that is missing, a class would lack most of what it is.
    """
    yield "hints", node
    takings = (each for each in _takings(node) if each.field == "decorator_list" or not isinstance(raised, ImportError))
    for take in itertools.islice(takings, _MOST):
        less = copy.deepcopy(node)
        take(less)
        yield "less", ast.fix_missing_locations(less)


def _takings(node: ast.stmt) -> Iterator[_Taking]:
    """The things that can be taken from a definition, or from one within it; each is found by its place in a copy."""
    for place, each in enumerate(ast.walk(node)):
        for number in range(len(getattr(each, "decorator_list", ()))):
            yield _Taking(place, "decorator_list", number)
        if isinstance(each, ast.ClassDef):
            yield from (_Taking(place, "bases", number) for number in range(len(each.bases)))
            own = [number for number, part in enumerate(each.body) if not isinstance(part, (*_FUNCTIONS, ast.ClassDef))]
            yield from (_Taking(place, "body", number) for number in own if len(each.body) > 1)
        elif isinstance(each, ast.arguments):
            yield from (_Taking(place, "defaults", number) for number in range(len(each.defaults)))


class _Taking:
    """Takes one part away; of defaults those before it as well, as Python wants none behind a parameter that has one."""

    def __init__(self, place: int, field: str, number: int) -> None:
        self._place, self.field, self._number = place, field, number

    def __call__(self, node: ast.stmt) -> None:
        owner = next(each for place, each in enumerate(ast.walk(node)) if place == self._place)
        parts = getattr(owner, self.field)
        first = 0 if self.field == "defaults" else self._number
        del parts[first : self._number + 1]
