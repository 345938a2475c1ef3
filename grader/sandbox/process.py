"""The interface of a worker's process, whichever isolation level started it, and the errors of starting one."""

from __future__ import annotations

import contextlib
import os
import socket
import threading
import time
from typing import Protocol


def is_main_thread() -> bool:
    """Return whether this is the main thread. Another thread ends early, and a child set to die with it would die too soon."""
    return threading.current_thread() is threading.main_thread()


class IsolationRefusedError(Exception):
    """Exception: this machine does not allow an isolation level, so that another one must be used; the message is the reason."""


class ZygoteGoneError(Exception):
    """Exception: the zygote (the parent process of the workers) has died, so that a new one must be started."""


class WallClock:
    """Wall clock of another process; on Linux without its waits for a CPU, so that a busy machine uses up no time limit."""

    def __init__(self, pid: int) -> None:
        self._waits = f"/proc/{pid}/schedstat"
        self._waited_s = self._read_s = 0.0
        self._began = self._now()

    def _now(self) -> float:
        with contextlib.suppress(OSError, ValueError, IndexError):
            self._waited_s = int(_small_file(self._waits).split()[1]) / 1e9
        return time.monotonic() - self._waited_s

    def read(self) -> float:
        """Return the seconds since this clock was created, on Linux without its process's waits for a CPU; they never decrease."""
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
    """Protocol of the handle of a worker process that runs untrusted code: what `Worker` needs, on any isolation level.

    Attributes
    ----------
    line
        Non-blocking socket for requests to the process and its answers.
    """

    line: socket.socket

    def cpu_s(self) -> float:
        """Return the CPU seconds used since the process was ready (wall-clock seconds if the system does not report them)."""

    def wall_s(self) -> float:
        """Return the seconds since the process was ready, without those in which it waited for a CPU (see `WallClock`)."""

    def end(self, grace_s: float = 0.0) -> int:
        """Wait `grace_s` seconds for the process to end by itself, kill it and its children, and return its exit code.

        The exit code is that of `subprocess.Popen`: negative for a signal. Raise GraderError if it cannot be found out any more.
        """
