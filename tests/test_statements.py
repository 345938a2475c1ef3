"""Tests of running a file statement by statement: a failing statement is skipped; what remains is as if the file had run as a whole."""

from __future__ import annotations

import ast
import signal
import time
from typing import Any

import pytest

from grader.worker import faults, statements

WITHIN_S = 0.8
needs_a_timer = pytest.mark.skipif(
    not hasattr(signal, "setitimer"), reason="Windows: the time is kept from outside alone"
)


def run(
    text: str,
    *,
    wanted: tuple[str, ...] = (),
    skipped: dict[tuple[str, int], str] | None = None,
    flags: int = 0,
    called: str = "lab",
) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """The names that the text leaves behind, and what was stepped over."""
    stepper = statements.StatementRunner(skipped or {}, (0, 0), list(wanted))
    names: dict[str, Any] = {"__name__": called}
    units = statements.units_of(ast.parse(text), faults.own_name("lab.py"), flags=flags)
    with statements.time_limit(WITHIN_S):
        stepper.run(units, "lab.py", names, lambda node: None)
    return names, stepper.noted


def told(noted: list[dict[str, Any]]) -> list[tuple[int, str, str, str]]:
    return [(each["at"], each["how"], each["type"], each["message"]) for each in noted]


MAIN = "__main__"
GUARD = "if __name__ == '__main__':\n"
BELOW = '"""What it is."""\n{}    "how it is run"\n    a = 1\n    1 / 0\n    b = 2\n\nc = 3\n'


@pytest.mark.parametrize(
    ("text", "called", "there", "skipped"),
    [
        ("a = 1\n1 / 0\nb = 2\n", "lab", {"a": 1, "b": 2}, [(2, "raised", "ZeroDivisionError", "division by zero")]),
        ("a = 1\nraise SystemExit(3)\nb = 2\n", "lab", {"a": 1, "b": 2}, [(2, "raised", "SystemExit", "3")]),
        ("a = 1\nraise KeyboardInterrupt\nb = 2\n", "lab", {"a": 1, "b": 2}, [(2, "raised", "KeyboardInterrupt", "")]),
        # Below a main guard a program goes on; what stands below anything else is one statement.
        (BELOW.format(GUARD), MAIN, {"a": 1, "b": 2, "c": 3, "__doc__": "What it is."}, [(5, "raised", "ZeroDivisionError", "division by zero")]),
        (BELOW.format("if '__main__' == __name__:\n"), MAIN, {"a": 1, "b": 2}, [(5, "raised", "ZeroDivisionError", "division by zero")]),
        (f"a = 0\n{GUARD}    1 / 0\n    a = 2\n", "lab", {"a": 0}, []),
        ("a = 0\nif __name__ != '__main__':\n    1 / 0\n    a = 2\n", MAIN, {"a": 0}, []),
        ("a = 0\nif __name__ == '__main__' and a:\n    1 / 0\n    a = 2\n", MAIN, {"a": 0}, []),
        # A file that looks whether a package is there is told so.
        ("try:\n    import nothing_here\nexcept ImportError:\n    nothing_here = None\n", "lab", {"nothing_here": None}, []),
    ],
)  # fmt: skip
def test_what_follows_a_statement_that_raises_is_there(
    text: str, called: str, there: dict[str, object], skipped: list[tuple[int, str, str, str]]
) -> None:
    names, noted = run(text, called=called)
    assert {name: names[name] for name in there} == there
    assert told(noted) == skipped


def test_what_is_imported_from_the_future_holds_for_the_whole_file_and_other_hints_that_raise_are_left_out() -> None:
    names, noted = run("from __future__ import annotations\ndef f(x: nothing) -> nothing: return 1\n")
    assert (names["f"](0), noted) == (1, [])
    names, noted = run("def f(x: Tuple[int]):\n    return x\n\n\nclass A:\n    a: Nothing = 3\n")
    assert (names["f"](4), names["A"].a) == (4, 3)
    assert [(at, how) for at, how, *_ in told(noted)] == [(1, "hints"), (5, "hints")]


@pytest.mark.parametrize(
    "text",
    [
        "\n@nothing\ndef f(): return 1\n",
        "\nclass f(nothing):\n    pass\n",
        "\nclass f:\n    nothing = nowhere\n",
        "\ndef f(first=2, second=nothing, third=1): return third\n",
    ],
    ids=["a decorator", "a base", "a line of a class", "a default"],
)
def test_a_definition_that_raises_is_lost_and_told_by_its_line(text: str) -> None:
    names, noted = run(text, wanted=("f", "g"))
    assert "f" not in names
    assert [(each["at"], each["how"], each["defines"]) for each in noted] == [(2, "raised", ["f"])]


def test_an_import_that_fails_costs_what_uses_it_and_not_what_is_imported_beside_it() -> None:
    names, noted = run("import nothing_here as n, math\nfrom nothing_here.parts import p\nimport math.q\nx = math.pi\n")
    assert names["x"] > 3
    for use in (
        lambda: names["n"].DataFrame,
        lambda: names["p"](),
        lambda: list(names["p"]),
        lambda: names["n"][0],
    ):
        with pytest.raises(ModuleNotFoundError, match="No module named 'nothing_here'"):
            use()
    assert [at for at, *_ in told(noted)] == [1, 2, 3]


@pytest.mark.parametrize("lost", ["helper = fast(max)", "class helper(fast):\n    pass"])
def test_what_was_made_with_a_missing_package_tells_of_the_package(lost: str) -> None:
    """The one that is asked for is missing as it is: what stands in for it must find its place free."""
    names, _ = run(f"from nothing_here import fast\n{lost}\n{lost.replace('helper', 'update')}\n", wanted=("update",))
    assert "update" not in names
    with pytest.raises(ModuleNotFoundError, match="No module named 'nothing_here'"):
        names["helper"](1)


@needs_a_timer
@pytest.mark.parametrize(
    "bad",
    [
        "while True: pass",
        "while True:\n    try:\n        1 / 0\n    except Exception:\n        pass",
        "import threading; threading.Event().wait()",
    ],
)
def test_a_statement_that_does_not_end_is_interrupted_in_half_of_the_time(bad: str) -> None:
    started = time.process_time()
    names, noted = run(f"{bad}\nb = 2\n")
    assert names["b"] == 2
    assert [how for _, how, *_ in told(noted)] == ["overran"]
    assert time.process_time() - started < WITHIN_S  # where it only waits, it takes none


@needs_a_timer
def test_what_was_running_when_it_was_interrupted_is_told() -> None:
    text = "def f():\n    while True: pass\n\n\nclass A:\n    def run(self): f()\n\n\nA().run()\n"
    _, noted = run(text, wanted=("f", "A", "g"))
    assert noted[0]["within"] == ["A", "f"]


def test_what_is_known_to_end_the_process_is_not_run() -> None:
    names, noted = run("a = 1\nimport os; os._exit(1)\nb = 2\n", skipped={("lab.py", 2): "it ends the process"})
    assert (names["a"], names["b"]) == (1, 2)
    assert told(noted) == [(2, "ended", "", "it ends the process")]


def test_a_cell_that_waits_is_run_as_a_whole() -> None:
    text = "import asyncio\ntask = asyncio.create_task(asyncio.sleep(0, 5))\nx = await task\n"
    names, noted = run(text, flags=ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)
    assert (names["x"], noted) == (5, [])
