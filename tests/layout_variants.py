"""Variants of one submission in other layouts: all calls at module level, as on the sheet, and in the cells of a notebook.

The definitions stay the same, so a fair marker gives the same points.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Callable, Iterator, Mapping

from tests.corpus.writing import Files, notebook

_OWN = ("imu_reader", "noisy_imu", "filters")
_FILES = tuple(f"{name}.py" for name in _OWN)


def can_be_rearranged(files: Files) -> bool:
    """Return whether these are the sheet's three files, valid Python, with no name defined in two of them.

    A notebook has neither modules of its own nor ``__file__``.
    """
    if set(files) != set(_FILES) or any("__file__" in str(content) for content in files.values()):
        return False
    try:
        trees = [_tree(files[name]) for name in _FILES]
    except (SyntaxError, UnicodeDecodeError):
        return False
    defined = Counter(part.name for tree in trees for part in _flat(tree) if isinstance(part, _DEFINITIONS))
    return max(defined.values(), default=0) == 1 and not any(
        _imports_otherwise(t) or _forgets_an_import(t) for t in trees
    )


def at_module_level(files: Files) -> Files:
    """Return each file without a main guard: its statements, and those of the functions that it calls, run at import."""
    return {name: _written(_flat(_tree(files[name]))) for name in _FILES}


def as_notebook(files: Files) -> Files:
    """One notebook: each definition in a cell of its own, and what is done between them."""
    parts = [part for name in _FILES for part in _flat(_tree(files[name])) if not _is_own_import(part)]
    return {"lab.ipynb": notebook(*_cells(parts))}


VARIANTS: Mapping[str, Callable[[Files], Files]] = {"at module level": at_module_level, "as a notebook": as_notebook}

_LIBRARIES = ("mujoco", "np", "plt")
_DEFINITIONS = (ast.FunctionDef, ast.ClassDef)


def _tree(content: object) -> ast.Module:
    return ast.parse(content if isinstance(content, str | bytes) else "")


def _written(parts: list[ast.stmt]) -> str:
    return "\n\n".join(map(ast.unparse, parts)) + "\n"


def _cells(parts: list[ast.stmt]) -> Iterator[str]:
    between: list[ast.stmt] = []
    for part in parts:
        if isinstance(part, _DEFINITIONS):
            if between:
                yield _written(between)
            between = []
            yield _written([part])
        else:
            between.append(part)
    if between:
        yield _written(between)


def _flat(tree: ast.Module) -> list[ast.stmt]:
    """The statements without main guards, and without the functions that nothing but a guard calls."""
    guarded = [part for guard in tree.body if _is_guard(guard) for part in guard.body]  # type: ignore[attr-defined]
    demos = {name for name in map(_called, guarded) if name}
    bodies = {part.name: part for part in tree.body if isinstance(part, ast.FunctionDef) and part.name in demos}
    bodies = {name: part for name, part in bodies.items() if _can_stand_alone(part)}
    flat: list[ast.stmt] = []
    for part in tree.body:
        if _is_guard(part):
            for done in part.body:  # type: ignore[attr-defined]
                flat += _body(bodies[_called(done)]) if _called(done) in bodies else [done]
        elif getattr(part, "name", None) not in bodies:
            flat.append(part)
    return flat


def _is_guard(part: ast.stmt) -> bool:
    return isinstance(part, ast.If) and "__name__" in ast.unparse(part.test) and not part.orelse


def _called(part: ast.stmt) -> str:
    """``compare`` of ``compare()``."""
    call = part.value if isinstance(part, ast.Expr) else None
    alone = isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and not call.args and not call.keywords
    return call.func.id if alone else ""  # type: ignore[union-attr] # a call of a name, then


def _can_stand_alone(function: ast.FunctionDef) -> bool:
    own = (ast.Return, ast.Yield, ast.Global, ast.Nonlocal)
    return not any(isinstance(node, own) for node in ast.walk(function)) and len(function.args.args) == len(
        function.args.defaults
    )


def _body(function: ast.FunctionDef) -> list[ast.stmt]:
    """What it does, after what its parameters are."""
    pairs = zip(function.args.args, function.args.defaults, strict=True)
    given = [ast.parse(f"{name.arg} = {ast.unparse(value)}").body[0] for name, value in pairs]
    return [*given, *function.body]


def _is_own_import(part: ast.stmt) -> bool:
    return isinstance(part, ast.ImportFrom) and part.module in _OWN


def _forgets_an_import(tree: ast.Module) -> bool:
    """Whether a file uses a library that it does not import: beside the other two, in a notebook, it is there."""
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]
    there = {each.asname or each.name.partition(".")[0] for node in imports for each in node.names}
    used = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    return "*" not in there and bool(used.intersection(_LIBRARIES) - there)


def _imports_otherwise(tree: ast.Module) -> bool:
    """Whether a file of its own is imported as a module, under another name, or not at the top."""
    found = [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom) and node not in tree.body]
    found = [node for node in found if any(name in ast.unparse(node) for name in _OWN)]
    for node in tree.body:
        if isinstance(node, ast.Import) and any(each.name in _OWN for each in node.names):
            found.append(node)
        if _is_own_import(node) and any(each.asname for each in node.names):  # type: ignore[attr-defined]
            found.append(node)  # type: ignore[arg-type]
    return bool(found)
