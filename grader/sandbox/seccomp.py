"""seccomp: which system calls a worker may make. Others fail with EPERM, or ENOSYS if callers then fall back to an older call.

The list is what honest student code needs (simulation, plots, threads, sqlite, archives, asyncio), with room to spare, and none of
what starts a process, opens a socket (but a pair within the worker) or reaches another process. A call by another ABI (32-bit, x32)
kills the worker. See seccomp(2); the program is classic BPF.
"""

from __future__ import annotations

import ctypes
import errno
import struct

from . import linux
from .syscalls import Machine, numbers

_FREE = """
    read write close openat open lseek mmap mprotect munmap mremap madvise brk fstat newfstatat stat lstat statx access
    faccessat faccessat2 readlink readlinkat getdents64 getdents pread64 pwrite64 readv writev preadv pwritev preadv2
    pwritev2 dup dup2 dup3 flock fsync fdatasync ftruncate truncate fallocate fadvise64 statfs fstatfs unlink unlinkat
    rename renameat renameat2 mkdir mkdirat rmdir symlink symlinkat link linkat getcwd chdir fchdir umask msync mincore
    sendfile copy_file_range pipe pipe2 poll ppoll select pselect6 epoll_create epoll_create1 epoll_ctl epoll_wait
    epoll_pwait eventfd2 timerfd_create timerfd_settime timerfd_gettime sendto recvfrom sendmsg recvmsg shutdown
    getsockname getpeername getsockopt rt_sigaction rt_sigprocmask rt_sigreturn rt_sigpending rt_sigtimedwait
    rt_sigsuspend sigaltstack pause alarm setitimer getitimer restart_syscall exit exit_group wait4 waitid futex
    set_robust_list get_robust_list set_tid_address rseq membarrier sched_yield sched_getscheduler sched_getparam
    sched_get_priority_max sched_get_priority_min getpriority getrlimit nanosleep clock_nanosleep clock_gettime
    clock_getres gettimeofday time times getrusage sysinfo uname getrandom getcpu getpid getppid gettid getuid geteuid
    getgid getegid getresuid getresgid getgroups getpgrp getpgid getsid get_mempolicy close_range
"""
# They change the inode, which Landlock does not guard: only where nothing but the scratch is mounted writable.
_OWN_FILES_ONLY = "chmod fchmod fchmodat utimensat utime utimes"
# glibc and Python fall back to older calls, whose arguments can be checked, when these do not exist.
_NOT_THERE = "clone3 openat2 io_uring_setup io_uring_enter io_uring_register"

_CLONE_THREAD = 0x00010000
_NEW_NAMESPACE = (
    linux.CLONE_NEWTIME
    | linux.CLONE_NEWNS
    | linux.CLONE_NEWCGROUP
    | linux.CLONE_NEWUTS
    | linux.CLONE_NEWIPC
    | linux.CLONE_NEWUSER
    | linux.CLONE_NEWPID
    | linux.CLONE_NEWNET
)
_AF_UNIX = 1
# DUPFD, GETFD, SETFD, GETFL, SETFL, GETLK, SETLK, SETLKW, OFD_GETLK, OFD_SETLK, OFD_SETLKW, DUPFD_CLOEXEC, GETPIPE_SZ.
# Not SETOWN and SETSIG: with O_ASYNC they signal a process of the same user.
_FCNTL = (0, 1, 2, 3, 4, 5, 6, 7, 36, 37, 38, 1030, 1032)
_IOCTL = (0x5401, 0x5413, 0x541B, 0x5421, 0x5450, 0x5451)  # TCGETS, TIOCGWINSZ, FIONREAD, FIONBIO, FIONCLEX, FIOCLEX
_PRCTL = (15, 16, 0x53564D41)  # SET_NAME, GET_NAME, SET_VMA (names of mappings)

_LOAD, _EQUAL, _AT_LEAST, _ANY_BIT, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
_ALLOW, _KILL = 0x7FFF0000, 0x80000000
_REFUSE, _MISSING = 0x00050000 | errno.EPERM, 0x00050000 | errno.ENOSYS
_NUMBER_AT, _ARCH_AT, _ARGUMENTS_AT = 0, 4, 16  # in struct seccomp_data; low half of an argument on little-endian
_X32_BIT = 0x40000000
_SET_MODE_FILTER = 1

Instruction = tuple[int, int, int, int]  # code, jump if true, jump if false, operand


def program(machine: Machine, pid: int, *, own_files_only: bool) -> bytes:
    """Return the seccomp filter program that allows a worker the system calls that it needs, and no others.

    Parameters
    ----------
    machine
        Whose system call table to use.
    pid
        The worker's own, as it sees it: the only process that it may signal.
    own_files_only
        Whether nothing but the worker's own files is writable, so that it may change their modes and times.
    """
    table = numbers(machine.name)
    free = [name for name in _FREE.split() + (_OWN_FILES_ONLY.split() if own_files_only else []) if name in table]
    code: list[Instruction] = [
        (_LOAD, 0, 0, _ARCH_AT),
        (_EQUAL, 1, 0, machine.audit),
        (_RETURN, 0, 0, _KILL),  # int 0x80 from mapped code: another table, another meaning
        (_LOAD, 0, 0, _NUMBER_AT),
        (_AT_LEAST, 0, 1, _X32_BIT),
        (_RETURN, 0, 0, _KILL),
    ]
    for name in free:
        code += [(_EQUAL, 0, 1, table[name]), (_RETURN, 0, 0, _ALLOW)]
    for name in _NOT_THERE.split():
        code += [(_EQUAL, 0, 1, table[name]), (_RETURN, 0, 0, _MISSING)]
    for name, rules in _guarded(pid):
        code += [(_EQUAL, 0, len(rules), table[name]), *rules]
    code.append((_RETURN, 0, 0, _REFUSE))
    return b"".join(struct.pack("=HBBI", *instruction) for instruction in code)


def _guarded(pid: int) -> list[tuple[str, list[Instruction]]]:
    """Return the calls that are allowed for some values of an argument alone, each with its part of the filter program."""
    myself = (0, pid)
    return [
        ("clone", _thread_only()),
        ("kill", _one_of(0, (pid,))),
        ("tgkill", _one_of(0, (pid,))),
        ("prlimit64", _one_of(0, myself)),
        ("sched_setaffinity", _one_of(0, myself)),
        ("sched_getaffinity", _one_of(0, myself)),
        ("socketpair", _one_of(0, (_AF_UNIX,))),
        ("fcntl", _one_of(1, _FCNTL)),
        ("ioctl", _one_of(1, _IOCTL)),
        ("prctl", _one_of(0, _PRCTL)),
    ]


def _one_of(argument: int, allowed: tuple[int, ...]) -> list[Instruction]:
    rules: list[Instruction] = [(_LOAD, 0, 0, _ARGUMENTS_AT + 8 * argument)]
    for value in allowed:
        rules += [(_EQUAL, 0, 1, value), (_RETURN, 0, 0, _ALLOW)]
    return [*rules, (_RETURN, 0, 0, _REFUSE)]


def _thread_only() -> list[Instruction]:
    """Return filter instructions by which clone() may start threads, but no process and no namespace."""
    return [
        (_LOAD, 0, 0, _ARGUMENTS_AT),
        (_ANY_BIT, 2, 0, _NEW_NAMESPACE),
        (_ANY_BIT, 0, 1, _CLONE_THREAD),
        (_RETURN, 0, 0, _ALLOW),
        (_RETURN, 0, 0, _REFUSE),
    ]


def enforce(filter_program: bytes) -> None:
    """Install a seccomp filter in this process for ever; `no_new_privs` must have been set, or the kernel refuses."""
    code = ctypes.create_string_buffer(filter_program, len(filter_program))
    header = struct.pack("@HP", len(filter_program) // 8, ctypes.addressof(code))
    linux.syscall("seccomp", _SET_MODE_FILTER, 0, ctypes.c_char_p(header))
