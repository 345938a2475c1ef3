"""What must be meant where an array has another form than is needed: what NumPy raises for, by what is there at that moment."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Sequence
from types import ModuleType
from typing import Any

import numpy as np

from .scope import Function, Meant, Scope

_FRACTION = re.compile(
    r"'(?:numpy\.)?float\d*' object cannot be interpreted as an integer|^expected a sequence of integers or a single integer"
)
_TRUTH = "truth value of an array"
_ROW = re.compile(
    r"could not broadcast input array from shape \((\d+),\)|setting an array element with a sequence|too many indices for array"
)
_SIZES = re.compile(r"could not be broadcast together with shapes \((\d+),\) \((\d+),\)")
_FILLED = ("zeros", "empty", "ones", "full")
_TOO_MANY = "too many values to unpack"
_TOO_FEW = re.compile(r"not enough values to unpack \(expected (\d+), got (\d+)\)")
_NO_NUMBERS = re.compile(
    r"can't multiply sequence by non-int|unsupported operand type|can only concatenate (?:list|tuple)"
)


def _index(raised: TypeError, scope: Scope) -> Meant:
    """An array that is called."""
    for each in scope.there(ast.Call) if "object is not callable" in str(raised) else ():
        if len(each.args) == 1 and not each.keywords and isinstance(scope.value_of(each.func), np.ndarray):
            yield "index", ast.unparse(each), f"{ast.unparse(each.func)}[{ast.unparse(each.args[0])}]"


def _whole(raised: TypeError, scope: Scope) -> Meant:
    """A fraction where a whole number is needed."""
    if _FRACTION.search(str(raised)):
        given = {ast.unparse(each) for call in scope.there(ast.Call) for each in _whole_wanted(call, scope)}
        yield from (("whole", each, f"int({each})") for each in given if len(given) == 1)


def _shape(raised: TypeError, scope: Scope) -> Meant:
    """Rows and columns one after the other, where NumPy wants them together."""
    for each in scope.there(ast.Call) if "as a data type" in str(raised) else ():
        if len(each.args) == 2 and not each.keywords:
            yield "shape", ast.unparse(each), f"{ast.unparse(each.func)}(({', '.join(map(ast.unparse, each.args))}))"


def _size(raised: TypeError, scope: Scope) -> Meant:
    """An array of random numbers' size, where its shape is needed."""
    for call in scope.there(ast.Call) if _FRACTION.search(str(raised)) else ():
        for each in [*call.args[2:3], *(option.value for option in call.keywords if option.arg == "size")]:
            if isinstance(scope.value_of(each), np.ndarray):
                shape = ast.Attribute(each, "shape", ast.Load())
                args = [shape if arg is each else arg for arg in call.args]
                options = [ast.keyword(o.arg, shape if o.value is each else o.value) for o in call.keywords]
                yield "shape", ast.unparse(call), ast.unparse(ast.Call(call.func, args, options))


def _truth(raised: ValueError, scope: Scope) -> Meant:
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


def _appended(raised: AttributeError, scope: Scope) -> Meant:
    """What `append` returns, put in the place of the list."""
    for each in scope.there(ast.Call) if raised.obj is None and raised.name == "append" else ():
        if isinstance(each.func, ast.Attribute) and len(each.args) == 1 and scope.value_of(each.func.value) is None:
            yield "appended", ast.unparse(each), f"[*{ast.unparse(each.func.value)}, {ast.unparse(each.args[0])}]"


def _whole_wanted(call: ast.Call, scope: Scope) -> Iterator[ast.expr]:
    """What a call is given that is no whole number, or may be none: a variable, or what a division gives."""
    for each in [part for arg in call.args for part in (arg.elts if isinstance(arg, ast.Tuple) else [arg])]:
        divided = isinstance(each, ast.BinOp) and isinstance(each.op, ast.Div | ast.FloorDiv | ast.Mult)
        if divided or isinstance(scope.value_of(each), float):
            yield each


def _rows(raised: ValueError | TypeError | IndexError, scope: Scope) -> Meant:
    """An array of another number of columns than what is stored in its rows."""
    if (found := _ROW.search(str(raised))) is None:
        return
    stored = [(scope.value_of(target.value), target, value) for target, value in _stored(scope)]
    beside = [array.shape[1] for array, _, _ in stored if isinstance(array, np.ndarray) and array.ndim == 2]
    for array, target, value in stored:
        given = scope.value_of(value)
        known = [len(given)] if isinstance(given, np.ndarray) and given.ndim == 1 else beside
        columns = int(found[1]) if found[1] else next(iter(known), 0)
        if isinstance(array, np.ndarray) and columns and array.shape[1:] != (columns,):
            for made in _made_in(scope.function, ast.unparse(target.value)):
                call = made.value
                assert isinstance(call, ast.Call)
                right = _with_shape(call, _of_rows(call.args[0], array, columns))
                yield "statement", ast.unparse(made), f"{ast.unparse(made.targets[0])} = {ast.unparse(right)}"


def _stored(scope: Scope) -> Iterator[tuple[ast.Subscript, ast.expr]]:
    """The items that the line stores in, each with what is stored there."""
    for each in scope.statements():
        if isinstance(each, ast.Assign):
            for target in each.targets:
                several = isinstance(target, ast.Tuple) and isinstance(each.value, ast.Tuple)
                pairs = zip(target.elts, each.value.elts, strict=False) if several else [(target, each.value)]  # type: ignore[attr-defined] # several are tuples
                for one, value in pairs:
                    parts = one.elts if isinstance(one, ast.Tuple) else [one]
                    yield from ((part, value) for part in parts if isinstance(part, ast.Subscript))


def _made_in(function: Function, name: str) -> Iterator[ast.Assign]:
    """How a function makes the array of this name: its one assignment, if that fills a shape."""
    sets = [each for each in ast.walk(function) if isinstance(each, ast.Assign)]
    made = [each for each in sets if name in map(ast.unparse, each.targets)]
    if len(made) == 1 and len(made[0].targets) == 1 and isinstance(made[0].value, ast.Call) and made[0].value.args:
        called = made[0].value.func
        if isinstance(called, ast.Attribute) and called.attr in _FILLED:
            yield made[0]


def _of_rows(shape: ast.expr, array: np.ndarray, columns: int) -> ast.expr:
    """The shape of so many rows as were meant, each with these columns."""
    parts = shape.elts if isinstance(shape, ast.Tuple | ast.List) else [shape]
    turned = len(parts) == 2 and array.shape[0] == columns  # (3, n) in place of (n, 3)
    return ast.Tuple([parts[1] if turned else parts[0], ast.Constant(columns)], ast.Load())


def _with_shape(call: ast.Call, shape: ast.expr) -> ast.Call:
    return ast.Call(call.func, [shape, *call.args[1:]], call.keywords)


def _drawn(raised: ValueError, scope: Scope) -> Meant:
    """Random numbers of another number than what they are added to has."""
    if (found := _SIZES.search(str(raised))) is None:
        return
    one, other = int(found[1]), int(found[2])
    for call in scope.there(ast.Call):
        for each in [*call.args[2:3], *(option.value for option in call.keywords if option.arg == "size")]:
            if isinstance(each, ast.Constant) and each.value in (one, other):
                right = ast.Constant(one if each.value == other else other)
                args = [right if arg is each else arg for arg in call.args]
                options = [ast.keyword(o.arg, right if o.value is each else o.value) for o in call.keywords]
                yield "shape", ast.unparse(call), ast.unparse(ast.Call(call.func, args, options))


def _one_of_one(raised: TypeError, scope: Scope) -> Meant:
    """An array of one number, where a slice wants the number."""
    if "only integer scalar arrays" not in str(raised) and "slice indices must be integers" not in str(raised):
        return
    bounds = [part for each in scope.there(ast.Slice) for part in ast.walk(each)]
    for each in [part for part in bounds if isinstance(part, ast.Name | ast.Attribute)]:
        value = scope.value_of(each)
        if isinstance(value, np.ndarray) and value.shape == (1,):
            yield "index", ast.unparse(each), f"{ast.unparse(each)}[0]"


def _together(raised: TypeError, scope: Scope) -> Meant:
    """Arrays one after the other, where NumPy wants them together."""
    for call in scope.there(ast.Call) if "scalar" in str(raised) or "argument" in str(raised) else ():
        name = call.func.attr if isinstance(call.func, ast.Attribute) else ""
        arrays = [isinstance(scope.value_of(each), np.ndarray) for each in call.args]
        if name in ("concatenate", "vstack", "hstack", "column_stack", "stack") and len(arrays) > 1 and all(arrays):
            options = "".join(f", {ast.unparse(each)}" for each in call.keywords)
            yield (
                "shape",
                ast.unparse(call),
                f"{ast.unparse(call.func)}(({', '.join(map(ast.unparse, call.args))}){options})",
            )


def _one_row(raised: ValueError, scope: Scope) -> Meant:
    """A row that is put below others, which is no array of one row."""
    if "must have same number of dimensions" not in str(raised):
        return
    for call in scope.there(ast.Call):
        name = call.func.attr if isinstance(call.func, ast.Attribute) else ""
        parts = (
            call.args[0].elts if name == "concatenate" and isinstance(call.args[0], ast.Tuple | ast.List) else call.args
        )
        values = [scope.value_of(each) for each in parts[:2]]
        if name in ("append", "concatenate") and [getattr(value, "ndim", 0) for value in values] == [2, 1]:
            row = ast.unparse(parts[1])
            yield "shape", row, f"[{row}]"


def _numbers(raised: TypeError, scope: Scope) -> Meant:
    """A list that is computed with."""
    named = (name for name, value in scope.globals.items() if isinstance(value, ModuleType) and value is np)
    numpy = next(named, "np")
    if not _NO_NUMBERS.search(str(raised)):
        return
    for each in scope.there(ast.BinOp):
        for side in (each.left, each.right):
            if isinstance(side, ast.Name | ast.Attribute) and isinstance(scope.value_of(side), list | tuple):
                yield "numbers", ast.unparse(side), f"{numpy}.asarray({ast.unparse(side)})"


def _put(raised: IndexError, scope: Scope) -> Meant:
    """A list that is still empty, in which something is put at a place."""
    if "list assignment index out of range" not in str(raised):
        return
    for each in scope.statements():
        target = each.targets[0] if isinstance(each, ast.Assign) and len(each.targets) == 1 else None
        if (
            isinstance(each, ast.Assign)
            and isinstance(target, ast.Subscript)
            and isinstance(scope.value_of(target.value), list)
        ):
            appended = f"{ast.unparse(target.value)}.append({ast.unparse(each.value)})"
            yield "statement", ast.unparse(each), appended


def _place(raised: IndexError, scope: Scope) -> Meant:
    """A fraction for the number of a row."""
    if "only integers, slices" in str(raised):
        for target, _ in _stored(scope):
            written = ast.unparse(target.slice)
            yield "whole", written, f"int(round({written}))"


def _unpacked(raised: ValueError, scope: Scope) -> Meant:
    """More names than what a call returns, as many of them too many as nobody uses; or fewer: the others are not asked for."""
    if _TOO_MANY in str(raised):
        yield from _with_others(scope)
    if (found := _TOO_FEW.search(str(raised))) is None:
        return
    read = {
        each.id for each in ast.walk(scope.function) if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Load)
    }
    for each in scope.statements():
        target = each.targets[0] if isinstance(each, ast.Assign) and len(each.targets) == 1 else None
        if isinstance(each, ast.Assign) and isinstance(target, ast.Tuple) and len(target.elts) == int(found[1]):
            used = [ast.unparse(one) for one in target.elts if not isinstance(one, ast.Name) or one.id in read]
            if len(used) == int(found[2]):
                yield "statement", ast.unparse(each), f"{', '.join(used)} = {ast.unparse(each.value)}"


def _with_others(scope: Scope) -> Meant:
    for each in scope.statements():
        target = each.targets[0] if isinstance(each, ast.Assign) and len(each.targets) == 1 else None
        if isinstance(each, ast.Assign) and isinstance(target, ast.Tuple) and isinstance(each.value, ast.Call):
            names = ", ".join(map(ast.unparse, target.elts))
            yield "statement", ast.unparse(each), f"{names}, *_ = {ast.unparse(each.value)}"


def _made(raised: NameError, scope: Scope) -> Meant:
    """A list or an array of rows that a loop fills and nothing makes."""
    loops = [each for each in ast.walk(scope.function) if isinstance(each, ast.For | ast.While)]
    around = [each for each in loops if each.lineno <= scope.line <= (each.end_lineno or 0)]
    name = str(raised.name or "")
    for loop in around[:1]:
        if any(ast.unparse(call.func) == f"{name}.append" for call in ast.walk(loop) if isinstance(call, ast.Call)):
            yield "made", name, f"{name} = []"
        elif any(ast.unparse(target.value) == name for target, _ in _stored(scope)) and isinstance(loop, ast.For):
            counted = (
                loop.iter.args if isinstance(loop.iter, ast.Call) and ast.unparse(loop.iter.func) == "range" else []
            )
            if len(counted) == 1:
                yield "made", name, f"{name} = [None] * {ast.unparse(counted[0])}"


RULES: Sequence[tuple[type[BaseException], Callable[[Any, Scope], Meant]]] = (
    (TypeError, _index),
    (TypeError, _size),
    (TypeError, _whole),
    (TypeError, _shape),
    (ValueError, _truth),
    (AttributeError, _appended),
    (ValueError, _rows),
    (TypeError, _rows),
    (IndexError, _rows),
    (ValueError, _drawn),
    (TypeError, _one_of_one),
    (TypeError, _together),
    (ValueError, _one_row),
    (TypeError, _numbers),
    (IndexError, _put),
    (NameError, _made),
    (IndexError, _place),
    (ValueError, _unpacked),
)
"""What is raised, and the rule that says what must be meant then."""
