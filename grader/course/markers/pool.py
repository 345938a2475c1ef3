"""Pool of worker processes, each with one warm marker, that marks many submissions in parallel.

If a marker dies, a fresh one marks its submission again. A submission that two markers failed on is returned as `Unmarked` with
the reason, which is not a zero. A marker that exceeds the time or memory of any sound work is ended; a submission on which
two markers were ended is returned as `Ended`.
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
    """Protocol of a marker, which grades one submission after the other in a worker process."""

    def mark(self, submission: Submission, cpu_s: float | None = None) -> Result: ...


OpenMarker = Callable[[], AbstractContextManager[Marking]]


@dataclass(frozen=True)
class Unmarked:
    """Outcome of a submission that the grader failed to mark, with the reason."""

    reason: str


@dataclass(frozen=True)
class Ended:
    """Outcome of a submission whose marking exceeded the limits on time or memory, with the reason."""

    reason: str


@dataclass(frozen=True)
class Bounds:
    """Limits on the process that grades one submission. Sound work takes a small part of them, even on a busy machine."""

    wall_s: float = 600.0
    memory_bytes: int = 3 << 30


_BOUNDS = Bounds()
MarkerAnswer: TypeAlias = "Result | Unmarked | Ended"


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
        """Return the next submission to mark; None if there is none at present."""
        if self._again:
            return self._again.popleft()
        submission = next(self._submissions, None)
        return None if submission is None else Task(submission)

    def failed(self, task: Task, reason: str) -> Unmarked | Ended | None:
        """Queue a failed task again and return None, or return its outcome after the last attempt."""
        task.reasons.append(reason)
        if len(task.reasons) < self._attempts:
            self._again.append(task)
            return None
        return Ended(task.stopped) if task.stopped else Unmarked(reason)


def mark_all(
    submissions: Iterator[Submission], open_marker: OpenMarker, jobs: int, bounds: Bounds = _BOUNDS
) -> Generator[tuple[Submission, MarkerAnswer], None, None]:
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

    A process is given a submission when it has none, so the one that ended a process is known, and no other is marked again.

    Parameters
    ----------
    open_marker, jobs, bounds
        See `mark_all`.
    attempts
        Number of markers that may fail on a submission before it is returned without a result.
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
        """Mark submissions as `mark_all` does; `cpu_s` may lower the rubric's limit on the CPU time of each submission."""
        backlog = Backlog(submissions, self._attempts)
        while self._hand_out(backlog, cpu_s):
            ready = connection.wait([process.line for process in self._busy], _POLL_S)
            for process in [each for each in self._busy if each.line in ready]:
                task = process.task
                outcome = self._received(process, backlog)
                self._hand_out(backlog, cpu_s)  # so that it works while the caller records this one
                if outcome is not None:
                    yield task.submission, outcome
            for process in self._busy:
                process.stop_beyond(self._bounds)

    def _hand_out(self, backlog: Backlog, cpu_s: float | None) -> bool:
        """Give each idle process a task, and start one while there are fewer than `jobs`; return whether any has a task."""
        while len(self._busy) < self._jobs and (task := backlog.next()) is not None:
            process = self._idle.pop() if self._idle else _MarkerProcess(self._open_marker)
            process.mark(task, cpu_s)
            self._busy.append(process)
        return bool(self._busy)

    def _received(self, process: _MarkerProcess, backlog: Backlog) -> MarkerAnswer | None:
        """Return the outcome that a process has sent; None if it has only opened its marker, or if its task will be retried.

        Raises
        ------
        GraderError, RequestError
            If the marker could not be opened, because no submission caused that.
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
    """Message of a worker process: its marker is open."""


_Message: TypeAlias = "_Opened | Result | str | Exception"
"""A string is the reason why the grader failed on a submission, an exception why the marker could not be opened."""


class _MarkerProcess:
    """Worker process with one marker, and the task that it was given last."""

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
        """Return the next message of the process; that it was killed, if it ended without one."""
        try:
            message: _Message = self.line.recv()
        except (EOFError, OSError):
            return self.stopped or KILLED
        return message

    def stop_beyond(self, bounds: Bounds) -> None:
        """Kill the process if it exceeds the bounds. Its time starts when its marker has opened."""
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
        """Let the process close its marker and end, and wait for that."""
        self.line.close()
        self._process.join()


def _memory_of(pid: int | None) -> int:
    """Return the resident memory of a process in bytes; 0 on systems without `/proc`."""
    with suppress(OSError, ValueError, IndexError), open(f"/proc/{pid}/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    return 0


def _serve(line: connection.Connection[_Message, Any], begin: Callable[[], None], open_marker: OpenMarker) -> None:
    """Open a marker in this process and mark what comes over the line, until it is closed or the grader fails."""
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
