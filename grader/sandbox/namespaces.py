"""Enter the namespaces of a sandboxed process: user, pid, net, ipc and uts.

A process that has more than one thread cannot enter a user namespace, so all of this comes before numpy is imported.
"""

from __future__ import annotations

import os
import signal

from . import linux

INSIDE_ID = 1000  # uid and gid as the sandbox sees them
DROPPED_ID = 60123  # what root becomes first: with uid 0 outside, root's files would still be its own

_SET_IDS = 1 << 6 | 1 << 7  # CAP_SETGID and CAP_SETUID
_ZYGOTE = linux.CLONE_NEWPID | linux.CLONE_NEWIPC | linux.CLONE_NEWUTS | linux.CLONE_NEWNET
_WORKER = linux.CLONE_NEWUSER | linux.CLONE_NEWNS | linux.CLONE_NEWIPC | linux.CLONE_NEWUTS


def may_drop_root() -> bool:
    """Return whether this process is root and may become another user: some containers map no other user or lack CAP_SETUID.

    If it may, the sandbox is built as root, which alone can read a Python below /root (mode 700); if not, in a user namespace.
    """
    if os.geteuid() != 0:
        return False
    try:
        return _is_mapped("uid_map") and _is_mapped("gid_map") and _may_set_ids()
    except OSError:
        return False


def _is_mapped(name: str) -> bool:
    with open(f"/proc/self/{name}", encoding="ascii") as file:
        ranges = [tuple(map(int, line.split())) for line in file]
    return any(first <= DROPPED_ID < first + count for first, _, count in ranges)


def _may_set_ids() -> bool:
    with open("/proc/self/status", encoding="utf-8") as file:
        effective = next(int(line.split()[1], 16) for line in file if line.startswith("CapEff:"))
    return effective & _SET_IDS == _SET_IDS


def enter_as_root() -> None:
    """Give up root for ever and enter new namespaces: the zygote (parent process) cannot undo the mounts that it made as root."""
    give_up_root()
    linux.unshare(linux.CLONE_NEWUSER | linux.CLONE_NEWNS | _ZYGOTE)


def give_up_root() -> None:
    os.setgroups([])
    os.setresgid(DROPPED_ID, DROPPED_ID, DROPPED_ID)
    os.setresuid(DROPPED_ID, DROPPED_ID, DROPPED_ID)
    linux.prctl(linux.PR_SET_DUMPABLE, 1)  # or /proc/self/uid_map belongs to root and cannot be written


def enter_as_user() -> None:
    linux.unshare(linux.CLONE_NEWUSER | linux.CLONE_NEWNS | _ZYGOTE)


def write_maps(proc: int, uid: int, gid: int) -> None:
    """Map the host's `uid` and `gid` to `INSIDE_ID`, the sandbox's only user, in a new user namespace; `proc` is an open /proc."""
    for name, line in (
        ("setgroups", "deny"),
        ("uid_map", f"{INSIDE_ID} {uid} 1"),
        ("gid_map", f"{INSIDE_ID} {gid} 1"),
    ):
        fd = os.open(f"self/{name}", os.O_WRONLY | os.O_CLOEXEC, dir_fd=proc)
        try:
            os.write(fd, line.encode())
        finally:
            os.close(fd)


def enter_as_worker(proc: int) -> None:
    """Enter namespaces of this worker's own, so that each worker has its own limit of threads; `proc` is a descriptor of /proc."""
    uid, gid = os.geteuid(), os.getegid()
    linux.unshare(_WORKER)
    write_maps(proc, uid, gid)


def fork_as_first(own_pid_namespace: int) -> int:
    """Fork a child that is pid 1 of a new pid namespace, so that all that it started ends with it; return as `os.fork` does.

    The parent then returns to its own namespace for later forks, by `own_pid_namespace`, a pidfd of this process. Without that,
    the next call would fail.
    """
    linux.unshare(linux.CLONE_NEWPID)
    try:
        pid = os.fork()
    except OSError:
        linux.setns(own_pid_namespace, linux.CLONE_NEWPID)
        raise
    if pid:
        linux.setns(own_pid_namespace, linux.CLONE_NEWPID)
    return pid


def die_with_parent() -> None:
    linux.prctl(linux.PR_SET_PDEATHSIG, signal.SIGKILL)
