"""Pool of worker processes that grade many submissions in parallel. Each keeps one marker, the object that grades, open.

If a worker process fails, another one grades its submission again. A submission that fails twice is returned with the reason: as
`Ended` if it exceeded the limits on time or memory, which leave any sound work enough; else as `Unmarked`, which is not a zero.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator
from contextlib import AbstractContextManager, ExitStack, suppress
from dataclasses import dataclass, field
from multiprocessing import connection
from types import TracebackType
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

from grader.base.errors import fault_text
from grader.engine.processes import starting_processes
from grader.engine.results import Result

if TYPE_CHECKING:
    from grader.intake import Submission

ATTEMPTS = 2
_POLL_S = 0.5
KILLED = "the marking process was killed"


class Marking(Protocol):
    """Protocol of a marker, whose `mark` grades a submission; `cpu_s` may lower the rubric's limit of CPU time, None keeps it."""

    def mark(self, submission: Submission, cpu_s: float | None = None) -> Result: ...


OpenMarker = Callable[[], AbstractContextManager[Marking]]


@dataclass(frozen=True)
class Unmarked:
    """Outcome of a submission on which the grader itself failed, with the reason. It has no grade, which is not a zero."""

    reason: str


@dataclass(frozen=True)
class Ended:
    """Outcome of a submission given up because it exceeded the limits on time or memory, with the reason. It earns nothing."""

    reason: str


@dataclass(frozen=True)
class Bounds:
    """Limits on the process that grades one submission, beyond which it is killed. Sound work takes a small part of them."""

    wall_s: float = 600.0
    memory_bytes: int = 3 << 30


_BOUNDS = Bounds()
MarkerAnswer: TypeAlias = "Result | Unmarked | Ended"


@dataclass
class Task:
    """A submission being graded, with the reasons of failed attempts; `stopped` is the limit that an attempt exceeded, else ""."""

    submission: Submission
    reasons: list[str] = field(default_factory=list)
    stopped: str = ""


class Backlog:
    """Queue of submissions to grade, taken from an iterator one at a time; those whose grading failed come first."""

    def __init__(self, submissions: Iterator[Submission], attempts: int = ATTEMPTS) -> None:
        self._submissions, self._attempts = submissions, attempts
        self._again: deque[Task] = deque()

    def next(self) -> Task | None:
        """Return the next submission to grade; None if none is waiting, though one that is being graded may fail and come back."""
        if self._again:
            return self._again.popleft()
        submission = next(self._submissions, None)
        return None if submission is None else Task(submission)

    def failed(self, task: Task, reason: str) -> Unmarked | Ended | None:
        """Queue a failed task for another attempt and return None; after the last of `attempts`, return the outcome.

        The outcome is `Ended` if an attempt exceeded a limit on time or memory, else `Unmarked`.
        """
        task.reasons.append(reason)
        if len(task.reasons) < self._attempts:
            self._again.append(task)
            return None
        return Ended(task.stopped) if task.stopped else Unmarked(reason)


def mark_all(
    submissions: Iterator[Submission], open_marker: OpenMarker, jobs: int, bounds: Bounds = _BOUNDS
) -> Generator[tuple[Submission, MarkerAnswer], None, None]:
    """Grade every submission on this machine; yield each with its outcome once it is known, in any order.

    The outcome is a result, `Unmarked` if the grader itself failed, or `Ended` if a limit was exceeded.

    Parameters
    ----------
    submissions
        Taken one at a time, so that a class need not fit into memory.
    open_marker
        Opens a marker, which grades submissions; called in each worker process, so it must be picklable.
    jobs
        Largest number of worker processes. They are started when there is work for them.
    bounds
        Time and memory beyond which the grading of one submission is ended.

    Raises
    ------
    GraderError, RequestError
        If a marker cannot be opened at all.
    """
    with Pool(open_marker, jobs, bounds) as pool:
        yield from pool.run(submissions)


class Pool:
    """Worker processes that grade submissions, kept for further calls of `run`, because starting them is slow; a context manager.

    Each process has one submission at a time. So it is known which submission ended a process, and only that one is graded again.

    Parameters
    ----------
    open_marker : picklable function with which each process opens a marker, the object that grades
    jobs : largest number of processes
    bounds : limits on time and memory of grading one submission
    attempts : number of processes that may fail on a submission before it is returned without a result
    """

    def __init__(self, open_marker: OpenMarker, jobs: int, bounds: Bounds, attempts: int = ATTEMPTS) -> None:
        self._open_marker, self._jobs, self._bounds, self._attempts = open_marker, max(1, jobs), bounds, attempts
        self._idle: list[_MarkerProcess] = []
        self._busy: list[_MarkerProcess] = []

    def __enter__(self) -> Pool:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        processes = [*self._idle, *self._busy]
        for process in processes:
            if kind is not None or process in self._busy:
                process.kill()  # its task may take minutes
            process.line.close()
        for process in processes:
            process.close()

    def run(
        self, submissions: Iterator[Submission], cpu_s: float | None = None
    ) -> Iterator[tuple[Submission, MarkerAnswer]]:
        """Grade submissions; yield each with its outcome (a result, `Unmarked` or `Ended`) once it is known, in any order.

        `cpu_s` may lower the rubric's limit of CPU seconds for each submission; None keeps it.
        """
        backlog = Backlog(submissions, self._attempts)
        while self._hand_out(backlog, cpu_s):
            ready = connection.wait([process.line for process in self._busy], _POLL_S)
            for process in [each for each in self._busy if each.line in ready]:
                task = process.task
                outcome = self._receive_outcome(process, backlog)
                self._hand_out(backlog, cpu_s)  # so that it works while the caller records this one
                if outcome is not None:
                    yield task.submission, outcome
            for process in self._busy:
                process.stop_beyond(self._bounds)

    def _hand_out(self, backlog: Backlog, cpu_s: float | None) -> bool:
        """Give tasks to idle processes, starting new ones up to `jobs`; return whether any is grading, else the run ends."""
        while len(self._busy) < self._jobs and (task := backlog.next()) is not None:
            process = self._idle.pop() if self._idle else _MarkerProcess(self._open_marker)
            process.mark(task, cpu_s)
            self._busy.append(process)
        return bool(self._busy)

    def _receive_outcome(self, process: _MarkerProcess, backlog: Backlog) -> MarkerAnswer | None:
        """Return the outcome that a process has sent; None if it has only got ready, or if its submission will be tried again.

        GraderError or RequestError if the process could not get ready, because no submission caused that.
        """
        message = process.receive()
        if isinstance(message, _Opened):
            process.began = time.monotonic()
            return None
        if isinstance(message, Exception):
            raise message
        self._busy.remove(process)
        if isinstance(message, Result):
            self._idle.append(process)
            return message
        process.close()
        process.task.stopped = process.stopped or process.task.stopped
        return backlog.failed(process.task, message)


@dataclass(frozen=True)
class _Opened:
    """Message of a worker process: it is ready to grade, so the time of its first submission counts from now."""


_Message: TypeAlias = "_Opened | Result | str | Exception"
"""A string is the reason why the grader failed on a submission, an exception why the marker could not be opened."""


class _MarkerProcess:
    """A worker process that grades, as the pool sees it: the pipe to it, its latest task, and why it was stopped."""

    task: Task

    def __init__(self, open_marker: OpenMarker) -> None:
        self.stopped = ""
        self.began: float | None = None
        context = multiprocessing.get_context("spawn")
        self.line, theirs = context.Pipe()
        with starting_processes() as begin:
            self._process = context.Process(target=_serve, args=(theirs, begin, open_marker))
            self._process.start()
        theirs.close()

    def mark(self, task: Task, cpu_s: float | None) -> None:
        self.task = task
        self.began = self.began and time.monotonic()
        with suppress(OSError):  # it has died, and `receive` tells it
            self.line.send((task.submission, cpu_s))

    def receive(self) -> _Message:
        """Return the next message of the process; if it ended without one, the limit it exceeded or that it was killed."""
        try:
            message: _Message = self.line.recv()
        except (EOFError, OSError):
            return self.stopped or KILLED
        return message

    def stop_beyond(self, bounds: Bounds) -> None:
        """Kill the process if it exceeds a limit on time or memory. Getting ready to grade does not count."""
        if self.began is None or self.stopped:
            return
        if time.monotonic() - self.began > bounds.wall_s:
            self.stopped = f"no end within {bounds.wall_s:g} s"
        elif _memory_of(self._process.pid) > bounds.memory_bytes:
            self.stopped = f"more than {bounds.memory_bytes / 2**30:g} GB of memory"
        if self.stopped:
            self.kill()

    def kill(self) -> None:
        self._process.kill()

    def close(self) -> None:
        """Close the pipe, at which the process cleans up and ends, and wait until it has, so that none is left."""
        self.line.close()
        self._process.join()


def _memory_of(pid: int | None) -> int:
    """Return the resident memory of a process in bytes; 0 if it has ended or the system has no `/proc`."""
    with suppress(OSError, ValueError, IndexError), open(f"/proc/{pid}/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    return 0


def _serve(line: connection.Connection[_Message, Any], begin: Callable[[], None], open_marker: OpenMarker) -> None:
    """Run a worker process: open the marker that grades, grade what comes through the pipe `line`, until it closes or fails."""
    begin()
    with ExitStack() as stack, suppress(EOFError, OSError):
        try:
            marker = stack.enter_context(open_marker())
        except Exception as problem:
            line.send(problem)
            return
        line.send(_Opened())
        while True:
            submission, cpu_s = line.recv()
            try:
                result = marker.mark(submission, cpu_s)
            except Exception as problem:
                line.send(fault_text(problem))
                return
            line.send(result)
