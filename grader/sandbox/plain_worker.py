"""The worker's side of the isolation level `none`: a process without isolation that answers requests as all workers do."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import sys
import tempfile
import traceback
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any


def start(arguments: Sequence[str]) -> Callable[[], None]:
    """Set up an unisolated worker; return the function that answers requests until the socket is closed.

    `arguments` are the socket's descriptor and a JSON object: ``folders`` of worker code, ``search`` (the `sys.path`), and
    ``end_with_parent``, whether the kernel kills the worker when the thread that started it ends.
    """
    line, plan = _line(int(arguments[0])), json.loads(arguments[1])
    sys.argv[:] = [""]
    sys.path[:] = plan["search"]  # packages may lie where only the grader's own environment says
    from . import worker  # noqa: PLC0415 - it pulls numpy
    from .imports import load_worker_code  # noqa: PLC0415

    if sys.platform == "linux" and plan["end_with_parent"]:
        from .namespaces import die_with_parent  # noqa: PLC0415 - of Linux only

        die_with_parent()
    try:
        answer = load_worker_code(plan["folders"], plan["search"])
    except Exception:
        worker.refuse_questions(line, traceback.format_exc(limit=-4)[-4000:])
        os._exit(1)
    tempfile.tempdir = None
    _limit()
    worker.take_streams()
    return partial(_work, line, answer)


def _line(fd: int) -> socket.socket:
    given = sys.stdin.buffer.read()
    if sys.platform == "win32":
        return socket.fromshare(given)
    return socket.socket(fileno=fd)


def _limit() -> None:
    with contextlib.suppress(ImportError):  # Windows
        from . import limits  # noqa: PLC0415 - of POSIX only

        limits.enforce(leave_out=("RLIMIT_NPROC",))


def _work(line: socket.socket, answer: Any) -> None:
    from . import worker  # noqa: PLC0415 - see start

    worker.run(line, answer)
    os._exit(0)
