"""How a function is called whose parameters are not the promised ones, which names of a file are supplied or matched, and what it returned."""

from __future__ import annotations

import ast
import re
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from grader.worker import fuzzy_names, statements
from grader.worker.calling import Slot, plan_call
from grader.worker.missing_imports import MissingImports
from grader.worker.values import Packer, numbers

SLOTS = (
    Slot("model", re.compile("^m$")),
    Slot("data", re.compile("^d$")),
    Slot("size", re.compile("std|size"), "option"),
    Slot("offset", re.compile("bias"), "option"),
    Slot("place", re.compile("^id"), "spare", (int, type(None))),
)
VALUES = {"model": "M", "data": "D", "size": "S", "offset": "O", "place": "P"}


def call(parameters: str, returned: str, slots: tuple[Slot, ...] = SLOTS) -> tuple[tuple[object, ...], tuple[str, ...]]:
    """What a function with these parameters is called with, and which of them depart from the promised ones."""
    function = eval(f"lambda {parameters}: ({returned},)")
    way = plan_call(function, slots)
    return way(function, VALUES | {"seconds": 3.0}), way.departs


@pytest.mark.parametrize(
    ("parameters", "returned", "came", "departs"),
    [
        ("model, data, size=1, offset=0", "model, data, size, offset", "MDSO", ()),
        ("first, second, *, size=1, offset=0", "first, second, size, offset", "MDSO", ()),
        ("m, d, std=1, bias=0", "m, d, std, bias", "MDSO", ("size", "offset")),
        ("data, model, size=1, offset=0", "model, data, size, offset", "MDSO", ("model", "data")),
        ("model, data, offset=0", "model, data, offset", "MDO", ()),  # what it makes of another size tells it
        ("model, size=1, offset=0", "model, size, offset", "MSO", ("data",)),
        ("model, data, idx, size=1, offset=0", "model, data, size, offset, idx", "MDSOP", ("place",)),
        ("model, data, size=1, offset=0, idx=None", "model, data, size, offset, idx", "MDSOP", ("place",)),
        ("model, data, size=1, offset=0, idx='x'", "model, data, size, offset, idx", "MDSOx", ()),
        ("m, d, std=1, bias=0, place='x'", "m, d, std, bias, place", "MDSOx", ("size", "offset")),
        ("d, m, /, size=1, offset=0", "m, d, size, offset", "DMSO", ()),  # what only position tells
        ("*given, **named", "*given, *named.values()", "MDSO", ()),
    ],
)
def test_a_function_is_called_by_its_own_parameters(
    parameters: str, returned: str, came: str, departs: tuple[str, ...]
) -> None:
    assert call(parameters, returned) == (tuple(came), departs)


def test_what_may_go_anywhere_goes_to_a_parameter_of_any_name() -> None:
    slots = (*SLOTS[:2], Slot("seconds", re.compile("sec"), free=True, anywhere=True), SLOTS[-1])
    assert call("env, sim, idx=None, length=5.0", "env, sim, idx, length", slots)[0] == ("M", "D", "P", 3.0)


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
        ("from a import *\nfrom brings_it import *\ndef reader(): return np", []),
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


# --- what it returned, as numbers: what is masked is none, whatever stands in memory in its place ---


def test_numbers_of_a_masked_array_have_gaps() -> None:
    masked = np.ma.masked_array([1, 2, 3], mask=[False, True, False])
    packer = Packer()
    node = packer.node(masked)
    assert node["kind"] == "array"
    for found, wanted in [
        (packer.arrays[node["key"]], [1.0, np.nan, 3.0]),
        (numbers(masked), [1.0, np.nan, 3.0]),
        (numbers(np.ma.masked_all(3)), [np.nan] * 3),
        (numbers((np.float32(1), 2)), [1.0, 2.0]),
    ]:
        assert type(found) is np.ndarray
        np.testing.assert_array_equal(found, wanted)
