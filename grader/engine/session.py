"""Session with the sandbox about one submission: processes, files, CPU time, and answers that are asked only once."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import PurePosixPath
from threading import Timer
from typing import Any, Protocol, TypeVar

import numpy as np

from grader.base.errors import Crashed, GraderError, Malformed, NoAnswer, TimedOut
from grader.base.text import printable
from grader.engine.findings import Missing
from grader.engine.load_report import DeadlyStatements, Loaded, overran
from grader.sandbox.printed import PLACE_AT, PLACE_BYTES
from grader.sandbox.sandbox import Sandbox, Worker
from grader.sandbox.wire import Frame

SEED = 0
"""Seed of the random generators of student code; no outcome depends on its value."""

_SENT_BYTES = 24_000_000
_LOADING = ("load", "run_script")
_WAITS_FOR = {"load": "{path} to be imported", "run_script": "{path} to run as a program"}
_WALL_PER_CPU = 4  # wall-clock seconds that a part has per second of its CPU time: code that waits uses time, too
_SLOW_S = 2.0  # seconds after which a message says what the grader waits for
_OF_ITS_TIME = 0.8  # share of the limit after which loading interrupts its own statements, before it is killed

T = TypeVar("T")
Listener = Callable[[str, str], None]
"""Called with the part that is being examined and the text that the student's code printed."""


class Sheet(Protocol):
    """Protocol of those attributes of a `Lab` that a session uses, so that a test can pass a smaller object."""

    @property
    def parts(self) -> Collection[Any]: ...

    @property
    def homes(self) -> Mapping[str, str]: ...

    @property
    def files(self) -> Collection[str]: ...

    @property
    def slug(self) -> str: ...

    @property
    def suffixes(self) -> Collection[str]: ...

    @property
    def waits_for(self) -> Mapping[str, str]: ...

    @property
    def checked(self) -> Callable[[str, Frame, Mapping[str, Any], Mapping[str, Any]], Frame]: ...

    def standin(self, name: str, lab_configuration: Mapping[str, Any]) -> str: ...
    def sheets_own(self, name: str) -> str: ...


class _Session:
    """A sandbox process (worker) with a submission's files, the reports on files loaded in it, and whether it has seen data."""

    def __init__(self, worker: Worker) -> None:
        self.worker = worker
        self.loaded: dict[str, Loaded] = {}
        self.has_seen_data = False
        self._heard = 0

    def new_output(self) -> str:
        """Return the text that the process printed since the last call."""
        text = self.worker.printed()
        news, self._heard = text[self._heard :], len(text)
        return news


class SandboxSession:
    """Session with the sandbox about one submission: asks each question once, and starts a new worker (process) if one ended.

    Parameters
    ----------
    sandbox : provides the workers
    lab : the lab, whose required names may be asked about
    files : the submission's files: relative path -> content
    above : relative path -> n, for each file from outside the folder with the lab's files: its path starts n levels above that.
        The worker stores it in its own folder and, if n is at most 2, again n levels above, so that programs find it in both
    lab_configuration : the lab's own settings, such as sensor names, for the worker and for code that replaces broken definitions
    call_cpu_s, submission_cpu_s : limits of CPU time, from the rubric
    waiting : called with a message if an answer takes long; None tells nothing
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
        self._lab_configuration = lab_configuration
        self._call_cpu_s, self._share_cpu_s = call_cpu_s, submission_cpu_s / (len(lab.parts) + 1)
        self._waiting = waiting
        self._part = ""
        self._used_cpu_s: defaultdict[str, float] = defaultdict(float)
        self._used_wall_s: defaultdict[str, float] = defaultdict(float)
        self._overrun: Counter[str] = Counter()
        self._session: _Session | None = None
        self.deadly: dict[str, NoAnswer] = {}
        self._suspects: set[str] = set()
        self._endings = DeadlyStatements()
        self._noted: set[str] = set()
        self._strays: dict[str, dict[str, str]] = {}
        self.broken: set[str] = set()
        self._sheets_own: Collection[str] = ()
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
        """Let correct code (stand-ins) replace these required names from now on, so that criteria that use them lose nothing."""
        if not self.broken.issuperset(names):
            self.broken |= set(names)
            self.end_session()

    def without_standins(self) -> AbstractContextManager[dict[Any, Any]]:
        """Use no correct code in place of broken definitions in this context; yield its answers by question, as `beside` does."""
        return self.beside(())

    @contextmanager
    def beside(self, sheets_own: Collection[str]) -> Iterator[dict[Any, Any]]:
        """Use, in this context and a new process, the lab sheet's code for the names `sheets_own`, the submission's for all others.

        So a caller sees how checks end without the faults in these names. No stand-ins (see `replace_broken`) are used: they would
        accept other arguments than the sheet's. Yields a dict of the answers given in the context, which are discarded at its end
        unless they are passed to `remember`.
        """
        before = self.broken, self._sheets_own, self._answers
        self.broken, self._sheets_own, self._answers = set(sheets_own), sheets_own, {}
        self.end_session()
        try:
            yield self._answers
        finally:
            self.broken, self._sheets_own, self._answers = before
            self.end_session()

    def remember(self, answers: Mapping[Any, Any]) -> None:
        """Keep the answers that `beside` yielded, by question, for use after its context; they replace earlier answers."""
        self._answers |= answers

    def end_session(self) -> None:
        if self._session is not None:
            self._pass_on_prints()
            self._session.worker.close()
            self._session = None

    def _pass_on_prints(self) -> None:
        if self.listen is not None and self._session is not None:
            self.listen(self._part, self._session.new_output())

    def _fresh_session(self) -> _Session:
        """Return the current process with the submission's files; start a new one if there is none or it has ended."""
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
        """Send the submission's files to a new process, with correct code for broken names and the statements that it must skip."""
        files, arrays = self._files_to_send()
        fields = {
            "files": files,
            "folder": self._lab.slug,
            "lab_configuration": self._lab_configuration,
            "seed": SEED,
            "withheld": sorted(self.deadly),
            "skipped": self._endings.to_skip(self.broken),
            "place": (PLACE_AT, PLACE_BYTES),
            "homes": dict(self._lab.homes),
            "required": list(self._lab.files),
            "standins": {name: self._standin(name) for name in sorted(self.broken)},
        }
        written = worker.ask("submit", fields, arrays, cpu_s=self._call_cpu_s).fields["written"]
        self.paths = frozenset([path for path, _, _ in files] + written)

    def _standin(self, name: str) -> str:
        if name in self._sheets_own:
            return self._lab.sheets_own(name)
        return self._lab.standin(name, self._lab_configuration)

    def _files_to_send(self) -> tuple[list[tuple[str, str, int]], dict[str, np.ndarray]]:
        """Return (path, key, folders above) of each file for a sandbox process, and the files' bytes by key.

        These are code and data up to 24 MB together. A file that ended each process that loaded it is left out.
        """
        rows: list[tuple[str, str, int]] = []
        arrays: dict[str, np.ndarray] = {}
        total = 0
        wanted = [
            p for p in self.files if PurePosixPath(p).suffix.lower() in self._lab.suffixes and p not in self.deadly
        ]
        for path in sorted(wanted, key=self._send_order):
            content = self.files[path]
            total += len(content)
            if total > _SENT_BYTES:
                break
            key = f"f{len(rows)}"
            rows.append((path, key, self._above.get(path, 0)))
            arrays[key] = np.frombuffer(content, dtype=np.uint8)
        return rows, arrays

    def _send_order(self, path: str) -> tuple[bool, bool, str]:
        """Return the sort key of a file to send: required files, other code, then data, as a size limit may cut off the end."""
        return (path not in self._lab.homes.values(), not path.endswith((".py", ".ipynb")), path)

    @property
    def used_cpu_s(self) -> float:
        """CPU time that the submission's code has used so far, in seconds."""
        return sum(self._used_cpu_s.values())

    def account_to(self, part: str) -> None:
        """Account time to `part` from now on (a criterion; ``bonuses``: all extensions); a loop uses up one part's equal share."""
        if part != self._part:
            self._pass_on_prints()
        self._part = part

    def ask(self, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray] | None = None) -> Frame:
        """Ask the current sandbox process a question, even if asked before, and return the reply; `once` reuses earlier answers.

        `op` names the operation, whose input is `fields` and `arrays`. The time is accounted to the current criterion.

        Raises
        ------
        NoAnswer
            If the process crashed, timed out or gave no valid answer, or if the criterion has no time left.
        """
        session = self._fresh_session()
        worker = session.worker
        if self._used_cpu_s[self._part] >= self._share_cpu_s or self._left_s() <= 0:
            raise TimedOut("this part used up its time", cpu_s=0.0, wall_s=0.0)
        limit_s = self._limit_s()
        if op in _LOADING:
            fields = {**fields, "within_s": _OF_ITS_TIME * limit_s}
        before, began = worker.cpu_s, worker.wall_s
        try:
            return self._checked_answer(session, op, fields, arrays or {}, limit_s)
        except TimedOut:
            self._overrun[self._part] += 1
            raise
        except Malformed:
            worker.close()  # no further reply of this worker can be trusted
            raise
        finally:
            self._used_cpu_s[self._part] += max(0.0, worker.cpu_s - before)
            self._used_wall_s[self._part] += max(0.0, worker.wall_s - began)
            session.has_seen_data |= op not in ("load", "outline")

    def _limit_s(self) -> float:
        """Return the CPU limit of a call; it halves after each timeout in a criterion, so that all take at most twice the first."""
        return float(self._call_cpu_s / 2 ** self._overrun[self._part])

    def _left_s(self) -> float:
        """Return the wall-clock seconds that the current criterion has left; after that its questions count as timed out."""
        return _WALL_PER_CPU * self._share_cpu_s - self._used_wall_s[self._part]

    def _checked_answer(
        self, session: _Session, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray], limit_s: float
    ) -> Frame:
        """Ask a process; check the answer by the lab's rules, and record statements that ended the process or took too long."""
        try:
            with self._telling_if_slow(op, fields, limit_s):
                frame = session.worker.ask(op, fields, arrays, cpu_s=limit_s, wall_s=3 * limit_s, most_s=self._left_s())
        except (Crashed, TimedOut) as nothing:
            if op in _LOADING and not session.has_seen_data:  # else the place that it wrote down may hold data
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
        """Report what the grader waits for if this context takes longer than two seconds, unless nobody listens."""
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

    def ask_fresh_worker(self, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Frame:
        """Ask a new process without the submission, so that no student code can change the reply; `ask` explains the arguments."""
        with self._sandbox.worker() as worker:
            return worker.ask(op, fields, arrays, cpu_s=self._call_cpu_s)

    def once(self, key: Any, ask: Callable[[], T]) -> T:
        """Return the answer to question `key`; `ask` runs only the first time, and its `NoAnswer` or `Missing` is raised again."""
        if key not in self._answers:
            try:
                self._answers[key] = self.retried(ask)
            except (NoAnswer, Missing) as nothing:
                self._answers[key] = nothing
        answer = self._answers[key]
        if isinstance(answer, Exception):
            raise answer.with_traceback(None)  # else its traceback grows each time it is raised
        return answer  # type: ignore[no-any-return]

    def once_named(self, called: str, key: Any, ask: Callable[[], T]) -> T:
        """Return the answer to question `key`, from `ask` for a new question; `stored_answer` finds it as `called`, if not ""."""
        if called:
            self._called[called] = key
        return self.once(key, ask)

    def stored_answer(self, called: str) -> Any:
        """Return the answer that `once_named` stored under a name, for charts; None if there is none. No question is asked."""
        answer = self._answers.get(self._called.get(called))
        return None if isinstance(answer, Exception) else answer

    def retried(self, ask: Callable[[], T]) -> T:
        """Return what `ask` returns. After a NoAnswer or GraderError, call `ask` again in a new process, or raise the exception.

        `ask` is called again whenever a statement was found that ended the process or took too long, as a new process skips such
        a statement. If none was found, `ask` is called again once, but not after a timeout.
        """
        tried = False
        while True:
            known = self._endings.count
            try:
                return ask()
            except (NoAnswer, GraderError) as nothing:
                if not self._may_help_to_repeat(nothing, known, tried=tried):
                    raise
                tried = self._endings.count == known
                self.end_session()

    def _may_help_to_repeat(self, nothing: Exception, known: int, *, tried: bool) -> bool:
        """Return whether to ask again: a statement that ended the process was found, or the process ended for the first time.

        A new process skips such a statement. A process may also end because the system is short of memory, or because of another
        file in it; code that ends its process does so twice. Code that used up its time would do so again.

        Parameters
        ----------
        nothing : why no answer came
        known : the number of such statements before the question
        tried : whether it was asked again for no other reason than that the process ended
        """
        return self._endings.count > known or not (tried or isinstance(nothing, TimedOut))
