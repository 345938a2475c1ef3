"""Virtual clock that the threads of student code share: pauses and simulation steps advance it, and nobody really waits.

If student code has several threads, one of them runs at a time. When all others pause or wait, the clock jumps to the end of
the pause that ends first, and that thread runs next. So a thread that polls at a fixed rate takes the same samples in each run.
"""

from __future__ import annotations

import contextlib
import math
import queue
import selectors
import threading
import weakref
from _thread import LockType, allocate_lock, get_ident
from dataclasses import dataclass
from typing import Any

_PATIENCE_S = 0.25
"""Real time that a thread waits for another one that neither pauses nor waits, as one that only computes does."""
_MAX_PATIENCE_S, _IMPATIENT_S = 2.0, 0.01
"""Real time that all threads together lose in this way, and the time that each waits afterwards."""


@dataclass(eq=False)
class _Wait:
    """A thread's pause, or its wait for another thread: until `lock` is released, or until the clock shows `end_s`."""

    end_s: float
    number: int
    lock: LockType
    is_over: bool = False


class Clock:
    """Virtual clock of student code: the seconds that have passed for it (`passed_s`), and which of its threads runs next."""

    def __init__(self) -> None:
        self.passed_s = 0.0
        self._guard = allocate_lock()
        self._threads: dict[object, _Wait | None] = {}
        self._ignored: set[object] = set()
        self._me: dict[int, object] = {}
        self._waits = 0
        self._patience_s = _MAX_PATIENCE_S

    def enter(self, thread: object) -> None:
        """Note that the caller is `thread`, the key given to `add`, so that it waits by this clock; called first in each thread."""
        self._me[get_ident()] = thread

    def add(self, thread: object) -> None:
        """Add a thread that starts next. From now on other threads run only while it pauses or waits, so one runs at a time."""
        with self._guard:
            self._threads[thread] = None

    def remove(self, thread: object) -> None:
        """Remove a thread that ends, and let the next thread run."""
        with self._guard:
            self._threads.pop(thread, None)
            self._ignored.discard(thread)
            self._me.pop(get_ident(), None)
        self._wake_next()

    def advance(self, seconds: float) -> float:
        """Let time pass for the calling thread; threads whose pauses end sooner run first. Return the clock's seconds."""
        if len(self._threads) <= 1 or get_ident() not in self._me:
            self.passed_s += seconds
        else:
            pause = allocate_lock()
            pause.acquire()
            self.wait(pause, seconds)
        return self.passed_s

    def wait(self, lock: LockType, seconds: float | None = None) -> bool:
        """Wait in virtual time until a lock is released: True, or False after `seconds`; with None, wait on even in a deadlock."""
        me = self._me.get(get_ident())
        if me is None:
            return lock.acquire(True, -1 if seconds is None else seconds)
        self._waits += 1
        own = _Wait(math.inf if seconds is None else self.passed_s + seconds, self._waits, lock)
        with self._guard:
            if self._patience_s > 0:
                self._ignored.discard(me)
            self._threads[me] = own
        try:
            self._wake_next()
            while not lock.acquire(True, _PATIENCE_S if self._patience_s > 0 else _IMPATIENT_S):
                self._lose_patience()
        finally:  # also if the time of the whole statement is up
            with self._guard:
                self._threads[me] = None
        return not own.is_over

    def _running(self) -> list[object]:
        """Return the threads that run: they do not pause, wait or compute for too long. A released lock makes its thread run."""
        return [
            thread
            for thread, wait in self._threads.items()
            if thread not in self._ignored and (wait is None or not wait.lock.locked())
        ]

    def _wake_next(self) -> None:
        """End the pause that ends first, and set the clock to its end, unless a thread is running."""
        with self._guard:
            if self._running():
                return
            pauses = [w for w in self._threads.values() if w and w.end_s < math.inf and w.lock.locked()]
            if pauses:
                first = min(pauses, key=lambda pause: (pause.end_s, pause.number))
                self.passed_s = max(self.passed_s, first.end_s)
                first.is_over = True
                first.lock.release()

    def _lose_patience(self) -> None:
        with self._guard:
            busy = self._running()
            if busy and self._patience_s > 0:
                self._patience_s -= _PATIENCE_S
            self._ignored.update(busy)
        self._wake_next()


def install(clock: Clock) -> None:
    """Make the standard library's locks, conditions, threads and event loops wait by the clock, not in real time, from now on."""
    main = object()
    clock.add(main)
    clock.enter(main)
    _replace_locks(clock)
    _replace_condition(clock)
    _replace_threads(clock)
    _replace_select(clock)


def _replace_locks(clock: Clock) -> None:
    """Let a lock that is released go to the thread that waits for it, not to one that the machine chooses at random."""

    class Lock:
        def __init__(self) -> None:
            self._lock, self._waiting = allocate_lock(), 0

        def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
            if not blocking or timeout != -1 or self._lock.acquire(False):
                return (blocking and timeout == -1) or self._lock.acquire(blocking, timeout)
            self._waiting += 1
            try:
                return clock.wait(self._lock)
            finally:
                self._waiting -= 1

        def release(self) -> None:
            self._lock.release()
            if self._waiting:
                clock.advance(0.0)

        def locked(self) -> bool:
            return self._lock.locked()

        def _at_fork_reinit(self) -> None:  # the standard library asks for it
            self.__init__()  # type: ignore[misc]

        def __enter__(self) -> bool:
            return self.acquire()

        def __exit__(self, *_: object) -> None:
            self.release()

    class ReentrantLock(threading._RLock):  # type: ignore[misc] # the standard library's, written in Python
        def __init__(self) -> None:
            super().__init__()
            self._block = Lock()

    vars(threading).update(Lock=Lock, RLock=ReentrantLock)
    vars(queue)["SimpleQueue"] = vars(queue)["_PySimpleQueue"]  # the other one waits where the clock cannot see it


def _replace_condition(clock: Clock) -> None:
    """Let `Condition.wait` wait by the clock, and with it all that is built on it: events, queues, semaphores, timers, futures."""

    def wait(condition: Any, timeout: float | None = None) -> bool:
        if not condition._is_owned():
            raise RuntimeError("cannot wait on un-acquired lock")
        waiter = allocate_lock()
        waiter.acquire()
        condition._waiters.append(waiter)
        saved, notified = condition._release_save(), False
        try:
            notified = clock.wait(waiter, timeout)
        finally:
            condition._acquire_restore(saved)
            if not notified and waiter in condition._waiters:
                condition._waiters.remove(waiter)
        return notified

    setattr(threading.Condition, "wait", wait)  # noqa: B010
    vars(threading)["_time"] = vars(queue)["time"] = lambda: clock.passed_s  # by which they count the rest of a timeout


def _replace_threads(clock: Clock) -> None:
    """Let a started thread run up to its first pause, so that the order is the same in each run, and `join` wait by the clock."""
    really_start, really_join = threading.Thread.start, threading.Thread.join
    ends: weakref.WeakKeyDictionary[threading.Thread, LockType] = weakref.WeakKeyDictionary()

    def start(thread: threading.Thread) -> None:
        if thread in ends:
            really_start(thread)  # raises: a thread starts once
        number, really_run = object(), thread.run
        end = ends[thread] = allocate_lock()
        end.acquire()

        def run() -> None:
            clock.enter(number)
            try:
                really_run()
            finally:
                with contextlib.suppress(RuntimeError):  # a `join` whose time was up has released it
                    end.release()
                clock.remove(number)

        setattr(thread, "run", run)  # noqa: B010
        clock.add(number)
        try:
            really_start(thread)
        except BaseException:
            clock.remove(number)
            raise
        clock.advance(0.0)

    def join(thread: threading.Thread, timeout: float | None = None) -> None:
        end = ends.get(thread)
        if end is not None and thread is not threading.current_thread():
            if not clock.wait(end, None if timeout is None else max(0.0, timeout)):
                return
            end.release()  # for the next one who joins
        really_join(thread, None if end is not None else timeout)

    setattr(threading.Thread, "start", start)  # noqa: B010
    setattr(threading.Thread, "join", join)  # noqa: B010


def _replace_select(clock: Clock) -> None:
    """Let the pauses of an event loop, which it spends in `select`, advance the clock instead of waiting."""
    selector: Any = selectors.DefaultSelector
    really = selector.select

    def select(own: Any, timeout: float | None = None) -> Any:
        ready = really(own, min(timeout, 0.0) if timeout else timeout)
        if ready or not timeout or timeout < 0:
            return ready
        clock.advance(timeout)
        return really(own, 0.0)

    selector.select = select
