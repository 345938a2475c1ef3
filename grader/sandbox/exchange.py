"""Send one request to untrusted code over a socket and receive the answer, within a time that is measured from outside."""

from __future__ import annotations

import math
import os
import selectors
import socket
from collections.abc import Callable

from . import wire

_SHORTEST_NAP_S = 0.005
_LONGEST_NAP_S = 1.0
_STOOD_S = 5.0  # between two looks at the clock: naps are far shorter, so the grader itself was stopped
_IDLE_SHARE = 0.02  # of one processor; what is starved by fifty others still gets as much
_CHUNK_BYTES = 1 << 18
_CORES = os.cpu_count() or 1


class LineClosedError(Exception):
    """Exception: the process at the other end of the socket has ended or closed the socket, so that no answer comes."""


class DeadlineError(Exception):
    """Exception: a worker's CPU time or wall-clock time is used up; `within` says in words which limit."""

    def __init__(self, within: str, cpu_s: float, wall_s: float) -> None:
        super().__init__()
        self.within = within
        self.cpu_s = cpu_s
        self.wall_s = wall_s


class Deadline:
    """Time limit of one answer: `cpu_s` seconds of CPU time, or `wall_s` idle seconds (at most 2 % of a CPU, as when code sleeps).

    After ten times `wall_s`, or `most_s` if that is less, the answer is cut off, idle or not. The functions `cpu_clock` and
    `wall_clock` return the worker's seconds so far; `wall_s` and `most_s` are measured by `wall_clock`. It leaves out (on Linux)
    waits for a processor, so that grades do not depend on how busy the machine is. Time in which the grader stood still, as after
    Ctrl-Z, does not count either.
    """

    def __init__(
        self,
        cpu_clock: Callable[[], float],
        wall_clock: Callable[[], float],
        cpu_s: float,
        wall_s: float,
        most_s: float = math.inf,
    ) -> None:
        self._cpu, self._wall = cpu_clock, wall_clock
        self._cpu_limit, self._wall_limit, self._most = cpu_s, wall_s, min(10 * wall_s, most_s)
        self._cpu_start, self._wall_start = cpu_clock(), wall_clock()
        self._seen, self._idle_s, self._stood_s = (0.0, 0.0), 0.0, 0.0

    def nap(self) -> float:
        """Return how many seconds to wait before the limits must be checked again; raise DeadlineError if a limit is exceeded."""
        cpu_s, wall_s = self._cpu() - self._cpu_start, self._wall() - self._wall_start - self._stood_s
        last_cpu_s, last_wall_s = self._seen
        if wall_s - last_wall_s > _STOOD_S:
            self._stood_s += wall_s - last_wall_s
            wall_s = last_wall_s
        if cpu_s - last_cpu_s <= _IDLE_SHARE * (wall_s - last_wall_s):
            self._idle_s += wall_s - last_wall_s
        self._seen = (cpu_s, wall_s)
        within = self._exceeded_limit(cpu_s, wall_s)
        if within:
            raise DeadlineError(within, cpu_s, wall_s)
        soonest = (self._cpu_limit - cpu_s) / _CORES  # all of its threads may run at once
        soonest = min(soonest, self._wall_limit - self._idle_s, self._most - wall_s)
        return min(max(soonest, _SHORTEST_NAP_S), _LONGEST_NAP_S)

    def _exceeded_limit(self, cpu_s: float, wall_s: float) -> str:
        """Describe the limit that is exceeded, for messages; return "" if none is."""
        if cpu_s >= self._cpu_limit:
            return f"{self._cpu_limit:g} s of CPU time"
        if self._idle_s >= self._wall_limit:
            return f"{self._wall_limit:g} s"
        return "the time that was left to it" if wall_s >= self._most else ""


def exchange(line: socket.socket, nonce: bytes, question: bytes, deadline: Deadline) -> wire.Frame:
    """Send `question`, a packed request, through the socket `line`; return the worker's answer, which must repeat the `nonce`.

    Raises
    ------
    LineClosedError
        If the other end of the socket is closed.
    DeadlineError
        If time is up.
    WireError
        If anything came before the request was sent in full, or what came is no answer to it.
    """
    with selectors.DefaultSelector() as selector:
        selector.register(line, selectors.EVENT_READ | selectors.EVENT_WRITE)
        _send(line, selector, question, deadline)
        selector.modify(line, selectors.EVENT_READ)
        incoming = wire.Incoming()
        while incoming.wanted:
            if selector.select(deadline.nap()):
                incoming.feed(_some(line, incoming.wanted))
    echoed, frame = incoming.finish()
    if echoed != nonce:
        raise wire.WireError("the answer belongs to another question")
    return frame


def _send(line: socket.socket, selector: selectors.BaseSelector, question: bytes, deadline: Deadline) -> None:
    rest = memoryview(question)
    while rest:
        for _, events in selector.select(deadline.nap()):
            if events & selectors.EVENT_READ:
                _some(line, 1)
                raise wire.WireError("an answer came before its question")
            rest = rest[_push(line, rest) :]


def _push(line: socket.socket, data: memoryview) -> int:
    try:
        return line.send(data[:_CHUNK_BYTES])
    except BlockingIOError:
        return 0
    except OSError:
        raise LineClosedError from None


def _some(line: socket.socket, wanted: int) -> bytes:
    try:
        chunk = line.recv(min(wanted, _CHUNK_BYTES))
    except BlockingIOError:
        return b""  # a wake-up for nothing
    except OSError:
        raise LineClosedError from None
    if not chunk:
        raise LineClosedError
    return chunk
