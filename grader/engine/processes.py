"""Start further processes of the grader so that they end with this one, ignore Ctrl-C, and import no student's module."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from multiprocessing import resource_tracker
from typing import Any


@contextmanager
def starting_processes() -> Iterator[Callable[[], None]]:
    """Let the caller start processes of the grader in this context; yields a function that each new process must call first.

    The context changes the working folder, so that a new Python imports no student's module. The yielded function sets the new
    process's working folder to the caller's, so that relative paths mean the same in both.
    """
    in_main = threading.current_thread() is threading.main_thread()
    begin = partial(_begin_process, os.getcwd(), in_main)
    with _in_library_folder(), _interrupts_held(), _daemon_allowed(), warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # about NumPy's idle threads; nothing waits for them
        yield begin


def context() -> Any:
    """Return the multiprocessing context for new processes: ``fork`` (fast) on Linux without other threads, else ``spawn``."""
    alone = sys.platform == "linux" and threading.active_count() == 1
    return multiprocessing.get_context("fork" if alone else "spawn")


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Hold a Ctrl-C back while processes are started, which takes seconds on a busy machine; it takes effect afterwards.

    The terminal sends it to all processes, and only this one should react. So the new ones inherit that it is blocked, until
    `_begin_process` makes them ignore it. A thread of this process may still receive it, so it is remembered, too. In another
    thread than the main one, which Python lets set no signal handler, nothing is done.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    received: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, frame: received.append(number))
    try:
        if sys.platform != "win32":
            resource_tracker.ensure_running()  # its start, which "spawn" needs, would unblock the signal again
            signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
        yield
    finally:
        if sys.platform != "win32":
            signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGINT])
        signal.signal(signal.SIGINT, before)
        if received:
            signal.raise_signal(signal.SIGINT)


@contextmanager
def _in_library_folder() -> Iterator[None]:
    """Work in the standard library's folder, so that a new Python process does not import a student's `signal.py`."""
    before = os.getcwd()
    os.chdir(os.path.dirname(os.__file__))
    try:
        yield
    finally:
        os.chdir(before)


@contextmanager
def _daemon_allowed() -> Iterator[None]:
    """Let a daemon process, such as a Dask worker, start children in this context.

    Python forbids it because children could outlive the daemon; the grader's processes do not.
    """
    own = multiprocessing.current_process()._config  # type: ignore[attr-defined] # no public way exists: python/cpython#82408
    daemon = own.pop("daemon", None)
    try:
        yield
    finally:
        if daemon is not None:
            own["daemon"] = daemon


def _begin_process(folder: str, in_main: bool) -> None:
    """Set up a new process of the grader: enter the working folder, ignore Ctrl-C, and end when the parent ends."""
    os.chdir(folder)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform != "win32":
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGINT])
    leave_with_parent(in_main)


def leave_with_parent(in_main: bool) -> None:
    """End this process when its parent ends. Otherwise it would wait forever for work: it holds both ends of its own queue.

    A watching thread cannot act during a long operation in C, so on Linux the kernel is asked to end the process as well. The
    kernel acts when the thread that started this process ends, so it is asked only if that was the main thread (`in_main`).
    """
    parent = multiprocessing.parent_process()

    def wait() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    if sys.platform == "linux" and in_main:
        from grader.sandbox.namespaces import die_with_parent  # noqa: PLC0415 - Linux only

        die_with_parent()
        if parent is not None and os.getppid() != parent.pid:
            os._exit(1)  # the parent ended before the kernel was asked
    threading.Thread(target=wait, daemon=True).start()
