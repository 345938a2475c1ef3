"""The loop of a worker: read a request from the socket, let the worker code answer it, until the socket is closed.

The loop is the same on every isolation level and every system. It runs in one process with the student's code: nothing here is a
secret, and nobody believes what it sends.
"""

from __future__ import annotations

import io
import os
import socket
import sys
from collections.abc import Callable, Mapping
from typing import Any

from . import arrays, wire  # noqa: F401 - of the wire: here, before the first worker is forked

Answer = Callable[[str, dict[str, Any], dict[str, Any]], tuple[Mapping[str, Any], Mapping[str, Any]]]

NO_NONCE = bytes(wire.NONCE_BYTES)
MAX_PRINTED_BYTES = 256 << 10
_CHUNK_BYTES = 1 << 18


def run(line: socket.socket, answer: Answer) -> None:
    """Report that the worker is ready, then send what `answer` returns for each request, until the grader closes the socket `line`.

    An exception in `answer` is sent as a text in place of the reply.
    """
    line.sendall(wire.pack(NO_NONCE, {"ready": True}, {}))
    while (question := _receive(line)) is not None:
        nonce, frame = question
        line.sendall(_reply(nonce, frame, answer))


def refuse_questions(line: socket.socket, reason: str) -> None:
    """Tell the grader through `line`, in place of `run`, why the worker could not be set up; the caller then ends the process."""
    line.sendall(wire.pack(NO_NONCE, {"ready": False, "reason": reason}, {}))


def _receive(line: socket.socket) -> tuple[bytes, wire.Frame] | None:
    incoming = wire.Incoming(wire.QUESTION)
    while incoming.wanted:
        chunk = line.recv(min(incoming.wanted, _CHUNK_BYTES))
        if not chunk:
            return None
        incoming.feed(chunk)
    return incoming.finish()


def _reply(nonce: bytes, frame: wire.Frame, answer: Answer) -> bytes:
    try:
        fields, arrays = answer(frame.fields["op"], frame.fields["fields"], frame.arrays)
        # half a character, as a file name or a title may hold, is no fault of the file that it stands in
        return wire.pack(nonce, {"fields": dict(fields)}, arrays, errors="replace")
    except BaseException as error:  # the worker code catches the student's own; this one slipped past it
        return wire.pack(nonce, {"worker_error": _described(error)}, {})


def _described(error: BaseException) -> str:
    """Return an error as text for the grader; only its type if `__repr__`, which may be student code, fails."""
    try:
        text = str(repr(error))
    except BaseException:
        text = type(error).__name__
    return text[:2000].encode("utf-8", "backslashreplace").decode("utf-8")


class _Printed(io.RawIOBase):
    """Standard output that takes everything and keeps the first 256 KB, because a full file is no error of the student's."""

    def __init__(self, fd: int, budget: list[int]) -> None:
        self._fd = fd
        self._budget = budget  # shared by both streams: bytes that are still kept

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._fd

    def write(self, data: Any, /) -> int:
        view = memoryview(data).cast("B")
        kept = view[: max(self._budget[0], 0)]
        self._budget[0] -= len(kept)
        try:
            while kept:
                kept = kept[os.write(self._fd, kept) :]
        except OSError:
            self._budget[0] = 0
        return len(view)


def take_streams() -> None:
    """Make print() write to descriptors 1 and 2 without delay, so that the grader can read the output even after a crash."""
    budget = [MAX_PRINTED_BYTES]
    sys.stdout, sys.stderr = _stream(1, budget), _stream(2, budget)
    vars(sys).update(__stdout__=sys.stdout, __stderr__=sys.stderr)


def _stream(fd: int, budget: list[int]) -> io.TextIOWrapper:
    raw: Any = _Printed(fd, budget)
    return io.TextIOWrapper(raw, encoding="utf-8", errors="backslashreplace", newline="\n", write_through=True)
