"""What a function raises for, where one thing alone can be meant: a slip of the pen in a name, a forgotten `self.` or `np.`.

So can be an array of another form than is needed, see `arrays`, other arguments than a function takes, see `arguments`, and a
method that is not called.
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
from typing import Any, TypeAlias

import numpy as np

from . import arguments, arrays, faults, flow, returning
from .scope import Function, Meant, Scope, is_set
from .submission import STATE

Slip: TypeAlias = dict[str, Any]

_CLOSE = 0.8
"""Of the letters in common, as difflib counts: one in five may be lost, doubled, another or elsewhere. It has raised already."""
_SHORTEST = 3
_KEYWORD = re.compile(r"unexpected keyword argument '(\w+)'")
_WITHOUT_SELF = re.compile(
    r"^(\w+)\.(\w+)\(\) (?:takes \d+ positional arguments? but|got multiple values for argument)"
)
_LONGEST = 200
_FROM = 4
"""Calls that are looked at from the innermost outwards, for one that gives what another stops at."""


def notice(raised: BaseException, *, drawing: bool = False) -> None:
    """Keep what must be meant by the name that this was raised for, if it is one; the first of a question counts.

    Parameters
    ----------
    drawing : whether a figure is drawn, and a call for its effect alone can be left out of that
    """
    with suppress(BaseException):  # what the student's objects answer is their code
        STATE.slip = STATE.slip or _news(_slips(raised)) or next(_left_out(raised, drawing=drawing), None)


def _news(found: Iterator[Slip]) -> Slip | None:
    """The first that is not mended yet; where all are, the first of them: then it does not help."""
    several = list(found)
    return next((slip for slip in several if slip not in STATE.slips), next(iter(several), None))


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
    frames = [frame for frame, at in own if frame.f_code.co_filename == file and _holds(function, at)]
    scope = Scope(frames, function, line, called_by_own=len(frames) < len(own))
    for kind, name, meant in _meant(raised, scope):
        yield _slip(file, function, kind, name, meant, at=line)
    yield from _from_outside(raised, own)
    yield from _of_helpers(raised, scope)


def _of_helpers(raised: BaseException, scope: Scope) -> Iterator[Slip]:
    """A helper without the `return` of what it computes."""
    for code in {function.__code__ for function in flow.called_for_nothing(raised, scope)}:
        function = _around(_tree(code.co_filename), code.co_firstlineno) if faults.is_own(code.co_filename) else None
        value = returning.last_of(function) if isinstance(function, ast.FunctionDef) else None
        if function and value is not None:
            yield _slip(code.co_filename, function, "returned", "no return", ast.unparse(value), at=function.lineno)


def _from_outside(raised: BaseException, own: list[tuple[FrameType, int]]) -> Iterator[Slip]:
    """What a function stops at that was called with its arguments in another order."""
    for frame, line in own[-2 : -2 - _FROM : -1]:  # a recursion has a thousand
        function = _around(_tree(frame.f_code.co_filename), line)
        if function is not None:
            for kind, name, meant in arguments.by_names(raised, Scope([frame], function, line)):
                yield _slip(frame.f_code.co_filename, function, kind, name, meant, at=line)


def _own_frames(raised: BaseException) -> list[tuple[FrameType, int]]:
    """The submission's frames that this came through, each with its line; the innermost last."""
    return [each for each in traceback.walk_tb(raised.__traceback__) if faults.is_own(each[0].f_code.co_filename)]


def _left_out(raised: BaseException, *, drawing: bool) -> Iterator[Slip]:
    """The innermost call whose value nobody uses: what it does to a figure, or tells, is all that is missing without it."""
    told = f"{type(raised).__name__}: {faults.describe(raised)['message']}"
    for frame, line in _own_frames(raised)[: -1 - _FROM : -1] if isinstance(raised, Exception) else ():
        file = frame.f_code.co_filename
        function = _around(_tree(file), line)
        statement = function and alone_at(function, line)
        if function and statement and (drawing or _only_tells(statement)):
            yield _slip(file, function, "left out", ast.unparse(statement)[:_LONGEST], told[:_LONGEST], at=line)


def alone_at(function: Function, line: int) -> ast.Expr | ast.Assert | None:
    """The call on this line whose value nobody uses, or what is asserted there."""
    calls = [each for each in ast.walk(function) if isinstance(each, ast.Expr) and isinstance(each.value, ast.Call)]
    alone: list[ast.Expr | ast.Assert] = [
        *calls,
        *(each for each in ast.walk(function) if isinstance(each, ast.Assert)),
    ]
    around = [each for each in alone if each.lineno <= line <= (each.end_lineno or 0)]
    return around[-1] if around else None


def _only_tells(statement: ast.Expr | ast.Assert) -> bool:
    """Whether it prints, logs, or looks whether something holds."""
    if isinstance(statement, ast.Assert):
        return True
    called = statement.value.func if isinstance(statement.value, ast.Call) else None
    logs = isinstance(called, ast.Attribute) and ast.unparse(called.value) in ("logging", "logger", "log")
    return logs or (isinstance(called, ast.Name) and called.id in ("print", "pprint", "display"))


def _name(raised: NameError, scope: Scope) -> Meant:
    if raised.name == "self":
        yield "self", "self", "self"
    elif raised.name and (name := _name_meant(raised.name, scope)):
        yield "expression", raised.name, name


def _member(raised: AttributeError, scope: Scope) -> Meant:
    named = [each for each in scope.there(ast.Attribute) if each.attr == raised.name]
    member = _other_form(named[0].attr, raised.obj) if named else ""
    if named and not member and not _owners(raised, scope):
        near = _nearest(named[0].attr, dir(raised.obj)) or _shorter(named[0].attr, dir(raised.obj))
        member = f".{near}" if near else ""
    for each in named:
        if member and scope.may_be(each.value, raised.obj):
            yield "expression", ast.unparse(each), ast.unparse(each.value) + member


def _owner(raised: AttributeError, scope: Scope) -> Meant:
    """A member of another object that is there, as the one of the program's two that has it."""
    owners = _owners(raised, scope)
    for each in scope.there(ast.Attribute) if len(owners) == 1 else ():
        of_it = isinstance(each.value, ast.Name) and scope.value_of(each.value) is raised.obj
        if of_it and each.attr == raised.name and not scope.is_given(ast.unparse(each.value)):
            yield "expression", ast.unparse(each), f"{owners[0]}.{each.attr}"


def _owners(raised: AttributeError, scope: Scope) -> list[str]:
    """What the other objects are called that have what this one was asked for, each by one of its names."""
    names = {**scope.globals, **scope.locals}
    return list({id(value): name for name, value in names.items() if _is_owner(value, raised)}.values())


def _is_owner(value: Any, raised: AttributeError) -> bool:
    """Whether something has what another thing was asked for; numbers and texts, and what draws, share too much to tell."""
    if value is raised.obj or isinstance(value, _PLAIN) or isinstance(raised.obj, _PLAIN) or callable(raised.obj):
        return False
    drawn = value.__name__ if isinstance(value, ModuleType) else type(value).__module__
    return not drawn.startswith("matplotlib") and raised.name in dir(value)


_PLAIN = (np.ndarray, list, dict, tuple, str, int, float, FunctionType, type, type(None))


def _exchanged(raised: TypeError, scope: Scope) -> Meant:
    """Two names for what a call returns, each in the other's place."""
    if "object is not subscriptable" not in str(raised):
        return
    asked = {each.value.id for each in scope.there(ast.Subscript) if isinstance(each.value, ast.Name)}
    for each in ast.walk(scope.function):
        target = each.targets[0] if isinstance(each, ast.Assign) else None
        if isinstance(target, ast.Tuple) and len(target.elts) == 2 and isinstance(each.value, ast.Call):  # type: ignore[attr-defined] # it has a target
            one, other = target.elts
            pairs = [(one, other), (other, one)]
            if any(
                isinstance(first, ast.Name)
                and first.id in asked
                and not hasattr(scope.value_of(first), "__getitem__")
                and isinstance(scope.value_of(second), np.ndarray)
                for first, second in pairs
            ):
                turned = ast.unparse(ast.Tuple([other, one], ast.Store())).strip("()")
                yield "statement", ast.unparse(each), f"{turned} = {ast.unparse(each.value)}"  # type: ignore[attr-defined]


def _own_constant(raised: AttributeError, scope: Scope) -> Meant:
    """A name of another file of the submission that begins as this one does, and is spoken of nowhere: half renamed."""
    if isinstance(raised.obj, ModuleType) and raised.obj in STATE.modules.values():
        asked = str(raised.name)
        first = asked.partition("_")[0]
        spoken_of = {each.attr for module in STATE.modules.values() for each in _attributes(module)}
        alike = [each for each in vars(raised.obj) if each.partition("_")[0] == first and each not in spoken_of]
        for each in scope.there(ast.Attribute) if len(alike) == 1 else ():
            if each.attr == asked and scope.value_of(each.value) is raised.obj:
                yield "expression", ast.unparse(each), f"{ast.unparse(each.value)}.{alike[0]}"


def _attributes(module: ModuleType) -> Iterator[ast.Attribute]:
    path = next(path for path, each in STATE.modules.items() if each is module)
    return (each for each in ast.walk(_tree(faults.own_name(path))) if isinstance(each, ast.Attribute))


def _of_itself(raised: RecursionError, scope: Scope) -> Meant:
    """A property that returns itself, where the object keeps what is meant under the same name with a line before it."""
    owner = scope.locals.get(scope.first)
    name = scope.function.name
    kept = [each for each in getattr(owner, "__dict__", {}) if each != name and each.endswith(f"_{name}")]
    if "property" in map(ast.unparse, scope.function.decorator_list) and len(kept) == 1:
        yield "expression", f"{scope.first}.{name}", f"{scope.first}.{kept[0]}"


def _key(raised: KeyError, scope: Scope) -> Meant:
    (key,) = raised.args
    for each in scope.there(ast.Subscript):
        if isinstance(key, str) and isinstance(each.slice, ast.Constant) and each.slice.value == key:
            meant = _nearest(key, _keys_of(scope.value_of(each.value)))
            if meant:
                yield "expression", ast.unparse(each), f"{ast.unparse(each.value)}[{meant!r}]"


def _keyword(raised: BaseException, scope: Scope) -> Meant:
    found = _KEYWORD.search(str(raised))
    if found and scope.there(ast.Call) and (name := _nearest(found[1], _keywords())):
        yield "keyword", found[1], name


def _called(raised: TypeError | AttributeError, scope: Scope) -> Meant:
    """A method without the brackets that call it."""
    if "'builtin_function_or_method'" in str(raised) or "'method'" in str(raised):
        called = [each.func for each in ast.walk(scope.function) if isinstance(each, ast.Call)]
        members = [each for each in ast.walk(scope.function) if isinstance(each, ast.Attribute) and each not in called]
        given = {ast.unparse(each) for each in members if not is_set(each) and _is_method(scope.value_of(each), each)}
        yield from (("called", each, f"{each}()") for each in given if len(given) == 1)


def _is_method(value: Any, written: ast.Attribute) -> bool:
    """Whether it is one by the name that is written there, and not what was kept under another."""
    return callable(value) and getattr(value, "__name__", "") == written.attr


_MEANT: Sequence[tuple[type[BaseException], Callable[[Any, Scope], Meant]]] = (
    *[rule for rule in flow.RULES if issubclass(rule[0], UnboundLocalError)],
    (NameError, _name),
    (AttributeError, _keyword),  # matplotlib raises it for those
    (TypeError, _keyword),
    (AttributeError, _member),
    (AttributeError, _own_constant),
    (AttributeError, _owner),
    (RecursionError, _of_itself),
    (TypeError, _exchanged),
    (KeyError, _key),
    *arrays.RULES,
    (TypeError, arguments.by_types),
    (TypeError, arguments.by_names),
    (TypeError, _called),
    (AttributeError, _called),
    *[rule for rule in flow.RULES if not issubclass(rule[0], UnboundLocalError)],
)


def _meant(raised: BaseException, scope: Scope) -> Meant:
    for kind, rule in _MEANT:
        if isinstance(raised, kind):
            yield from rule(raised, scope)


def _name_meant(name: str, scope: Scope) -> str | None:
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


def _other_form(name: str, owner: Any) -> str:
    """A key of a dictionary; what a panel sets where pyplot has a function, or the reverse."""
    if name in _keys_of(owner):
        return f"[{name!r}]"
    other = _NOW.get(name) or (name.removeprefix("set_") if name.startswith("set_") else f"set_{name}")
    return f".{other}" if other in dir(owner) else ""


_NOW = {"randn": "standard_normal", "rand": "random", "randint": "integers", "random_sample": "random"}
"""What NumPy's older random numbers are called in its newer ones."""


def _keys_of(value: Any) -> set[str]:
    return {key for key in value if isinstance(key, str)} if isinstance(value, dict) else set()


def _is_own_object(value: Any) -> bool:
    return type(value).__module__ in {module.__name__ for module in STATE.modules.values()}


def _kept_by_nobody(raised: AttributeError) -> Iterator[Slip]:
    """An attribute that `__init__` does not set, though it has a variable of that name, or one parameter that it does not use."""
    made = getattr(type(raised.obj), "__init__", None)
    if not isinstance(made, FunctionType) or not _is_own_object(raised.obj):
        return
    code = made.__code__
    function = _around(_tree(code.co_filename), code.co_firstlineno)
    name = str(raised.name)
    meant = [name] if name in code.co_varnames else _unused(function) if function and name not in code.co_names else []
    if len(meant) == 1:
        yield from _of_code(code, "kept", meant[0], name)
    elif (
        function
        and "super" not in code.co_names
        and (given := _given_to_base(type(raised.obj), code, name)) is not None
    ):
        call = f"super().__init__({', '.join(given)})"
        yield _slip(code.co_filename, function, "begun", "no super().__init__", call, at=function.lineno)


def _given_to_base(kind: type, code: CodeType, name: str) -> list[str] | None:
    """What the base that sets an attribute is given, by its parameters' names; None where none sets it, or more is needed."""
    made = [vars(base).get("__init__") for base in kind.__mro__[1:]]
    setting = next((each for each in made if isinstance(each, FunctionType) and name in each.__code__.co_names), None)
    if setting is None or setting.__code__.co_kwonlyargcount:
        return None
    names = setting.__code__.co_varnames[1 : setting.__code__.co_argcount]
    needed = names[: len(names) - len(setting.__defaults__ or ())]
    own = code.co_varnames[: code.co_argcount]
    return [f"{each}={each}" for each in names if each in own] if all(each in own for each in needed) else None


def _unused(function: Function) -> list[str]:
    """The parameters, but for the first, that a method does nothing with."""
    used = {each.id for each in ast.walk(function) if isinstance(each, ast.Name)}
    return [each.arg for each in [*function.args.args[1:], *function.args.kwonlyargs] if each.arg not in used]


def _without_self(kind: str, method: str) -> Iterator[Slip]:
    """A method that speaks of `self`, and has no such parameter."""
    for module in list(STATE.modules.values()):
        own = vars(vars(module).get(kind, object)).get(method)
        if isinstance(own, FunctionType) and "self" in own.__code__.co_names:
            yield from _of_code(own.__code__, "self", "self", "self")


def _of_code(code: CodeType, kind: str, own: str, name: str) -> Iterator[Slip]:
    function = _around(_tree(code.co_filename), code.co_firstlineno)
    if function and faults.is_own(code.co_filename):
        meant = f"self.{name}" if kind == "kept" else name
        yield _slip(code.co_filename, function, kind, own, meant, at=function.lineno)


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


def _shorter(name: str, among: Iterable[str]) -> str | None:
    """The one that this is short for, or that is short for it: letters of it in their order, from the first on."""
    known = [each for each in among if not each.startswith("_") and len(each) >= _SHORTEST and each[0] == name[0]]
    both = [(each, *sorted((each, name), key=len)) for each in known if len(each) != len(name)]
    alike = [each for each, short, long in both if len(short) >= _SHORTEST and _stands_in(short, long)]
    return alike[0] if len(alike) == 1 else None


def _stands_in(short: str, long: str) -> bool:
    letters = iter(long)
    return all(letter in letters for letter in short)


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
    return max((each for each in functions if _holds(each, line)), key=lambda each: each.lineno, default=None)


def _holds(function: Function, line: int) -> bool:
    return _first_line(function) <= line <= (function.end_lineno or 0)


def _first_line(function: Function) -> int:
    return min([function.lineno, *(each.lineno for each in function.decorator_list)])
