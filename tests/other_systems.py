"""Run a program as on a system that is not Linux: ``python tests/other_systems.py win32 -m grader check LAB``."""

from __future__ import annotations

import builtins
import contextlib
import importlib
import io
import os
import runpy
import select
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

_PACKAGES = (
    "asyncio", "concurrent.futures", "difflib", "getpass", "html", "http.client", "jinja2", "json", "matplotlib.animation", "matplotlib.pyplot",
    "mujoco", "multiprocessing.connection", "pytest", "_pytest.capture", "_pytest.faulthandler", "_pytest.tmpdir", "rich.console", "rich.live",
    "rich.table", "scipy.special", "shutil", "sqlite3", "tarfile", "tempfile", "traceback", "typer.main", "typer.testing", "yaml", "zipfile",
)  # fmt: skip
_LINUX = {
    os: ("memfd_create", "waitid", "sched_getaffinity", "sched_setaffinity", "pidfd_open", "unshare", "setns", "getrandom"),
    select: ("epoll",),
    socket: ("SO_PEERCRED", "SCM_CREDENTIALS"),
}  # fmt: skip
_POSIX = {
    os: (
        "fork", "forkpty", "openpty", "killpg", "setsid", "getsid", "getpgid", "setpgid", "pread", "pwrite", "getuid", "geteuid", "getgid",
        "getegid", "chown", "fchown", "chroot", "mkfifo", "mknod", "uname", "sysconf", "statvfs", "nice", "wait", "wait3", "wait4",
        "O_NOFOLLOW", "O_DIRECTORY", "O_NONBLOCK", "O_CLOEXEC", "fwalk", "register_at_fork", "posix_spawn", "eventfd",
    ),
    signal: ("SIGKILL", "SIGCHLD", "SIGCONT", "SIGURG", "SIGALRM", "SIGHUP", "SIGSTOP", "SIGXCPU", "alarm", "setitimer", "pthread_sigmask"),
    select: ("poll",),
    socket: ("AF_UNIX", "send_fds", "recv_fds"),
    time: ("clock_gettime", "clock_settime", "tzset"),
}  # fmt: skip
_POSIX_MODULES = ("fcntl", "grp", "pty", "pwd", "resource", "syslog", "termios", "tty")


class _Popen(subprocess.Popen):  # type: ignore[type-arg]
    """Starts a worker on the same system; on Windows its socket is given to it in the other way. Other programs start as they are."""

    def __init__(self, command: list[str], *, creationflags: int = 0, **given: Any) -> None:
        if "--plain" in command:
            at = command.index("--plain") - 1
            if sys.platform == "win32":
                given["pass_fds"] = (int(command[at + 2]),)  # Windows' share() does it there
                assert not {"start_new_session", "preexec_fn"} & set(given)
            command = [*command[:at], __file__, sys.platform, *command[at:]]
        super().__init__(command, **given)

    def kill(self) -> None:
        """As TerminateProcess does: without a signal."""
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.pid, 9)


def _socketpair() -> tuple[socket.socket, socket.socket]:
    """As Windows makes one: over TCP."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        ours = socket.create_connection(server.getsockname())
        return ours, server.accept()[0]


_is_there, _names_in = os.access, os.listdir


def _as_it_is_written(path: Any) -> Any:
    """Return the path of the file that a file system which ignores upper and lower case finds by this path."""
    if not isinstance(path, str | os.PathLike) or _is_there(path, os.F_OK):
        return path
    folder, name = os.path.split(os.fspath(path))
    above = _as_it_is_written(folder) if folder else "."
    there = _names_in(above) if name and os.path.isdir(above) else []
    return os.path.join(above, next((each for each in there if each.casefold() == name.casefold()), name))


def _ignore_case() -> None:
    """Let files be found by names with other upper and lower case, as on Windows and macOS."""

    def found(call: Any) -> Any:
        return lambda path=".", *arguments, **named: call(_as_it_is_written(path), *arguments, **named)

    for module, names in {
        os: ("access", "stat", "lstat", "open", "scandir", "listdir"),
        io: ("open",),
        builtins: ("open",),
    }.items():
        for name in names:
            setattr(module, name, found(getattr(module, name)))


def be(system: str) -> None:
    """Take away what that system does not have, and add what it has."""
    for name in _PACKAGES:
        importlib.import_module(name)
    sys.platform = system
    _ignore_case()
    gone = [_LINUX, _POSIX] if system == "win32" else [_LINUX]
    for module, names in ((m, names) for table in gone for m, names in table.items()):
        for name in names:
            with contextlib.suppress(AttributeError):
                delattr(module, name)
    subprocess.Popen = _Popen  # type: ignore[misc]
    if system == "win32":
        sys.modules.update(dict.fromkeys(_POSIX_MODULES))  # type: ignore[arg-type] # None: an ImportError
        Socket: Any = socket.socket
        Socket.share = lambda line, _pid: str(line.fileno()).encode()
        vars(socket)["socketpair"] = _socketpair
        vars(socket)["fromshare"] = lambda data: Socket(fileno=int(data))
        vars(subprocess)["CREATE_NEW_PROCESS_GROUP"] = 0x200
        vars(io)["_WindowsConsoleIO"] = type("_WindowsConsoleIO", (), {})


def main(system: str, program: str, *arguments: str) -> None:
    be(system)
    if program == "-m":
        sys.argv[:] = list(arguments)
        sys.path[0] = str(Path(__file__).resolve().parent.parent)
        runpy.run_module(arguments[0], run_name="__main__", alter_sys=True)
    else:
        sys.argv[:] = [program, *arguments]
        sys.path[0] = os.path.dirname(program)
        runpy.run_path(program, run_name="__main__")


if __name__ == "__main__":
    main(*sys.argv[1:])
