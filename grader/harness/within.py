"""What stands within a file's statements: which names are used and bound there, and which lines bring one that a function lacks."""

from __future__ import annotations

import ast
import sys
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from . import stepping

_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
_COMPUTED = ("abs", "dict", "float", "int", "len", "list", "max", "min", "range", "round", "set", "str", "sum", "tuple")
_NUMERICAL = ("math", "np", "numpy")
_FROM = {
    "collections": ("Counter", "OrderedDict", "defaultdict", "deque", "namedtuple"), "dataclasses": ("dataclass", "field"),
    "functools": ("cached_property", "lru_cache", "partial", "reduce", "wraps"), "abc": ("ABC", "abstractmethod"),
    "enum": ("Enum", "IntEnum"), "pathlib": ("Path",), "typing": ("NamedTuple", "Protocol"), "copy": ("deepcopy",),
    "scipy": ("signal", "stats"), "matplotlib": ("animation", "gridspec"), "matplotlib.gridspec": ("GridSpec",),
    "matplotlib.animation": ("FuncAnimation",), "matplotlib.figure": ("Figure",),
}  # fmt: skip
"""Names that are known by themselves, beside those of modules."""


def elsewhere(nodes: Sequence[ast.stmt], seen: Seen) -> Iterator[tuple[str, ast.stmt]]:
    """Names that a file has elsewhere than where it is imported, each with the line that brings it there."""
    for each in [each for each in seen.imports if each not in nodes]:
        yield from ((name, _single(each, alias)) for alias in each.names if (name := _name_of(alias)) != "*")
    for assigned in _assignments(nodes, seen):
        if isinstance(assigned.targets[0], ast.Name) and _is_plain(assigned.value):
            yield assigned.targets[0].id, assigned


def _name_of(alias: ast.alias) -> str:
    return (alias.asname or alias.name).split(".")[0]


def _single(node: ast.Import | ast.ImportFrom, alias: ast.alias) -> ast.stmt:
    if isinstance(node, ast.Import):
        return ast.copy_location(ast.Import([alias]), node)
    return ast.copy_location(ast.ImportFrom(node.module, [alias], node.level), node)


def _assignments(nodes: Sequence[ast.stmt], seen: Seen) -> Iterator[ast.Assign]:
    """What a program sets and an import does not: below a main guard, and as a global of a function."""
    for guard in filter(stepping.is_main_guard, nodes):
        yield from (each for each in guard.body if isinstance(each, ast.Assign))
    for function in functions(nodes) if seen.has_globals else ():
        names = {name for each in ast.walk(function) if isinstance(each, ast.Global) for name in each.names}
        yield from (each for each in ast.walk(function) if isinstance(each, ast.Assign) and _sets(each, names))


def _sets(node: ast.Assign, names: set[str]) -> bool:
    return isinstance(node.targets[0], ast.Name) and node.targets[0].id in names


def _is_plain(value: ast.expr) -> bool:
    """Whether an expression is a constant of the program: numbers, texts, and what is computed of them."""
    calls = [each.func for each in ast.walk(value) if isinstance(each, ast.Call)]
    return all(
        (isinstance(call, ast.Name) and call.id in _COMPUTED)
        or (isinstance(call, ast.Attribute) and ast.unparse(call.value) in _NUMERICAL)
        for call in calls
    )


def forgotten(nodes: Sequence[ast.stmt], missed: Collection[str]) -> Iterator[tuple[str, ast.stmt]]:
    """Of these names Python's own modules, of which something is asked, and what everybody takes from one: each with its import."""
    modules = {name for name in missed if name in sys.stdlib_module_names}
    asked = (each.value for node in nodes for each in ast.walk(node) if modules and isinstance(each, ast.Attribute))
    for name in sorted(modules.intersection(each.id for each in asked if isinstance(each, ast.Name))):
        yield name, ast.parse(f"import {name}").body[0]
    for module, names in _FROM.items():
        for name in [name for name in names if name in missed]:
            yield name, ast.parse(f"from {module} import {name}").body[0]


def lacking(name: str, nodes: Sequence[ast.stmt]) -> bool:
    """Whether a function uses a name that it does not bind, or a definition is made with it."""
    made_with = [part for node in nodes if isinstance(node, stepping.DEFINITIONS) for part in _made_with(node)]
    return name in used(made_with) or any(
        name in used([each]) and name not in set(bound(each)) for each in functions(nodes)
    )


def _made_with(node: ast.stmt) -> list[ast.expr]:
    """The decorators and bases of a definition."""
    return [*getattr(node, "decorator_list", ()), *getattr(node, "bases", ())]


def functions(nodes: Iterable[ast.stmt]) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    """The functions and methods that are not within another one."""
    for node in nodes:
        if isinstance(node, _FUNCTIONS):
            yield node
        elif isinstance(node, ast.ClassDef):
            yield from functions(node.body)


def imported(node: ast.AST) -> list[str]:
    if not isinstance(node, ast.Import | ast.ImportFrom):
        return []
    return [(alias.asname or alias.name).split(".")[0] for alias in node.names]


@dataclass
class Seen:
    """What stands in some lines: the names that are read, imports wherever they are, and whether a function sets globals."""

    names: set[str] = field(default_factory=set)
    imports: list[ast.Import | ast.ImportFrom] = field(default_factory=list)
    has_globals: bool = False


def look(nodes: Sequence[ast.AST]) -> Seen:
    """What stands there, but for type hints: the names in these are needed by nobody who runs it."""
    seen, left = Seen(), list(nodes)
    while left:  # each file is looked at in each process: `ast.walk` takes ten times as long
        node = left.pop()
        kind = node.__class__
        if kind is ast.Name:
            if node.ctx.__class__ is ast.Load:  # type: ignore[attr-defined] # it is a name
                seen.names.add(node.id)  # type: ignore[attr-defined]
        elif isinstance(node, ast.Import | ast.ImportFrom):
            seen.imports.append(node)
        elif kind is ast.Global:
            seen.has_globals = True
        elif kind is not ast.Constant:
            for name in node._fields:
                value = getattr(node, name, None) if name not in _PASSED_OVER else None
                if value.__class__ is list:
                    left += [each for each in value if isinstance(each, ast.AST)]
                elif isinstance(value, ast.AST):
                    left.append(value)
    return seen


_PASSED_OVER = frozenset(("annotation", "returns", "type_params", "ctx", "op", "ops"))


def used(nodes: Sequence[ast.AST]) -> set[str]:
    """The names that are read there."""
    return look(nodes).names


def bound(node: ast.AST) -> Iterator[str]:
    """All names that anything in a statement binds, wherever."""
    for each in ast.walk(node):
        if isinstance(each, ast.Name) and not isinstance(each.ctx, ast.Load):
            yield each.id
        elif isinstance(each, ast.arg):
            yield each.arg
        elif isinstance(each, ast.Import | ast.ImportFrom):
            yield from imported(each)
        elif isinstance(each, ast.Global | ast.Nonlocal):
            yield from each.names
        elif isinstance(each, (*stepping.DEFINITIONS, ast.ExceptHandler, ast.MatchAs, ast.MatchStar)):
            yield each.name or ""
