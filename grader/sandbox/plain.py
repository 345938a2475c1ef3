"""The lowest isolation level: a new process for every worker, with time limits and no isolation, on any system.

It is for one's own code on one's own machine, and needs nothing of POSIX that Windows lacks.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from typing import Any

from grader.base.errors import GraderError

from . import surroundings, wire
from .paths import empty_folder
from .plan import Contents
from .printed import Printed
from .process import WallClock, is_main_thread

_READY_WITHIN_S = 300.0


class PlainProcess:
    """Handle of a worker process of the level `none`, which has limits only; its methods are those of `process.Process`.

    Making a handle starts the process; GraderError is raised if the worker code does not start.
    """

    def __init__(self, contents: Contents, printed: Printed) -> None:
        self._code: int | None = None
        self._cpu_s = self._wall_s = self._before_s = 0.0
        self._place = os.path.realpath(tempfile.mkdtemp(prefix="imugrade-"))
        self.line, theirs = socket.socketpair()
        try:
            with theirs:
                self._popen = self._start(contents, theirs, printed)
            self._started = time.monotonic()
            self._await_hello(printed)
            self._before_s = self._clock()
            self._wall = WallClock(self._popen.pid)
        except BaseException:
            self._discard()
            raise

    def _start(self, contents: Contents, theirs: socket.socket, printed: Printed) -> subprocess.Popen[bytes]:
        search = surroundings.search_without_isolation()
        folders = [str(folder) for folder in (contents.worker_code, contents.questions) if folder]
        plan = {"folders": folders, "search": search, "end_with_parent": is_main_thread()}
        inherited: dict[str, Any] = {"pass_fds": (theirs.fileno(),), "start_new_session": True}
        if sys.platform == "win32":
            inherited = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
        scratch, fonts = os.path.join(self._place, "scratch"), os.path.join(self._place, "matplotlib")
        os.mkdir(scratch)
        _copy_font_lists(fonts)
        popen = subprocess.Popen(
            [sys.executable, "-B", "-s", surroundings.zygote(), "--plain", str(theirs.fileno()), json.dumps(plan)],
            stdin=subprocess.PIPE,
            stdout=printed.fd,
            stderr=printed.fd,
            cwd=scratch,
            env=_environment(scratch, fonts),
            **inherited,
        )
        with contextlib.suppress(OSError):
            if popen.stdin is not None:
                popen.stdin.write(_socket_as_bytes(theirs, popen.pid))
                popen.stdin.close()
        return popen

    def _await_hello(self, printed: Printed) -> None:
        self.line.settimeout(_READY_WITHIN_S)
        incoming = wire.Incoming()
        try:
            while incoming.wanted:
                chunk = self.line.recv(incoming.wanted)
                if not chunk:
                    raise GraderError(f"the worker code did not start: {printed.read()[-2000:]}")
                incoming.feed(chunk)
            _, frame = incoming.finish()
        except (OSError, wire.WireError) as error:
            raise GraderError(f"a worker did not get ready: {error}") from None
        if not frame.fields.get("ready"):
            raise GraderError(f"the worker code did not start: {frame.fields.get('reason')}")
        self.line.setblocking(False)

    def _clock(self) -> float:
        """Return the process's CPU seconds on Linux; other systems do not tell them, so there the wall-clock seconds."""
        if sys.platform == "linux":
            return time.clock_gettime((~self._popen.pid << 3) | 2)
        return time.monotonic() - self._started

    def cpu_s(self) -> float:
        if self._code is None:
            with contextlib.suppress(OSError):
                self._cpu_s = self._clock() - self._before_s
        return self._cpu_s

    def wall_s(self) -> float:
        if self._code is None:
            self._wall_s = self._wall.read()
        return self._wall_s

    def end(self, grace_s: float = 0.0) -> int:
        if self._code is not None:
            return self._code
        self.cpu_s()
        self.wall_s()
        self.line.close()
        _wait_without_reaping(self._popen, grace_s)
        self._discard()
        self._code = self._popen.returncode
        return self._code

    def _discard(self) -> None:
        self.line.close()
        popen = getattr(self, "_popen", None)
        if popen is not None:
            _kill_group(popen)
        with contextlib.suppress(OSError):
            empty_folder(self._place)
            os.rmdir(self._place)


def _wait_without_reaping(popen: subprocess.Popen[bytes], seconds: float) -> None:
    """Wait until the process has ended, at most `seconds`, and keep its pid from being given away: its group is killed by it."""
    deadline = time.monotonic() + seconds
    if not hasattr(os, "waitid"):  # macOS and Windows: a moment must do
        time.sleep(min(seconds, 0.05))
        return
    while os.waitid(os.P_PID, popen.pid, os.WEXITED | os.WNOWAIT | os.WNOHANG) is None and time.monotonic() < deadline:
        time.sleep(0.002)


def _kill_group(popen: subprocess.Popen[bytes]) -> None:
    if hasattr(os, "killpg"):
        with contextlib.suppress(OSError):  # all of it is gone
            os.killpg(popen.pid, signal.SIGKILL)
    popen.kill()
    popen.wait()


def _socket_as_bytes(theirs: socket.socket, pid: int) -> bytes:
    """Return the bytes from which a child on Windows opens the socket; b"" elsewhere, where the child inherits the socket."""
    if sys.platform == "win32":
        return theirs.share(pid)
    return b""


def _copy_font_lists(folder: str) -> None:
    """Copy matplotlib's lists of fonts to a new folder; without them it searches the fonts, which may take many seconds."""
    os.mkdir(folder)
    with contextlib.suppress(OSError):
        for path in surroundings.font_lists():
            shutil.copy(path, folder)


def _environment(scratch: str, cache: str) -> dict[str, str]:
    environment = surroundings.environment(scratch, cache)
    if sys.platform == "win32":  # Python does not start without, or does not find its libraries
        environment.update({name: os.environ.get(name, "") for name in ("SYSTEMROOT", "WINDIR", "PATH")})
        environment.update(TEMP=scratch, TMP=scratch, USERPROFILE=scratch)
    return environment
