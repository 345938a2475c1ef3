"""Replace parts of a submission by stand-ins (working definitions that the grader sends), and correct misspelled names."""

from __future__ import annotations

import ast
import builtins
import types
from collections.abc import Iterator, Mapping
from typing import Any

from . import compiling, fuzzy_names, statements
from .submission import STATE


def define(sources: Mapping[str, str]) -> None:
    """Run `sources`, {required name: source text}, and keep what they define in `STATE.standins`, to replace broken definitions."""
    space = types.ModuleType("standins")
    vars(space)["__builtins__"] = vars(builtins)
    for name, source in sources.items():
        exec(compile(source, "<stand-in>", "exec"), vars(space))
        STATE.standins[name] = vars(space)[name]


def fill(path: str, names: dict[str, Any]) -> None:
    """Put stand-ins (the grader's definitions) into a file's namespace `names` for required names that it should define and lacks.

    The file should define its own names, those of required files that were not submitted, and any that it tried to define.
    """
    lacking = [name for name in STATE.standins if name not in names]
    own = compiling.defined(path) if lacking else set()
    for name in lacking:
        home = f"{STATE.homes.get(name)}.py"
        if home == path or home not in STATE.paths or name in own:
            names[name] = STATE.standins[name]


def of_module(module: str) -> dict[str, Any]:
    """Return {name: stand-in} for the required names of a module, submitted or not, that the grader sent definitions for."""
    return {name: standin for name, standin in STATE.standins.items() if STATE.homes.get(name) == module}


def standin_for(own: Any, name: str) -> Any:
    """Return the grader's definition of `name`, to replace the student's `own`; raise KeyError if there is none.

    A class keeps the student's additional methods.
    """
    standin = STATE.standins[name]
    if not (issubclass(type(own), type) and isinstance(standin, type)):
        return standin
    sheets = {part for kind in standin.__mro__ for part in vars(kind)}
    methods = (types.FunctionType, classmethod, staticmethod)
    members = [member for kind in reversed(type.mro(own)) for member in fuzzy_names.members_of(kind).items()]
    beside = {part: value for part, value in members if isinstance(value, methods) and part not in sheets}
    meant = (each for known in STATE.misspelled_methods.values() for each in known.items())
    beside |= {method: getattr(standin, n.partition(".")[2]) for n, method in meant if n.startswith(f"{name}.")}
    return type(name, (standin,), beside)


def misspelled(path: str, units: list[statements.Unit]) -> dict[str, str]:
    """Return {student's name: required name} where `units` lack a name and just one definition is a letter, case or `_` off."""
    pairs = fuzzy_names.misspelled([unit.node for unit in units], STATE.names_expected_in(path))
    return {own: name for name, own in pairs}


def replace_defined(node: ast.stmt, meant: Mapping[str, str], names: dict[str, Any]) -> None:
    """Put the stand-in (the grader's definition), if any, of each name that a statement just defined into the namespace `names`.

    The stand-in replaces the student's broken definition. `meant` maps misspelled names to right ones.
    """
    known = {own: meant.get(own, own) for own in statements.bound(node)}
    names.update({own: standin_for(names.get(own), n) for own, n in known.items() if n in STATE.standins})


def alias_misspelled(meant: Mapping[str, str], names: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Define misspelled names in `names` under their right names, too; yield (right, misspelled). `meant` is {misspelled: right}.

    Names that a stand-in (the grader's definition) replaced are left out.
    """
    for own, name in meant.items():
        if name not in STATE.standins and own in names:
            names[name] = names[own]
            yield name, own
