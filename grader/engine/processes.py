"""Processes of our own beside this one: how they are started, and that they end with the run that started them."""

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
from typing import Any


@contextmanager
def starting_ours() -> Iterator[Callable[[], None]]:
    """Start processes of the grader in this context, and yield what each of them calls first.

    The context changes the working folder, so that a new Python imports no student's module. The yielded function returns the new
    process to the folder that the caller works in. That folder is read before the change: relative paths mean the same in both.
    """
    in_main = threading.current_thread() is threading.main_thread()
    begin = partial(_begin_process, os.getcwd(), in_main)
    with _interrupts_ignored(), _beside_no_student(), _though_a_daemon(), warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of idle threads of numpy's, which nothing here waits for
        yield begin


def context() -> Any:
    """How a process of ours starts: as a copy of this one, which takes milliseconds, where no other thread could be at work."""
    alone = sys.platform == "linux" and threading.active_count() == 1
    return multiprocessing.get_context("fork" if alone else "spawn")


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """A process started in here is deaf to Ctrl-C: the terminal sends it to all, and one process is to answer it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _beside_no_student() -> Iterator[None]:
    """A new Python first looks for its modules in the folder that it is started in: not for a `signal.py` of a student's."""
    before = os.getcwd()
    os.chdir(os.path.dirname(os.__file__))
    try:
        yield
    finally:
        os.chdir(before)


@contextmanager
def _though_a_daemon() -> Iterator[None]:
    """A daemon, as Dask's nanny starts its workers, may have no children, for they might outlive it: ours do not."""
    own = multiprocessing.current_process()._config  # type: ignore[attr-defined] # there is no other way: python/cpython#82408
    daemon = own.pop("daemon", None)
    try:
        yield
    finally:
        if daemon is not None:
            own["daemon"] = daemon


def _begin_process(folder: str, in_main: bool) -> None:
    """Enter the working folder and arrange that this process ends with its parent."""
    os.chdir(folder)
    leave_with_parent(in_main)


def leave_with_parent(in_main: bool) -> None:
    """From its first moment: a worker whose run was killed would wait for work for ever, with both ends of its own queue.

    A thread cannot see to it while a long operation in C is going on, so the kernel is asked where it can be. What it waits for
    is the end of the thread that started this process, so only the main one will do.
    """
    parent = multiprocessing.parent_process()

    def wait() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    if sys.platform == "linux" and in_main:
        from grader.sandbox.namespaces import die_with_parent  # noqa: PLC0415 - of Linux only

        die_with_parent()
        if parent is not None and os.getppid() != parent.pid:
            os._exit(1)  # it ended before it could take this process along
    threading.Thread(target=wait, daemon=True).start()
