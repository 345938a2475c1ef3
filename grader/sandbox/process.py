"""The interface of a worker's process, independent of how it was started."""

from __future__ import annotations

import contextlib
import os
import socket
import threading
import time
from typing import Protocol


def is_main_thread() -> bool:
    """Return whether this is the main thread, with which the kernel may end a child: other threads may end earlier."""
    return threading.current_thread() is threading.main_thread()


class WallsRefusedError(Exception):
    """This machine does not allow these walls; the reason in words."""


class ZygoteGoneError(Exception):
    """The zygote died, or was killed before its walls were up."""


class WallClock:
    """The time that passes for a process: what it waits for a processor does not count, where the system tells of it (Linux).

    Without that, a busy machine could not be told from code that sleeps.
    """

    def __init__(self, pid: int) -> None:
        self._waits = f"/proc/{pid}/schedstat"
        self._waited_s = self._read_s = 0.0
        self._began = self._now()

    def _now(self) -> float:
        with contextlib.suppress(OSError, ValueError, IndexError):
            self._waited_s = int(_small_file(self._waits).split()[1]) / 1e9
        return time.monotonic() - self._waited_s

    def read(self) -> float:
        """Seconds since it was made; never fewer than it said before, though a wait for a processor is told when it is over."""
        self._read_s = max(self._read_s, self._now() - self._began)
        return self._read_s


def _small_file(path: str) -> bytes:
    """The first bytes of a file that is asked for a hundred times a submission: `open` takes twice as long."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        return os.read(descriptor, 256)
    finally:
        os.close(descriptor)


class Process(Protocol):
    """A process of untrusted code, held from outside.

    Attributes
    ----------
    line
        Non-blocking; its other end is the process's.
    """

    line: socket.socket

    def cpu_s(self) -> float:
        """CPU seconds that it has used since it was ready (wall seconds where a system cannot tell)."""

    def wall_s(self) -> float:
        """Seconds on the clock since it was ready, see `WallClock`."""

    def end(self, grace_s: float = 0.0) -> int:
        """Kill everything that it started, once it has had a moment to end by itself; how it ended, as Popen says it.

        Raises
        ------
        GraderError
            If nobody can tell any more.
        """
