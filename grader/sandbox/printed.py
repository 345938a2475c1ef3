"""Capture a worker's stdout and stderr in a memory file of fixed size, so that a flood of output costs nothing."""

from __future__ import annotations

import os
import sys
import tempfile
from typing import Any

MAX_BYTES = 256 << 10
PLACE_AT, PLACE_BYTES = MAX_BYTES, 1 << 10
"""Room behind what is printed, in which a worker writes down where it is, for the case that it does not come back."""


class Printed:
    """Output of one worker: stdout and stderr as one text, and a note of the student's statement that is running, in case it dies.

    Attributes
    ----------
    fd
        Descriptor of the file that the worker gets as stdout and stderr.
    """

    def __init__(self) -> None:
        self._file: Any = _sealed_memory() if sys.platform == "linux" else _unnamed_file()
        self.fd: int = self._file.fileno()

    def read(self) -> str:
        """Return the first 256 KB that the worker has printed (the rest is lost), undecodable bytes replaced; "" after `close`."""
        if self._file.closed:
            return ""
        # The offset is shared with the worker, which may have moved it: clamped, and never moved here.
        size = max(0, min(os.lseek(self.fd, 0, os.SEEK_CUR), MAX_BYTES))
        return _read_start(self.fd, size).decode("utf-8", "replace")

    def place(self) -> str:
        """Return the worker's note of the running statement, JSON: [[file, number of the statement]], or [] between statements.

        The number identifies a statement in its file (top-level ones count from 0). While one imports another file, the note is of
        that file. Before the first statement the text is no JSON, and after `close` or on Windows it is ""; callers ignore both.
        """
        if self._file.closed or not hasattr(os, "pread"):
            return ""
        return os.pread(self.fd, PLACE_BYTES, PLACE_AT).decode("utf-8", "replace")

    def close(self) -> None:
        self._file.close()


def _sealed_memory() -> Any:
    """Return a memory file of fixed size, so that a worker that writes too much gets an error and fills nothing."""
    import fcntl  # noqa: PLC0415 - not on every system

    fd = os.memfd_create("printed", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
    os.ftruncate(fd, PLACE_AT + PLACE_BYTES)
    fcntl.fcntl(fd, fcntl.F_ADD_SEALS, fcntl.F_SEAL_GROW | fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_SEAL)
    return os.fdopen(fd, "r+b", buffering=0)


def _unnamed_file() -> Any:
    return tempfile.TemporaryFile(buffering=0)


def _read_start(fd: int, size: int) -> bytes:
    if hasattr(os, "pread"):
        return os.pread(fd, size, 0)
    here = os.lseek(fd, 0, os.SEEK_CUR)  # Windows
    os.lseek(fd, 0, os.SEEK_SET)
    data = os.read(fd, size)
    os.lseek(fd, here, os.SEEK_SET)
    return data
