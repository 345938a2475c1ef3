"""The talk with the sandbox about one submission: its workers, its files, the time that they have, and each answer once."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import PurePosixPath
from threading import Timer
from typing import Any, Protocol, TypeVar

import numpy as np

from grader.base.errors import Crashed, GraderError, Malformed, NoAnswer, TimedOut
from grader.base.text import printable
from grader.engine.findings import Missing
from grader.engine.load_report import Endings, Loaded, overran
from grader.sandbox.printed import PLACE_AT, PLACE_BYTES
from grader.sandbox.sandbox import Sandbox, Worker
from grader.sandbox.wire import Frame

SEED = 0
"""Seed of the generators that student code draws from; no verdict rests on it."""

_SENT = (".py", ".ipynb", ".xml", ".csv", ".txt", ".json", ".yaml", ".yml", ".toml", ".ini", ".cfg", ".npy", ".npz")
_SENT_BYTES = 24_000_000
_LOADING = ("load", "run_script")
_WAITS_FOR = {"load": "{path} to be imported", "run_script": "{path} to run as a program"}
_WALL_PER_CPU = 4  # seconds on the clock that a part has for each of its CPU time: waiting costs time, too
_SLOW_S = 2.0  # after which a line says what is waited for
_OF_ITS_TIME = 0.8  # is what loading has before the process is ended: it may interrupt its statements itself

T = TypeVar("T")
Listener = Callable[[str, str], None]
"""Hears what a student's code prints: the part that is being examined, and the text."""


class Sheet(Protocol):
    """What a conversation needs to know of the lab that it is about."""

    @property
    def parts(self) -> Collection[Any]: ...

    @property
    def homes(self) -> Mapping[str, str]: ...

    @property
    def files(self) -> Collection[str]: ...

    @property
    def waits_for(self) -> Mapping[str, str]: ...

    @property
    def checked(self) -> Callable[[str, Frame, Mapping[str, Any], Mapping[str, Any]], Frame]: ...

    def standin(self, name: str, lab_configuration: Mapping[str, Any]) -> str: ...


class _Session:
    """One worker with the submission's files in it."""

    def __init__(self, worker: Worker) -> None:
        self.worker = worker
        self.loaded: dict[str, Loaded] = {}
        self.has_seen_data = False
        self._heard = 0

    def news(self) -> str:
        """What the worker has printed since this was asked last."""
        text = self.worker.printed()
        news, self._heard = text[self._heard :], len(text)
        return news


class Asking:
    """Asks each question about a submission once, in a fresh worker where one died.

    Parameters
    ----------
    sandbox : the zygote that workers come from
    lab : whose names are asked for, a `Lab`
    files : relative path -> content
    above : how many folders above the others some of them lie
    lab_configuration : what the worker code is given with the files: the lab's own
    call_cpu_s, submission_cpu_s : limits, from the rubric
    waiting : called with what is waited for, where an answer takes long
    """

    def __init__(
        self,
        sandbox: Sandbox,
        lab: Sheet,
        files: Mapping[str, bytes],
        *,
        above: Mapping[str, int],
        lab_configuration: Mapping[str, Any],
        call_cpu_s: float,
        submission_cpu_s: float,
        waiting: Callable[[str], None] | None = None,
    ) -> None:
        self._sandbox, self._lab, self._above = sandbox, lab, above
        self.files = dict(files)
        self._furniture = lab_configuration
        self._call_cpu_s, self._share_cpu_s = call_cpu_s, submission_cpu_s / (len(lab.parts) + 1)
        self._waiting = waiting
        self._part = ""
        self._used_cpu_s: defaultdict[str, float] = defaultdict(float)
        self._used_wall_s: defaultdict[str, float] = defaultdict(float)
        self._overrun: Counter[str] = Counter()
        self._session: _Session | None = None
        self.deadly: dict[str, NoAnswer] = {}
        self._suspects: set[str] = set()
        self._endings = Endings()
        self._noted: set[str] = set()
        self._strays: dict[str, dict[str, str]] = {}
        self.broken: set[str] = set()
        self._answers: dict[Any, Any] = {}
        self._called: dict[str, str] = {}
        self._outline: Mapping[str, Sequence[str]] | None = None
        self.paths: frozenset[str] = frozenset(files)
        self.used: list[str] = []
        self.notes: list[str] = []
        self.listen: Listener | None = None

    def close(self) -> None:
        self.end_session()

    def replace_broken(self, names: Sequence[str]) -> None:
        """From now on sound stand-ins take the place of these names: their own checks are over."""
        if not self.broken.issuperset(names):
            self.broken |= set(names)
            self.end_session()

    @contextmanager
    def without_standins(self) -> Iterator[dict[Any, Any]]:
        """The submission as it was handed in, in a process of its own: its answers, forgotten unless `remember` has them."""
        (broken, self.broken), (answers, self._answers) = (self.broken, set()), (self._answers, {})
        self.end_session()
        try:
            yield self._answers
        finally:
            self.broken, self._answers = broken, answers
            self.end_session()

    def remember(self, answers: Mapping[Any, Any]) -> None:
        """Put these in the place of answers to the same questions."""
        self._answers |= answers

    def end_session(self) -> None:
        if self._session is not None:
            self._pass_on_prints()
            self._session.worker.close()
            self._session = None

    def _pass_on_prints(self) -> None:
        if self.listen is not None and self._session is not None:
            self.listen(self._part, self._session.news())

    def _fresh_session(self) -> _Session:
        if self._session is None or not self._session.worker.alive:
            self.end_session()
            self._session = _Session(self._sandbox.worker())
            try:
                self._submit(self._session.worker)
            except NoAnswer:
                self.end_session()
                raise
        return self._session

    def _submit(self, worker: Worker) -> None:
        files, arrays = self._files_to_send()
        fields = {
            "files": files,
            "lab_configuration": self._furniture,
            "seed": SEED,
            "withheld": sorted(self.deadly),
            "skipped": self._endings.beside(self.broken),
            "place": (PLACE_AT, PLACE_BYTES),
            "homes": dict(self._lab.homes),
            "required": list(self._lab.files),
            "standins": {name: self._lab.standin(name, self._furniture) for name in sorted(self.broken)},
        }
        written = worker.ask("submit", fields, arrays, cpu_s=self._call_cpu_s).fields["written"]
        self.paths = frozenset([path for path, _, _ in files] + written)

    def _files_to_send(self) -> tuple[list[tuple[str, str, int]], dict[str, np.ndarray]]:
        rows: list[tuple[str, str, int]] = []
        arrays: dict[str, np.ndarray] = {}
        total = 0
        wanted = [p for p in self.files if PurePosixPath(p).suffix.lower() in _SENT and p not in self.deadly]
        for path in sorted(wanted, key=self._turn_of):
            content = self.files[path]
            total += len(content)
            if total > _SENT_BYTES:
                break
            key = f"f{len(rows)}"
            rows.append((path, key, self._above.get(path, 0)))
            arrays[key] = np.frombuffer(content, dtype=np.uint8)
        return rows, arrays

    def _turn_of(self, path: str) -> tuple[bool, bool, str]:
        """Sort key of a file to send: those that the lab asks for, then other code, then data."""
        return (path not in self._lab.homes.values(), not path.endswith((".py", ".ipynb")), path)

    @property
    def used_cpu_s(self) -> float:
        """CPU time of the submission's code so far."""
        return sum(self._used_cpu_s.values())

    def turn_to(self, part: str) -> None:
        """What is asked from now on is on the account of this part: no endless loop takes another part's time."""
        if part != self._part:
            self._pass_on_prints()
        self._part = part

    def ask(self, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray] | None = None) -> Frame:
        session = self._fresh_session()
        worker = session.worker
        if self._used_cpu_s[self._part] >= self._share_cpu_s or self._left_s() <= 0:
            raise TimedOut("this part used up its time", cpu_s=0.0, wall_s=0.0)
        limit_s = self._limit_s()
        if op in _LOADING:
            fields = {**fields, "within_s": _OF_ITS_TIME * limit_s}
        before, began = worker.cpu_s, worker.wall_s
        try:
            return self._asked(session, op, fields, arrays or {}, limit_s)
        except TimedOut:
            self._overrun[self._part] += 1
            raise
        except Malformed:
            worker.close()  # nothing more that comes from there can be relied on
            raise
        finally:
            self._used_cpu_s[self._part] += max(0.0, worker.cpu_s - before)
            self._used_wall_s[self._part] += max(0.0, worker.wall_s - began)
            session.has_seen_data |= op not in ("load", "outline")

    def _limit_s(self) -> float:
        """Half as much after each call that did not end: all together they take no more than twice the first."""
        return float(self._call_cpu_s / 2 ** self._overrun[self._part])

    def _left_s(self) -> float:
        """What the part that is examined still has on the clock."""
        return _WALL_PER_CPU * self._share_cpu_s - self._used_wall_s[self._part]

    def _asked(
        self, session: _Session, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray], limit_s: float
    ) -> Frame:
        try:
            with self._telling_if_slow(op, fields, limit_s):
                frame = session.worker.ask(op, fields, arrays, cpu_s=limit_s, wall_s=3 * limit_s, most_s=self._left_s())
        except (Crashed, TimedOut) as nothing:
            if op in _LOADING and not session.has_seen_data:  # or what it wrote down may tell of data
                self._endings.learn_place(session.worker.place(), nothing, self.broken)
            raise
        self._lab.checked(op, frame, fields, arrays)
        if op in _LOADING and overran(frame):
            self._overrun[self._part] += 1
            if not session.has_seen_data:
                self._endings.learn_overrun(frame, self.broken)
        return frame

    @contextmanager
    def _telling_if_slow(self, op: str, fields: Mapping[str, Any], limit_s: float) -> Iterator[None]:
        if self._waiting is None:
            yield
            return
        words = {**_WAITS_FOR, **self._lab.waits_for}
        what = words.get(op, "{path}").format(path=printable(str(fields.get("path", "an answer")), 80))
        timer = Timer(_SLOW_S, self._waiting, [f"Waiting for {what}: {limit_s:g} s of CPU time at most."])
        timer.daemon = True
        timer.start()
        try:
            yield
        finally:
            timer.cancel()

    def ask_aside(self, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Frame:
        """Ask a worker that has never seen the submission: one that runs it could say anything."""
        with self._sandbox.worker() as worker:
            return worker.ask(op, fields, arrays, cpu_s=self._call_cpu_s)

    def once(self, key: Any, ask: Callable[[], T]) -> T:
        """Ask a question once; remember the answer, or that there was none."""
        if key not in self._answers:
            try:
                self._answers[key] = self.retried(ask)
            except (NoAnswer, Missing) as nothing:
                self._answers[key] = nothing
        answer = self._answers[key]
        if isinstance(answer, Exception):
            raise answer.with_traceback(None)  # or it would grow with every time that it is raised
        return answer  # type: ignore[no-any-return]

    def known_as(self, called: str, key: Any, ask: Callable[[], T]) -> T:
        """As `once`, for what a report looks up by a name."""
        if called:
            self._called[called] = key
        return self.once(key, ask)

    def answered(self, called: str) -> Any:
        """What was answered under a name; None where nothing was. Nothing is asked."""
        answer = self._answers.get(self._called.get(called))
        return None if isinstance(answer, Exception) else answer

    def retried(self, ask: Callable[[], T]) -> T:
        """Ask; and once more in a new process where the first one ended.

        A system that is short of memory ends processes, too, the box's among them, and another file in it may be to blame: who ends
        it by himself does so twice. And once more without a statement that turned out to end it.
        """
        while True:
            known = self._endings.found_out
            try:
                return self._twice(ask)
            except NoAnswer:
                if self._endings.found_out == known:
                    raise
                self.end_session()

    def _twice(self, ask: Callable[[], T]) -> T:
        try:
            return ask()
        except (Crashed, Malformed, GraderError):
            self.end_session()
            return ask()
