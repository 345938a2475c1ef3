"""The `return` that somebody forgot: a function that computes its values, and keeps or prints them, gives them to nobody.

Where such a function comes to its end it returns what stands last there: values by themselves, those that are printed, or those
that were set. Whoever marks is told of it, as one fault.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from typing import Literal, TypeAlias

Kind: TypeAlias = Literal["value", "pair", "mapping"]
_Setting = (ast.Assign, ast.AnnAssign, ast.AugAssign)


def completed(tree: ast.Module, wanted: Mapping[str, Kind]) -> dict[str, bool]:
    """Give functions of a file the last line that they lack; whether the last definition of each wanted one lacked it.

    Parameters
    ----------
    wanted : what has to be returned by each function, or each method by ``Class.method``
    """
    lacked = {}
    for name, function in (each for node in tree.body for each in _functions(node)):
        if name in wanted:
            value = None if _yields(function) else _last(function.body, wanted[name])
            lacked[name] = value is not None
            if value is not None:
                function.body.append(ast.fix_missing_locations(ast.copy_location(ast.Return(value), function.body[-1])))
    return lacked


def last_of(function: ast.FunctionDef) -> ast.expr | None:
    """What a function that returns nothing has last: the one value that it sets or that stands there by itself."""
    if _yields(function) or any(isinstance(each, ast.Return) and each.value for each in ast.walk(function)):
        return None
    last = function.body[-1]
    return last.value if isinstance(last, ast.Expr) else _last(function.body, "value")


def _functions(node: ast.stmt) -> Iterator[tuple[str, ast.FunctionDef]]:
    if isinstance(node, ast.FunctionDef):
        yield node.name, node
    elif isinstance(node, ast.ClassDef):
        yield from ((f"{node.name}.{each.name}", each) for each in node.body if isinstance(each, ast.FunctionDef))


def _yields(function: ast.FunctionDef) -> bool:
    return any(isinstance(each, ast.Yield | ast.YieldFrom) for each in ast.walk(function))


def _last(body: Sequence[ast.stmt], kind: Kind) -> ast.expr | None:
    """What these statements would return at their end; None where they do not come to it, or leave no such thing there."""
    names: list[str] = []  # set by the last lines
    for node in reversed(body):
        if isinstance(node, ast.If) and node.orelse:
            return None if names else _of_both(node, kind)
        if isinstance(node, _Setting):
            if (value := _set_by(node, kind)) is not None:
                return value
            names += [] if kind == "mapping" else [name for name in reversed(_targets(node)) if name not in names]
        elif isinstance(node, ast.Expr):
            if not names and (value := _by_itself(node.value, kind)) is not None:
                return _read(_copied(ast.unparse(value))) if kind == "value" else value
        elif kind == "mapping" and isinstance(node, ast.For | ast.While) and not _returns(node):
            return _filled_by(node)
        elif not isinstance(node, ast.If | ast.Pass) or _returns(node):
            return None
        if len(names) >= (2 if kind == "pair" else 1):
            return _of_names(names, body, kind)
    return None


def _filled_by(loop: ast.For | ast.While) -> ast.expr | None:
    """The dictionary that a loop fills, or its arrays and lists under their own names."""
    stored = [each for each in ast.walk(loop) if isinstance(each, ast.Subscript) and isinstance(each.ctx, ast.Store)]
    methods = [each for each in ast.walk(loop) if isinstance(each, ast.Attribute) and each.attr == "append"]
    named = list(dict.fromkeys(filter(None, map(_whose, [*stored, *methods]))))
    if len(named) == 1:
        return _read(named[0])
    return _read(f"{{{', '.join(f'{name!r}: {name}' for name in named)}}}") if named else None


def _whose(part: ast.expr) -> str:
    """The variable of which something is a part, however deep; empty where it is of none."""
    while isinstance(part, ast.Subscript | ast.Attribute):
        part = part.value
    return part.id if isinstance(part, ast.Name) else ""


def _of_names(names: Sequence[str], body: Sequence[ast.stmt], kind: Kind) -> ast.expr | None:
    """What was set last, or the only two in the order in which they were first set."""
    if kind == "value":
        return _read(_copied(names[0]))
    order = [name for node in body if isinstance(node, _Setting) for name in _targets(node)]
    return _read(", ".join(sorted(names, key=order.index))) if len(names) == 2 else None


def _copied(written: str) -> str:
    """A copy of what an object keeps: that is its own."""
    return written if written.isidentifier() else f"__import__('copy').copy({written})"


def _of_both(choice: ast.If, kind: Kind) -> ast.expr | None:
    """Of a choice: what both branches leave, or the one that comes to its end."""
    branches = [branch for branch in (choice.body, choice.orelse) if not isinstance(branch[-1], ast.Return | ast.Raise)]
    values = [_last(branch, kind) for branch in branches]
    same = {"" if value is None else ast.unparse(value) for value in values}
    return values[0] if len(same) == 1 else None


def _set_by(node: ast.Assign | ast.AnnAssign | ast.AugAssign, kind: Kind) -> ast.expr | None:
    """The target of a statement that sets all that is wanted at once."""
    targets = _targets(node)
    at_once = kind != "value" and len(targets) == 1 and node.value is not None and _is(node.value, kind)
    return _read(targets[0]) if at_once else None


def _is(value: ast.expr, kind: Kind) -> bool:
    if kind == "mapping":
        is_call = isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id == "dict"
        return is_call or isinstance(value, ast.Dict)
    if kind == "pair":
        return isinstance(value, ast.Tuple) and len(value.elts) == 2
    return isinstance(value, ast.Name | ast.Attribute)


def _by_itself(value: ast.expr, kind: Kind) -> ast.expr | None:
    """What stands alone in a line or is printed, if it is what is wanted."""
    if isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id == "print":
        told = [each for each in value.args if not isinstance(each, ast.Constant | ast.JoinedStr)]
        value = told[0] if len(told) == 1 else ast.Tuple(told, ast.Load())
    return value if _is(value, kind) else None


def _targets(node: ast.Assign | ast.AnnAssign | ast.AugAssign) -> list[str]:
    """The names and attributes that a statement sets."""
    target = node.targets[0] if isinstance(node, ast.Assign) else node.target
    each = target.elts if isinstance(target, ast.Tuple) else [target]
    return [ast.unparse(one) for one in each if isinstance(one, ast.Name | ast.Attribute)]


def _returns(node: ast.AST) -> bool:
    return any(isinstance(each, ast.Return) for each in ast.walk(node))


def _read(written: str) -> ast.expr:
    return ast.parse(written, mode="eval").body
