"""Landlock: limit which files a worker may open, and keep it from network, sockets and processes outside.

It needs no privilege, and holds where no mount can. What it does not cover (stat, chmod, UDP) the other layers do. See Linux's
Documentation/userspace-api/landlock.rst; the bits are those of include/uapi/linux/landlock.h.
"""

from __future__ import annotations

import ctypes
import os
import stat
import struct
from collections.abc import Iterable

from . import linux
from .rootfs import DEVICES

_EXECUTE, _WRITE_FILE, _READ_FILE, _READ_DIR = 1 << 0, 1 << 1, 1 << 2, 1 << 3
_MAKE_CHAR, _MAKE_SOCK, _MAKE_FIFO, _MAKE_BLOCK = 1 << 6, 1 << 9, 1 << 10, 1 << 11
_TRUNCATE, _IOCTL_DEV = 1 << 14, 1 << 15
_RIGHTS_BY_ABI = (0, 13, 14, 15, 15, 16)  # how many of the bits above are known to ABI 0, 1, 2, ...; later ones: all 16
_NETWORK = 0b11  # bind and connect TCP, from ABI 4
_SCOPES = 0b11  # abstract unix sockets and signals, from ABI 6

_READ = _READ_FILE | _READ_DIR
_SCRATCH = 0xFFFF & ~(_EXECUTE | _MAKE_CHAR | _MAKE_SOCK | _MAKE_FIFO | _MAKE_BLOCK | _IOCTL_DEV)
_FILE_ONLY = _EXECUTE | _WRITE_FILE | _READ_FILE | _TRUNCATE | _IOCTL_DEV
_RULE_PATH_BENEATH = 1
_GIVE_VERSION = 1


def abi() -> int:
    """Return the kernel's version of Landlock, for `ruleset`, as older versions know fewer access rights; 0 without Landlock."""
    try:
        return linux.syscall("landlock_create_ruleset", None, 0, _GIVE_VERSION)
    except (OSError, KeyError):
        return 0


def ruleset(version: int, readable: Iterable[str], listed: Iterable[str], writable: Iterable[str]) -> int:
    """Make a rule set for `enforce`, and return its file descriptor; raise OSError if the kernel refuses.

    It allows reading below the paths `readable`, listing folders below `listed`, and all below `writable` but execution and new
    special files; devices such as /dev/null may be written. Missing paths are left out. An older `version` (`abi`) restricts less.
    """
    known = (1 << _RIGHTS_BY_ABI[min(version, len(_RIGHTS_BY_ABI) - 1)]) - 1
    network = _NETWORK if version >= 4 else 0
    scopes = _SCOPES if version >= 6 else 0
    attributes = struct.pack("=QQQ", known, network, scopes)[: 8 if version < 4 else 16 if version < 6 else 24]
    rules = linux.syscall("landlock_create_ruleset", ctypes.c_char_p(attributes), len(attributes), 0)
    for path in readable:
        _allow(rules, path, _READ & known)
    for path in listed:
        _allow(rules, path, _READ_DIR & known)
    for path in writable:
        _allow(rules, path, _SCRATCH & known)
    for path in DEVICES:
        _allow(rules, path, (_READ_FILE | _WRITE_FILE | _TRUNCATE) & known)
    return rules


def _allow(rules: int, path: str, rights: int) -> None:
    """Add a rule that gives `rights` below a path; do nothing if there is no such path."""
    try:
        fd = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except OSError:
        return
    try:
        if not stat.S_ISDIR(os.fstat(fd).st_mode):
            rights &= _FILE_ONLY
        rule = struct.pack("=Qi", rights, fd)
        linux.syscall("landlock_add_rule", rules, _RULE_PATH_BENEATH, ctypes.c_char_p(rule), 0)
    finally:
        os.close(fd)


def enforce(rules: int) -> None:
    """Restrict this process for ever to a rule set, the descriptor from `ruleset`; raise OSError unless `no_new_privs` is set."""
    linux.syscall("landlock_restrict_self", rules, 0)
