"""Fake students: their functions run in this process, and the lab's own questions are asked of them without a sandbox."""

from __future__ import annotations

import importlib
import itertools
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import mujoco
import numpy as np
import yaml

from grader.engine import feedback, hidden_feedback, rubric
from grader.engine.faults import rows
from grader.engine.findings import Charged, CheckFailed, Missing, Raised, Skipped
from grader.engine.load_report import Loaded
from grader.engine.traces import Traces
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.labs.imu.robot import robot_of
from grader.labs.imu.student import Student
from grader.labs.imu.worker import HANDLERS, simulation
from grader.sandbox.wire import Frame
from grader.worker import submission
from tests.generated import differs
from tests.recordings.answers import history_after

WORDS = Path(__file__).parent / "words.yaml"
Check = Callable[[Any, Any], None]
Marked = tuple[float, list[str]] | str | None
"""All points; the share that is kept with the faults; or "skipped" or "raised"."""


@cache
def truth() -> Traces:
    """The shipped traces."""
    return bundles.shipped()


class FakeStudent(Student):
    """A student made of functions and classes, by the names that the lab asks for."""

    def __init__(self, **parts: Any) -> None:
        self.parts, self.robot = parts, robot_of(truth())
        self.files, self.notes, self.broken, self.drawn = {}, [], set(), ()  # type: ignore[assignment, misc]
        self._answers, self._called, self._lab = {}, {}, LAB
        self._lab_configuration = {"methods": ()}
        np.random.seed(0)  # as the worker code seeds what it loads

    def place_of(self, name: str) -> str:
        if name not in self.parts:
            raise Missing(name, "name-missing", f"nobody made {name}")
        return name

    def load(self, path: str) -> Loaded:
        return Loaded(frozenset([path]), None, (), (), (), Frame({}))

    def once(self, key: Any, ask: Callable[[], Any]) -> Any:
        if key not in self._answers:
            self._answers[key] = ask()
        return self._answers[key]

    def end_session(self) -> None:
        """Do nothing: there is no process."""

    def retried(self, ask: Callable[[], Any]) -> Any:
        return ask()

    def ask(
        self, op: str, fields: Mapping[str, Any] | None = None, arrays: Mapping[str, np.ndarray] | None = None
    ) -> Frame:
        fields, arrays = dict(fields or {}), dict(arrays or {})
        with _as_in_the_sandbox(self.parts):
            frame = Frame(*HANDLERS[op](fields, arrays))
        return self._lab.checked(op, frame, fields, arrays) if op != "replay" else frame

    def ask_fresh_worker(self, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Frame:
        """Ask without a submission: a run that was simulated before has the same answer."""
        if op != "replay":
            return self.ask(op, fields, arrays)
        run = history_after("", op, fields, arrays)
        if run not in _REPLAYS:
            _REPLAYS[run] = self.ask(op, fields, arrays)
        return _REPLAYS[run]


_REPLAYS: dict[str, Frame] = {}


@contextmanager
def _as_in_the_sandbox(parts: Mapping[str, Any]) -> Iterator[None]:
    """The worker code finds these parts and watches the steps; what it changes is put back."""
    own = {name: getattr(mujoco, name) for name in ("mj_step", "mj_step1", "mj_step2")}
    entropy = np.random.bit_generator
    with (
        mock.patch.object(submission, "find", lambda name, _path: parts[name]),
        mock.patch.object(submission.STATE, "folder", str(Path.cwd())),
        mock.patch.object(entropy, "randbits", entropy.randbits),
    ):
        simulation._watch_steps()
        try:
            yield
        finally:
            for name, step in own.items():
                setattr(mujoco, name, step)


@dataclass(frozen=True)
class Case:
    """A check and a made-up student, with what a fair marker says to it."""

    name: str
    check: Check
    student: Callable[[], Student]
    marked: Marked = None

    @property
    def id(self) -> str:
        return f"{self.check.check.id}: {self.name}"  # type: ignore[attr-defined]


@dataclass(frozen=True)
class Row:
    """A made-up student with the checks of a criterion that a fair marker does not pass; all others are passed."""

    name: str
    student: Callable[[], Student]
    marks: Mapping[Check, Marked]

    def cases(self, checks: Sequence[Check]) -> list[Case]:
        """Return a case for each check, all of one student, who is asked each question once."""
        student = cache(self.student)
        return [Case(self.name, check, student, self.marks.get(check)) for check in checks]


def finding(case: Case) -> BaseException | None:
    """What the check says of the student."""
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            case.check(case.student(), truth())
        except (Charged, CheckFailed, Skipped, Raised, Missing) as found:
            return found
    return None


def marked(found: BaseException | None) -> Marked:
    """A finding as a case has it; what another check is charged is not charged again, or not reached."""
    if not isinstance(found, Charged | CheckFailed):
        return None if found is None else type(found).__name__.lower()
    told = feedback.feedback_on(found, None, rows(LAB))
    if told.outcome in ("partial", "failed"):
        return round(told.keeps, 4), list(told.faults)
    return None if isinstance(found, Charged) and found.charge.keeps else "skipped"


def kept(student: Student, checks: Sequence[Check]) -> dict[str, float]:
    """Points that each check leaves to a student."""
    worth = {check.id: check.max_points for check in rubric.load(LAB).checks}
    points = {}
    for check in checks:
        found = finding(Case("", check, lambda: student))
        keeps = found.charge.keeps if isinstance(found, Charged) else float(found is None)
        points[check.check.id] = keeps * worth[check.check.id]  # type: ignore[attr-defined]
    return points


def words(found: BaseException | None) -> dict[str, str]:
    """What a student is told, `hidden` of it where the scenario is hidden."""
    if isinstance(found, Charged | CheckFailed):
        said, hidden = feedback.feedback_on(found, None, rows(LAB)), hidden_feedback.feedback_on(found, rows(LAB))
        texts = {"expected": said.expected, "got": said.got, "hint": said.hint, "said": said.said, "hidden": hidden.got}
        return {key: str(text) for key, text in texts.items() if text}
    if isinstance(found, Raised):  # what the exception says is Python's or NumPy's, and differs between versions
        return {"raised": found.error.type, "while": found.doing}
    return {} if found is None else {type(found).__name__.lower(): str(found)}


def all_cases() -> list[Case]:
    names = sorted(path.stem for path in Path(__file__).parent.glob("test_check_*.py"))
    return [case for name in names for case in importlib.import_module(f"tests.judging.{name}").CASES]


@cache
def faults_shown() -> frozenset[str]:
    """Return the faults that made-up students and filters are charged for, by name."""
    made_up = [case.marked for case in all_cases()]
    filters = importlib.import_module("tests.judging.test_filtering")
    charged = [words for _, _, marked in (*filters.FILTERS, *filters.ANSWERS) for _, words in marked.values()]
    return frozenset(
        itertools.chain(*(mark[1] for mark in made_up if isinstance(mark, tuple)), *map(str.split, charged))
    )


def all_words() -> str:
    """Ask every check about its made-up students and filters, and return the text of `words.yaml`."""
    said = {case.id: told for case in all_cases() if (told := words(finding(case)))}
    said |= importlib.import_module("tests.judging.test_filtering").all_words()
    return yaml.safe_dump(said, sort_keys=True, width=200, allow_unicode=True)


@cache
def pinned() -> Mapping[str, Mapping[str, str]]:
    """What `words.yaml` says, by the id of the case."""
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    said: Mapping[str, Mapping[str, str]] = yaml.load(WORDS.read_text(encoding="utf-8"), Loader=loader)
    return said


def is_as_marked(*cases: Case) -> None:
    """Assert that each check marks its student as the case says; other words than those pinned make the run fail once."""
    wrong = []
    for case in cases:
        found = finding(case)
        if (got := marked(found)) != case.marked:
            wrong.append(f"{case.id}: expected {case.marked}, got {got}: {found!r}")
        elif (said := words(found)) != (before := pinned().get(case.id, {})):
            differs(WORDS, f"{case.id}: expected {before}, got {said}")
    assert wrong == []
