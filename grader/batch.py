"""Many submissions: one warm marker a core, each in a process of its own.

A marker that dies takes nothing with it but the submission that it was marking, which is given to a fresh one; a
submission that two markers could not mark is handed back unmarked with the reason, never lost and never a zero.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from grader.errors import RequestError
from grader.results import Result

if TYPE_CHECKING:
    from grader.intake import Submission

ATTEMPTS = 2
KILLED = "the marking process was killed"


class Marking(Protocol):
    """What is needed of a marker."""

    def mark(self, submission: Submission) -> Result: ...


OpenMarker = Callable[[], AbstractContextManager[Marking]]


@dataclass(frozen=True)
class Unmarked:
    """Why a submission could not be marked: a fault of the grader."""

    reason: str


@dataclass
class Task:
    """A submission that is to be marked, and why that failed so far."""

    submission: Submission
    reasons: list[str] = field(default_factory=list)


class Backlog:
    """What is still to be marked: first what failed once, then the submissions, taken one at a time."""

    def __init__(self, submissions: Iterator[Submission]) -> None:
        self._submissions = submissions
        self._again: deque[Task] = deque()

    def next(self) -> Task | None:
        """The next task; None when there is none at present."""
        if self._again:
            return self._again.popleft()
        submission = next(self._submissions, None)
        return None if submission is None else Task(submission)

    def failed(self, task: Task, reason: str) -> Unmarked | None:
        """Take a task back, which has failed; the end of it if that was once too often."""
        task.reasons.append(reason)
        if len(task.reasons) < ATTEMPTS:
            self._again.append(task)
            return None
        return Unmarked(reason)


def mark_all(
    submissions: Iterator[Submission], open_marker: OpenMarker, jobs: int
) -> Generator[tuple[Submission, Result | Unmarked], None, None]:
    """Mark every submission and yield each as it is done, in no particular order.

    Parameters
    ----------
    submissions
        Taken one at a time, so that a class need not fit into memory.
    open_marker
        Makes a marker; called in each worker process, so it must be picklable.
    jobs
        How many worker processes there are at most; started as there is work for them.

    Raises
    ------
    GraderError, RequestError
        If a marker cannot be opened at all.
    """
    pool = _Pool(submissions, open_marker, jobs)
    try:
        yield from pool.run()
        pool.close()
    except BaseException:
        pool.abandon()
        raise


class _Pool:
    """Desks at work, and those that wait for work."""

    def __init__(self, submissions: Iterator[Submission], open_marker: OpenMarker, jobs: int) -> None:
        self._strangers = set(multiprocessing.active_children())
        self._desks: list[_Desk] = []
        self._backlog = Backlog(submissions)
        self._open_marker = open_marker
        self._idle: deque[_Desk | None] = deque([None] * max(1, jobs))  # None: a desk that was not needed so far
        self._busy: dict[Future[Result], tuple[_Desk, Task]] = {}

    def run(self) -> Iterator[tuple[Submission, Result | Unmarked]]:
        while self._hand_out():
            done, _ = wait(self._busy, return_when=FIRST_COMPLETED)
            for future in done:
                desk, task = self._busy.pop(future)
                outcome = self._outcome(future, desk, task)
                if outcome is not None:
                    yield task.submission, outcome

    def close(self) -> None:
        for desk in self._idle:
            if desk is not None:
                desk.close()

    def abandon(self) -> None:
        """End every process at once: what they are doing may take minutes."""
        for worker in set(multiprocessing.active_children()) - self._strangers:
            worker.kill()
        for desk in self._desks:
            desk.dismiss(wait=True)

    def _hand_out(self) -> bool:
        """Give every idle desk something to do; False when nothing is left to wait for."""
        while self._idle and (task := self._backlog.next()) is not None:
            desk = self._idle.popleft() or self._new_desk()
            self._busy[desk.mark(task.submission)] = (desk, task)
        return bool(self._busy)

    def _new_desk(self) -> _Desk:
        self._desks = [desk for desk in self._desks if not desk.dismissed] + [_Desk(self._open_marker)]
        return self._desks[-1]

    def _outcome(self, future: Future[Result], desk: _Desk, task: Task) -> Result | Unmarked | None:
        """What came of a task; None if it is to be tried again."""
        problem = future.exception()
        if problem is None:
            self._idle.appendleft(desk)
            return future.result()
        desk.check_opened()
        desk.dismiss()
        self._idle.append(None)
        return self._backlog.failed(task, KILLED if isinstance(problem, BrokenProcessPool) else words(problem))


def words(problem: BaseException) -> str:
    """What failed, on one line."""
    return " ".join(f"{type(problem).__name__}: {problem}".split())


class _Desk:
    """One worker process with one marker. A pool of one each, so that it is known whose submission broke it."""

    def __init__(self, open_marker: OpenMarker) -> None:
        self.dismissed = False
        context = multiprocessing.get_context("spawn")
        self._executor = ProcessPoolExecutor(1, mp_context=context, initializer=_leave_with_parent)
        with _interrupts_ignored():
            self._opened = self._executor.submit(_open, open_marker)

    def mark(self, submission: Submission) -> Future[Result]:
        try:
            return self._executor.submit(_mark, submission)
        except BrokenProcessPool as problem:  # it died while it was idle
            future: Future[Result] = Future()
            future.set_exception(problem)
            return future

    def check_opened(self) -> None:
        """Raise what opening the marker raised: then no submission is to blame."""
        problem = self._opened.exception()
        if problem is not None and not isinstance(problem, BrokenProcessPool):
            raise problem

    def dismiss(self, *, wait: bool = False) -> None:
        self.dismissed = True
        if sys.version_info < (3, 11, 5):  # or they wait for ever for a process that is gone to read what it was sent
            with suppress(OSError):  # the executor's own thread may be closing it just now
                self._executor._call_queue._reader.close()  # type: ignore[attr-defined] # as later versions do: cpython#94777
        self._executor.shutdown(wait, cancel_futures=True)

    def close(self) -> None:
        with suppress(BrokenProcessPool):  # then it is gone already, and so is everything that it had started
            self._executor.submit(_close).result()
        self._executor.shutdown()


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """A process started in here is deaf to Ctrl-C: the terminal sends it to all, and one process is to answer it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


# What follows runs in the worker process.

_open_marker: AbstractContextManager[Marking] | None = None
_marker: Marking | None = None


def _leave_with_parent() -> None:
    """From its first moment: a worker whose run was killed would wait for work for ever, with both ends of its own queue."""

    def wait() -> None:
        parent = multiprocessing.parent_process()
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


def _open(open_marker: OpenMarker) -> None:
    global _open_marker, _marker  # noqa: PLW0603 - the process has one marker, made once
    _open_marker = open_marker()
    _marker = _open_marker.__enter__()


def _mark(submission: Submission) -> Result:
    if _marker is None:
        raise RequestError("no marker could be opened")
    return _marker.mark(submission)


def _close() -> None:
    if _open_marker is not None:
        _open_marker.__exit__(None, None, None)
