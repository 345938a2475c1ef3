"""What must be meant where lines stand in another order than they run, or a variable is set elsewhere than where it is needed."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Sequence
from types import FunctionType, GeneratorType, ModuleType
from typing import Any

from .scope import Meant, Scope, blocks

_LOCAL = re.compile(r"local variable '(\w+)'")
_BEYOND = re.compile(r"index (\d+) is out of bounds for axis 0 with size (\d+)|list (?:assignment )?index out of range")
_COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.GeneratorExp, ast.DictComp)
_WALKED_ONCE = (GeneratorType, zip, map, filter)


def _hidden(raised: UnboundLocalError, scope: Scope) -> Meant:
    """A module that a variable of the function hides, which gets its value later."""
    name = _unset(raised)
    module = scope.globals.get(name)
    for each in scope.there(ast.Attribute) if isinstance(module, ModuleType) else ():
        if ast.unparse(each.value) == name and hasattr(module, each.attr):
            yield "expression", ast.unparse(each), f"globals()[{name!r}].{each.attr}"


def _unset(raised: UnboundLocalError) -> str:
    found = _LOCAL.search(str(raised))
    return found[1] if found else ""


def _set_below(raised: UnboundLocalError, scope: Scope) -> Meant:
    """A variable that is set once, further below in the same block: the two lines are in each other's place."""
    name, statement = _unset(raised), scope.statements()
    for block in blocks(scope.function):
        setting = [each for each in block if isinstance(each, ast.Assign) and name in map(ast.unparse, each.targets)]
        if len(setting) == 1 and any(each in block and setting[0].lineno > each.lineno for each in statement):
            yield "moved", ast.unparse(setting[0]), f"{ast.unparse(setting[0])}, further up"


def _set_in_one_branch(raised: UnboundLocalError, scope: Scope) -> Meant:
    """A variable that one branch sets: it is what the other one sets last, too."""
    name = _unset(raised)
    for choice in [each for each in ast.walk(scope.function) if isinstance(each, ast.If) and each.orelse]:
        for one, other in ((choice.body, choice.orelse), (choice.orelse, choice.body)):
            last = one[-1]
            if name in _names_set(other) - _names_set(one) and isinstance(last, ast.Assign):
                yield "statement", ast.unparse(last), f"{name} = {ast.unparse(last)}"


def _names_set(block: Sequence[ast.stmt]) -> set[str]:
    nodes = (each for statement in block for each in ast.walk(statement))
    return {each.id for each in nodes if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)}


def _of_a_loop(raised: NameError, scope: Scope) -> Meant:
    """A name that nothing has, within a loop or a comprehension whose own variable nobody reads."""
    around = [
        *(each for kind in _COMPREHENSIONS for each in scope.there(kind)),
        *(each for each in scope.statements() if isinstance(each, ast.For)),
    ]
    own = {name for loop in around for name in _unread(loop)}
    if raised.name and len(own) == 1 and raised.name not in own:
        yield "expression", raised.name, own.pop()


def _unread(loop: ast.AST) -> Iterator[str]:
    targets = [part.target for part in getattr(loop, "generators", [loop])]
    read = {each.id for each in ast.walk(loop) if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Load)}
    for target in targets:
        yield from (each.id for each in ast.walk(target) if isinstance(each, ast.Name) and each.id not in read)


def _one_too_far(raised: IndexError, scope: Scope) -> Meant:
    """A loop that counts from one, or to one more than there are."""
    if not _BEYOND.search(str(raised)):
        return
    for loop in [each for each in scope.statements() if isinstance(each, ast.For)][:1]:
        call = loop.iter
        if (
            isinstance(call, ast.Call)
            and ast.unparse(call.func) == "range"
            and len(call.args) <= 2
            and not call.keywords
        ):
            start = call.args[0] if len(call.args) == 2 else None
            if start is None or (isinstance(start, ast.Constant) and start.value in (0, 1)):
                yield "index", ast.unparse(call), f"range({_one_less(call.args[-1])})"


def _one_less(end: ast.expr) -> str:
    """``n`` of ``n + 1``"""
    added = isinstance(end, ast.BinOp) and isinstance(end.op, ast.Add) and ast.unparse(end.right) == "1"
    return ast.unparse(end.left) if added and isinstance(end, ast.BinOp) else f"{ast.unparse(end)} - 1"


def _walked_twice(raised: Exception, scope: Scope) -> Meant:
    """What can be gone through once, and has been."""
    used = {each.id for each in scope.there(ast.Name)}
    for name in sorted(used):
        value = scope.locals.get(name)
        over = isinstance(value, _WALKED_ONCE) and not (isinstance(value, GeneratorType) and value.gi_frame)
        made = [
            each
            for each in ast.walk(scope.function)
            if isinstance(each, ast.Assign) and name in map(ast.unparse, each.targets)
        ]
        if over and len(made) == 1:
            yield "statement", ast.unparse(made[0]), f"{name} = list({ast.unparse(made[0].value)})"


def called_for_nothing(raised: BaseException, scope: Scope) -> Iterator[FunctionType]:
    """The functions of the line that may have given nothing, where something was needed."""
    for call in scope.there(ast.Call) if "NoneType" in str(raised) else ():
        function = scope.value_of(call.func)
        if isinstance(function, FunctionType):
            yield function


def _no_property(raised: TypeError, scope: Scope) -> Meant:
    """What is no function, and is called without anything."""
    for call in scope.there(ast.Call) if "object is not callable" in str(raised) else ():
        alone = not call.args and not call.keywords and isinstance(call.func, ast.Attribute)
        if alone and not callable(scope.value_of(call.func)):
            yield "index", ast.unparse(call), ast.unparse(call.func)


def _without_owner(raised: NameError, scope: Scope) -> Meant:
    """A part of an object that nothing has, where a variable is called so."""
    for each in scope.there(ast.Attribute):
        if ast.unparse(each.value) == raised.name and each.attr in {*scope.locals, *scope.globals}:
            yield "expression", ast.unparse(each), each.attr


RULES: Sequence[tuple[type[BaseException], Callable[[Any, Scope], Meant]]] = (
    (UnboundLocalError, _hidden),
    (UnboundLocalError, _set_below),
    (UnboundLocalError, _set_in_one_branch),
    (NameError, _without_owner),
    (NameError, _of_a_loop),
    (IndexError, _one_too_far),
    (TypeError, _no_property),
    (Exception, _walked_twice),
)
"""What is raised, and the rule that says what must be meant then."""
