"""What must be meant where a function is called with other arguments than it takes: some of them elsewhere, or one forgotten.

A compiled function says which types it takes, and each argument goes where its type belongs. A Python function has parameters, and
a variable that is called as one of them goes there.
"""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from types import FunctionType
from typing import Any

from .scope import Meant, Scope

_INCOMPATIBLE = re.compile(
    r"^(\w+)\(\): incompatible function arguments[^\n]*\n\s*1\. \((.*?)\) -> [^\n]*(?:\n\n|$)", re.DOTALL
)
_PARAMETER = re.compile(r"(?:^|, )(\w+): ((?:[^,\[\]]|\[[^\[\]]*(?:\[[^\]]*\][^\[\]]*)*\])+)")
_UNKNOWN = object()


@dataclass(frozen=True)
class _Parameter:
    """One of a compiled function: its type as it is told there."""

    type: str
    needed: bool

    @property
    def is_of_the_library(self) -> bool:
        """Whether it is an object that a program has one of, and no number or text."""
        return "._" in self.type

    def takes(self, value: Any) -> bool:
        if self.is_of_the_library:
            return f"{type(value).__module__}.{type(value).__qualname__}" == self.type
        if "SupportsInt" in self.type or self.type == "int":
            return hasattr(value, "__index__") or type(value).__module__.endswith("._enums")
        return isinstance(value, str) if self.type == "str" else "ndarray" in self.type and hasattr(value, "dtype")


def by_types(raised: TypeError, scope: Scope) -> Meant:
    """A compiled function's arguments in its order, with the one object of a type that is there in the place of what is not."""
    if (found := _INCOMPATIBLE.match(str(raised))) is None or "\n    2. " in str(raised):
        return
    wanted = [
        _Parameter(kind.partition(" = ")[0].strip(), " = " not in kind) for _, kind in _PARAMETER.findall(found[2])
    ]
    for call in scope.there(ast.Call):
        if ast.unparse(call.func).rpartition(".")[2] == found[1] and not call.keywords:
            given = _in_order(wanted, call, scope)
            if given is not None:
                yield "arguments", ast.unparse(call), f"{ast.unparse(call.func)}({', '.join(given)})"


def _in_order(wanted: Sequence[_Parameter], call: ast.Call, scope: Scope) -> list[str] | None:
    """What each parameter is given; None where that is not known, or something that may be meant would be lost."""
    left = [(ast.unparse(each), _value(each, scope)) for each in call.args]
    ordered: list[str] = []
    for parameter in wanted:
        own = next((each for each in left if each[1] is not _UNKNOWN and parameter.takes(each[1])), None)
        if own is None and parameter.is_of_the_library:
            there = _only_one(parameter, scope)
            own = (there, None) if there else None
        if own is None and parameter.needed:
            own = next((each for each in left if each[1] is _UNKNOWN), None)
        if own is None and parameter.needed:
            return None
        if own is None:
            break
        ordered.append(own[0])
        left = [each for each in left if each is not own]
    may_be_meant = [each for each in left if each[1] is _UNKNOWN or isinstance(each[1], str)]
    return None if may_be_meant else ordered


def _value(written: ast.expr, scope: Scope) -> Any:
    value = scope.value_of(written) if isinstance(written, ast.Name | ast.Attribute | ast.Constant) else None
    return _UNKNOWN if value is None else value


def _only_one(parameter: _Parameter, scope: Scope) -> str:
    """What the one object of this type is called where the line runs; empty where there is none, or several."""
    for known in _known(scope):
        there = {name: value for name, value in known.items() if parameter.takes(value)}
        if there:
            return next(iter(there)) if len({id(value) for value in there.values()}) == 1 else ""
    return ""


def _known(scope: Scope) -> Iterator[dict[str, Any]]:
    """What a line can speak of, the nearest first: variables, attributes of the object whose method it is in, globals."""
    yield dict(scope.locals)
    owner = scope.locals.get(scope.first)
    yield {f"{scope.first}.{name}": value for name, value in getattr(owner, "__dict__", {}).items()}
    yield dict(scope.globals)


def by_names(raised: BaseException, scope: Scope) -> Meant:
    """A Python function's arguments in its order, where they are called as its parameters are."""
    for call in scope.there(ast.Call):
        function = scope.value_of(call.func)
        if isinstance(function, FunctionType) and not call.keywords:
            given = _by_parameters(function, call, scope)
            if given is not None and given != [ast.unparse(each) for each in call.args]:
                yield "arguments", ast.unparse(call), f"{ast.unparse(call.func)}({', '.join(given)})"


def _by_parameters(function: FunctionType, call: ast.Call, scope: Scope) -> list[str] | None:
    parameters = [p for p in inspect.signature(function).parameters.values() if p.kind is p.POSITIONAL_OR_KEYWORD]
    names = [p.name for p in parameters]
    needed = [p.name for p in parameters if p.default is p.empty]
    if any(isinstance(each, ast.Starred) for each in call.args) or len(call.args) > len(names):
        return None
    own = {name: ast.unparse(each) for each in call.args if (name := _last(each)) in names}
    others = [ast.unparse(each) for each in call.args if _last(each) not in own]
    free = [name for name in names if name not in own]
    lacking = [name for name in needed if name not in own][: max(0, len(needed) - len(call.args))]
    there = {
        name: own
        for known in reversed(list(_known(scope)))
        for own in known
        if (name := own.rpartition(".")[2]) in lacking
    }
    if len(there) < len(lacking) or (not own and not lacking):
        return None
    own |= there
    own |= dict(zip([name for name in free if name not in there], others, strict=False))
    return [own[name] for name in names if name in own] if len(own) == len(call.args) + len(lacking) else None


def _last(written: ast.expr) -> str:
    """What a variable or an attribute is called; empty for anything else."""
    return ast.unparse(written).rpartition(".")[2] if isinstance(written, ast.Name | ast.Attribute) else ""
