"""How a function is called whose parameters are not the promised ones, and which names of a file are supplied or matched."""

from __future__ import annotations

import ast
import re
from types import ModuleType
from typing import Any

import pytest

from grader.worker import fuzzy_names, statements
from grader.worker.calling import Slot, plan_call
from grader.worker.missing_imports import MissingImports

SLOTS = (
    Slot("model", re.compile("^m$")),
    Slot("data", re.compile("^d$")),
    Slot("size", re.compile("std|size"), "option"),
    Slot("offset", re.compile("bias"), "option"),
    Slot("place", re.compile("^id"), "spare", (int, type(None))),
)
VALUES = {"model": "M", "data": "D", "size": "S", "offset": "O", "place": "P"}


def _as_promised(model, data, size=1, offset=0):
    return model, data, size, offset  # type: ignore[no-untyped-def]


def _any_words(first, second, *, size=1, offset=0):
    return first, second, size, offset  # type: ignore[no-untyped-def]


def _other_words(m, d, std=1, bias=0):
    return m, d, std, bias  # type: ignore[no-untyped-def]


def _other_order(data, model, size=1, offset=0):
    return model, data, size, offset  # type: ignore[no-untyped-def]


def _without_size(model, data, offset=0):
    return model, data, "S", offset  # type: ignore[no-untyped-def]


def _without_data(model, size=1, offset=0):
    return model, "D", size, offset  # type: ignore[no-untyped-def]


def _asks_for_more(model, data, idx, size=1, offset=0):
    return model, data, size, offset, idx  # type: ignore[no-untyped-def]


def _may_take_more(model, data, size=1, offset=0, idx=None):
    return model, data, size, offset, idx  # type: ignore[no-untyped-def]


def _means_another(model, data, size=1, offset=0, idx="x"):
    return model, data, size, offset, idx  # type: ignore[no-untyped-def]


def _has_its_own(m, d, std=1, bias=0, place="x"):
    return m, d, std, bias, place  # type: ignore[no-untyped-def]


def _by_position_alone(d, m, /, size=1, offset=0):
    return m, d, size, offset  # type: ignore[no-untyped-def]


def _whatever(*given, **named):
    return *given, *named.values()  # type: ignore[no-untyped-def]


CALLS: dict[Any, tuple[str, tuple[str, ...]]] = {
    _as_promised: ("MDSO", ()),
    _any_words: ("MDSO", ()),
    _other_words: ("MDSO", ("size", "offset")),
    _other_order: ("MDSO", ("model", "data")),
    _without_size: ("MDSO", ()),  # what it makes of another size tells it
    _without_data: ("MDSO", ("data",)),
    _asks_for_more: ("MDSOP", ("place",)),
    _may_take_more: ("MDSOP", ("place",)),
    _means_another: ("MDSOx", ()),
    _has_its_own: ("MDSOx", ("size", "offset")),
    _whatever: ("MDSO", ()),
}


@pytest.mark.parametrize("function", CALLS, ids=lambda function: function.__name__)
def test_a_function_is_called_by_its_own_parameters(function: Any) -> None:
    way = plan_call(function, SLOTS)
    came, departs = CALLS[function]
    assert way(function, VALUES) == tuple(came)
    assert way.departs == departs


def test_what_only_position_tells_is_given_as_promised() -> None:
    assert plan_call(_by_position_alone, SLOTS)(_by_position_alone, VALUES) == ("D", "M", "S", "O")


def test_what_may_go_anywhere_goes_to_a_parameter_of_any_name() -> None:
    def function(env, sim, idx=None, length=5.0):
        return env, sim, idx, length  # type: ignore[no-untyped-def]

    slots = (*SLOTS[:2], Slot("seconds", re.compile("sec"), free=True, anywhere=True), SLOTS[-1])
    assert plan_call(function, slots)(function, VALUES | {"seconds": 3.0}) == ("M", "D", "P", 3.0)


def test_what_nobody_can_give_raises_as_the_promised_call_does() -> None:
    def function(model, data, secret):
        return secret  # type: ignore[no-untyped-def]

    way = plan_call(function, SLOTS)
    assert way.as_promised
    with pytest.raises(TypeError):
        way(function, VALUES)


# --- missing imports -----------------------------------------------------------------------------------------------------

LIBRARIES: dict[str, Any] = {"np": ModuleType("numpy")}


def _supplied(text: str) -> list[str]:
    names: dict[str, Any] = {}
    units = statements.units_of(ast.parse(text), "file.py")
    missing = MissingImports(units, ["np"], ["Filter", "reader"], (LIBRARIES | {"reader": "the partner's"}).get)
    missing.before(names)
    for unit in units:
        if not isinstance(unit.node, ast.ImportFrom):
            exec(unit.code, names)
        elif unit.node.module == "brings_it":
            names["np"] = ModuleType("brought along")
        missing.after(unit.node, names)
    missing.at_end(names)
    return missing.supplied


@pytest.mark.parametrize(
    ("text", "supplied"),
    [
        ("def reader(): return np", ["np"]),
        ("from a import *\ndef reader(): return np", ["np"]),
        ("from brings_it import *\ndef reader(): return np", []),
        ("np = 1\ndef reader(): return np", []),
        ("def reader():\n    import numpy as np\n    return np", []),
        ("exec('np = 1')\ndef reader(): return np", []),
        ("class Filter:\n    def update(self): return reader()", ["reader"]),
        ("class Filter:\n    def update(self): return nobody()", []),
        ("def reader(): return n\nif __name__ == '__main__':\n    n = 3", []),
        ("class Filter: pass\nFilter = Filter()", ["Filter"]),
        ("def reader(): return 1\ndel reader", ["reader"]),
        ("class Filter: pass\nclass Filter(Filter): pass", []),
    ],
)
def test_what_a_file_uses_and_binds_nowhere_is_supplied(text: str, supplied: list[str]) -> None:
    assert _supplied(text) == supplied


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("class LowpassFilter: pass", [("LowPassFilter", "LowpassFilter")]),
        ("class low_pass_filter: pass", [("LowPassFilter", "low_pass_filter")]),
        ("class LowPassFiltr: pass", [("LowPassFilter", "LowPassFiltr")]),
        ("class LowPassFiltrs: pass", []),
        ("def low_pass_filter(x): pass", []),
        ("class LowpassFilter: pass\nclass LowPassFilter: pass", []),
    ],
)
def test_one_definition_a_letter_away_is_the_required_one(text: str, found: list[tuple[str, str]]) -> None:
    assert list(fuzzy_names.misspelled(ast.parse(text).body, ["LowPassFilter"])) == found


CLASS = "class LowPassFilter:\n    def __init__(self, alpha):\n        pass\n\n"


def _method(name: str) -> str:
    return f"    def {name}(self, x):\n        return x\n\n"


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        (CLASS + _method("Update"), "Update"),
        (CLASS + _method("updat"), "updat"),
        ("class Base:\n" + _method("udpate") + CLASS.replace(":", "(Base):", 1), "udpate"),
        (CLASS + _method("updates") + _method("Update"), None),
        (CLASS + _method("process"), None),
        (CLASS.replace("LowPassFilter", "Filter") + _method("Update"), None),
    ],
)
def test_one_method_a_letter_away_is_the_required_one(text: str, meant: str | None) -> None:
    names: dict[str, Any] = {}
    exec(text, names)
    known = {"LowPassFilter.update": "of an earlier definition"}
    fuzzy_names.alias_misspelled_method(names.get("LowPassFilter"), "LowPassFilter", ["LowPassFilter.update"], known)
    assert known == ({} if meant is None else {"LowPassFilter.update": meant})
