"""Mutants of the judging itself: checks, diagnosis, findings, rubric, recordings; each is looked at without a sandbox.

A mutant meets recorded cases that come to the line it changes, then the unit tests that do (arrays in, findings out). It is killed by a case
that is not judged as the corpus says, or by the tests that fail, of which all are named. Each one runs in a process forked from one that
has loaded everything: the function that is changed gets its new code there, and where a table or a class is changed all is imported anew.
"""

from __future__ import annotations

import ast
import gc
import os
import re
import resource
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence, Set
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from importlib.machinery import SourceFileLoader
from itertools import accumulate
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
import scipy.special
import yaml

import grader
from tests.mutants import grading
from tests.mutants.grading import Reasons
from tests.mutants.operators import Mutant, mutants
from tests.mutants.reach import Collected, Reach, collecting, in_a_fork, measured, remembering
from tests.recordings.marker import recorded_corpus, verdict
from tests.scoreboard import Case

ROOT = Path(grader.__file__).parents[1]
_PLACES = (
    "grader/labs/imu/bonuses/*.py",
    "grader/labs/imu/data_collection/*.py",
    "grader/labs/imu/filtering/*.py",
    "grader/labs/imu/noise_model/*.py",
    "grader/labs/imu/sensor_access/*.py",
    "grader/labs/imu/visualization/*.py",
    "grader/engine/charging.py",
    "grader/engine/figures.py",
    "grader/engine/findings.py",
    "grader/engine/rubric*.py",
)
_LOADED = (mpl, np, pytest, scipy.special, yaml)
"""What every mutant needs and none changes: loaded here, before the fork."""
_KEPT = ("grader.base", "grader.sandbox", "grader.intake", "tests.corpus", "tests.mutants")
"""Modules that stand below what is mutated, or hold data: they stay as they are."""
_CPU_S = 180
"""Of one mutant; one that takes more is in a loop without an end."""
_TESTS_S, _ALL_TESTS_S = 8.0, 60.0
"""Of the tests that a mutant meets, its file's own first, then the quickest: of one that is known to survive, and of any other."""
_CASES, _MOST_CASES = 30, 120
"""Recorded cases that a mutant is held against, likewise."""


def files() -> list[str]:
    """The files that are mutated, as they are named in messages."""
    found = [path for place in _PLACES for path in sorted(ROOT.glob(place))]
    return [path.relative_to(ROOT).as_posix() for path in found if path.stem != "__init__"]


def reasons() -> Reasons:
    """Why mutants of the judging survive: what `judging.yaml` says."""
    return grading.reasons("judging.yaml")


def judging_mutants(chosen: Sequence[str]) -> list[Mutant]:
    """The mutants of these files, in the order of the code."""
    unjudged = reasons().unjudged
    made = [
        mutant
        for file in chosen
        for mutant in mutants(file, (ROOT / file).read_text("utf-8"), frozenset(unjudged.get(file, ())))
    ]
    return [mutant for mutant in made if not _judges_the_same(mutant)]


def _judges_the_same(mutant: Mutant) -> bool:
    """Whether it takes `strict=True` from a `zip`, leaves None unsaid, or leaves NumPy's own value where mypy wants the type named."""
    return (
        "strict=(False)" in mutant.source
        or (mutant.operator == "keyword" and ", strict=True) → zip(" in mutant.change)
        or mutant.change.startswith("return None → return")
        or (mutant.operator == "copy" and _TYPE.fullmatch(mutant.change) is not None)
    )


_TYPE = re.compile(r"(?:bool|float|np\.asarray)\((.*)\) → \1(?: \(\d+\))?")


def is_python(mutant: Mutant) -> bool:
    """Whether it can be read: Python before 3.12 does not say where the parts of an f-string stand."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            compile(mutant.source, mutant.file, "exec")
    except SyntaxError:
        return False
    return True


@dataclass(frozen=True)
class End:
    """What killed a mutant: a case of the corpus, or else these tests; neither for a survivor."""

    case: bool = False
    tests: tuple[str, ...] = ()
    problem: str = ""

    def __str__(self) -> str:
        return "cases" if self.case else ", ".join(self.tests) or self.problem


def ends(chosen: Sequence[Mutant], jobs: int, tell: Callable[[Iterator[tuple[Mutant, End]]], None]) -> None:
    """Tell each mutant with what killed it."""

    def judge(collected: Collected) -> None:
        judged = _Judged(collected, measured(collected, files(), verdict, jobs))
        with ThreadPoolExecutor(jobs) as pool:  # each waits for its process
            tell(zip(chosen, pool.map(judged.end_of, chosen), strict=True))

    collecting(ROOT, judge)


class _Judged:
    """Mutants against the tests and cases that come to what they change."""

    def __init__(self, collected: Collected, reach: Reach) -> None:
        self._collected = collected
        self._reach = reach
        _standing()
        gc.freeze()  # what is here now is nothing that a mutant leaves behind

    def end_of(self, mutant: Mutant) -> End:
        """What killed it; one that could not be judged is named, and counts as a survivor."""
        try:
            end: End = in_a_fork(lambda: self._killed_by(mutant))
        except ChildProcessError as ended:
            print(f"{mutant.key}: not judged: {ended}", file=sys.__stderr__, flush=True)
            return End(problem=str(ended) if str(ended).startswith("signal") else "")
        return end

    def _killed_by(self, mutant: Mutant) -> End:
        resource.setrlimit(resource.RLIMIT_CPU, (_CPU_S, _CPU_S))
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        warnings.simplefilter("ignore")  # of syntax that a mutant has
        by_line = self._reach.of(mutant.file, statement(mutant))
        reached = by_line if function_of(mutant) else self._reached_by_name(mutant)
        reached = reached or self._reach.of_file(mutant.file)
        tests_s, cases = (_TESTS_S, _CASES) if reasons().of(mutant) else (_ALL_TESTS_S, _MOST_CASES)
        tests = self._first(mutant.file, reached, tests_s)
        in_place = bool(by_line) and put_in_place(mutant)
        if not in_place:  # what runs when a module is loaded
            _change(mutant)
        if _fails_on_a_case(_sample(reached, cases)):
            return End(case=True)
        return End(tests=tuple(self._collected.failing(tests) if in_place else _failing(tests)))

    def _reached_by_name(self, mutant: Mutant) -> set[str]:
        """What comes to a line that speaks of what a statement of a module gives a value to."""
        found: set[str] = set()
        for name in names_of(mutant):
            for file in [mutant.file] if name.startswith("_") else files():
                lines = (ROOT / file).read_text("utf-8").splitlines()
                found |= self._reach.of(file, [i for i, line in enumerate(lines, 1) if re.search(rf"\b{name}\b", line)])
        return found

    def _first(self, file: str, reached: Set[str], most_s: float) -> list[str]:
        """The tests of so many seconds; a slow machine leaves out others than those that are written for this file."""
        own = f"test_{Path(file).name}::"
        seconds = self._reach.seconds
        tests = sorted(reached & set(self._collected.items), key=lambda name: (own not in name, seconds[name], name))
        total = accumulate(seconds[name] for name in tests)
        return [name for name, till in zip(tests, total, strict=True) if till < most_s]


# ---------------------------------------------------------------- where a mutant stands


@cache
def _tree(file: str) -> ast.Module:
    return ast.parse((ROOT / file).read_text("utf-8"))


def statement(mutant: Mutant) -> range:
    """The lines of the innermost statement that is changed, without what stands inside it."""
    around = [
        node
        for node in ast.walk(_tree(mutant.file))
        if isinstance(node, ast.stmt) and node.lineno <= mutant.line <= _end(node)
    ]
    inner = max(around, key=lambda node: (node.lineno, -_end(node)))
    body = getattr(inner, "body", None)
    return range(inner.lineno, body[0].lineno if body else _end(inner) + 1)


def function_of(mutant: Mutant) -> str | None:
    """The qualified name of the outermost function in whose body it stands."""

    def search(nodes: Sequence[ast.stmt], place: str) -> str | None:
        for node in nodes:
            if isinstance(node, ast.FunctionDef) and node.body[0].lineno <= mutant.line <= _end(node):
                return place + node.name
            if isinstance(node, ast.ClassDef) and (found := search(node.body, f"{place}{node.name}.")):
                return found
        return None

    return search(_tree(mutant.file).body, "")


def names_of(mutant: Mutant) -> list[str]:
    """What the statement of a module that is changed gives a value to."""
    for node in _tree(mutant.file).body:
        if node.lineno <= mutant.line <= _end(node) and isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            return [name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name)]
    return []


def _end(node: ast.stmt) -> int:
    assert node.end_lineno is not None
    return node.end_lineno


# ---------------------------------------------------------------- the changed function


def put_in_place(mutant: Mutant) -> bool:
    """Give the function that is changed its new code, where it stands in one; what is made when a module is loaded is made anew."""
    name = function_of(mutant)
    if name is None:
        return False
    path = str(ROOT / mutant.file)
    functions, remembered = _standing()[path]
    for each in remembered:
        each.cache_clear()
    before = _code_of(name, (ROOT / mutant.file).read_text("utf-8"), path)
    after = _code_of(name, mutant.source, path)
    inner = list(_inside(before)), list(_inside(after))
    if len(inner[0]) != len(inner[1]):
        if any(function.__code__ in inner[0] for function in functions):
            return False  # which of those made when the module was loaded became which is not known
        inner = [], []
    closures = dict(zip(*inner, strict=True))
    changed = False
    try:
        for function in functions:
            if function.__qualname__ == name and function.__code__.co_name == before.co_name:
                function.__code__, changed = after, True
            elif function.__code__ in closures:  # made when the module was loaded
                function.__code__ = closures[function.__code__]
    except ValueError:  # another number of variables from around it
        return False
    return changed


@cache
def _standing() -> dict[str, tuple[list[FunctionType], list[Any]]]:
    """By file: the functions that stand there, and those of them that remember what they gave; looked for once, before all forks."""
    there: dict[str, tuple[list[FunctionType], list[Any]]] = {str(ROOT / file): ([], []) for file in files()}
    for thing in gc.get_objects():
        if isinstance(thing, FunctionType) and thing.__code__.co_filename in there:
            there[thing.__code__.co_filename][0].append(thing)
    for each in remembering(files()):
        there[each.__wrapped__.__code__.co_filename][1].append(each)
    return there


def _code_of(name: str, source: str, path: str) -> CodeType:
    code = compile(source, path, "exec")
    for part in name.split("."):
        (code,) = [c for c in code.co_consts if isinstance(c, CodeType) and c.co_name == part][-1:]
    return code


def _inside(code: CodeType) -> Iterator[CodeType]:
    """The functions that are made in it, from the outside in; what makes a list or a set outlives no call."""
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            if inner.co_name.isidentifier() or inner.co_name == "<lambda>":
                yield inner
            yield from _inside(inner)


# ---------------------------------------------------------------- the changed module


def _change(mutant: Mutant) -> None:
    """From now on the module is the mutant: whatever could have imported it is imported anew."""
    for name in list(sys.modules):
        if name.split(".")[0] in ("grader", "tests") and not name.startswith(_KEPT) and name not in ("grader", "tests"):
            del sys.modules[name]
    path, get_code = str(ROOT / mutant.file), SourceFileLoader.get_code

    def changed(loader: SourceFileLoader, fullname: str) -> CodeType | None:
        return compile(mutant.source, path, "exec") if loader.path == path else get_code(loader, fullname)

    SourceFileLoader.get_code = changed  # type: ignore[method-assign] # this process ends with the mutant


# ---------------------------------------------------------------- tests and cases anew


class _Failed:
    """The tests that fail, and files that cannot be collected."""

    def __init__(self) -> None:
        self.names: set[str] = set()

    def pytest_runtest_logreport(self, report: pytest.TestReport | pytest.CollectReport) -> None:
        if report.failed:
            self.names.add(report.nodeid)

    pytest_collectreport = pytest_runtest_logreport


def _failing(tests: Sequence[str]) -> list[str]:
    """The tests of what is imported anew that fail, and their files that cannot be collected."""
    failed = _Failed()
    options = ["-o", "addopts=", "-q", "-p", "no:cacheprovider", "-p", "no:faulthandler", "--rootdir", str(ROOT)]
    if tests:
        pytest.main([*options, *(str(ROOT / test) for test in tests)], plugins=[failed])
    return sorted(failed.names)


def _fails_on_a_case(cases: Sequence[Case]) -> bool:
    """Whether a case is judged otherwise, or cannot be judged; in a process of its own, which leaves nothing behind."""

    def fails() -> bool:
        from tests.generated import differences
        from tests.recordings.losses import disagreements
        from tests.recordings.marker import verdict as judged

        return any(disagreements(judged(case, records=False)) or differences for case in cases)

    try:
        failed: bool = in_a_fork(fails)
    except ChildProcessError:  # the checks cannot be loaded, or judging stops at a loss
        return True
    return failed


def _sample(reached: Set[str], most: int) -> list[Case]:
    """Cases that come there, sound ones and others, spread over the corpus."""
    there = [case for case in recorded_corpus() if case.id in reached]
    faulty = [case for case in there if case.part != "sound"]
    sound = [case for case in there if case.part == "sound"]
    return [*_spread(faulty, most), *_spread(sound, most // 5)]


def _spread(cases: Sequence[Case], most: int) -> Sequence[Case]:
    return cases[:: max(1, -(-len(cases) // most))]
