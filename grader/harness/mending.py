"""Putting right in a file's text what was noticed in it, see `slips`: in the function that it was noticed in, and nowhere else."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping

from .scope import Function, blocks, is_set
from .slips import alone_at
from .submission import STATE


def mend(tree: ast.Module, path: str) -> None:
    """Put right what was noticed in a file, where it was noticed."""
    for slip in [each for each in STATE.slips if each["path"] == path]:
        functions = [each for each in ast.walk(tree) if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef)]
        for function in [each for each in functions if each.lineno == slip["function"]]:
            if slip["kind"] == "left out":
                _leave_out(function, alone_at(function, slip["at"]))
            else:
                _MENDS.get(slip["kind"], _everywhere)(function, slip["own"], slip["meant"])
            ast.fix_missing_locations(function)


def _leave_out(function: Function, statement: ast.Expr | ast.Assert | None) -> None:
    for block in blocks(function):
        block[:] = [ast.Pass() if each is statement else each for each in block]


def _take_self(function: Function, own: str, meant: str) -> None:
    function.args.args.insert(0, ast.arg(meant))


def _keep(function: Function, own: str, meant: str) -> None:
    function.body += ast.parse(f"{meant} = {own}").body


def _begin(function: Function, own: str, meant: str) -> None:
    function.body[:0] = ast.parse(meant).body


def _return(function: Function, own: str, meant: str) -> None:
    function.body.append(ast.Return(ast.parse(meant, mode="eval").body))


def _rename_keyword(function: Function, own: str, meant: str) -> None:
    for each in [each for each in ast.walk(function) if isinstance(each, ast.keyword) and each.arg == own]:
        each.arg = meant


def _ask_whether_there(function: Function, own: str, meant: str) -> None:
    _WhetherThere(own, meant).visit(function)


def _compute_with(function: Function, own: str, meant: str) -> None:
    """An array of a list, where it is computed with, and nowhere else."""
    function.body[:0] = ast.parse("import numpy as np").body
    for computed in [each for each in ast.walk(function) if isinstance(each, ast.BinOp)]:
        _Instead(own, meant).generic_visit(computed)


def _put(function: Function, own: str, meant: str) -> None:
    """One statement where another is written."""
    for block in blocks(function):
        block[:] = [
            ast.copy_location(ast.parse(meant).body[0], each) if ast.unparse(each) == own else each for each in block
        ]


def _move(function: Function, own: str, meant: str) -> None:
    """A statement before the first one of its block that reads what it sets."""
    for block in blocks(function):
        for moved in [each for each in block if isinstance(each, ast.Assign) and ast.unparse(each) == own][:1]:
            names = set(map(ast.unparse, moved.targets))
            first = next(at for at, each in enumerate(block) if each is moved or names & _names_in(each))
            block.remove(moved)
            block.insert(first, moved)


def _make(function: Function, own: str, meant: str) -> None:
    """What a loop fills, before the outermost loop that speaks of it."""
    for block in blocks(function):
        for at, each in enumerate(block):
            if isinstance(each, ast.For | ast.While) and own in _names_in(each):
                block[at:at] = ast.parse(meant).body
                return


def _names_in(node: ast.AST) -> set[str]:
    return {each.id for each in ast.walk(node) if isinstance(each, ast.Name)}


def _everywhere(function: Function, own: str, meant: str) -> None:
    _Instead(own, meant).visit(function)


_MENDS: Mapping[str, Callable[[Function, str, str], None]] = {
    "self": _take_self,
    "kept": _keep,
    "begun": _begin,
    "returned": _return,
    "keyword": _rename_keyword,
    "asked": _ask_whether_there,
    "numbers": _compute_with,
    "statement": _put,
    "moved": _move,
    "made": _make,
}
"""By the kind of a slip, see `grader.engine.slips`; any other is an expression in the place of another."""


class _Instead(ast.NodeTransformer):
    """Puts one expression where another is written."""

    def __init__(self, own: str, meant: str) -> None:
        self._own, self._meant = own, meant

    def visit(self, node: ast.AST) -> ast.AST:
        if isinstance(node, ast.expr) and not is_set(node) and ast.unparse(node) == self._own:
            return ast.copy_location(ast.parse(self._meant, mode="eval").body, node)
        visited: ast.AST = self.generic_visit(node)
        return visited


class _WhetherThere(ast.NodeTransformer):
    """Asks whether something is there, where it is asked whether it is true; what ``own or other`` gives is one of both."""

    def __init__(self, own: str, meant: str) -> None:
        self._own, self._meant = own, meant

    def _asked(self, test: ast.expr) -> ast.expr:
        """A test, and what it is put together from."""
        if isinstance(test, ast.BoolOp):
            test.values = [self._asked(each) for each in test.values]
        elif isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
            test.operand = self._asked(test.operand)
        elif ast.unparse(test) == self._own:
            return ast.copy_location(ast.parse(self._meant, mode="eval").body, test)
        else:
            self.visit(test)
        return test

    def visit(self, node: ast.AST) -> ast.AST:
        if isinstance(node, ast.If | ast.IfExp | ast.While):
            node.test = self._asked(node.test)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return self._asked(node)
        elif isinstance(node, ast.BoolOp) and ast.unparse(node.values[0]) == self._own:
            first, *others = node.values
            there = ast.parse(self._meant, mode="eval").body
            other = others[0] if len(others) == 1 else ast.BoolOp(node.op, others)
            one, another = (first, other) if isinstance(node.op, ast.Or) else (other, first)
            return ast.copy_location(ast.IfExp(there, one, another), node)
        visited: ast.AST = self.generic_visit(node)
        return visited
