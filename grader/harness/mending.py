"""Putting right in a file's text what was noticed in it, see `slips`: in the function that it was noticed in, and nowhere else."""

from __future__ import annotations

import ast

from .scope import Function, is_set
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
                _mend(function, slip["kind"], slip["own"], slip["meant"])
            ast.fix_missing_locations(function)


def _leave_out(function: Function, statement: ast.Expr | ast.Assert | None) -> None:
    for block in _blocks(function):
        block[:] = [ast.Pass() if each is statement else each for each in block]


def _put(function: Function, own: str, meant: str) -> None:
    """One statement where another is written."""
    for block in _blocks(function):
        block[:] = [
            ast.copy_location(ast.parse(meant).body[0], each) if ast.unparse(each) == own else each for each in block
        ]


def _make(function: Function, own: str, meant: str) -> None:
    """What a loop fills, before the outermost loop that speaks of it."""
    for block in _blocks(function):
        for at, each in enumerate(block):
            names = {part.id for part in ast.walk(each) if isinstance(part, ast.Name)}
            if isinstance(each, ast.For | ast.While) and own in names:
                block[at:at] = ast.parse(meant).body
                return


def _blocks(function: Function) -> list[list[ast.stmt]]:
    return [
        block
        for each in ast.walk(function)
        for name in ("body", "orelse", "finalbody")
        if isinstance(block := getattr(each, name, None), list)
    ]


def _mend(function: Function, kind: str, own: str, meant: str) -> None:
    if kind == "self":
        function.args.args.insert(0, ast.arg("self"))
    elif kind == "begun":
        function.body[:0] = ast.parse(meant).body
    elif kind == "kept":
        function.body += ast.parse(f"{meant} = {own}").body
    elif kind == "numbers":
        function.body[:0] = ast.parse("import numpy as np").body
        for computed in [each for each in ast.walk(function) if isinstance(each, ast.BinOp)]:
            _Instead(own, meant).generic_visit(computed)
    elif kind == "asked":
        _WhetherThere(own, meant).visit(function)
    elif kind == "made":
        _make(function, own, meant)
    elif kind == "statement":
        _put(function, own, meant)
    elif kind == "keyword":
        for each in [each for each in ast.walk(function) if isinstance(each, ast.keyword) and each.arg == own]:
            each.arg = meant
    else:
        _Instead(own, meant).visit(function)


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
