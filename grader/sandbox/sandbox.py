"""A sandbox: the place where untrusted code runs, as the grader sees it.

    with Sandbox(Contents(worker_code)) as sandbox, sandbox.worker() as worker:
        frame = worker.ask("read", {"seed": 1}, {"state": state}, cpu_s=10.0)

Whatever the code in the sandbox does, `ask` ends in a frame (the answer), in a `NoAnswer`, or, if the grader itself is at fault, in
a `GraderError`.
"""

from __future__ import annotations

import contextlib
import math
import secrets
import signal
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from grader.base.errors import Crashed, GraderError, Malformed, NoAnswer, TimedOut

from . import level_choice, surroundings, wire
from .exchange import Deadline, DeadlineError, LineClosedError, exchange
from .isolation_levels import LEVELS, NO_ISOLATION, IsolationLevel, named
from .plain import PlainProcess
from .plan import Contents
from .printed import Printed
from .process import IsolationRefusedError, Process, ZygoteGoneError

if TYPE_CHECKING:
    import numpy as np

    from .launch import Zygote

_NO_MEMORY = (
    "this machine ran out of memory, so that the kernel ended the process; grade again with fewer jobs or more memory"
)
_SIGKILL = 9  # `signal.SIGKILL`, which Windows lacks
_GRACE_S = 1.0  # for a process that hung up to end by itself, so that we learn how


class Sandbox:
    """A place for untrusted code: an isolated zygote (parent process) forks workers in milliseconds; level "none" starts each anew.

    Parameters
    ----------
    contents
        What runs in the sandbox; its worker code answers the requests.
    isolation_level
        The name of one of `LEVELS`; None for the best that this machine allows, at worst "none".

    Attributes
    ----------
    isolation_level
        The isolation level in use.
    why
        Text for reports: why no better level works and what this one lacks, "" if neither; or that this one was asked for.

    Raises
    ------
    GraderError
        If the isolation level that was asked for is unknown or cannot be had here.
    """

    def __init__(self, contents: Contents, *, isolation_level: str | None = None) -> None:
        self._contents = replace(
            contents,
            worker_code=contents.worker_code.resolve(),
            questions=contents.questions and contents.questions.resolve(),
        )
        self._workers: list[Worker] = []
        self._zygote: Zygote | None = None
        self._closed = False
        _make_undumpable()
        surroundings.compile_once([str(f) for f in (self._contents.worker_code, self._contents.questions) if f])
        if isolation_level is None:
            self._zygote, self.why = level_choice.best_zygote(self._contents)
            self.isolation_level = self._zygote.isolation_level if self._zygote else NO_ISOLATION
        else:
            self.isolation_level, self.why = _requested_level(isolation_level), f"{isolation_level} was asked for"
            self._zygote = self._start()

    def __enter__(self) -> Sandbox:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def worker(self) -> Worker:
        """Return a new worker without any state of the earlier ones. The levels `bubblewrap` and `landlock` allow four at a time.

        Raise GraderError for a fifth worker at these levels, after `close`, or if even a new zygote (parent process) forks none.
        """
        if self._closed:
            raise GraderError("the sandbox is closed")
        printed = Printed()
        try:
            worker = Worker(self._spawn(printed), printed)
        except BaseException:
            printed.close()
            raise
        self._workers = [*(known for known in self._workers if not known.closed), worker]
        return worker

    def warm(self, modules: Sequence[str]) -> None:
        """Let the zygote (the parent process), if there is one, import these modules before its next fork, for all new workers."""
        new = [name for name in modules if name not in self._contents.warm]
        self._contents = replace(self._contents, warm=(*self._contents.warm, *new))

    def close(self) -> None:
        """End every worker and the zygote (the parent process), and remove the folders that were made for them."""
        self._closed = True
        for worker in self._workers:
            worker.close()
        if self._zygote is not None:
            self._zygote.close()
            self._zygote = None

    def _start(self) -> Zygote | None:
        if not self.isolation_level.isolates:
            return None
        try:
            return level_choice.start_zygote(self.isolation_level, self._contents)
        except IsolationRefusedError as error:
            raise GraderError(
                f"this machine does not allow the isolation level {self.isolation_level.name!r}: {error}"
            ) from None

    def _spawn(self, printed: Printed) -> Process:
        if not self.isolation_level.isolates:
            return PlainProcess(self._contents, printed)
        try:
            return self._spawn_once(printed)
        except ZygoteGoneError:
            self._restart()
        try:
            return self._spawn_once(printed)
        except ZygoteGoneError as error:
            raise GraderError(f"the sandbox died twice: {error}") from None

    def _spawn_once(self, printed: Printed) -> Process:
        if self._zygote is None:
            self._zygote = self._start()
        if self._zygote is None:
            raise GraderError("the sandbox has no zygote")
        self._zygote.await_ready()
        return self._zygote.spawn(printed, self._contents.warm)

    def _restart(self) -> None:
        if self._zygote is not None:
            self._zygote.close()
        self._zygote = None


class Worker:
    """A process in the sandbox that runs untrusted code and answers requests; it is dead after `close` or one failed answer."""

    def __init__(self, process: Process, printed: Printed) -> None:
        self._process = process
        self._printed = printed
        self._text: str | None = None
        self._oom_kills = _oom_kills()
        self.alive = True

    def __enter__(self) -> Worker:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def cpu_s(self) -> float:
        """CPU seconds used since the worker was ready."""
        return self._process.cpu_s()

    @property
    def wall_s(self) -> float:
        """Wall-clock seconds since the worker was ready, without those in which it waited for a processor."""
        return self._process.wall_s()

    def ask(
        self,
        op: str,
        fields: Mapping[str, Any] | None = None,
        arrays: Mapping[str, np.ndarray] | None = None,
        *,
        cpu_s: float = 10.0,
        wall_s: float | None = None,
        most_s: float = math.inf,
    ) -> wire.Frame:
        """Send one request to the worker and return its answer.

        Parameters
        ----------
        op, fields, arrays
            What the worker code's `answer` gets: the request's name, its plain data and its arrays.
        cpu_s
            CPU seconds that the answer may take, all threads together.
        wall_s
            Idle seconds in all (at most 2 % of a CPU in use, as by code that sleeps); by default max(3 * cpu_s, cpu_s + 20).
        most_s
            Seconds that may pass in all, whatever the code does; ten times `wall_s` if that is less.

        Raises
        ------
        TimedOut, Crashed, Malformed
            If the code in the sandbox takes too long, has died or sends no valid answer; the worker is dead afterwards.
        GraderError
            If the request itself cannot be sent, the machine ran out of memory, or the sandbox itself failed.
        """
        if not self.alive:
            raise Crashed("the process had already ended")
        nonce = secrets.token_bytes(wire.NONCE_BYTES)
        question = _packed(nonce, op, fields or {}, arrays or {})
        limit = max(3 * cpu_s, cpu_s + 20) if wall_s is None else wall_s
        try:
            frame = exchange(
                self._process.line,
                nonce,
                question,
                Deadline(self._process.cpu_s, self._process.wall_s, cpu_s, limit, most_s),
            )
            return _unwrapped(frame)
        except DeadlineError as error:
            failure: NoAnswer = TimedOut(f"no answer within {error.within}", cpu_s=error.cpu_s, wall_s=error.wall_s)
        except LineClosedError:
            self.alive = False
            code = self._process.end(_GRACE_S)
            if code == -_SIGKILL and _oom_kills() > self._oom_kills:
                raise GraderError(_NO_MEMORY) from None
            failure = Crashed(_exit_in_words(code))
        except (wire.WireError, Malformed) as error:
            failure = Malformed(f"what came back is no answer: {error}")
        self._end()
        raise failure

    def printed(self) -> str:
        """Return the first 256 KB that the worker has printed (stdout and stderr); after `close`, the text up to then."""
        return self._printed.read() if self._text is None else self._text

    def place(self) -> str:
        """Return which statement the worker noted as running (see `Printed.place`), to find what killed it. Code can forge this."""
        return self._printed.place()

    def close(self) -> None:
        """Kill the worker and all that it started; what it printed can still be read."""
        self._end()
        if self._text is None:
            self._text = self._printed.read()
            self._printed.close()

    @property
    def closed(self) -> bool:
        return self._text is not None

    def _end(self) -> None:
        self.alive = False
        with contextlib.suppress(GraderError):  # the zygote is gone, and the worker with it
            self._process.end()


def _requested_level(name: str) -> IsolationLevel:
    isolation_level = named(name)
    if isolation_level is None:
        raise GraderError(f"there is no isolation level {name!r}, only {', '.join(each.name for each in LEVELS)}")
    return isolation_level


def _packed(nonce: bytes, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> bytes:
    try:
        return wire.pack(nonce, {"op": op, "fields": dict(fields)}, arrays, wire.QUESTION)
    except wire.WireError as error:
        raise GraderError(f"the question {op!r} cannot be sent: {error}") from None


def _unwrapped(frame: wire.Frame) -> wire.Frame:
    """Return the frame without the wrapping of the worker's loop; raise Malformed if it holds an error or is no answer."""
    if set(frame.fields) == {"worker_error"}:
        raise Malformed(str(frame.fields["worker_error"]))
    fields = frame.fields.get("fields")
    if set(frame.fields) != {"fields"} or not isinstance(fields, dict):
        raise Malformed("it has no fields")
    return wire.Frame(fields, frame.arrays)


def _oom_kills() -> int:
    """Return how many processes the kernel has ended for lack of memory, so that this is no crash of the code; 0 if unknown."""
    with contextlib.suppress(OSError, ValueError, StopIteration):
        lines = Path("/proc/vmstat").read_text(encoding="ascii").splitlines()
        return int(next(line for line in lines if line.startswith("oom_kill ")).split()[1])
    return 0


def _exit_in_words(code: int) -> str:
    if code >= 0:
        return f"the process ended with exit code {code} before it answered"
    try:
        name = signal.Signals(-code).name
    except ValueError:
        name = f"signal {-code}"
    return f"the process was ended by {name} before it answered"


def _make_undumpable() -> None:
    """Keep other processes of the same user out of the grader's memory, where hidden data lies: no ptrace, no /proc/PID/mem."""
    if sys.platform == "linux":
        from . import linux  # noqa: PLC0415 - of Linux only

        linux.prctl(linux.PR_SET_DUMPABLE, 0)
