"""pytest meets the rubric: how a function becomes a check, and how its end becomes a result.

A check is a function that returns when all is earned and raises a finding otherwise (`verdicts`). Any other exception is a
fault of the grader: the check is then not judged, and never counted as zero.
"""

from __future__ import annotations

import itertools
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Literal, TypeVar

import numpy as np
import pytest

from .conversation import Missing
from .errors import GraderError, NoAnswer
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
    """One submission under examination: which checks it gets, and how each of them ended."""

    def __init__(self, student: Student, truth: Traces, only: str | None) -> None:
        self.student, self.truth, self._only = student, truth, only
        self._attempted = {part for part, name in EXTENSIONS.items() if attempts(student.files, name)}
        self._stories: dict[str, str] = {}
        self._lost: set[str] = set()
        self._alone = False
        self.judgements: dict[str, Judgement] = {}

    def wants(self, this: Check) -> bool:
        """Whether the check is asked for; nothing is asked about an extension that was not attempted."""
        asked_about = this.criterion in self._attempted or this.criterion not in EXTENSIONS
        return asked_about and self._only in (None, this.criterion)

    def begin(self, this: Check) -> None:
        """Put stand-ins in the place of parts whose own checks are over and lost."""
        if self._alone:
            return
        before = [part for part in PARTS if _turn(part) < _turn(this.criterion)]
        self.student.replace_broken([name for part in before if part in self._lost for name in PARTS[part]])

    def end(self, this: Check, ended: BaseException | None, duration_s: float) -> None:
        """Write down how a check ended."""
        verdict, trouble = None, ""
        if ended is None:
            verdict = Told("passed", 1.0, "")
        elif isinstance(ended, Lost | Skipped | Raised | Missing | NoAnswer):
            same, hidden = story(ended), self.truth.name != "public"
            if hidden and isinstance(ended, Raised) and not self.student.has_line(ended.fault):
                ended.fault = replace(ended.fault, line=None)
            verdict = told(ended, self._stories.get(same) if same else None, hidden=hidden)
            if same:
                self._stories.setdefault(same, this.title)
        else:
            trouble = f"{type(ended).__name__}: {ended}"
        if verdict is None or verdict.keeps < 1.0:
            self._lost.add(this.criterion)
        self.judgements[this.id] = Judgement(this, verdict, trouble, duration_s)

    def lost_beside_standins(self, criterion: str) -> bool:
        """Whether a part lost points beside stand-ins: they follow the sheet, and it may fit what else was handed in."""
        return bool(PARTS.get(criterion) and self.student.broken) and criterion in self._lost

    @contextmanager
    def alone(self, criterion: str) -> Iterator[None]:
        """Examine a part once more, beside the submission's own; that counts if a check ends better and none worse."""
        beside = {id_: each for id_, each in self.judgements.items() if each.check.criterion == criterion}
        stories, titles = self._stories, {each.check.title for each in beside.values()}
        self._stories = {same: title for same, title in stories.items() if title not in titles}
        self._lost.discard(criterion)
        with self.student.without_standins() as answers:
            self._alone = True
            try:
                yield
            finally:
                self._alone = False
        gains = [_kept(self.judgements[id_]) - _kept(each) for id_, each in beside.items()]
        if min(gains) >= 0 < max(gains):
            self.student.remember(answers)
        else:
            self.judgements |= beside
            self._stories = stories
            self._lost.add(criterion)


def _kept(judgement: Judgement) -> float:
    return -1.0 if judgement.told is None else judgement.told.keeps


def _turn(criterion: str) -> int:
    return list(PARTS).index(criterion) if criterion in PARTS else len(PARTS)


def _check(item: pytest.Item) -> Check:
    return item.function.check  # type: ignore[attr-defined,no-any-return]


def _run(items: list[pytest.Item]) -> None:
    for item, following in itertools.zip_longest(items, items[1:]):
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)


class Session:
    """The pytest plugin: one session over the checks, collected once, whose items every submission runs through.

    As pytest-xdist does, items are run by calling `pytest_runtest_protocol`; fixtures are made anew each time.
    """

    def __init__(self) -> None:
        self._items: list[pytest.Item] = []
        self._examination: Examination | None = None

    @property
    def checks(self) -> dict[str, Check]:
        """Every check that there is, by id."""
        return {_check(item).id: _check(item) for item in self._items}

    def run(self, examination: Examination) -> None:
        """Run the checks that a submission gets, in the order of `PARTS`."""
        self._examination = examination
        wanted = [item for item in self._items if examination.wants(_check(item))]
        for criterion, items in itertools.groupby(wanted, lambda item: _check(item).criterion):
            own = list(items)
            _run(own)
            if examination.lost_beside_standins(criterion):
                with examination.alone(criterion):
                    _run(own)

    @property
    def _now(self) -> Examination:
        assert self._examination is not None, "checks run for a submission only"
        return self._examination

    @pytest.fixture
    def student(self) -> Student:
        """The submission under examination."""
        return self._now.student

    @pytest.fixture
    def truth(self) -> Traces:
        """The ground truth."""
        return self._now.truth

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        self._items = sorted(session.items, key=lambda item: _turn(_check(item).criterion))

    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        self._now.begin(_check(item))

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        started = time.perf_counter()
        ended: BaseException | None = None
        try:
            with np.errstate(all="ignore"), warnings.catch_warnings():
                # a student's numbers may overflow in a check; that is no news to anyone
                warnings.simplefilter("ignore")
                yield
        except BaseException as error:
            ended = error
            raise
        finally:
            self._now.end(_check(item), ended, time.perf_counter() - started)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_makereport(self, item: pytest.Item, call: pytest.CallInfo[None]) -> pytest.TestReport:
        """Only whether it failed: pytest's own report quotes source for every frame, half a second for each lost check."""
        failed = call.excinfo is not None
        told = repr(call.excinfo.value)[:300] if call.excinfo is not None else None
        outcome: Literal["passed", "failed"] = "failed" if failed else "passed"
        return pytest.TestReport(item.nodeid, item.location, {}, outcome, told, call.when)  # type: ignore[arg-type] # never "collect"


@cache
def session() -> Session:
    """The process's one quiet pytest session, free of whatever configuration or plugins the machine has.

    Raises
    ------
    GraderError
        If pytest cannot collect the checks.
    """
    collected = Session()
    switched_off = ("terminal", "cacheprovider", "doctest", "junitxml", "pastebin", "faulthandler", "stepwise", "logging",
                    "warnings", "capture", "debugging", "unittest", "setuponly", "setupplan", "tmpdir", "monkeypatch", "recwarn",
                    "unraisableexception", "threadexception", "nose", "legacypath")  # fmt: skip
    options = [
        "-c",
        str(CHECKS / "pytest.ini"),
        "--rootdir",
        str(CHECKS),
        "--noconftest",
        "--assert=plain",
        "--collect-only",
    ]
    options += [word for name in switched_off for word in ("-p", f"no:{name}")]
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # one that shuffles tests is common
        code = int(pytest.main([*options, str(CHECKS)], plugins=[collected]))
    if code == pytest.ExitCode.INTERRUPTED:
        raise KeyboardInterrupt  # pytest has swallowed it
    if code != 0:
        raise GraderError(f"the pytest session over the checks ended with code {code}")
    return collected


def known_checks() -> dict[str, Check]:
    """Every check that exists as a pytest check, by id."""
    return session().checks
