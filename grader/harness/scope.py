"""What a line of a student's function sees when it raises, and what is written there."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from types import FrameType
from typing import Any, TypeAlias, TypeVar

_Node = TypeVar("_Node", bound=ast.expr)
Function: TypeAlias = ast.FunctionDef | ast.AsyncFunctionDef
Meant: TypeAlias = Iterator[tuple[str, str, str]]
"""The kind of slip, what is written there, and what is meant by it."""


class Scope:
    """What a line of a function sees: its own variables, and those of the expressions in it that have frames of their own."""

    def __init__(
        self, frames: Sequence[FrameType], function: Function, line: int, *, called_by_own: bool = False
    ) -> None:
        self.function, self.line, self.called_by_own = function, line, called_by_own
        self.locals = {name: value for frame in frames for name, value in frame.f_locals.items()}
        self.globals, self.builtins = frames[-1].f_globals, frames[-1].f_builtins
        codes = [frame.f_code for frame in frames if frame.f_code.co_name == function.name]
        self.first = codes[-1].co_varnames[0] if codes and codes[-1].co_argcount else ""

    def may_be(self, written: ast.expr, value: Any) -> bool:
        """Whether an expression may have this value: what a variable has is known."""
        return not isinstance(written, ast.Name) or self.value_of(written) is value

    def value_of(self, written: ast.expr) -> Any:
        """What a variable has, one of its attributes, or what stands there as it is; None of anything else."""
        if isinstance(written, ast.Attribute):
            return getattr(self.value_of(written.value), written.attr, None)
        if isinstance(written, ast.Constant):
            return written.value
        return self.locals.get(written.id, self.globals.get(written.id)) if isinstance(written, ast.Name) else None

    def there(self, kind: type[_Node]) -> list[_Node]:
        """The expressions of one kind that the line reads."""
        nodes = [each for each in ast.walk(self.function) if isinstance(each, kind)]
        return [each for each in nodes if each.lineno <= self.line <= (each.end_lineno or 0) and not is_set(each)]

    def names(self) -> set[str]:
        return {*self.locals, *self.globals, *(name for name in self.builtins if not name.startswith("_"))}

    def is_given(self, name: str) -> bool:
        """Whether it is a parameter, and the submission's own code calls the function: then what it is given may be wrong."""
        arguments = self.function.args
        named = {each.arg for each in [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]}
        return name in named and self.called_by_own

    def statements(self) -> list[ast.stmt]:
        """The statements that the line is of, the innermost last."""
        nodes = [each for each in ast.walk(self.function) if isinstance(each, ast.stmt) and each is not self.function]
        return [each for each in nodes if each.lineno <= self.line <= (each.end_lineno or 0)]


def is_set(node: ast.expr) -> bool:
    return isinstance(getattr(node, "ctx", None), ast.Store | ast.Del)


def blocks(function: Function) -> Iterator[list[ast.stmt]]:
    """The statements of a function that stand below each other, the outermost first."""
    for each in ast.walk(function):
        for name in ("body", "orelse", "finalbody"):
            if isinstance(block := getattr(each, name, None), list):
                yield block
