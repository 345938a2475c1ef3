"""The interface of a worker's process, independent of how it was started."""

from __future__ import annotations

import contextlib
import os
import socket
import threading
import time
from typing import Protocol


def is_main_thread() -> bool:
    """Return whether this is the main thread, to which the kernel may tie a child's end: other threads may end earlier."""
    return threading.current_thread() is threading.main_thread()


class IsolationRefusedError(Exception):
    """Exception: the kernel refuses an isolation step of this level; the message is the reason."""


class ZygoteGoneError(Exception):
    """Exception: the zygote (the warm parent) died, or was killed before it was isolated."""


class WallClock:
    """Wall clock of a process that, on Linux, leaves out the time in which the process waits for a CPU.

    So a busy machine does not use up the time limit, and code that sleeps does.
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
        """Return the seconds since the clock was created. It never runs backwards, although the kernel reports a wait late."""
        self._read_s = max(self._read_s, self._now() - self._began)
        return self._read_s


def _small_file(path: str) -> bytes:
    """Return up to 256 bytes of a file. It is read a hundred times per submission, and `open` takes twice as long."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        return os.read(descriptor, 256)
    finally:
        os.close(descriptor)


class Process(Protocol):
    """Handle of a worker process that runs untrusted code.

    Attributes
    ----------
    line
        Non-blocking socket to the process.
    """

    line: socket.socket

    def cpu_s(self) -> float:
        """Return the CPU seconds used since the process was ready (wall-clock seconds if the system does not report them)."""

    def wall_s(self) -> float:
        """Return the seconds of its `WallClock` since the process was ready."""

    def end(self, grace_s: float = 0.0) -> int:
        """Wait `grace_s` seconds for the process to end by itself, kill it and its children, and return its exit code.

        The exit code is that of `subprocess.Popen`: negative for a signal.

        Raises
        ------
        GraderError
            If the exit code cannot be found out any more.
        """
