"""Bounds on what a hostile input may cost the trusted side, kept by clocks of CPU time: they hold on a busy machine, too."""

from __future__ import annotations

import contextlib
import signal
import tracemalloc
from collections.abc import Iterator
from typing import NoReturn

import pytest


@contextlib.contextmanager
def cpu_within(seconds: float) -> Iterator[None]:
    """Fail, in the middle of it, what uses more CPU time than that."""

    def stop(*_: object) -> NoReturn:
        pytest.fail(f"more than {seconds:g} s of CPU time")  # no Exception: what is tried may catch all of those

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


@contextlib.contextmanager
def memory_within(megabytes: float) -> Iterator[None]:
    """Fail afterwards what held more memory than that at a time, as Python and NumPy count it."""
    tracemalloc.start()
    try:
        yield
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak <= megabytes * 1e6, f"{peak / 1e6:.0f} MB"
