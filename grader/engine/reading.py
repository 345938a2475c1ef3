"""Read submissions in a separate process that can be killed: a hostile file may block or exhaust it, and the grader goes on."""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Protocol, TypeVar

from grader.base.errors import RequestError
from grader.engine.processes import context, starting_processes
from grader.intake import Submission, read_submission
from grader.intake.names import safe_id
from grader.intake.submission import original_name, unread

WITHIN_S = 60.0
"""Time limit for reading one submission; 20 times what the largest accepted archive takes."""
_ATTEMPTS = 2
MEMORY_BYTES = 4 << 30
_LEAVES_WITHIN_S = 0.2
_ENDED_WITHIN_S = 5.0


class Readable(Protocol):
    """Protocol of a submission that was not read yet: it is pickled and sent to the reading process, which calls `read`.

    `id` and `name` become those of the unreadable submission if reading fails.
    """

    @property
    def id(self) -> str: ...

    @property
    def name(self) -> str: ...

    def read(self) -> Submission: ...


Entry = TypeVar("Entry", bound=Readable)


@dataclass(frozen=True)
class SingleSubmission:
    """A folder or file to read as one submission; by the lab's file names in `required`, `read` finds the right folder in it."""

    path: Path
    required: tuple[str, ...]

    @property
    def name(self) -> str:
        return original_name(self.path)

    @property
    def id(self) -> str:
        return safe_id(self.name)

    def read(self) -> Submission:
        return read_submission(self.path, self.required)


def read_apart(path: Path, required: tuple[str, ...]) -> Submission:
    """Read and return the submission at `path`, in a new process, so that no file can block the grader or fill its memory.

    `required` are the files that the lab asks for. If the process gives no answer, the submission counts as unreadable. Outside
    Linux no process is started: it would be slow, and people grade only their own code there, because there is no sandbox.
    """
    if sys.platform != "linux":
        return SingleSubmission(path, required).read()
    with ReadingProcess() as reader:
        return reader.read(SingleSubmission(path, required))


class ReadingProcess:
    """A process that reads the files of one submission after the other, and runs none; it is replaced if it had to be killed.

    Parameters
    ----------
    within_s : seconds for one submission, after which the process is killed
    memory_bytes : limit of the process's memory
    """

    def __init__(self, within_s: float = WITHIN_S, memory_bytes: int = MEMORY_BYTES) -> None:
        self._within_s, self._memory_bytes = within_s, memory_bytes
        self._process: multiprocessing.process.BaseProcess | None = None
        self._line: Connection | None = None

    def __enter__(self) -> ReadingProcess:
        return self

    def __exit__(self, *raised: object) -> None:
        self._end()

    def read(self, entry: Readable) -> Submission:
        """Read and return a submission; after two attempts without an answer, return one that counts as unreadable.

        Raises
        ------
        RequestError
            If the submission's file has disappeared.
        """
        return next(self.each([entry]))[1]

    def each(self, entries: Iterable[Entry]) -> Iterator[tuple[Entry, Submission]]:
        """Yield each entry with its submission, as `read` returns it; while the caller works on one, the next one is read."""
        following = iter(entries)
        entry = next(following, None)
        if entry is not None:
            self._ask(entry)
        while entry is not None:
            submission, read = self._receive_submission(entry), entry
            entry = next(following, None)
            if entry is not None:
                self._ask(entry)
            yield read, submission

    def _receive_submission(self, entry: Readable) -> Submission:
        """Return the submission that was asked for; an unreadable one after two attempts without an answer.

        A RequestError that reading raised is raised here.
        """
        answer = self._receive()
        for _ in range(_ATTEMPTS - 1):
            if answer is None:
                self._ask(entry)
                answer = self._receive()
        if isinstance(answer, RequestError):
            raise answer
        if isinstance(answer, Submission):
            return answer
        return unread(
            entry.id, entry.name, answer or f"What was handed in could not be read within {self._within_s:g} s."
        )

    def _ask(self, entry: Readable) -> None:
        line = self._line or self._start()
        with suppress(OSError):  # the process has ended: `_receive` finds no answer
            line.send(entry)

    def _receive(self) -> Submission | RequestError | str | None:
        """Return what the process sends; None if it was too slow or was killed, and then the process is ended."""
        with suppress(EOFError, OSError):
            if self._line is not None and self._line.poll(self._within_s):
                answer: Submission | RequestError | str = self._line.recv()
                return answer
        self._end()
        return None

    def _start(self) -> Connection:
        """Start the reading process, and return the connection to it."""
        start = context()
        self._line, theirs = start.Pipe()
        copied = (self._line,) if start.get_start_method() == "fork" else ()
        with starting_processes() as begin, theirs:
            process = start.Process(target=_serve, args=(theirs, copied, self._memory_bytes, begin), daemon=True)
            process.start()
        self._process = process
        return self._line

    def _end(self) -> None:
        """Close the connection, and kill the process if it does not end by itself."""
        if self._line is not None:
            self._line.close()
        if self._process is not None:
            self._process.join(_LEAVES_WITHIN_S)  # it sees that the pipe is closed, unless it is busy
            if self._process.is_alive():
                self._process.kill()
                self._process.join(_ENDED_WITHIN_S)
        self._line = self._process = None


def _serve(line: Connection, copied: Iterable[Connection], memory_bytes: int, begin: Callable[[], None]) -> None:
    """Read the submissions that the parent sends, in the child process, until the parent closes the connection."""
    for end in copied:  # a copy of the parent's end: while it is open, the pipe does not close
        end.close()
    begin()
    _bound_memory(memory_bytes)
    with suppress(EOFError, OSError):  # the run is over
        while True:
            line.send(_read(line.recv()))


def _read(entry: Readable) -> Submission | RequestError | str:
    """Return the submission; a RequestError for the parent to raise; or the reason, as text, why it cannot be read."""
    try:
        return entry.read()
    except RequestError as error:
        return error
    except MemoryError:
        return "What was handed in takes too much memory to be read."
    except Exception as error:  # the grader failed; the instructor finds the submission among the unreadable ones
        return f"What was handed in could not be read ({type(error).__name__})."


def _bound_memory(most: int) -> None:
    with suppress(ImportError, OSError, ValueError):  # Windows has no limits, macOS refuses them
        import resource  # noqa: PLC0415 - POSIX only

        resource.setrlimit(resource.RLIMIT_AS, (most, most))
