"""What a function raises for, where one thing alone can be meant: a slip of the pen in a name, a forgotten `self.` or `np.`.

So can be an array that is called or asked whether it is there, a method that is not called, a fraction of a step, a shape in two
parts or an array in its place, what `append` returns.
A call for its effect alone that prints, or that stands in a plot, is left out where nothing can be meant by it.
It is noticed when it is raised, by what is there to choose from at that moment, and mended when the file is loaded the next time,
in that function alone. What never runs stays as it is. Whoever marks is told, as one fault.
"""

from __future__ import annotations

import ast
import difflib
import linecache
import re
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from types import CodeType, FrameType, FunctionType, ModuleType
from typing import Any, TypeAlias, TypeVar

import numpy as np

from . import faults
from .submission import STATE

Slip: TypeAlias = dict[str, Any]
_Node = TypeVar("_Node", bound=ast.expr)
Function: TypeAlias = ast.FunctionDef | ast.AsyncFunctionDef

_CLOSE = 0.8
"""Of the letters in common, as difflib counts: one in five may be lost, doubled, another or elsewhere. It has raised already."""
_SHORTEST = 3
_KEYWORD = re.compile(r"unexpected keyword argument '(\w+)'")
_WITHOUT_SELF = re.compile(
    r"^(\w+)\.(\w+)\(\) (?:takes \d+ positional arguments? but|got multiple values for argument)"
)
_FRACTION = re.compile(
    r"'(?:numpy\.)?float\d*' object cannot be interpreted as an integer|^expected a sequence of integers or a single integer"
)
_TRUTH = "truth value of an array"
_LONGEST = 200


def notice(raised: BaseException, *, drawing: bool = False) -> None:
    """Keep what must be meant by the name that this was raised for, if it is one; the first of a question counts.

    Parameters
    ----------
    drawing : whether a figure is drawn, and a call for its effect alone can be left out of that
    """
    with suppress(BaseException):  # what the student's objects answer is their code
        STATE.slip = STATE.slip or next(_slips(raised), None) or next(_left_out(raised, drawing=drawing), None)


def noticed() -> Slip | None:
    """What was noticed since this was asked last."""
    slip, STATE.slip = STATE.slip, None
    return slip


def _slips(raised: BaseException) -> Iterator[Slip]:
    if isinstance(raised, TypeError) and (found := _WITHOUT_SELF.match(str(raised))):
        yield from _without_self(*found.groups())
    if isinstance(raised, AttributeError):
        yield from _kept_by_nobody(raised)
    own = _own_frames(raised)
    if not own:
        return
    file, line = own[-1][0].f_code.co_filename, own[-1][1]
    function = _around(_tree(file), line)
    if function is None:
        return
    frames = [frame for frame, at in own if frame.f_code.co_filename == file and _first_line(function) <= at]
    for kind, name, meant in _meant(raised, _Scope(frames, function, line)):
        yield _slip(file, function, kind, name, meant, at=line)


def _own_frames(raised: BaseException) -> list[tuple[FrameType, int]]:
    """The submission's frames that this came through, each with its line; the innermost last."""
    return [each for each in traceback.walk_tb(raised.__traceback__) if faults.is_own(each[0].f_code.co_filename)]


def _left_out(raised: BaseException, *, drawing: bool) -> Iterator[Slip]:
    """The innermost call whose value nobody uses: what it does to a figure, or tells, is all that is missing without it."""
    told = f"{type(raised).__name__}: {faults.describe(raised)['message']}"
    for frame, line in reversed(_own_frames(raised)) if isinstance(raised, Exception) else ():
        file = frame.f_code.co_filename
        function = _around(_tree(file), line)
        statement = function and call_at(function, line)
        if function and statement and (drawing or _prints(statement)):
            yield _slip(file, function, "left out", ast.unparse(statement)[:_LONGEST], told[:_LONGEST], at=line)


def call_at(function: Function, line: int) -> ast.Expr | None:
    """The call on this line whose value nobody uses."""
    alone = [each for each in ast.walk(function) if isinstance(each, ast.Expr) and isinstance(each.value, ast.Call)]
    around = [each for each in alone if each.lineno <= line <= (each.end_lineno or 0)]
    return around[-1] if around else None


def _prints(statement: ast.Expr) -> bool:
    called = statement.value.func if isinstance(statement.value, ast.Call) else None
    logs = isinstance(called, ast.Attribute) and ast.unparse(called.value) in ("logging", "logger", "log")
    return logs or (isinstance(called, ast.Name) and called.id in ("print", "pprint", "display"))


class _Scope:
    """What a line of a function sees: its own variables, and those of the expressions in it that have frames of their own."""

    def __init__(self, frames: Sequence[FrameType], function: Function, line: int) -> None:
        self.function, self.line = function, line
        self.locals = {name: value for frame in frames for name, value in frame.f_locals.items()}
        self.globals, self.builtins = frames[-1].f_globals, frames[-1].f_builtins
        codes = [frame.f_code for frame in frames if frame.f_code.co_name == function.name]
        self.first = codes[-1].co_varnames[0] if codes and codes[-1].co_argcount else ""

    def may_be(self, written: ast.expr, value: Any) -> bool:
        """Whether an expression may have this value: what a variable has is known."""
        return not isinstance(written, ast.Name) or self.value_of(written) is value

    def value_of(self, written: ast.expr) -> Any:
        """What a variable has, or one of its attributes; None of anything else."""
        if isinstance(written, ast.Attribute):
            return getattr(self.value_of(written.value), written.attr, None)
        return self.locals.get(written.id, self.globals.get(written.id)) if isinstance(written, ast.Name) else None

    def there(self, kind: type[_Node]) -> list[_Node]:
        """The expressions of one kind that the line reads."""
        nodes = [each for each in ast.walk(self.function) if isinstance(each, kind)]
        return [each for each in nodes if each.lineno <= self.line <= (each.end_lineno or 0) and not is_set(each)]

    def names(self) -> set[str]:
        return {*self.locals, *self.globals, *(name for name in self.builtins if not name.startswith("_"))}


_Meant: TypeAlias = Iterator[tuple[str, str, str]]
"""The kind of slip, what is written there, and what is meant by it."""


def _name(raised: NameError, scope: _Scope) -> _Meant:
    if raised.name == "self":
        yield "self", "self", "self"
    elif raised.name and (name := _name_meant(raised.name, scope)):
        yield "expression", raised.name, name


def _member(raised: AttributeError, scope: _Scope) -> _Meant:
    named = [each for each in scope.there(ast.Attribute) if each.attr == raised.name]
    member = _member_meant(named[0].attr, raised.obj) if named else ""
    for each in named:
        if member and scope.may_be(each.value, raised.obj):
            yield "expression", ast.unparse(each), ast.unparse(each.value) + member


def _key(raised: KeyError, scope: _Scope) -> _Meant:
    (key,) = raised.args
    for each in scope.there(ast.Subscript):
        if isinstance(key, str) and isinstance(each.slice, ast.Constant) and each.slice.value == key:
            meant = _nearest(key, _keys_of(scope.value_of(each.value)))
            if meant:
                yield "expression", ast.unparse(each), f"{ast.unparse(each.value)}[{meant!r}]"


def _keyword(raised: BaseException, scope: _Scope) -> _Meant:
    found = _KEYWORD.search(str(raised))
    if found and scope.there(ast.Call) and (name := _nearest(found[1], _keywords())):
        yield "keyword", found[1], name


def _index(raised: TypeError, scope: _Scope) -> _Meant:
    """An array that is called."""
    for each in scope.there(ast.Call) if "object is not callable" in str(raised) else ():
        if len(each.args) == 1 and not each.keywords and isinstance(scope.value_of(each.func), np.ndarray):
            yield "index", ast.unparse(each), f"{ast.unparse(each.func)}[{ast.unparse(each.args[0])}]"


def _whole(raised: TypeError, scope: _Scope) -> _Meant:
    """A fraction where a whole number is needed."""
    if _FRACTION.search(str(raised)):
        given = {ast.unparse(each) for call in scope.there(ast.Call) for each in _whole_wanted(call, scope)}
        yield from (("whole", each, f"int({each})") for each in given if len(given) == 1)


def _shape(raised: TypeError, scope: _Scope) -> _Meant:
    """Rows and columns one after the other, where NumPy wants them together."""
    for each in scope.there(ast.Call) if "as a data type" in str(raised) else ():
        if len(each.args) == 2 and not each.keywords:
            yield "shape", ast.unparse(each), f"{ast.unparse(each.func)}(({', '.join(map(ast.unparse, each.args))}))"


def _size(raised: TypeError, scope: _Scope) -> _Meant:
    """An array of random numbers' size, where its shape is needed."""
    for call in scope.there(ast.Call) if _FRACTION.search(str(raised)) else ():
        for each in [*call.args[2:3], *(option.value for option in call.keywords if option.arg == "size")]:
            if isinstance(scope.value_of(each), np.ndarray):
                shape = ast.Attribute(each, "shape", ast.Load())
                args = [shape if arg is each else arg for arg in call.args]
                options = [ast.keyword(o.arg, shape if o.value is each else o.value) for o in call.keywords]
                yield "shape", ast.unparse(call), ast.unparse(ast.Call(call.func, args, options))


def _truth(raised: ValueError, scope: _Scope) -> _Meant:
    """An array that is asked whether it is true, or the same as nothing, where nothing may be in its place."""
    if _TRUTH not in str(raised):
        return
    for each in scope.there(ast.Compare):
        if len(each.ops) == 1 and ast.unparse(each.comparators[0]) == "None":
            sign = " is " if isinstance(each.ops[0], ast.Eq) else " is not "
            yield "compared", ast.unparse(each), f"{ast.unparse(each.left)}{sign}None"
    asked = [each for each in _asked_for_truth(scope.function) if each.lineno <= scope.line <= (each.end_lineno or 0)]
    given = {ast.unparse(each) for each in asked if isinstance(scope.value_of(each), np.ndarray)}
    yield from (("asked", each, f"{each} is not None") for each in given if len(given) == 1)


def _asked_for_truth(function: Function) -> Iterator[ast.expr]:
    """The expressions whose truth decides something."""
    for each in ast.walk(function):
        if isinstance(each, ast.If | ast.IfExp | ast.While):
            yield each.test
        elif isinstance(each, ast.BoolOp):
            yield from each.values
        elif isinstance(each, ast.UnaryOp) and isinstance(each.op, ast.Not):
            yield each.operand


def _appended(raised: AttributeError, scope: _Scope) -> _Meant:
    """What `append` returns, put in the place of the list."""
    for each in scope.there(ast.Call) if raised.obj is None and raised.name == "append" else ():
        if isinstance(each.func, ast.Attribute) and len(each.args) == 1 and scope.value_of(each.func.value) is None:
            yield "appended", ast.unparse(each), f"[*{ast.unparse(each.func.value)}, {ast.unparse(each.args[0])}]"


def _called(raised: TypeError | AttributeError, scope: _Scope) -> _Meant:
    """A method without the brackets that call it."""
    if "'builtin_function_or_method'" in str(raised) or "'method'" in str(raised):
        called = [each.func for each in ast.walk(scope.function) if isinstance(each, ast.Call)]
        members = [each for each in ast.walk(scope.function) if isinstance(each, ast.Attribute) and each not in called]
        given = {ast.unparse(each) for each in members if not is_set(each) and _is_method(scope.value_of(each), each)}
        yield from (("called", each, f"{each}()") for each in given if len(given) == 1)


def _is_method(value: Any, written: ast.Attribute) -> bool:
    """Whether it is one by the name that is written there, and not what was kept under another."""
    return callable(value) and getattr(value, "__name__", "") == written.attr


_MEANT: Sequence[tuple[type[BaseException], Callable[[Any, _Scope], _Meant]]] = (
    (NameError, _name),
    (AttributeError, _keyword),  # matplotlib raises it for those
    (TypeError, _keyword),
    (AttributeError, _member),
    (KeyError, _key),
    (TypeError, _index),
    (TypeError, _size),
    (TypeError, _whole),
    (TypeError, _shape),
    (ValueError, _truth),
    (AttributeError, _appended),
    (TypeError, _called),
    (AttributeError, _called),
)


def _meant(raised: BaseException, scope: _Scope) -> _Meant:
    for kind, rule in _MEANT:
        if isinstance(raised, kind):
            yield from rule(raised, scope)


def _whole_wanted(call: ast.Call, scope: _Scope) -> Iterator[ast.expr]:
    """What a call is given that is no whole number, or may be none: a variable, or what a division gives."""
    for each in [part for arg in call.args for part in (arg.elts if isinstance(arg, ast.Tuple) else [arg])]:
        divided = isinstance(each, ast.BinOp) and isinstance(each.op, ast.Div | ast.FloorDiv | ast.Mult)
        if divided or isinstance(scope.value_of(each), float):
            yield each


def _name_meant(name: str, scope: _Scope) -> str | None:
    """A member of the object whose method it is, one of a library that is imported, or a name that is spelled nearly so."""
    owner = scope.locals.get(scope.first)
    if _is_own_object(owner) and name in dir(owner):
        return f"{scope.first}.{name}"
    libraries = {each: scope.globals.get(each) for each in STATE.furniture.get("libraries", ())}
    holding = {
        library: each
        for each, library in libraries.items()
        if isinstance(library, ModuleType) and hasattr(library, name)
    }
    near = _nearest(name, scope.names())
    candidates = [*(f"{each}.{name}" for each in holding.values()), *([near] if near else [])]
    return candidates[0] if len(candidates) == 1 else None


def _member_meant(name: str, owner: Any) -> str:
    """A key of a dictionary; what a panel sets where pyplot has a function, or the reverse; else what is spelled nearly so."""
    if name in _keys_of(owner):
        return f"[{name!r}]"
    members = dir(owner)
    other = name.removeprefix("set_") if name.startswith("set_") else f"set_{name}"
    member = other if other in members else _nearest(name, members)
    return f".{member}" if member else ""


def _keys_of(value: Any) -> set[str]:
    return {key for key in value if isinstance(key, str)} if isinstance(value, dict) else set()


def _is_own_object(value: Any) -> bool:
    return type(value).__module__ in {module.__name__ for module in STATE.modules.values()}


def _kept_by_nobody(raised: AttributeError) -> Iterator[Slip]:
    """An attribute that is set nowhere, where `__init__` has a variable of that name: the `self.` is forgotten there."""
    made = getattr(type(raised.obj), "__init__", None)
    if isinstance(made, FunctionType) and _is_own_object(raised.obj) and raised.name in made.__code__.co_varnames:
        yield from _of_code(made.__code__, "kept", raised.name)


def _without_self(kind: str, method: str) -> Iterator[Slip]:
    """A method that speaks of `self`, and has no such parameter."""
    for module in list(STATE.modules.values()):
        own = vars(vars(module).get(kind, object)).get(method)
        if isinstance(own, FunctionType) and "self" in own.__code__.co_names:
            yield from _of_code(own.__code__, "self", "self")


def _of_code(code: CodeType, kind: str, name: str) -> Iterator[Slip]:
    function = _around(_tree(code.co_filename), code.co_firstlineno)
    if function and faults.is_own(code.co_filename):
        yield _slip(
            code.co_filename, function, kind, name, f"self.{name}" if kind == "kept" else name, at=function.lineno
        )


def _slip(file: str, function: Function, kind: str, own: str, meant: str, *, at: int) -> Slip:
    if max(len(own), len(meant)) > _LONGEST:
        raise ValueError("what is written there is too long to be told")
    place = {"path": faults.path_of(file), "function": function.lineno, "at": at}
    return {**place, "kind": kind, "own": own, "meant": meant}


# --- what there is to choose from ----------------------------------------------------------------------------------------


def _nearest(name: str, among: Iterable[str]) -> str | None:
    """The one that is spelled nearly as this is; none where two are alike in that, or this is short."""
    if len(name) < _SHORTEST:
        return None
    known = {each for each in among if each != name and not each.startswith("__")}
    likeness = sorted(((_likeness(name, each), each) for each in known), reverse=True)[:2]
    best = [each for each in likeness if each[0] >= _CLOSE and each[0] == likeness[0][0]]
    return best[0][1] if len(best) == 1 else None


def _likeness(one: str, other: str) -> float:
    plain, others = (each.casefold().replace("_", "") for each in (one, other))
    ratio = difflib.SequenceMatcher(None, plain, others).ratio()
    return max(ratio, _CLOSE) if sorted(plain) == sorted(others) else ratio  # in another order


def _keywords() -> set[str]:
    """What a function of the submission's own may be given by name, and what curves and texts may be."""
    from matplotlib.lines import Line2D
    from matplotlib.text import Text

    setters = {each.removeprefix("set_") for each in (*dir(Line2D), *dir(Text)) if each.startswith("set_")}
    members = [each for module in STATE.modules.values() for each in vars(module).values()]
    made = [vars(each).get("__init__") if isinstance(each, type) else each for each in members]
    codes = [each.__code__ for each in made if isinstance(each, FunctionType)]
    return setters.union(*(code.co_varnames[: code.co_argcount + code.co_kwonlyargcount] for code in codes))


# --- in the text ---------------------------------------------------------------------------------------------------------


def _tree(file: str) -> ast.Module:
    return ast.parse("".join(linecache.getlines(file)))


def _around(tree: ast.Module, line: int) -> Function | None:
    """The innermost function that this line is in."""
    functions = [each for each in ast.walk(tree) if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef)]
    around = [each for each in functions if _first_line(each) <= line <= (each.end_lineno or 0)]
    return max(around, key=lambda each: each.lineno, default=None)


def _first_line(function: Function) -> int:
    return min([function.lineno, *(each.lineno for each in function.decorator_list)])


def is_set(node: ast.expr) -> bool:
    return isinstance(getattr(node, "ctx", None), ast.Store | ast.Del)
