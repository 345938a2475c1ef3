"""Mutants of the judging itself: checks, diagnosis, findings, rubric, recordings; each is looked at without a box.

A mutant meets the unit tests of its module first (arrays in, findings out), then tapes of submissions that the module judges. It is
killed by a test that fails, or by a case that is not judged as the corpus says. Each one runs in a process forked from one that has
loaded everything else, so that what is judged with is imported anew, with one module changed.
"""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import importlib.util
import os
import re
import resource
import signal
import sys
import warnings
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import CodeType, ModuleType

import matplotlib as mpl
import numpy as np
import pytest
import scipy.special
import yaml

import grader
from grader.ground.errors import GraderError
from tests.mutants import grading
from tests.mutants.grading import Reasons
from tests.mutants.operators import Mutant, mutants
from tests.scoreboard import Case
from tests.tapes.storing import shelf, taped

ROOT = Path(grader.__file__).parents[1]
TESTS = ROOT / "tests" / "judging"
_PLACES = (
    "grader/labs/imu/checks/*.py",
    "grader/labs/imu/diagnosis/*.py",
    "grader/labs/imu/recordings.py",
    "grader/engine/figures.py",
    "grader/engine/findings.py",
    "grader/engine/rubric.py",
    "grader/engine/rubric_nodes.py",
)
_LOADED = (mpl, np, pytest, scipy.special, yaml)
"""What every mutant needs and none changes: loaded here, before the fork."""
_KEPT = ("grader.ground", "grader.sandbox", "grader.intake", "tests.tapes", "tests.corpus", "tests.mutants")
"""Modules that stand below what is mutated, or hold data: they stay as they are."""
_CPU_S = 120
"""Of one mutant; one that takes more is in a loop without an end."""
_CASES = 30
"""Tapes that a mutant is held against."""
_MORE_TESTS = {
    "rubric": ("tests/test_rubric.py",),
    "findings": tuple(
        f"tests/judging/test_{name}.py" for name in ("check_sensor_access", "handed_in", "lost_pictures")
    ),
    "labels": ("tests/test_languages.py",),
    "figures": ("tests/test_figures.py", "tests/test_sight.py"),
    "noise_laws": ("tests/test_unforeseen_noise_filter.py",),
    "filter_outputs": ("tests/test_unforeseen_noise_filter.py",),
    "filtering": ("tests/test_unforeseen_noise_filter.py",),
    "handling": ("tests/test_unforeseen_reader_collect.py",),
    "collection": ("tests/test_unforeseen_reader_collect.py",),
}
_MORE_TESTS["handed_in"] = ("tests/judging/test_sensors_shown.py",)
_MORE_TESTS["fitting"] = tuple(f"tests/judging/test_check_{part}.py" for part in ("sensor_access", "filtering"))
_MORE_TESTS |= dict.fromkeys(
    ("check_complementary_filter", "tilting", "check_allan_variance", "allan", "check_multiple_imus",
     "check_realtime_visualization", "liveplot"),
    ("tests/judging/test_check_extensions.py",),
)  # fmt: skip
_MORE_TESTS["rubric_nodes"] = _MORE_TESTS["rubric"]
"""Tests without a box under another name, by module."""
_PARTS = {
    "sensor_access": ("check_sensor_access", "reading", "handling"),
    "data_collection": ("check_data_collection", "row_faults", "run_starts", "collection", "recordings"),
    "visualization": (
        "check_visualization", "plot_runs", "panel_words", "curve_faults", "lost_pictures", "plots", "labels", "comparing",
        "figures",
    ),
    "noise_model": ("check_noise_model", "noise_runs", "noise", "noise_laws", "noise_twins"),
    "filtering": ("check_filtering", "filtering", "filter_outputs"),
    "complementary_filter": ("check_complementary_filter", "tilting"),
    "allan_variance": ("check_allan_variance", "allan"),
    "multiple_imus": ("check_multiple_imus",),
    "realtime_visualization": ("check_realtime_visualization", "liveplot"),
}  # fmt: skip
"""Which modules judge which part; what stands in no row judges every part."""


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
    return [mutant for mutant in made if not (_drops_a_proof(mutant) or _says_no_less(mutant) or _drops_a_type(mutant))]


def _drops_a_proof(mutant: Mutant) -> bool:
    """Whether it takes `strict=True` from a `zip`: what that proves is so, and nothing is judged by it."""
    return "strict=(False)" in mutant.source or (
        mutant.operator == "keyword" and ", strict=True) → zip(" in mutant.change
    )


def _says_no_less(mutant: Mutant) -> bool:
    """Whether it returns None as before, unsaid."""
    return mutant.change.startswith("return None → return")


def _drops_a_type(mutant: Mutant) -> bool:
    """Whether it leaves NumPy's own truth value, number or array where mypy wants the type named: nothing is judged by it."""
    return mutant.operator == "copy" and _TYPE.fullmatch(mutant.change) is not None


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


def ends(chosen: Sequence[Mutant], jobs: int) -> Iterator[tuple[Mutant, str]]:
    """Each mutant with what killed it; "" for a survivor."""
    shelf()
    with ThreadPoolExecutor(jobs) as pool:  # each waits for its process
        yield from zip(chosen, pool.map(_end_of, chosen), strict=True)


_ENDS = ("", "unit tests", "tapes")


def _end_of(mutant: Mutant) -> str:
    child = os.fork()
    if not child:
        try:
            os._exit(_ENDS.index(_killed_by(mutant)))
        except BaseException as problem:
            print(f"{mutant.key}: {type(problem).__name__}: {problem}", file=sys.__stderr__, flush=True)
            os._exit(len(_ENDS))
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        return f"signal {signal.Signals(os.WTERMSIG(status)).name}"
    code = os.WEXITSTATUS(status)
    assert code < len(_ENDS), f"{mutant.key}: its judgement failed"
    return _ENDS[code]


def _killed_by(mutant: Mutant) -> str:
    resource.setrlimit(resource.RLIMIT_CPU, (_CPU_S, _CPU_S))
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    warnings.simplefilter("ignore")  # of syntax that a mutant has
    _change(mutant)
    if _fails_a_unit_test(mutant):
        return "unit tests"
    return "tapes" if _fails_on_a_tape(mutant) else ""


# ---------------------------------------------------------------- the changed module


class _Changed(importlib.machinery.SourceFileLoader):
    """Loads the mutant where its module is asked for."""

    def __init__(self, name: str, path: str, source: str) -> None:
        super().__init__(name, path)
        self._source = source

    def get_code(self, fullname: str) -> CodeType:
        return compile(self._source, self.path, "exec")


class _Finder(importlib.abc.MetaPathFinder):
    def __init__(self, mutant: Mutant) -> None:
        self._name = mutant.file.removesuffix(".py").replace("/", ".")
        self._path, self._source = str(ROOT / mutant.file), mutant.source

    def find_spec(
        self, fullname: str, path: object, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if fullname != self._name:
            return None
        loader = _Changed(fullname, self._path, self._source)
        return importlib.util.spec_from_file_location(fullname, self._path, loader=loader)


def _change(mutant: Mutant) -> None:
    """From now on the module is the mutant: whatever could have imported it is imported anew."""
    for name in list(sys.modules):
        if name.split(".")[0] in ("grader", "tests") and not name.startswith(_KEPT) and name not in ("grader", "tests"):
            del sys.modules[name]
    sys.meta_path.insert(0, _Finder(mutant))


# ---------------------------------------------------------------- unit tests, then tapes


def unit_tests(file: str) -> list[str]:
    """The files with tests of a module's functions: its own, those of the checks of its part, and others that are listed."""
    stem = Path(file).stem
    parts = [modules[0] for modules in _PARTS.values() if stem in modules]
    own = [TESTS / f"test_{name}.py" for name in dict.fromkeys((stem, *parts))]
    return [str(path) for path in (*own, *(ROOT / more for more in _MORE_TESTS.get(stem, ()))) if path.exists()]


def _fails_a_unit_test(mutant: Mutant) -> bool:
    """Whether a test says so, or cannot be collected: what `conftest.py` cannot load is an error of usage."""
    if not (tests := unit_tests(mutant.file)):
        return False
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    options = ["-o", "addopts=", "-x", "-q", "-p", "no:cacheprovider", "-p", "no:faulthandler", "--rootdir", str(ROOT)]
    code = pytest.main([*options, *tests])
    assert code != pytest.ExitCode.NO_TESTS_COLLECTED
    return code != pytest.ExitCode.OK


def _fails_on_a_tape(mutant: Mutant) -> bool:
    from tests.tapes.losses import disagreements
    from tests.tapes.player import player

    try:
        return any(disagreements(player().verdict(case)) for case in _sample(Path(mutant.file).stem))
    except GraderError:  # the checks cannot be loaded
        return True


def _sample(module: str) -> list[Case]:
    """Cases that lose points by a module, and sound ones, spread over the corpus."""
    from tests.tapes.losses import pinned

    parts = tuple(f"{part}." for part, modules in _PARTS.items() if module in modules)
    faulty = [case for case in taped() if any(check.startswith(parts or "") for check in pinned().get(case.id, ()))]
    sound = [case for case in taped() if case.part == "sound"]
    return [*_spread(faulty, _CASES), *_spread(sound, _CASES // 5)]


def _spread(cases: Sequence[Case], most: int) -> Sequence[Case]:
    return cases[:: max(1, -(-len(cases) // most))]
