"""Which tests, and which recorded cases, come to which line of what is mutated: measured once, so that a mutant meets those that can tell.

The tests are those without a sandbox. They are collected once, and every mutant runs some of them in a fork of the process that did.
"""

from __future__ import annotations

import functools
import gc
import os
import pickle
import signal
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import coverage
import pytest

from tests.generated import differences
from tests.recordings.marker import recorded_corpus
from tests.scoreboard import Case

_ALSO = ("test_rubric",)
"""Files of tests without a sandbox that are not marked as quick, since they are few."""
_CASES = "tests/recordings/test_corpus.py::test_a_case"
"""A mutant meets all cases of the corpus, and not only those of a shorter run."""
Lines = Mapping[str, Mapping[int, frozenset[str]]]
"""By file and line: what came there, tests and cases by their names."""


@dataclass(frozen=True)
class Reach:
    """What comes where, and how long each test takes."""

    lines: Lines
    seconds: Mapping[str, float]

    def of(self, file: str, chosen: Iterable[int]) -> set[str]:
        """What comes to one of these lines."""
        by_line = self.lines.get(file, {})
        return {name for line in chosen for name in by_line.get(line, ())}

    def of_file(self, file: str) -> set[str]:
        return {name for names in self.lines.get(file, {}).values() for name in names}


class Collected:
    """pytest's session, held where its tests would run."""

    def __init__(self, then: Callable[[Collected], None]) -> None:
        self._then = then
        self._failed = False
        self.items: dict[str, pytest.Item] = {}

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items[:] = [
            item
            for item in items
            if (item.get_closest_marker("quick") or item.path.stem in _ALSO) and not item.nodeid.startswith(_CASES)
        ]

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        self.items = {item.nodeid: item for item in session.items}
        self._then(self)
        return True

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._failed |= report.failed

    def failing(self, names: Sequence[str]) -> list[str]:
        """Run these tests and return those that fail."""
        failed = []
        for item, following in pairwise([*(self.items[name] for name in names), None]):
            assert item is not None
            self._failed = False
            differences.clear()
            item.ihook.pytest_runtest_protocol(item=item, nextitem=following)
            if self._failed or differences:
                failed.append(item.nodeid)
        return failed


def collecting(root: Path, then: Callable[[Collected], None]) -> int:
    """Collect the tests without a sandbox and hand them over."""
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    options = ["-o", "addopts=", "-s", "-p", "no:cacheprovider", "-p", "no:faulthandler", "-p", "no:terminal"]
    return int(pytest.main([*options, "--rootdir", str(root), str(root / "tests")], plugins=[Collected(then)]))


# ---------------------------------------------------------------- measuring


def measured(collected: Collected, files: Sequence[str], judge: Callable[[Case], object], jobs: int) -> Reach:
    """Run all tests and judge all cases once, in processes that end with it."""
    tests, cases = list(collected.items), list(recorded_corpus())
    shares = [(tests[i::jobs], cases[i::jobs]) for i in range(jobs)]
    with ThreadPoolExecutor(jobs) as pool:
        made = list(pool.map(lambda share: in_a_fork(lambda: _measure(collected, files, judge, *share)), shares))
    lines: defaultdict[str, defaultdict[int, frozenset[str]]] = defaultdict(lambda: defaultdict(frozenset))
    for reach in made:
        for file, by_line in reach.lines.items():
            for line, names in by_line.items():
                lines[file][line] |= names
    return Reach(lines, {name: took for reach in made for name, took in reach.seconds.items()})


def in_a_fork(work: Callable[[], Any]) -> Any:
    """Return what this returns in a process of its own; raise ChildProcessError with how that ended if it ends otherwise."""
    with tempfile.TemporaryFile() as told:
        child = os.fork()
        if not child:
            try:
                pickle.dump(work(), told)
                told.flush()
                os._exit(0)
            except BaseException as problem:
                print(f"{type(problem).__name__}: {problem}", file=sys.__stderr__, flush=True)
            finally:
                os._exit(1)
        _, status = os.waitpid(child, 0)
        if os.WIFSIGNALED(status):
            raise ChildProcessError(f"signal {signal.Signals(os.WTERMSIG(status)).name}")
        if status:
            raise ChildProcessError("its process failed")
        told.seek(0)
        return pickle.load(told)


def _measure(
    collected: Collected,
    files: Sequence[str],
    judge: Callable[[Case], object],
    tests: Sequence[str],
    cases: Sequence[Case],
) -> Reach:
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    root = Path(__file__).parents[2]
    tool = coverage.Coverage(data_file=None, include=[str(root / file) for file in files], messages=False)
    seconds: dict[str, float] = {}
    known = remembering(files)
    tool.start()
    for name, run in _runs(collected, tests, judge, cases):
        for function in known:
            function.cache_clear()
        tool.switch_context(name)
        begun = time.perf_counter()
        run()
        seconds[name] = time.perf_counter() - begun
    tool.stop()
    data = tool.get_data()
    lines = {
        file: {line: frozenset(names) - {""} for line, names in data.contexts_by_lineno(str(root / file)).items()}
        for file in files
    }
    return Reach(lines, seconds)


def remembering(files: Sequence[str]) -> list[Any]:
    """The functions of these files that remember what they gave: who comes second would not come to their lines."""
    modules = {file.removesuffix(".py").replace("/", ".") for file in files}
    kinds = (functools._lru_cache_wrapper,)
    return [thing for thing in gc.get_objects() if isinstance(thing, kinds) and thing.__module__ in modules]


def _runs(
    collected: Collected, tests: Sequence[str], judge: Callable[[Case], object], cases: Sequence[Case]
) -> Iterator[tuple[str, Callable[[], object]]]:
    yield from ((test, lambda test=test: collected.failing([test])) for test in tests)  # type: ignore[misc]
    yield from ((case.id, lambda case=case: judge(case)) for case in cases)  # type: ignore[misc]
