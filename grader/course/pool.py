"""Pool of worker processes, each with one warm marker, that marks many submissions in parallel.

If a marker dies, a fresh one marks its submission again. A submission that two markers failed on is returned as `Unmarked` with
the reason, which is not a zero. A marker that exceeds the time or memory of any sound work is ended; a submission on which
two markers were ended is returned as `Stopped`.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, field
from types import TracebackType
from typing import TYPE_CHECKING, Protocol, TypeAlias

from grader.base.errors import RequestError
from grader.engine.processes import starting_processes
from grader.engine.results import Result

if TYPE_CHECKING:
    from grader.intake import Submission

ATTEMPTS = 2
_POLL_S = 0.5
KILLED = "the marking process was killed"


class Marking(Protocol):
    """Interface of a marker."""

    def mark(self, submission: Submission, cpu_s: float | None = None) -> Result: ...


OpenMarker = Callable[[], AbstractContextManager[Marking]]


@dataclass(frozen=True)
class Unmarked:
    """Outcome of a submission that the grader failed to mark, with the reason."""

    reason: str


@dataclass(frozen=True)
class Stopped:
    """Outcome of a submission whose marking exceeded the limits on time or memory, with the reason."""

    reason: str


@dataclass(frozen=True)
class Bounds:
    """Limits of a marker on one submission. Sound work takes a small part of them, even on a busy machine."""

    wall_s: float = 600.0
    memory_bytes: int = 3 << 30


_BOUNDS = Bounds()
Outcome: TypeAlias = "Result | Unmarked | Stopped"


@dataclass
class Task:
    """Submission in the queue, with the reasons of failed attempts; `stopped` is the reason if a marker was ended."""

    submission: Submission
    reasons: list[str] = field(default_factory=list)
    stopped: str = ""


class Backlog:
    """Queue of submissions to mark; those to be retried come first. Submissions are taken from the iterator one at a time."""

    def __init__(self, submissions: Iterator[Submission], attempts: int = ATTEMPTS) -> None:
        self._submissions, self._attempts = submissions, attempts
        self._again: deque[Task] = deque()

    def next(self) -> Task | None:
        """Return the next task; None if there is none at present."""
        if self._again:
            return self._again.popleft()
        submission = next(self._submissions, None)
        return None if submission is None else Task(submission)

    def put_back(self, task: Task) -> None:
        """Put a task that was not begun back into the queue."""
        self._again.append(task)

    def failed(self, task: Task, reason: str) -> Unmarked | Stopped | None:
        """Queue a failed task again and return None, or return its outcome after the last attempt."""
        task.reasons.append(reason)
        if len(task.reasons) < self._attempts:
            self._again.append(task)
            return None
        return Stopped(task.stopped) if task.stopped else Unmarked(reason)


def mark_all(
    submissions: Iterator[Submission], open_marker: OpenMarker, jobs: int, bounds: Bounds = _BOUNDS
) -> Generator[tuple[Submission, Outcome], None, None]:
    """Mark every submission and yield each as it is done, in no particular order.

    Parameters
    ----------
    submissions
        Taken one at a time, so that a class need not fit into memory.
    open_marker
        Makes a marker; called in each worker process, so it must be picklable.
    jobs
        Largest number of worker processes. They are started when there is work for them.
    bounds
        Time and memory after which a marker is ended.

    Raises
    ------
    GraderError, RequestError
        If a marker cannot be opened at all.
    """
    with Pool(open_marker, jobs, bounds) as pool:
        yield from pool.run(submissions)


class Pool:
    """Pool of worker processes, each with one marker, kept from one run to the next; a context manager.

    Parameters
    ----------
    open_marker, jobs, bounds
        See `mark_all`.
    attempts
        Number of markers that may fail on a submission before it is returned without a result.
    """

    def __init__(self, open_marker: OpenMarker, jobs: int, bounds: Bounds, attempts: int = ATTEMPTS) -> None:
        self._bounds, self._attempts = bounds, attempts
        self._other_children = set(multiprocessing.active_children())
        self._processes: list[_MarkerProcess] = []
        self._backlog = Backlog(iter(()))
        self._open_marker = open_marker
        self._cpu_s: float | None = None
        self._idle: deque[_MarkerProcess | None] = deque(
            [None] * max(1, jobs)
        )  # None: a process that is not started yet
        self._given: dict[Future[Result], tuple[_MarkerProcess, Task]] = {}  # the first of each process is being marked

    def __enter__(self) -> Pool:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._close() if kind is None else self._kill_all()

    def run(
        self, submissions: Iterator[Submission], cpu_s: float | None = None
    ) -> Iterator[tuple[Submission, Outcome]]:
        """Mark submissions as `mark_all` does; `cpu_s` may lower the rubric's limit on the CPU time of each submission."""
        self._cpu_s = cpu_s
        self._backlog = Backlog(submissions, self._attempts)
        while self._hand_out():
            done, waiting = wait(self._given, timeout=_POLL_S, return_when=FIRST_COMPLETED)
            for process in {self._given[future][0] for future in waiting}:
                process.stop_beyond(self._bounds)
            for future in [
                each for each in self._given if each in done
            ]:  # the futures of each process in the order of submission
                if future not in self._given:  # it waited for a process that has failed
                    continue
                submission, outcome = self._finished(future)
                if outcome is not None:
                    yield submission, outcome

    def _close(self) -> None:
        for process in self._idle:
            if process is not None:
                process.close()

    def _kill_all(self) -> None:
        """Kill every worker process, because their tasks may take minutes."""
        for worker in set(multiprocessing.active_children()) - self._other_children:
            worker.kill()
        for process in self._processes:
            process.dismiss(wait=True)

    def _hand_out(self) -> bool:
        """Give every process a task to mark and one to wait; return False when no task is left to wait for.

        Between two results the parent records one and writes its pages. A waiting task keeps the worker busy meanwhile.
        """
        while self._idle and (task := self._backlog.next()) is not None:
            self._give(self._idle.popleft() or self._start_process(), task)
        for process in {process for process, _ in self._given.values()}:
            if len(self._futures_of(process)) == 1 and (task := self._backlog.next()) is not None:
                self._give(process, task)
        return bool(self._given)

    def _give(self, process: _MarkerProcess, task: Task) -> None:
        self._given[process.mark(task.submission, self._cpu_s)] = (process, task)

    def _start_process(self) -> _MarkerProcess:
        self._processes = [process for process in self._processes if not process.dismissed] + [
            _MarkerProcess(self._open_marker)
        ]
        return self._processes[-1]

    def _finished(self, future: Future[Result]) -> tuple[Submission, Outcome | None]:
        """Return a finished submission and its outcome; None in place of the outcome if it will be retried."""
        process = self._given[future][0]
        problem = future.exception()
        if problem is not None:
            return self._failed(process, problem)
        _, task = self._given.pop(future)
        process.began = None
        if not self._futures_of(process):
            self._idle.appendleft(process)
        return task.submission, future.result()

    def _failed(self, process: _MarkerProcess, problem: BaseException) -> tuple[Submission, Outcome | None]:
        """Dismiss a process that failed on its first task, and put its other tasks, which it has not begun, back into the queue."""
        process.check_opened()
        process.dismiss()
        self._idle.append(None)
        task, *others = [self._given.pop(future)[1] for future in self._futures_of(process)]
        for other in others:
            self._backlog.put_back(other)
        killed = process.stopped or KILLED
        task.stopped = process.stopped or task.stopped
        reason = killed if isinstance(problem, BrokenProcessPool) else exception_text(problem)
        return task.submission, self._backlog.failed(task, reason)

    def _futures_of(self, process: _MarkerProcess) -> list[Future[Result]]:
        """Return the futures of a process in the order of submission."""
        return [future for future, (whose, _) in self._given.items() if whose is process]


def exception_text(problem: BaseException) -> str:
    """Return an exception's type and message on one line."""
    return " ".join(f"{type(problem).__name__}: {problem}".split())


class _MarkerProcess:
    """Worker process with one marker. Each has an executor of its own, so that the submission that broke it is known."""

    def __init__(self, open_marker: OpenMarker) -> None:
        self.dismissed = False
        self.stopped = ""
        self.began: float | None = None
        context = multiprocessing.get_context("spawn")
        with starting_processes() as begin:
            self._executor = ProcessPoolExecutor(1, mp_context=context, initializer=begin)
            self._opened = self._executor.submit(_open, open_marker)

    def mark(self, submission: Submission, cpu_s: float | None = None) -> Future[Result]:
        try:
            return self._executor.submit(_mark, submission, cpu_s)
        except BrokenProcessPool as problem:  # it died while it was idle
            future: Future[Result] = Future()
            future.set_exception(problem)
            return future

    def stop_beyond(self, bounds: Bounds) -> None:
        """Kill the process if it exceeds the bounds. Its time starts at the first call after the marker has opened."""
        if self.stopped or not self._opened.done() or self._opened.exception() is not None:
            return
        self.began = self.began or time.monotonic()
        pid = self._opened.result()
        if time.monotonic() - self.began > bounds.wall_s:
            self.stopped = f"no end within {bounds.wall_s:g} s"
        elif _memory_of(pid) > bounds.memory_bytes:
            self.stopped = f"more than {bounds.memory_bytes / 2**30:g} GB of memory"
        if self.stopped:
            with suppress(OSError):  # the process has just ended
                os.kill(pid, getattr(signal, "SIGKILL", signal.SIGTERM))  # Windows ends a process with either

    def check_opened(self) -> None:
        """Raise the exception that opening the marker raised, because no submission caused it."""
        problem = self._opened.exception()
        if problem is not None and not isinstance(problem, BrokenProcessPool):
            raise problem

    def dismiss(self, *, wait: bool = False) -> None:
        self.dismissed = True
        if sys.version_info < (3, 11, 5):  # without this, shutdown waits for ever for a dead process to read its queue
            with suppress(OSError):  # the executor's own thread may be closing it just now
                self._executor._call_queue._reader.close()  # type: ignore[attr-defined] # as later versions do: cpython#94777
        self._executor.shutdown(wait, cancel_futures=True)

    def close(self) -> None:
        with suppress(BrokenProcessPool):  # the process and its children have already ended
            self._executor.submit(_close).result()
        self._executor.shutdown()


def _memory_of(pid: int) -> int:
    """Return the resident memory of a process in bytes; 0 on systems without `/proc`."""
    with suppress(OSError, ValueError, IndexError), open(f"/proc/{pid}/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    return 0


# The rest of this module runs in the worker process.

_open_marker: AbstractContextManager[Marking] | None = None
_marker: Marking | None = None


def _open(open_marker: OpenMarker) -> int:
    """Open the marker that grades in this process, and return the id of the process."""
    global _open_marker, _marker  # noqa: PLW0603 - the process has one marker, made once
    _open_marker = open_marker()
    _marker = _open_marker.__enter__()
    return os.getpid()


def _mark(submission: Submission, cpu_s: float | None) -> Result:
    if _marker is None:
        raise RequestError("no marker could be opened")
    return _marker.mark(submission, cpu_s)


def _close() -> None:
    if _open_marker is not None:
        _open_marker.__exit__(None, None, None)
