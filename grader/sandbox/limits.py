"""Set a worker's resource limits (rlimits), after the imports, whose threads and mappings would exceed them."""

from __future__ import annotations

import contextlib
import resource

MEMORY_BYTES = 4 << 30
FILE_BYTES = 32 << 20
OPEN_FILES = 128
PROCESSES = 64  # threads count too
CPU_SECONDS = 600  # the grader's own clock ends a worker long before; this is for the day when there is no grader

_LIMITS = (
    ("RLIMIT_AS", MEMORY_BYTES),
    ("RLIMIT_FSIZE", FILE_BYTES),
    ("RLIMIT_NOFILE", OPEN_FILES),
    ("RLIMIT_NPROC", PROCESSES),
    ("RLIMIT_CPU", CPU_SECONDS),
    ("RLIMIT_CORE", 0),
    ("RLIMIT_MEMLOCK", 0),
    ("RLIMIT_MSGQUEUE", 0),
)


def enforce(*, leave_out: tuple[str, ...] = ()) -> None:
    """Lower this process's resource limits to those of a worker, except `leave_out` (such as "RLIMIT_AS") and any refused ones."""
    for name, value in _LIMITS:
        if name not in leave_out and hasattr(resource, name):
            _lower(getattr(resource, name), value)


def _lower(which: int, value: int) -> None:
    _, hard = resource.getrlimit(which)
    value = value if hard == resource.RLIM_INFINITY else min(value, hard)
    with contextlib.suppress(OSError, ValueError):  # macOS refuses some; what matters there is the grader's clock
        resource.setrlimit(which, (value, value))
