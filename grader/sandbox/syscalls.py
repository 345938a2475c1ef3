"""System call numbers of the machine types that the isolation supports.

x86_64 has its own table (arch/x86/entry/syscalls/syscall_64.tbl), aarch64 uses the generic one (include/uapi/asm-generic/unistd.h),
which leaves out what a newer call replaces ("-").
"""

from __future__ import annotations

import os
import sys
from typing import NamedTuple

_TABLE = """
read                          0    63
write                         1    64
close                         3    57
openat                      257    56
open                          2     -
lseek                         8    62
mmap                          9   222
mprotect                     10   226
munmap                       11   215
mremap                       25   216
madvise                      28   233
brk                          12   214
fstat                         5    80
newfstatat                  262    79
stat                          4     -
lstat                         6     -
statx                       332   291
access                       21     -
faccessat                   269    48
faccessat2                  439   439
readlink                     89     -
readlinkat                  267    78
getdents64                  217    61
getdents                     78     -
pread64                      17    67
pwrite64                     18    68
readv                        19    65
writev                       20    66
preadv                      295    69
pwritev                     296    70
preadv2                     327   286
pwritev2                    328   287
dup                          32    23
dup2                         33     -
dup3                        292    24
fcntl                        72    25
ioctl                        16    29
flock                        73    32
fsync                        74    82
fdatasync                    75    83
ftruncate                    77    46
truncate                     76    45
fallocate                   285    47
fadvise64                   221   223
statfs                      137    43
fstatfs                     138    44
unlink                       87     -
unlinkat                    263    35
rename                       82     -
renameat                    264    38
renameat2                   316   276
mkdir                        83     -
mkdirat                     258    34
rmdir                        84     -
symlink                      88     -
symlinkat                   266    36
link                         86     -
linkat                      265    37
getcwd                       79    17
chdir                        80    49
fchdir                       81    50
umask                        95   166
msync                        26   227
mincore                      27   232
sendfile                     40    71
copy_file_range             326   285
chmod                        90     -
fchmod                       91    52
fchmodat                    268    53
utimensat                   280    88
utime                       132     -
utimes                      235     -
pipe                         22     -
pipe2                       293    59
poll                          7     -
ppoll                       271    73
select                       23     -
pselect6                    270    72
epoll_create                213     -
epoll_create1               291    20
epoll_ctl                   233    21
epoll_wait                  232     -
epoll_pwait                 281    22
eventfd2                    290    19
timerfd_create              283    85
timerfd_settime             286    86
timerfd_gettime             287    87
sendto                       44   206
recvfrom                     45   207
sendmsg                      46   211
recvmsg                      47   212
shutdown                     48   210
getsockname                  51   204
getpeername                  52   205
getsockopt                   55   209
socketpair                   53   199
rt_sigaction                 13   134
rt_sigprocmask               14   135
rt_sigreturn                 15   139
rt_sigpending               127   136
rt_sigtimedwait             128   137
rt_sigsuspend               130   133
sigaltstack                 131   132
pause                        34     -
alarm                        37     -
setitimer                    38   103
getitimer                    36   102
restart_syscall             219   128
kill                         62   129
tgkill                      234   131
clone                        56   220
clone3                      435   435
exit                         60    93
exit_group                  231    94
wait4                        61   260
waitid                      247    95
futex                       202    98
set_robust_list             273    99
get_robust_list             274   100
set_tid_address             218    96
rseq                        334   293
membarrier                  324   283
sched_yield                  24   124
sched_getaffinity           204   123
sched_setaffinity           203   122
sched_getscheduler          145   120
sched_getparam              143   121
sched_get_priority_max      146   125
sched_get_priority_min      147   126
getpriority                 140   141
prlimit64                   302   261
getrlimit                    97   163
prctl                       157   167
nanosleep                    35   101
clock_nanosleep             230   115
clock_gettime               228   113
clock_getres                229   114
gettimeofday                 96   169
time                        201     -
times                       100   153
getrusage                    98   165
sysinfo                      99   179
uname                        63   160
getrandom                   318   278
getcpu                      309   168
getpid                       39   172
getppid                     110   173
gettid                      186   178
getuid                      102   174
geteuid                     107   175
getgid                      104   176
getegid                     108   177
getresuid                   118   148
getresgid                   120   150
getgroups                   115   158
getpgrp                     111     -
getpgid                     121   155
getsid                      124   156
get_mempolicy               239   236
openat2                     437   437
io_uring_setup              425   425
io_uring_enter              426   426
io_uring_register           427   427
close_range                 436   436
pivot_root                  155    41
mount_setattr               442   442
landlock_create_ruleset     444   444
landlock_add_rule           445   445
landlock_restrict_self      446   446
seccomp                     317   277
pidfd_open                  434   434
capset                      126    91
"""

_COLUMNS = {"x86_64": 1, "aarch64": 2}


class Machine(NamedTuple):
    """A processor architecture as seccomp knows it: its name, and the AUDIT_ARCH_* constant of linux/audit.h (`audit`)."""

    name: str
    audit: int


_MACHINES = {"x86_64": Machine("x86_64", 0xC000003E), "aarch64": Machine("aarch64", 0xC00000B7)}


def machine() -> Machine:
    """Return the processor architecture of this process; raise OSError if this module has no table for it or Python is 32-bit."""
    name = os.uname().machine
    if name not in _MACHINES or sys.maxsize < 1 << 32:  # a 32-bit Python has another table on the same machine
        raise OSError(f"no system call table for {name}")
    return _MACHINES[name]


def numbers(name: str) -> dict[str, int]:
    """Return {system call: number} of the processor architecture `name`, for seccomp filters; an empty dict if it is unknown."""
    column = _COLUMNS.get(name)
    if column is None:
        return {}
    rows = (line.split() for line in _TABLE.split("\n") if line.strip())
    return {row[0]: int(row[column]) for row in rows if row[column] != "-"}


NUMBERS = numbers(os.uname().machine)
