"""pytest meets the rubric: how a function becomes a check, and how its end becomes a result.

A check is a function that returns when all is earned and raises a finding otherwise (`verdicts`). Any other exception is a
fault of the grader: the check is then not judged, and never counted as zero.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
import pytest

from .conversation import Missing
from .errors import NoAnswer
from .feedback import Told, story, told
from .student import Student
from .student_extensions import EXTENSIONS, attempts
from .traces import Traces
from .verdicts import Lost, Raised, Skipped

CHECKS = Path(__file__).parent / "checks"
"""Where the checks live. Named, not imported: they import this module."""

Function = TypeVar("Function", bound=Callable[..., None])

PARTS: Mapping[str, tuple[str, ...]] = {
    "sensor_access": ("get_imu_readings",),
    "data_collection": ("simulate_and_collect",),
    "noise_model": ("NoisyIMU",),
    "filtering": ("LowPassFilter",),
    "visualization": (),
}
"""The criteria in the order in which they are examined, with the names that get a stand-in where points were lost.
The plots come last: scripts that draw them use everything else."""


@dataclass(frozen=True)
class Check:
    """What a check is: its id, the sentence that a student reads, and the step of the sheet that it belongs to."""

    id: str
    title: str
    lab_step: int | None

    @property
    def criterion(self) -> str:
        return self.id.split(".")[0]


@dataclass(frozen=True)
class Judgement:
    """How one check ended; `told` is None where the grader failed to judge."""

    check: Check
    told: Told | None
    trouble: str
    duration_s: float


def check(check_id: str, *, lab_step: int | None = None) -> Callable[[Function], Function]:
    """Make a function the check `check_id`; its docstring is the sentence that the student reads."""

    def mark(function: Function) -> Function:
        assert function.__doc__, f"{check_id} has no sentence"
        title = " ".join(function.__doc__.strip().split("\n\n")[0].split()).rstrip(".")
        function.check = Check(check_id, title, lab_step)  # type: ignore[attr-defined]
        return function

    return mark


class Examination:
    """The pytest plugin of one submission's session: hands out the fixtures and writes down how each check ended."""

    def __init__(self, student: Student, truth: Traces, only: str | None) -> None:
        self._student, self._truth, self._only = student, truth, only
        self._stories: dict[str, str] = {}
        self._lost: set[str] = set()
        self.judgements: dict[str, Judgement] = {}

    @pytest.fixture
    def student(self) -> Student:
        """The submission under examination."""
        return self._student

    @pytest.fixture
    def truth(self) -> Traces:
        """The ground truth."""
        return self._truth

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        order = list(PARTS)
        left_out = {part for part, name in EXTENSIONS.items() if not attempts(self._student.files, name)}
        wanted = [i for i in items if self._only in (None, _check(i).criterion) and _check(i).criterion not in left_out]
        position = {name: n for n, name in enumerate(order)}
        items[:] = sorted(wanted, key=lambda item: position.get(_check(item).criterion, len(order)))

    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        done = list(PARTS)
        criterion = _check(item).criterion
        before = done[: done.index(criterion)] if criterion in done else done
        self._student.replace_broken([name for part in before if part in self._lost for name in PARTS[part]])

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        started = time.perf_counter()
        ended: BaseException | None = None
        try:
            with np.errstate(all="ignore"), warnings.catch_warnings():
                warnings.simplefilter(
                    "ignore"
                )  # a student's numbers may overflow in a check; that is no news to anyone
                yield
        except BaseException as error:
            ended = error
            raise
        finally:
            self._write_down(_check(item), ended, time.perf_counter() - started)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_makereport(self, item: pytest.Item, call: pytest.CallInfo[None]) -> pytest.TestReport:
        """Only whether it failed: pytest's own report quotes source for every frame, half a second for each lost check."""
        failed = call.excinfo is not None
        told = repr(call.excinfo.value)[:300] if call.excinfo is not None else None
        outcome: Literal["passed", "failed"] = "failed" if failed else "passed"
        return pytest.TestReport(item.nodeid, item.location, {}, outcome, told, call.when)  # type: ignore[arg-type] # never "collect"

    def _write_down(self, this: Check, ended: BaseException | None, duration_s: float) -> None:
        verdict, trouble = None, ""
        if ended is None:
            verdict = Told("passed", 1.0, "")
        elif isinstance(ended, Lost | Skipped | Raised | Missing | NoAnswer):
            same, hidden = story(ended), self._truth.name != "public"
            if hidden and isinstance(ended, Raised) and not self._student.has_line(ended.fault):
                ended.fault = replace(ended.fault, line=None)
            verdict = told(ended, self._stories.get(same) if same else None, hidden=hidden)
            if same:
                self._stories.setdefault(same, this.title)
        else:
            trouble = f"{type(ended).__name__}: {ended}"
        if verdict is None or verdict.keeps < 1.0:
            self._lost.add(this.criterion)
        self.judgements[this.id] = Judgement(this, verdict, trouble, duration_s)


def _check(item: pytest.Item) -> Check:
    return item.function.check  # type: ignore[attr-defined,no-any-return]


class Collector:
    """Notes which checks there are, without running one."""

    def __init__(self) -> None:
        self.checks: dict[str, Check] = {}

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        self.checks = {_check(item).id: _check(item) for item in session.items}


def run_pytest(arguments: Sequence[str], plugin: object) -> int:
    """One quiet pytest session over the checks, free of whatever configuration or plugins the machine has."""
    switched_off = ("terminal", "cacheprovider", "doctest", "junitxml", "pastebin", "faulthandler", "stepwise", "logging",
                    "warnings", "debugging", "unittest", "setuponly", "setupplan", "tmpdir", "monkeypatch", "recwarn",
                    "unraisableexception", "threadexception", "nose", "legacypath")  # fmt: skip
    options = [
        "-c",
        str(CHECKS / "pytest.ini"),
        "--rootdir",
        str(CHECKS),
        "--capture=no",
        "--noconftest",
        "--assert=plain",
    ]
    options += [word for name in switched_off for word in ("-p", f"no:{name}")]
    return int(pytest.main([*options, *arguments, str(CHECKS)], plugins=[plugin]))


def known_checks() -> dict[str, Any]:
    """Every check that exists as a pytest check, by id."""
    collector = Collector()
    run_pytest(["--collect-only"], collector)
    return dict(collector.checks)
