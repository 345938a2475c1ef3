"""Replace randomness and time by repeatable sources, so that the same bytes get the same grade, also on a busy machine.

Libraries get the real process id and a `time.monotonic` that counts real time, too, because a lock or a wait depends on them.
"""

from __future__ import annotations

import datetime
import functools
import hashlib
import operator
import os
import random
import sys
import time
import types
from collections.abc import Callable
from typing import Any

import numpy as np

from . import virtual_time

PID = 1
"""Process id that student code sees: the one that its process has in a namespace of its own."""

_LOOK_S = 1e-6  # what reading a clock takes
_NEW_YEAR_S = 1_767_225_600.0  # 2026
_CLOCKS = {"time": _NEW_YEAR_S, "perf_counter": 100.0, "process_time": 1.0, "thread_time": 1.0}
CLOCK = virtual_time.Clock()
"""Clock of student code: it advances with pauses, with simulated steps, and a little with each reading.

So a loop that runs for some seconds makes the same number of rounds in every run, whatever else the machine does.
"""


class _Bytes:
    """Source of random bytes in place of the kernel's: SHAKE-128 over a counter, statistically alike, and the same in each run."""

    def __init__(self) -> None:
        self.restart(0)

    def restart(self, number: int) -> None:
        self._number, self._count = number, 0

    def __call__(self, size: int, flags: int = 0) -> bytes:
        self._count += 1
        return _SHAKE(f"{self._number}/{self._count}".encode()).digest(operator.index(size))


_SHAKE = hashlib.shake_128
_BYTES = _Bytes()


def install(folder: str) -> None:
    """Replace the clocks (by `CLOCK`), random bytes, the contents of `np.empty` and the process id by repeatable ones.

    Libraries (code outside the submission's `folder`) get the real process id and a `time.monotonic` that counts real time, too.
    """
    _LIBRARY.own_folder = folder
    virtual_time.install(CLOCK)
    _replace_clocks()
    _replace_dates()
    _replace_process()
    _replace_random_bytes()
    _fill_empty_arrays()


def seed(number: int) -> None:
    """Seed every random generator, so that a regrade draws the same numbers. No grade depends on which seed it is."""
    _BYTES.restart(number)
    random.seed(number)
    np.random.seed(number)
    stream = random.Random(number + 1)
    bit_generator: Any = sys.modules.get("numpy.random.bit_generator")
    if bit_generator is not None and hasattr(bit_generator, "randbits"):
        bit_generator.randbits = stream.getrandbits  # default_rng() without a seed takes its entropy from here


_EVENT_LOOP = os.path.join("asyncio", "base_events.py")  # its pauses pass by the clock, see `virtual_time`


class _Library:
    """Test whether a library calls, which needs the real clock, or student code: library code has an absolute file name."""

    own_folder = "/"

    def calls(self) -> bool:
        name = sys._getframe(2).f_code.co_filename
        if name.endswith(_EVENT_LOOP):
            return False
        return name.startswith("<frozen") or (os.path.isabs(name) and not name.startswith(self.own_folder))


_LIBRARY = _Library()


def _replace_clocks() -> None:
    """Let `sleep` advance all clocks instead of waiting. `monotonic` stays real for libraries, whose waits depend on it."""

    def sleep(seconds: float) -> None:
        if seconds < 0:
            raise ValueError("sleep length must be non-negative")
        CLOCK.advance(float(seconds))

    def reading(start_s: float) -> Callable[[], float]:
        return lambda: start_s + CLOCK.advance(_LOOK_S)

    def reading_ns(start_s: float) -> Callable[[], int]:
        return lambda: round((start_s + CLOCK.advance(_LOOK_S)) * 1e9)

    def monotonic() -> float:
        return really() + CLOCK.passed_s if _LIBRARY.calls() else _CLOCKS["perf_counter"] + CLOCK.advance(_LOOK_S)

    def monotonic_ns() -> int:
        seconds = really() + CLOCK.passed_s if _LIBRARY.calls() else _CLOCKS["perf_counter"] + CLOCK.advance(_LOOK_S)
        return round(seconds * 1e9)

    really = time.monotonic
    vars(time).update(sleep=sleep, monotonic=monotonic, monotonic_ns=monotonic_ns)
    if hasattr(time, "clock_gettime"):  # not on Windows
        real_time = getattr(time, "CLOCK_REALTIME", 0)

        def clock(number: int) -> float:
            return time.time() if number == real_time else time.perf_counter()

        vars(time).update(clock_gettime=clock, clock_gettime_ns=lambda number: round(clock(number) * 1e9))
    for name, start_s in _CLOCKS.items():
        vars(time).update({name: reading(start_s), f"{name}_ns": reading_ns(start_s)})
    if "timeit" in sys.modules:
        vars(sys.modules["timeit"])["default_timer"] = time.perf_counter
    vars(os)["times"] = lambda: os.times_result((time.process_time(), 0.0, 0.0, 0.0, time.perf_counter()))


def _replace_dates() -> None:
    """Make dates and broken-down times (`datetime.now`, `localtime`) follow the repeatable clock of student code."""

    def at(convert: Callable[..., Any]) -> Callable[..., Any]:
        return lambda seconds=None: convert(time.time() if seconds is None else seconds)

    def formatted(convert: Callable[..., Any]) -> Callable[..., Any]:
        return lambda *args: convert(*args, *(() if args and not isinstance(args[-1], str) else (time.localtime(),)))

    for name in ("localtime", "gmtime", "ctime"):
        vars(time)[name] = at(getattr(time, name))
    for name in ("strftime", "asctime"):
        vars(time)[name] = formatted(getattr(time, name))
    real, real_date = datetime.datetime, datetime.date

    class _Real(type):
        """Instances of the replaced classes are those of the real ones."""

        def __instancecheck__(cls, value: object) -> bool:
            return isinstance(value, cls.__base__ or object)

        def __subclasscheck__(cls, other: type) -> bool:
            return issubclass(other, cls.__base__ or object)

    def now(cls: type, tz: Any = None) -> Any:
        return real.fromtimestamp(time.time(), tz)

    def utcnow(cls: type) -> Any:
        return real.fromtimestamp(time.time(), datetime.timezone.utc).replace(tzinfo=None)

    def new(cls: type, *args: Any, **kwargs: Any) -> Any:
        base: Any = cls.__base__ if type(cls) is _Real else cls
        return base.__new__(base, *args, **kwargs)

    methods = {"now": classmethod(now), "today": classmethod(now), "utcnow": classmethod(utcnow), "__new__": new}
    today = {"today": classmethod(lambda cls: real.fromtimestamp(time.time()).date()), "__new__": new}
    vars(datetime).update(datetime=_Real("datetime", (real,), methods), date=_Real("date", (real_date,), today))


def _replace_process() -> None:
    """Give student code the process id 1 on every isolation level, so that no grade depends on it; libraries get the real one."""
    really = os.getpid
    vars(os)["getpid"] = lambda: really() if _LIBRARY.calls() else PID


def _replace_random_bytes() -> None:
    """Take random bytes from `_BYTES`, the same in each run: in `os.urandom`, `secrets` and generators without a seed."""
    seed_by = random.Random.seed

    def seeded(self: random.Random, a: Any = None, version: int = 2) -> None:
        seed_by(self, int.from_bytes(_BYTES(32), "little") if a is None else a, version)

    vars(os).update(urandom=_BYTES, getrandom=_BYTES)
    vars(random)["_urandom"] = _BYTES
    vars(sys.modules.get("_ssl", types.ModuleType("_ssl")))["RAND_bytes"] = _BYTES
    setattr(random.Random, "seed", seeded)  # noqa: B010
    vars(random)["seed"] = vars(random)["_inst"].seed


NEVER_WRITTEN = np.array([0x7FF8_0000_0000_0000 | 0x2A5A5 << 29], dtype=np.uint64).view(np.float64)[0]
"""NaN that fills the arrays of `np.empty`: its payload tells memory that was never written from a computed NaN, and survives sums,
copies and a conversion to float32 and back."""


def _fill_empty_arrays() -> None:
    """Let `np.empty` and `np.empty_like` fill their arrays (`NEVER_WRITTEN`), so that forgotten elements repeat and are found."""
    numpy = sys.modules["numpy"]  # the student's; the worker code has a copy of the module
    for name in ("empty", "empty_like"):
        setattr(numpy, name, _filled(getattr(numpy, name)))


def _filled(make: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(make)
    def make_filled(*args: Any, **kwargs: Any) -> Any:
        made = make(*args, **kwargs)
        kind = made.dtype.kind
        if kind in "fc":
            made.fill(NEVER_WRITTEN)
        elif kind in "iub":
            made.fill(False if kind == "b" else np.iinfo(made.dtype).max)
        return made

    return make_filled
