"""Decoys that attacks aim at, and the state of the machine before and after: what was touched, reached or left behind."""

from __future__ import annotations

import hashlib
import os
import socket
import stat
import subprocess
import sys
import tempfile
import time
import zlib
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import psutil

import grader
from tests.corpus.writing import Files, Link

SECRET = "imugrade-bait-5f1c83"
"""What the decoys hold. It may show up nowhere in what the grader writes."""
_PACKAGE = Path(grader.__file__).parent
_SETTLING_S = 5.0


class Decoys(ExitStack):
    """The decoys of one run; a context manager.

    `folder` holds a file to read (``@SECRET@``), one to change (``@TARGET@``) and a neighbour's submission (``@NEIGHBOUR@``);
    ``@PORT@``, ``@UDP@``, ``@SOCKET@`` and ``@ABSTRACT@`` are listened to, ``@PID@`` is a process that does nothing.
    """

    def __enter__(self) -> Decoys:
        super().__enter__()
        self.folder = Path(self.enter_context(tempfile.TemporaryDirectory(prefix="imugrade-bait-")))
        os.chmod(self.folder, 0o777)  # reading and writing it is a matter of the sandbox, not of modes
        self._abstract = f"{SECRET} {self.folder.name}"
        self._ipc_key = hex(zlib.crc32(self.folder.name.encode()) >> 1)  # /proc shows keys as signed numbers
        self.callback(self._remove_shared_memory)
        self._lay_out()
        self._listeners = self._listen()
        self._decoy = self._start_decoy()
        self.callback(lambda: self._decoy.wait())
        self.callback(lambda: self._decoy.kill())
        self._adopt_orphans(1)
        self.callback(self._adopt_orphans, 0)
        self._before = self._state()
        return self

    def _remove_shared_memory(self) -> None:
        with suppress(FileNotFoundError):
            subprocess.run(["ipcrm", "-M", self._ipc_key, "-Q", self._ipc_key], check=False, capture_output=True)

    def _lay_out(self) -> None:
        for name in ("secret.txt", "target.txt", "neighbour/filters.py", "traces.npz", "rubric.yaml"):
            path = self.folder / name
            path.parent.mkdir(exist_ok=True)
            path.write_text(f"{SECRET} {name}\n", encoding="utf-8")
            os.chmod(path, 0o666)

    def _listen(self) -> dict[str, socket.socket]:
        listeners = {
            "PORT": socket.create_server(("127.0.0.1", 0)),
            "UDP": socket.socket(socket.AF_INET, socket.SOCK_DGRAM),
            "SOCKET": socket.socket(socket.AF_UNIX),
            "ABSTRACT": socket.socket(socket.AF_UNIX),
        }
        for listener in listeners.values():
            self.enter_context(listener)
            listener.setblocking(False)
        listeners["UDP"].bind(("127.0.0.1", 0))
        listeners["SOCKET"].bind(str(self.folder / "socket"))
        listeners["ABSTRACT"].bind("\0" + self._abstract)
        for name in ("SOCKET", "ABSTRACT"):
            listeners[name].listen()
        os.chmod(self.folder / "socket", 0o777)
        return listeners

    @staticmethod
    def _adopt_orphans(yes: int) -> None:
        """Whatever outlives its parent below this process becomes its child, and can be found."""
        if sys.platform == "linux":
            from grader.sandbox import linux

            linux.prctl(36, yes)  # PR_SET_CHILD_SUBREAPER

    @staticmethod
    def _start_decoy() -> subprocess.Popen[bytes]:
        program = "import signal; signal.sigwait([signal.SIGUSR2])"
        return subprocess.Popen([sys.executable, "-c", program], env={"BAIT": SECRET})

    def fill(self, files: Files) -> Files:
        """The submission with the marks replaced."""
        marks = {
            "@SECRET@": str(self.folder / "secret.txt"),
            "@TARGET@": str(self.folder / "target.txt"),
            "@NEIGHBOUR@": str(self.folder / "neighbour"),
            "@FOLDER@": str(self.folder),
            "@SOCKET@": str(self.folder / "socket"),
            "@ABSTRACT@": self._abstract,
            "@PORT@": str(self._listeners["PORT"].getsockname()[1]),
            "@UDP@": str(self._listeners["UDP"].getsockname()[1]),
            "@PID@": str(self._decoy.pid),
            "@GRADER@": str(os.getpid()),
            "@IPC@": self._ipc_key,
        }
        return {_filled(name, marks): _filled_content(content, marks) for name, content in files.items()}

    # --- what happened -----------------------------------------------------------------------------------------------

    def troubles(self, expected: frozenset[int]) -> list[str]:
        """What is not as it was; `expected` are the processes below this one that may be there."""
        found = [f"{name} was reached" for name in self._reached()]
        if self._decoy.poll() is not None:
            found.append("the decoy process was ended")
            self._decoy = self._start_decoy()
        after = self._state()
        found += [f"{name} changed" for name in sorted(after.keys() | self._before) if after.get(name) != self._before.get(name)]
        self._before = after
        left = self.left_over(expected)
        return found + ([f"{len(left)} processes are left over"] if left else [])

    def left_over(self, expected: frozenset[int]) -> set[int]:
        """Processes below this one that should not be there, after a moment to end."""
        end = time.monotonic() + _SETTLING_S
        while (left := below(os.getpid()) - expected - {self._decoy.pid}) and time.monotonic() < end:
            for pid in left:
                with suppress(ChildProcessError):
                    os.waitpid(pid, os.WNOHANG)
            time.sleep(0.1)
        return left

    def _reached(self) -> list[str]:
        reached = []
        for name, listener in self._listeners.items():
            with suppress(BlockingIOError):
                if name == "UDP":
                    listener.recv(100)
                else:
                    listener.accept()[0].close()
                reached.append(f"the listener {name}")
        return reached

    def _state(self) -> Mapping[str, Any]:
        """Every decoy, every file of the grader and every object of System V, with what would show a change."""
        decoys = {f"the decoy {path.relative_to(self.folder)}": _look(path) for path in self.folder.rglob("*")}
        package = [path for path in _PACKAGE.rglob("*") if path.suffix != ".pyc" and path.name != "__pycache__"]
        own = {f"the grader's {path.relative_to(_PACKAGE)}": _look(path) for path in package}
        shared = {"shared memory or a queue": self._ipc_key} if self._ipc_key in _ipc_keys() else {}
        return {**decoys, **own, **shared}


def _look(path: Path) -> tuple[object, ...]:
    with suppress(OSError):
        at = path.lstat()
        if not stat.S_ISREG(at.st_mode):
            return at.st_mode, at.st_uid
        return at.st_mode, at.st_uid, at.st_nlink, at.st_mtime_ns, hashlib.sha256(path.read_bytes()).hexdigest()
    return ("gone",)


def _ipc_keys() -> set[str]:
    """Keys of the host's shared memory and message queues, which outlive the processes that made them."""
    rows: list[str] = []
    for kind in ("shm", "msg"):
        with suppress(OSError):
            rows += Path(f"/proc/sysvipc/{kind}").read_text(encoding="ascii").splitlines()[1:]
    return {hex(int(row.split()[0])) for row in rows}


def _filled(text: str, marks: Mapping[str, str]) -> str:
    for mark, value in marks.items():
        text = text.replace(mark, value)
    return text


def _filled_content(content: str | bytes | Link, marks: Mapping[str, str]) -> str | bytes | Link:
    if isinstance(content, Link):
        return Link(_filled(content.target, marks))
    return _filled(content, marks) if isinstance(content, str) else content


def below(pid: int) -> set[int]:
    """Every living process that descends from a process."""
    found = set()
    with suppress(psutil.NoSuchProcess):
        for child in psutil.Process(pid).children(recursive=True):
            with suppress(psutil.NoSuchProcess):
                found |= {child.pid} if child.status() != psutil.STATUS_ZOMBIE else set()
    return found
