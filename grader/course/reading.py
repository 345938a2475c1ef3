"""Reading what a class handed in, in a process that can be ended: what is read is hostile, and a class must go on."""

from __future__ import annotations

import multiprocessing
import os
import threading
from contextlib import suppress
from multiprocessing.connection import Connection
from types import TracebackType

from grader.course.pool import begin_process, interrupts_ignored, started_beside_no_student
from grader.ground.errors import RequestError
from grader.intake import Submission
from grader.intake.submission import unread
from grader.platforms.classes import Entry

WITHIN_S = 60.0
"""Twenty times what the largest archive takes that is opened at all."""
_ATTEMPTS = 2
MEMORY_BYTES = 4 << 30
_ENDED_WITHIN_S = 5.0


class Reader:
    """A process that reads one submission after the other; a new one where it had to be ended.

    Parameters
    ----------
    within_s, memory_bytes : what one submission may take
    """

    def __init__(self, within_s: float = WITHIN_S, memory_bytes: int = MEMORY_BYTES) -> None:
        self._within_s, self._memory_bytes = within_s, memory_bytes
        self._process: multiprocessing.process.BaseProcess | None = None
        self._line: Connection | None = None

    def __enter__(self) -> Reader:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()

    def read(self, entry: Entry) -> Submission:
        """Read a submission; where that comes to no end twice, it is one that cannot be read.

        Raises
        ------
        RequestError
            If it has gone meanwhile.
        """
        for _ in range(_ATTEMPTS):
            answer = self._answer(entry)
            if answer is not None:
                break
        if isinstance(answer, RequestError):
            raise answer
        if isinstance(answer, Submission):
            return answer
        return unread(
            entry.id, entry.name, answer or f"What was handed in could not be read within {self._within_s:g} s."
        )

    def _answer(self, entry: Entry) -> Submission | RequestError | str | None:
        """What the process says; None where it did not come to an end with it, or was killed, whoever did that."""
        line = self._line or self._start()
        try:
            line.send(entry)
            if line.poll(self._within_s):
                answer: Submission | RequestError | str = line.recv()
                return answer
        except (EOFError, OSError):
            pass
        self._end()
        return None

    def _start(self) -> Connection:
        context = multiprocessing.get_context("spawn")
        self._line, theirs = context.Pipe()
        in_main = threading.current_thread() is threading.main_thread()
        self._process = context.Process(
            target=_serve, args=(theirs, self._memory_bytes, os.getcwd(), in_main), daemon=True
        )
        with interrupts_ignored(), started_beside_no_student(), theirs:
            self._process.start()
        return self._line

    def _end(self) -> None:
        if self._line is not None:
            self._line.close()
        if self._process is not None:
            self._process.kill()
            self._process.join(_ENDED_WITHIN_S)
        self._line = self._process = None


def _serve(line: Connection, memory_bytes: int, folder: str, in_main: bool) -> None:
    begin_process(folder, in_main)
    _bound_memory(memory_bytes)
    with suppress(EOFError, OSError):  # the run is over
        while True:
            line.send(_read(line.recv()))


def _read(entry: Entry) -> Submission | RequestError | str:
    """A submission, or why there is none."""
    try:
        return entry.read()
    except RequestError as error:
        return error
    except MemoryError:
        return "What was handed in takes too much memory to be read."
    except (
        Exception
    ) as error:  # a fault of ours, and the class goes on: the instructor finds it among the unreadable ones
        return f"What was handed in could not be read ({type(error).__name__})."


def _bound_memory(most: int) -> None:
    with suppress(ImportError, OSError, ValueError):  # Windows has none of it, macOS refuses
        import resource  # noqa: PLC0415 - of POSIX only

        resource.setrlimit(resource.RLIMIT_AS, (most, most))
