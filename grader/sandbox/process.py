"""What a worker needs of the process behind it, whatever started that process."""

from __future__ import annotations

import socket
import threading
from typing import Protocol


def is_main_thread() -> bool:
    """Whether the kernel may end a child with this thread: it knows no other parent, and other threads may end."""
    return threading.current_thread() is threading.main_thread()


class WallsRefusedError(Exception):
    """This machine does not allow these walls; the reason in words."""


class ZygoteGoneError(Exception):
    """The zygote died, or was killed before its walls were up."""


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

    def end(self, grace_s: float = 0.0) -> int:
        """Kill everything that it started, once it has had a moment to end by itself; how it ended, as Popen says it.

        Raises
        ------
        GraderError
            If nobody can tell any more.
        """
