"""Start a zygote (the parent process) and ask it for workers: the grader's end of the control socket."""

from __future__ import annotations

import contextlib
import json
import os
import select
import shutil
import signal
import socket
import stat
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from grader.base.errors import GraderError

from . import bubblewrap, namespaces, rootfs, surroundings, wire
from .isolation_levels import IsolationLevel
from .paths import empty_folder
from .plan import Contents, Plan
from .printed import Printed
from .process import IsolationRefusedError, WallClock, ZygoteGoneError, is_main_thread

_ISOLATED_WITHIN_S = 60.0
_READY_WITHIN_S = 300.0
_WORKER_WITHIN_S = 60.0
_END_WITHIN_S = 30.0
_MAX_MESSAGE = 1 << 20
_SCRATCH_FOLDERS = 4
_PACKAGES = "packages"  # on the isolation level without a root of its own: links to the packages that are shown
_KILLED = (-signal.SIGKILL, signal.SIGKILL, 128 + signal.SIGKILL)  # itself; what serve and bwrap make of their child's
_UCRED = struct.Struct("3i")


class Zygote:
    """Handle of a zygote, parent process of workers. Making it starts and isolates the zygote; `await_ready` awaits the imports.

    Raises
    ------
    IsolationRefusedError
        If the kernel refuses the isolation, or it does not hold when tried from inside.
    ZygoteGoneError
        If the zygote was killed before it was isolated, which says nothing about the machine.
    """

    def __init__(self, isolation_level: IsolationLevel, contents: Contents) -> None:
        self.isolation_level = isolation_level
        self.without_landlock = False
        self._lock = threading.RLock()
        self._ready = False
        self._count = 0
        self._spawned: dict[int, int] = {}
        self._ended: dict[int, tuple[int, float]] = {}
        self._refused: dict[int, str] = {}
        self._folder: str | None = None
        self._log = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the zygote
        self._control, self._process = self._start(contents)
        try:
            self._await_isolation()
        except BaseException:
            self.close()
            raise

    @property
    def pid(self) -> int:
        """Id of the process that the grader started for the zygote; when it ends, the zygote and all its workers end, too."""
        return self._process.pid

    # Starting

    def _start(self, contents: Contents) -> tuple[socket.socket, subprocess.Popen[bytes]]:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        process: subprocess.Popen[bytes] | None = None
        try:
            uid = {} if self.isolation_level.own_namespaces else _harmless_uid(_needed(contents))
            scratch, cache = self._folders(uid, contents.packages)
            command = [sys.executable, "-B", "-s", surroundings.zygote(), str(theirs.fileno())]
            if self.isolation_level.program:
                command = bubblewrap.command(self._plan(contents, uid, scratch, cache), theirs.fileno())
            process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=self._log,
                stderr=self._log,
                env=surroundings.environment(scratch[0], cache),
                cwd="/",
                pass_fds=(theirs.fileno(),),
                start_new_session=True,
                **uid,
            )
            # Made while Python starts: what to show takes as long to find out.
            message = self._plan(contents, uid, scratch, cache).packed()
        except BaseException:
            ours.close()
            if process is not None:
                process.kill()
                process.wait()
            self._discard()
            raise
        finally:
            theirs.close()
        ours.settimeout(_ISOLATED_WITHIN_S)
        with contextlib.suppress(OSError):
            ours.send(message)
        return ours, process

    def _plan(self, contents: Contents, uid: dict[str, Any], scratch: tuple[str, ...], cache: str) -> Plan:
        visible = surroundings.visible(contents.readable, contents.packages)
        search = surroundings.search(visible)
        if self._folder is not None:
            search = surroundings.search_by_links(visible, os.path.join(self._folder, _PACKAGES))
            visible = (*visible, os.path.join(self._folder, _PACKAGES))
        return Plan(
            isolation_level=self.isolation_level,
            worker_code=str(contents.worker_code.resolve()),
            questions=str(contents.questions.resolve()) if contents.questions else "",
            visible=visible,
            hidden=surroundings.hidden(),
            code=surroundings.code(),
            search=search,
            warm=contents.warm,
            thorough=contents.thorough,
            fonts=tuple(path for path in surroundings.font_lists() if not uid or _open_to_all(path)),
            scratch=scratch,
            cache=cache,
            decoy=surroundings.decoy(),
            # Where there are folders to remove it must not be killed: it ends when the control socket closes.
            end_with_parent=self.isolation_level.own_root and is_main_thread(),
        )

    def _folders(self, uid: dict[str, Any], libraries: tuple[str, ...]) -> tuple[tuple[str, ...], str]:
        """Return the scratch folders, where workers run, and the cache folder; make them if the sandbox has no root of its own."""
        names = [rootfs.SCRATCH, *(f"{rootfs.SCRATCH}{number}" for number in range(2, _SCRATCH_FOLDERS + 1))]
        if self.isolation_level.own_root:
            return tuple(names[:1] if self.isolation_level.own_namespaces else names), rootfs.CACHE
        self._folder = os.path.realpath(tempfile.mkdtemp(prefix="imugrade-"))
        os.chmod(self._folder, 0o711)
        folders = [self._folder + name for name in names]
        cache = self._folder + rootfs.CACHE
        surroundings.link_packages(os.path.join(self._folder, _PACKAGES), libraries)
        for path in (*folders, cache):
            os.mkdir(path, 0o700)
        with contextlib.suppress(OSError):
            for font_list in surroundings.font_lists():
                shutil.copyfile(font_list, os.path.join(cache, os.path.basename(font_list)))
        if uid:
            _change_owner(self._folder, uid["user"], uid["group"])
        return tuple(folders), cache

    def _await_isolation(self) -> None:
        message, _ = self._receive(_ISOLATED_WITHIN_S)
        if message is None and self._was_killed():
            raise ZygoteGoneError("it was killed before it was isolated")
        if message is None:
            raise IsolationRefusedError(self._log_tail() or "the process ended without a word")
        if not message.get("isolated"):
            raise IsolationRefusedError(str(message.get("reason")))
        self.without_landlock = bool(message.get("without_landlock"))

    def _was_killed(self) -> bool:
        """Return whether the zygote, or its child in a pid namespace, was ended with SIGKILL, as when memory runs out."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            return self._process.wait(1.0) in _KILLED
        return False

    def await_ready(self) -> None:
        """Wait until the zygote has imported all libraries and the worker code (ours, which runs student code) has warmed up.

        Raises
        ------
        ZygoteGoneError
            If the zygote died during the imports.
        GraderError
            If an import failed; the message holds its error.
        """
        with self._lock:
            if self._ready:
                return
            message, _ = self._receive(_READY_WITHIN_S)
            if message is None:
                raise ZygoteGoneError(f"it did not start: {self._log_tail() or 'it ended without a word'}")
            if not message.get("ready"):
                raise GraderError(f"the worker code did not start: {message.get('reason')}")
            self._ready = True

    def _log_tail(self) -> str:
        """Return the last 2,000 bytes of what the zygote printed, for error messages."""
        self._log.seek(0)
        return self._log.read()[-2000:].decode("utf-8", "replace").strip()

    # Talking

    def _receive(self, within_s: float) -> tuple[dict[str, Any] | None, list[int]]:
        """Return the zygote's next message and its descriptors; None and [] if it has ended or sends none in time."""
        self._control.settimeout(within_s)
        try:
            data, fds, _, _ = socket.recv_fds(self._control, _MAX_MESSAGE, 1)
        except OSError:
            return None, []
        return (json.loads(data) if data else None), list(fds)

    def _await_report(self, table: dict[int, Any], number: int, within_s: float) -> None:
        """Read the zygote's messages until worker `number` is in `table` or refused; raise ZygoteGoneError if neither comes."""
        deadline = time.monotonic() + within_s
        while number not in table and number not in self._refused:
            message, fds = self._receive(max(0.01, deadline - time.monotonic()))
            if message is None:
                raise ZygoteGoneError(self._log_tail())
            if "spawned" in message:
                self._spawned[message["spawned"]] = fds[0]
            elif "ended" in message:
                self._ended[message["ended"]] = message["code"], message["cpu_s"]
            elif "failed" in message:
                self._refused[message["failed"]] = message["reason"]

    def spawn(self, printed: Printed, warm: Sequence[str]) -> Sandboxed:
        """Let the zygote import modules of `warm` that it lacks, and fork a worker that prints into `printed`; return its handle.

        Raises
        ------
        ZygoteGoneError
            If the zygote is gone.
        GraderError
            If the zygote cannot fork a worker.
        """
        ours, theirs = socket.socketpair()
        try:
            with self._lock, theirs:
                self._count += 1
                number = self._count
                ours.setsockopt(socket.SOL_SOCKET, socket.SO_PASSCRED, 1)  # the kernel then tells the worker's pid
                self._send(json.dumps({"spawn": number, "warm": warm}).encode(), [theirs.fileno(), printed.fd])
                self._await_report(self._spawned, number, _WORKER_WITHIN_S)
            if number in self._refused:
                raise GraderError(f"no worker could be started: {self._refused.pop(number)}")
            return Sandboxed(self, number, self._spawned.pop(number), ours)
        except BaseException:
            ours.close()
            raise

    def _send(self, message: bytes, fds: list[int]) -> None:
        try:
            socket.send_fds(self._control, [message], fds)
        except OSError:
            raise ZygoteGoneError(self._log_tail()) from None

    def await_end(self, number: int) -> tuple[int, float]:
        """Wait for the zygote's report that a worker has ended; return its exit code (negative for a signal) and its CPU seconds.

        The caller has killed the worker before. Its `number` counts from 1, in the order of `spawn`. Raise ZygoteGoneError if no
        report comes within 30 s, or if the zygote ends first.
        """
        with self._lock:
            self._await_report(self._ended, number, _END_WITHIN_S)
            return self._ended.pop(number)

    # Ending

    def close(self) -> None:
        """End the zygote and all its workers, and remove the folders that were made for them."""
        self._control.close()
        try:
            self._process.wait(_END_WITHIN_S if self._ready else 0.5)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._discard()

    def _discard(self) -> None:
        self._log.close()
        if self._folder is not None:
            with contextlib.suppress(OSError):
                empty_folder(self._folder)
                os.rmdir(self._folder)


class Sandboxed:
    """Handle of a worker that the zygote (parent process) forked, to measure and end the worker as `process.Process` describes."""

    def __init__(self, zygote: Zygote, number: int, pidfd: int, line: socket.socket) -> None:
        self.line = line
        self._zygote = zygote
        self._number = number
        self._pidfd = pidfd
        self._code: int | None = None
        self._cpu_s = self._wall_s = 0.0
        self._clock: WallClock | None = None
        try:
            self._pid = _await_hello(line)
            self._before_s = time.clock_gettime(_cpu_clock(self._pid))
            self._clock = WallClock(self._pid)
        except BaseException:
            self.end()
            raise

    def cpu_s(self) -> float:
        if self._code is None:
            with contextlib.suppress(OSError):  # it has just been reaped
                self._cpu_s = time.clock_gettime(_cpu_clock(self._pid)) - self._before_s
        return self._cpu_s

    def wall_s(self) -> float:
        if self._code is None and self._clock is not None:
            self._wall_s = self._clock.read()
        return self._wall_s

    def end(self, grace_s: float = 0.0) -> int:
        if self._code is not None:
            return self._code
        self.wall_s()
        self.line.close()
        _wait_for(self._pidfd, grace_s)
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(self._pidfd, signal.SIGKILL)
        self._code = -signal.SIGKILL
        os.close(self._pidfd)
        try:
            self._code, total_s = self._zygote.await_end(self._number)
        except ZygoteGoneError as error:
            raise GraderError(f"the sandbox is gone: {error}") from None
        self._cpu_s = max(self._cpu_s, total_s - getattr(self, "_before_s", 0.0))
        return self._code


def _await_hello(line: socket.socket) -> int:
    """Wait until the worker is isolated; return its pid as this process sees it, by which its CPU time is measured.

    The worker speaks before the student's code is there, so that this may be believed. Raise GraderError if it does not.
    """
    line.settimeout(_WORKER_WITHIN_S)
    incoming = wire.Incoming()
    pid = 0
    try:
        while incoming.wanted:
            chunk, control, _, _ = line.recvmsg(incoming.wanted, socket.CMSG_SPACE(_UCRED.size))
            if not chunk:
                raise GraderError("a worker ended before it was ready")
            incoming.feed(chunk)
            pid = next((_UCRED.unpack(data)[0] for _, kind, data in control if kind == socket.SCM_CREDENTIALS), pid)
        _, frame = incoming.finish()
    except (OSError, wire.WireError) as error:
        raise GraderError(f"a worker did not get ready: {error}") from None
    if not frame.fields.get("ready"):
        raise GraderError(f"a worker could not be isolated: {frame.fields.get('reason')}")
    line.setsockopt(socket.SOL_SOCKET, socket.SO_PASSCRED, 0)
    line.setblocking(False)
    return pid


def _cpu_clock(pid: int) -> int:
    """Return the id of another process's CPU-time clock, which counts all its threads; see clock_getcpuclockid(3)."""
    return (~pid << 3) | 2


def _wait_for(pidfd: int, seconds: float) -> None:
    poll = select.poll()
    poll.register(pidfd, select.POLLIN)
    poll.poll(seconds * 1000)


def _needed(contents: Contents) -> list[str]:
    shown = surroundings.visible(contents.readable, contents.packages)
    folders = [contents.worker_code, *([contents.questions] if contents.questions else [])]
    own = [str(path) for folder in folders for path in (folder, *folder.rglob("*.py"))]
    return [*shown, *surroundings.code(), *own]


def _harmless_uid(needed: Sequence[str]) -> dict[str, Any]:
    """Return the arguments by which root starts the zygote as a plain user; {} if not root, or if only root can read the code."""
    if not namespaces.may_drop_root() or not all(_open_to_all(path) for path in needed):
        return {}
    return {"user": namespaces.DROPPED_ID, "group": namespaces.DROPPED_ID, "extra_groups": []}


def _change_owner(folder: str, user: int, group: int) -> None:
    for top, folders, files in os.walk(folder):
        for path in (top, *(os.path.join(top, name) for name in (*folders, *files))):
            os.chown(path, user, group, follow_symlinks=False)


def _open_to_all(path: str) -> bool:
    real = Path(os.path.realpath(path))
    if not real.exists():
        return True
    folders = [*real.parents, real] if real.is_dir() else real.parents
    return bool(real.stat().st_mode & stat.S_IROTH) and all(f.stat().st_mode & stat.S_IXOTH for f in folders)
