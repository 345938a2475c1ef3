"""Run checks with pytest: the decorator that makes a function a check, and the pytest session that judges a submission.

A check returns if all its points are earned, and raises a finding otherwise (an exception of `findings`). Any other exception is a
failure of the grader: the check is then not judged, and never counted as zero.
"""

from __future__ import annotations

import atexit
import functools
import itertools
import secrets
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from grader.base.errors import GraderError, NoAnswer, RequestError, fault_text, message_of
from grader.base.text import printable
from grader.engine import hidden_feedback
from grader.engine.check_catalog import Check, check_files, title_of
from grader.engine.faults import rows
from grader.engine.feedback import Feedback, cause_key, feedback_on
from grader.engine.findings import Charged, CheckFailed, Missing, Raised, Skipped
from grader.engine.lab import Lab, Part
from grader.engine.public_session import PublicSession
from grader.engine.rubric import OwnChecks
from grader.engine.submission_session import SubmissionSession
from grader.engine.traces import Traces


@dataclass(frozen=True)
class Judgement:
    """How one check ended on one submission; `grader.Marker` makes a `CheckResult` of it.

    Attributes
    ----------
    feedback : what students read; None if the grader failed to judge
    trouble : message for the report on why the grader failed; "" if judged, or if the message could hold hidden data
    ours : whether the failure is the grader's for sure (a GraderError or RequestError), not caused by what student code returned
    fault : the grader's exception with its place in the grader, without a message that could hold hidden data; "" if judged
    """

    check: Check
    feedback: Feedback | None
    trouble: str
    duration_s: float
    ours: bool = False
    fault: str = ""

    @property
    def keeps(self) -> float:
        """Share of the check's points that is earned, 0 to 1; -1 if not judged, so that it ranks below every outcome."""
        return -1.0 if self.feedback is None else self.feedback.keeps


def check(check_id: str, *, lab_step: int | None = None) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Return a decorator that makes a pytest function the check `check_id`, which step `lab_step` of the lab sheet teaches.

    Students read the function's docstring as the title. `lab_step` is None if no single step teaches it.
    """

    def mark(function: Callable[..., None]) -> Callable[..., None]:
        assert function.__doc__, f"{check_id} has no sentence"
        function.check = Check(check_id, title_of(function.__doc__), lab_step)  # type: ignore[attr-defined]
        return function

    return mark


class CheckRun:
    """One run of the checks on one submission: selects its checks, prepares each of them, and records how each ended."""

    def __init__(
        self, lab: Lab, student: SubmissionSession, truth: Traces, only: str | None, look: PublicSession | None = None
    ) -> None:
        self.student, self.truth, self._only = student, truth, only
        self._lab, self._faults, self._look = lab, rows(lab), look
        self._secret = truth.name != "public"
        self._attempted = {bonus.id for bonus in lab.bonuses if bonus.attempted_in(student.files)}
        # Title of the check that reported a cause first, by the cause's key; later checks refer to that check.
        self._reported: dict[str, str] = {}
        self._lost: set[str] = set()  # criteria in which a check lost points
        self._alone = False  # True while a part is examined without stand-ins
        self.judgements: dict[str, Judgement] = {}

    def wants(self, this: Check) -> bool:
        """Return whether to run a check. False if its extension was not attempted, or if `--only` names another part of the lab."""
        asked_about = this.criterion in self._attempted or this.criterion in self._lab.examined
        return asked_about and self._only in (None, this.criterion)

    def begin(self, this: Check) -> None:
        """Prepare a check: account its CPU time to its criterion, and replace faulty functions of earlier criteria by correct code.

        So a fault costs points in its own criterion only. All extensions share one account. A rerun (`rerun_beside`) sets its
        replacements itself.
        """
        self.student.account_to(this.criterion if this.criterion in self._lab.examined else "bonuses")
        if self._alone:
            return
        lost = [part for part in self._parts_before(this.criterion) if part.id in self._lost]
        self.student.replace_broken([name for part in lost for name in part.names])

    def end(self, this: Check, ended: BaseException | None, duration_s: float) -> None:
        """Record how a check ended: with the exception `ended`, or passed if that is None. A KeyboardInterrupt is not recorded."""
        if isinstance(ended, KeyboardInterrupt):
            return
        verdict, cause = None, ended
        try:
            verdict = self._verdict(this, ended)
        except Exception as fault_of_ours:  # the check ran; its feedback failed
            said = "" if self._secret else f": {message_of(fault_of_ours)}"
            cause = fault_of_ours
            ended = GraderError(f"feedback on {this.id}: {type(fault_of_ours).__name__}{said}")
        ours = isinstance(ended, GraderError | RequestError)
        trouble = fault = ""
        if verdict is None and ended is not None and cause is not None:
            trouble = f"{type(ended).__name__}: {message_of(ended)}" if ours or not self._secret else ""
            fault = fault_text(cause, message=not self._secret)
        if verdict is None or verdict.keeps < 1.0:
            self._lost.add(this.criterion)
        self.judgements[this.id] = Judgement(this, verdict, trouble, duration_s, ours, fault)

    def _verdict(self, this: Check, ended: BaseException | None) -> Feedback | None:
        """Return the feedback on the exception that ended a check, a pass if that is None; None if the grader itself failed."""
        if ended is None:
            return Feedback("passed", 1.0, "")
        if not isinstance(ended, Charged | CheckFailed | Skipped | Raised | Missing | NoAnswer):
            return None
        finding = self._with_public_text(ended)
        same = (hidden_feedback.cause_key if self._secret else cause_key)(finding, this.criterion)
        verdict = self._feedback(finding, self._reported.get(same) if same else None)
        if same:
            self._reported.setdefault(same, this.title)
        return verdict

    def _with_public_text(self, finding: BaseException) -> BaseException:
        """Return a finding that students may read: a `Missing` that may hold hidden data is replaced, any other is unchanged."""
        if not (self._secret and isinstance(finding, Missing)):
            return finding
        return hidden_feedback.missing(finding, self._look.missing(finding.name) if self._look else None)

    def _feedback(self, finding: BaseException, earlier: str | None) -> Feedback:
        """Return the feedback on a finding, the exception that ended a check; on hidden scenarios it has no text of student code.

        `earlier` is the title of a check that reported the same cause before; None if this is the first.
        """
        if (
            self._secret
            and earlier is None
            and isinstance(finding, Charged | CheckFailed | Skipped | Raised | NoAnswer)
        ):
            return hidden_feedback.feedback_on(finding, self._faults)
        return feedback_on(finding, earlier, self._faults)

    def other_partners(self, criterion: str) -> Iterator[frozenset[str]]:
        """Yield, for each rerun of a criterion, the required names for which the rerun takes the lab sheet's code.

        A function may fail only because of functions that it calls. If the criterion lost points while stand-ins (correct code)
        replaced some functions, the empty set is yielded for a rerun without them. After that, if student code raised in the
        criterion, a rerun takes the sheet's code for the functions of the criterion graded first, which later ones may call; that
        criterion itself has no such rerun. Unlike a stand-in, the sheet's code takes the sheet's arguments only, so that it
        excuses no wrong call. Extensions, and criteria that are graded last because no other needs their functions (`Part.needed`),
        have no rerun.
        """
        part = self._lab.part(criterion)
        if part is None or not part.needed or criterion not in self._lab.examined:
            return
        if self.student.broken and criterion in self._lost:
            yield frozenset()
        raised = any(each.feedback and each.feedback.outcome == "error" for each in self._judged_in(criterion).values())
        yield from (frozenset(each.names) for each in self._parts_before(criterion)[:1] if raised)

    def _parts_before(self, criterion: str) -> list[Part]:
        """Return the criteria that are graded before the given one and whose functions others need."""
        turn = grading_order(self._lab, criterion)
        return [part for part in self._lab.parts if part.needed and grading_order(self._lab, part.id) < turn]

    def _judged_in(self, criterion: str) -> dict[str, Judgement]:
        return {id_: each for id_, each in self.judgements.items() if each.check.criterion == criterion}

    @contextmanager
    def rerun_beside(self, sheets_own: Collection[str], criterion: str) -> Iterator[None]:
        """Let the caller rerun a criterion's checks in this context, with the lab sheet's own code for the names in `sheets_own`.

        The new outcomes replace the old ones if at least one check ends better and none worse; otherwise they are discarded.
        """
        beside = self._judged_in(criterion)
        stories, titles = self._reported, {each.check.title for each in beside.values()}
        self._reported = {same: title for same, title in stories.items() if title not in titles}
        self._lost.discard(criterion)
        with self.student.beside(sheets_own) as answers:
            self._alone = True
            try:
                yield
            finally:
                self._alone = False
        gains = [self.judgements[id_].keeps - each.keeps for id_, each in beside.items()]
        if min(gains) >= 0 < max(gains):
            self.student.remember(answers)
            self.student.replace_broken(sorted(sheets_own))  # for the parts that follow
        else:
            self.judgements |= beside
            self._reported = stories
            self._lost.add(criterion)


def grading_order(lab: Lab, criterion: str) -> int:
    """Return a criterion's place in the order in which the lab's criteria are examined; extensions come last."""
    return lab.examined.index(criterion) if criterion in lab.examined else len(lab.examined)


def _check_of(item: pytest.Item) -> Check:
    return item.function.check  # type: ignore[attr-defined,no-any-return]


def _run_items(items: list[pytest.Item]) -> None:
    for item, following in itertools.zip_longest(items, items[1:]):
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)


class Session:
    """Internal pytest plugin: collects a lab's checks once per process, and runs them for each submission.

    Like pytest-xdist, it runs items by calling `pytest_runtest_protocol`; fixtures are made anew each time.
    """

    def __init__(self, lab: Lab) -> None:
        self._lab = lab
        self._items: list[pytest.Item] = []
        self.troubles: list[str] = []
        self.private: tempfile.TemporaryDirectory[str] | None = None
        self._examination: CheckRun | None = None

    @property
    def checks(self) -> dict[str, Check]:
        """The collected checks by id, the instructor's own included."""
        return {_check_of(item).id: _check_of(item) for item in self._items}

    def run(self, check_run: CheckRun) -> None:
        """Run the checks that `check_run` wants, by criterion. `CheckRun.other_partners` says which of them run again, and how."""
        self._examination = check_run
        wanted = [item for item in self._items if check_run.wants(_check_of(item))]
        for criterion, items in itertools.groupby(wanted, lambda item: _check_of(item).criterion):
            own = list(items)
            _run_items(own)
            for partners in check_run.other_partners(criterion):
                with check_run.rerun_beside(partners, criterion):
                    _run_items(own)

    @property
    def _now(self) -> CheckRun:
        assert self._examination is not None, "checks run for a submission only"
        return self._examination

    @pytest.fixture
    def student(self) -> SubmissionSession:
        """Return the sandbox session about the submission that is checked; pytest passes it to checks as the argument `student`."""
        return self._now.student

    @pytest.fixture
    def truth(self) -> Traces:
        """Return the traces (ground truth) to check against; pytest passes it to checks as the argument `truth`."""
        return self._now.truth

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self.troubles.append(f"{Path(report.nodeid).name}: {_last_line(str(report.longrepr))}")

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        checks = [item for item in session.items if hasattr(getattr(item, "function", None), "check")]
        names = [f"{item.path.name}: {item.name}" for item in session.items if item not in checks]
        self.troubles += [f"{name} is no check: write @check(...) above it" for name in names]
        twice = Counter(_check_of(item).id for item in checks)
        self.troubles += [f"there are {count} checks {id_}" for id_, count in twice.items() if count > 1]
        self._items = sorted(checks, key=lambda item: grading_order(self._lab, _check_of(item).criterion))

    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        self._now.begin(_check_of(item))

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        started = time.perf_counter()
        ended: BaseException | None = None
        try:
            with np.errstate(all="ignore"), warnings.catch_warnings():
                # a student's numbers may overflow in a check: such warnings are expected
                warnings.simplefilter("ignore")
                yield
        except BaseException as error:
            ended = error
            raise
        finally:
            self._now.end(_check_of(item), ended, time.perf_counter() - started)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_makereport(self, item: pytest.Item, call: pytest.CallInfo[None]) -> pytest.TestReport:
        """Return a report that says only whether a check failed; pytest's own takes 0.5 s per failed check, and nobody reads it."""
        outcome: Literal["passed", "failed"] = "passed" if call.excinfo is None else "failed"
        return pytest.TestReport(item.nodeid, item.location, {}, outcome, None, call.when)  # type: ignore[arg-type] # never "collect"


def _last_line(text: str) -> str:
    """Return the last line of pytest's report on a file that it failed to collect; it names the exception for our message."""
    lines = [line.removeprefix("E").strip() for line in text.splitlines() if line.strip()]
    return printable(lines[-1] if lines else "it cannot be read", 300)


@functools.cache
def session(lab: Lab, own: OwnChecks = ()) -> Session:
    """Return the pytest session over a lab's checks and `own`; a process collects these checks once and then keeps the session.

    The machine's pytest configuration and plugins are not used.

    Parameters
    ----------
    own : name and content of each file of the instructor's own checks; they are trusted like the rubric and run in this process

    Raises
    ------
    RequestError
        If the instructor's own checks cannot be collected.
    GraderError
        If pytest cannot collect the checks.
    """
    collected = Session(lab)
    if own:
        collected.private = tempfile.TemporaryDirectory(prefix="imugrade-")  # pytest rereads it when checks run
        atexit.register(collected.private.cleanup)
    code = _collect(collected, lab, [str(_write(own, Path(collected.private.name)))] if collected.private else [])
    if code == pytest.ExitCode.INTERRUPTED and not collected.troubles:
        raise KeyboardInterrupt  # pytest has caught it
    if own and collected.troubles:
        raise RequestError("\n".join(f"own checks: {trouble}" for trouble in collected.troubles))
    if code != 0 or collected.troubles:
        raise GraderError(f"the pytest session over the checks ended with code {code}: {'; '.join(collected.troubles)}")
    return collected


def _write(own: OwnChecks, private: Path) -> Path:
    """Write the instructor's own checks into a new package with a unique name in the folder `private`; return its path."""
    folder = private / f"own_checks_{secrets.token_hex(8)}"
    folder.mkdir()
    for name, content in {"__init__.py": b"", **dict(own)}.items():
        Path(folder, name).write_bytes(content)
    return folder


def _collect(collected: Session, lab: Lab, more: Sequence[str]) -> int:
    """Collect the lab's checks and those at the paths `more` with pytest into the plugin `collected`; return pytest's exit code.

    Plugins that print, cache or capture are off.
    """
    switched_off = ("terminal", "cacheprovider", "doctest", "junitxml", "pastebin", "faulthandler", "stepwise", "logging",
                    "warnings", "capture", "debugging", "unittest", "setuponly", "setupplan", "tmpdir", "monkeypatch", "recwarn",
                    "unraisableexception", "threadexception", "nose", "legacypath")  # fmt: skip
    options = ["-c", str(Path(__file__).with_name("checks.ini")), "--rootdir", str(lab.folder)]
    options += ["--noconftest", "--assert=plain", "--collect-only"]
    options += [word for name in switched_off for word in ("-p", f"no:{name}")]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", list(sys.path))  # pytest adds folders, and one of them will be deleted
        patch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # plugins that shuffle tests are common
        for ours in ("PYTEST_ADDOPTS", "PYTEST_PLUGINS"):  # set for another pytest, perhaps one that runs this process
            patch.delenv(ours, raising=False)
        return int(pytest.main([*options, *map(str, check_files(lab)), *more], plugins=[collected]))


def known_checks(lab: Lab, own: OwnChecks = ()) -> dict[str, Check]:
    """Return the collected checks of a lab by id, including the instructor's own, to compare a rubric with them."""
    return session(lab, own).checks
