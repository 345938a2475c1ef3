"""Linux calls that Python lacks (or has from 3.12 on only), by ctypes; each raises OSError as os.* would.

The symbols are resolved at import, so that a worker, which is forked, does not pay for it.
"""

from __future__ import annotations

import ctypes
import os
from typing import Any

from .syscalls import NUMBERS

CLONE_NEWTIME = 0x00000080
CLONE_NEWNS = 0x00020000
CLONE_NEWCGROUP = 0x02000000
CLONE_NEWUTS = 0x04000000
CLONE_NEWIPC = 0x08000000
CLONE_NEWUSER = 0x10000000
CLONE_NEWPID = 0x20000000
CLONE_NEWNET = 0x40000000

MS_RDONLY, MS_NOSUID, MS_NODEV, MS_NOEXEC = 1, 2, 4, 8
MS_BIND, MS_REC, MS_PRIVATE = 0x1000, 0x4000, 0x40000
MNT_DETACH = 2

PR_SET_PDEATHSIG, PR_SET_DUMPABLE, PR_CAPBSET_DROP, PR_SET_NO_NEW_PRIVS, PR_CAP_AMBIENT = 1, 4, 24, 38, 47
PR_CAP_AMBIENT_CLEAR_ALL = 4

_AT_FDCWD = -100
_AT_RECURSIVE = 0x8000
_CAPABILITY_VERSION_3 = 0x20080522

_libc: Any = ctypes.CDLL(None, use_errno=True)
_libc.syscall.restype = ctypes.c_long
_mount = _libc.mount
_mount.argtypes = [ctypes.c_char_p, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_ulong, ctypes.c_char_p]
_umount2 = _libc.umount2
_umount2.argtypes = [ctypes.c_char_p, ctypes.c_int]
_prctl = _libc.prctl
_prctl.argtypes = [ctypes.c_int] + [ctypes.c_ulong] * 4
_unshare = _libc.unshare
_setns = _libc.setns


def _checked(result: int, what: str) -> int:
    if result < 0:
        code = ctypes.get_errno()
        raise OSError(code, f"{what}: {os.strerror(code)}")
    return result


def syscall(name: str, *arguments: Any) -> int:
    """Make the system call `name`, passing an int as C long; return its result. Raise OSError, or KeyError for an unknown name."""
    values = [ctypes.c_long(a) if isinstance(a, int) else a for a in arguments]
    return _checked(_libc.syscall(ctypes.c_long(NUMBERS[name]), *values), name)


def unshare(flags: int) -> None:
    """Move this process into the new namespaces that `flags` name, as unshare(2) does."""
    _checked(_unshare(flags), "unshare")


def setns(fd: int, kind: int) -> None:
    _checked(_setns(fd, kind), "setns")


def prctl(option: int, *arguments: int) -> int:
    values = (*arguments, 0, 0, 0, 0)[:4]
    return _checked(_prctl(option, *values), f"prctl {option}")


def mount(source: str, target: str, kind: str = "", flags: int = 0, options: str = "") -> None:
    result = _mount(os.fsencode(source), os.fsencode(target), kind.encode(), flags, options.encode())
    _checked(result, f"mount {target}")


def umount(target: str) -> None:
    """Detach a mount at once, even if a process still uses it, so that the host's files are out of reach."""
    _checked(_umount2(os.fsencode(target), MNT_DETACH), f"umount {target}")


def pivot_root(new: str, put_old: str) -> None:
    syscall("pivot_root", ctypes.c_char_p(os.fsencode(new)), ctypes.c_char_p(os.fsencode(put_old)))


def mount_setattr(path: str, attributes: int, *, recursive: bool) -> None:
    """Add attributes to a mount (MS_RDONLY, MS_NOSUID, MS_NODEV, MS_NOEXEC); if `recursive`, to all mounts below it, too."""
    request = (ctypes.c_uint64 * 4)(attributes, 0, 0, 0)
    flags = _AT_RECURSIVE if recursive else 0
    where = ctypes.c_char_p(os.fsencode(path))
    syscall("mount_setattr", _AT_FDCWD, where, flags, ctypes.byref(request), ctypes.sizeof(request))


def close_from(first: int) -> None:
    """Close every file descriptor from `first` on, so that student code inherits none of the grader's."""
    try:
        syscall("close_range", first, 0xFFFFFFFF, 0)
    except OSError:  # Linux before 5.9
        os.closerange(first, 65536)


def drop_capabilities() -> None:
    """Give up every capability (right of root) of this process, and the settings by which it could regain one."""
    for capability in range(64):
        if _prctl(PR_CAPBSET_DROP, capability, 0, 0, 0) < 0:
            break  # EINVAL behind the last one; EPERM where there is none to drop
    prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL)
    header = (ctypes.c_uint32 * 2)(_CAPABILITY_VERSION_3, 0)
    nothing = (ctypes.c_uint32 * 6)()
    syscall("capset", ctypes.byref(header), ctypes.byref(nothing))
