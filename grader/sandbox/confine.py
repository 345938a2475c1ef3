"""Isolate one worker in its own process: mounts, limits, Landlock and seccomp, in the only order that works.

Mounts come before Landlock, which forbids them; everything comes before seccomp, which forbids everything.
"""

from __future__ import annotations

import contextlib
import os
import socket
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

from . import landlock, limits, linux, namespaces, rootfs, seccomp
from .isolation_levels import IsolationLevel
from .syscalls import Machine

FIRST_SPARE_FD = 4  # 0 to 2 are the standard streams, 3 is the line to the grader


@dataclass(frozen=True)
class Confinement:
    """Parameters of a worker's isolation, which the zygote (the parent process) passes on to each worker that it forks.

    Attributes
    ----------
    isolation_level
        The isolation level, on which the mechanisms depend that are used.
    machine
        Architecture, for the system call numbers of seccomp.
    landlock_abi
        Landlock's version in the kernel; 0 if the kernel has no Landlock.
    rules
        Pairs of a scratch folder, which a worker may write, and the descriptor of its Landlock rule set. Rule sets are built once,
        as they have hundreds of rules. A worker whose folder has no pair builds its own.
    proc
        Descriptor of the host's /proc, or -1 without one. The worker closes it before student code runs.
    zygote
        The zygote's pid, by which a worker recognises that its zygote has died, and then ends itself; 0 for workers in a pid
        namespace of their own, where the zygote has no pid.
    """

    isolation_level: IsolationLevel
    machine: Machine
    landlock_abi: int
    rules: tuple[tuple[str, int], ...]
    proc: int
    zygote: int


def confine(confinement: Confinement, scratch: str) -> None:
    """Isolate this process irrevocably. `scratch` becomes its only writable folder and its working directory.

    Raise OSError if the kernel refuses a step; the process must then end.
    """
    os.umask(0o077)
    os.setsid()
    _raise_oom_score(confinement.proc)
    if confinement.isolation_level.own_namespaces:
        namespaces.enter_as_worker(confinement.proc)
        rootfs.mount_scratch()
    rules = _keep_rules(confinement, scratch)
    os.chdir(scratch)
    # Without a user namespace, this limit would count all processes of the user.
    limits.enforce(leave_out=() if confinement.isolation_level.own_namespaces else ("RLIMIT_NPROC",))
    linux.prctl(linux.PR_SET_DUMPABLE, 0)
    _end_with_zygote(confinement.zygote)
    linux.drop_capabilities()
    linux.prctl(linux.PR_SET_NO_NEW_PRIVS, 1)
    if confinement.landlock_abi:
        _forbid_files(confinement, scratch, rules)
    seccomp.enforce(seccomp_program(confinement, os.getpid()))


@lru_cache(maxsize=2)
def seccomp_program(confinement: Confinement, pid: int) -> bytes:
    """Return the seccomp filter for a worker that is process `pid` and may signal only itself. Cached: most workers are pid 1."""
    return seccomp.program(confinement.machine, pid, own_files_only=confinement.isolation_level.own_namespaces)


def _raise_oom_score(proc: int) -> None:
    """Make this process the first that the kernel ends when memory runs out, not the grader; without a /proc (-1) do nothing."""
    if proc < 0:
        return
    with contextlib.suppress(OSError):
        fd = os.open("self/oom_score_adj", os.O_WRONLY | os.O_CLOEXEC, dir_fd=proc)
        os.write(fd, b"1000")
        os.close(fd)


def _end_with_zygote(zygote: int) -> None:
    namespaces.die_with_parent()
    if zygote and os.getppid() != zygote:
        os._exit(1)  # it died before it could take us along


def _keep_rules(confinement: Confinement, scratch: str) -> int:
    """Close all descriptors but the streams, the socket and this worker's Landlock rules; return the rules, or -1 without any."""
    made = dict(confinement.rules).get(scratch, -1)
    if made < 0:
        linux.close_from(FIRST_SPARE_FD)
        return -1
    os.dup2(made, FIRST_SPARE_FD)
    linux.close_from(FIRST_SPARE_FD + 1)
    return FIRST_SPARE_FD


def _forbid_files(confinement: Confinement, scratch: str, made: int) -> None:
    rules = landlock.ruleset(confinement.landlock_abi, ["/"], [], [scratch]) if made < 0 else made
    landlock.enforce(rules)
    os.close(rules)


def check_isolation(decoy: str) -> None:
    """Try, as a process isolated by `confine`, to open a socket, fork, read `decoy` and write outside its folder: all must fail.

    `decoy` is a file of the grader. Raise OSError at the first attempt that succeeds: the isolation level must then not be used.
    """
    attempts: tuple[tuple[str, Callable[[], object]], ...] = (
        ("a socket could be opened", _open_socket),
        ("a process could be started", _start_process),
        ("the grader's files could be read", lambda: os.close(os.open(decoy, os.O_RDONLY))),
        ("the working directory's parent could be written to", lambda: os.mkdir("../leak")),
    )
    for what, attempt in attempts:
        try:
            attempt()
        except OSError:
            continue
        raise OSError(what)


def _open_socket() -> None:
    socket.socket().close()


def _start_process() -> None:
    if os.fork() == 0:
        os._exit(0)
    os.wait()
