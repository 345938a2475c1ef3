"""Static name analysis: which names statements read, bind and import, to find those that a file forgot to import."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence

from . import statements

_PASSED_OVER = frozenset(("annotation", "returns", "type_params", "ctx", "op", "ops"))
"""Fields of a node that hold no name that the code needs when it runs: type hints among them."""


def imported(node: ast.AST) -> list[str]:
    """Return the names that an import statement binds, "*" for a star import; an empty list for any other statement."""
    if not isinstance(node, ast.Import | ast.ImportFrom):
        return []
    return [(alias.asname or alias.name).split(".")[0] for alias in node.names]


def used(nodes: Sequence[ast.AST]) -> set[str]:
    """Return the names that these nodes read, also in functions' bodies; built-in and local names count, type hints do not."""
    names, left = set(), list(nodes)
    while left:  # every file is analysed in every process: `ast.walk` takes ten times as long
        node = left.pop()
        kind = node.__class__
        if kind is ast.Name:
            if node.ctx.__class__ is ast.Load:  # type: ignore[attr-defined] # it is a name
                names.add(node.id)  # type: ignore[attr-defined]
        elif kind is not ast.Constant:
            for name in node._fields:
                value = getattr(node, name, None) if name not in _PASSED_OVER else None
                if value.__class__ is list:
                    left += [each for each in value if isinstance(each, ast.AST)]
                elif isinstance(value, ast.AST):
                    left.append(value)
    return names


def bound(node: ast.AST) -> Iterator[str]:
    """Yield all names that a statement assigns, defines or imports, also inside functions: a file need not import these."""
    for each in ast.walk(node):
        if isinstance(each, ast.Name) and not isinstance(each.ctx, ast.Load):
            yield each.id
        elif isinstance(each, ast.arg):
            yield each.arg
        elif isinstance(each, ast.Import | ast.ImportFrom):
            yield from imported(each)
        elif isinstance(each, ast.Global | ast.Nonlocal):
            yield from each.names
        elif isinstance(each, (*statements.DEFINITIONS, ast.ExceptHandler, ast.MatchAs, ast.MatchStar)):
            yield each.name or ""
