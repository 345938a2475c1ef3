"""Runtime environment of student code: lab files are found, `input` returns "", no waiting, trace and audit hooks do nothing."""

from __future__ import annotations

import builtins
import contextlib
import io
import os
import pathlib
import signal
import sys
from collections.abc import Iterator
from typing import Any

from . import compat, desktop_stubs, repeatability

_MAX_INPUTS = 100


def import_libraries() -> None:
    """Import the libraries of every submission in the zygote (parent process of all workers), so that no worker waits for them."""
    with contextlib.suppress(ImportError):
        import _ssl  # noqa: F401 - see `repeatability`

    import matplotlib.pyplot as plt
    import numpy.random  # noqa: F401
    import PIL.Image  # noqa: F401

    plt.switch_backend("Agg")


def use_libraries() -> None:
    """Use each library once in the zygote (parent process of all workers), because the first use is slow."""
    import matplotlib.pyplot as plt
    import PIL.Image

    figure, axes = plt.subplots(2, 1, sharex=True)
    axes[0].plot([0, 1], [0, 1], label=r"m/s² $m/s^2$")
    axes[0].set_title("warm up")
    axes[0].legend()
    figure.tight_layout()
    figure.canvas.draw()
    plt.close("all")
    PIL.Image.preinit()


def install(*, run_magic: desktop_stubs.RunMagic) -> None:
    """Replace functions so that student code runs repeatably and without a user (`input` returns ""); `run_magic` does ``%run``."""
    _answer_input()
    compat.install()
    desktop_stubs.install(run_magic)
    repeatability.install(_HOME)
    _disable_hooks()
    _exit_on_own_signals()
    _replace_open()


_INSTEAD: dict[str, str] = {}


def redirect_missing(ending: str, place: str) -> None:
    """Let `open` read the submission's file `place` for a path that ends with `ending` and exists only on a student's disk."""
    _INSTEAD[ending] = place


def is_redirected(path: Any) -> bool:
    """Return whether `redirect_missing` gave a file for a path's ending, to load if the path's own file cannot be loaded."""
    return _ending(path) in _INSTEAD


def redirected(path: Any) -> Any:
    """Return `path`; but if nothing exists there and `redirect_missing` gave a file for its ending, return that file."""
    ending = _ending(path)
    if ending in _INSTEAD:
        try:
            _REAL_STAT(os.fsdecode(path))
        except (OSError, ValueError):
            return os.path.join(_HOME, _INSTEAD[ending])
    return path


def _ending(path: Any) -> str:
    name = os.fsdecode(path).replace("\\", "/") if isinstance(path, str | bytes | os.PathLike) else ""
    return next((ending for ending in _INSTEAD if name.endswith(ending)), "")


_REAL_STAT, _REAL_OPEN = os.stat, builtins.open


def _replace_open() -> None:
    """Let `open` and `os.stat` find files under redirected paths, and `open` create the folder of a file that it writes."""

    def stat(path: Any, **options: Any) -> os.stat_result:
        return _REAL_STAT(redirected(path), **options)

    def opened(file: Any, mode: str = "r", *args: Any, **options: Any) -> Any:
        if "r" not in mode:
            _make_parent_folder(file)
        return _REAL_OPEN(redirected(file) if "r" in mode else file, mode, *args, **options)

    vars(os)["stat"] = stat
    vars(builtins)["open"] = vars(io)["open"] = opened
    accessor = getattr(pathlib, "_NormalAccessor", None)  # Python 3.10's paths hold on to both
    if accessor is not None:
        accessor.stat, accessor.open = staticmethod(stat), staticmethod(opened)


def _make_parent_folder(file: Any) -> None:
    """Create the folder of a file that student code writes: it may exist on the student's computer; archives lack empty folders."""
    if isinstance(file, str | os.PathLike):
        with contextlib.suppress(OSError, ValueError, TypeError, RecursionError):
            os.makedirs(os.path.dirname(os.fspath(file)) or ".", exist_ok=True)


_HOME = "."


def remember_folder(folder: str) -> None:
    """Remember the scratch folder, which holds the submission's files, because student code may change the working directory."""
    global _HOME  # noqa: PLW0603 - one process, one submission
    _HOME = folder


def _answer_input() -> None:
    """Make `input` print its prompt and return "", as nobody types during grading; raise EOFError after a hundred calls."""
    asked = 0

    def answer(prompt: object = "") -> str:
        nonlocal asked
        asked += 1
        if asked > _MAX_INPUTS:
            raise EOFError("input() was called more than a hundred times")
        print(prompt)
        return ""

    builtins.input = answer


def _disable_hooks() -> None:
    """Ignore trace, profile and audit hooks of student code: an error in such a hook would end a statement of the worker code."""
    vars(sys).update(settrace=_no_hook, setprofile=_no_hook, addaudithook=_no_hook)
    monitoring = getattr(sys, "monitoring", None)  # since Python 3.12
    if monitoring is not None:
        vars(monitoring)["register_callback"] = _no_hook


def _no_hook(*args: Any) -> None:
    """Stand in for a function that registers a hook, such as `sys.settrace`, and do nothing."""


def _exit_on_own_signals() -> None:
    """Make a process that signals itself exit: as the first process of a PID namespace it would ignore its own signals."""

    def kill(pid: int, number: int) -> None:
        default = number != 0 and signal.getsignal(number) in (signal.SIG_DFL, None)
        if pid in (os.getpid(), repeatability.PID) and default and number not in harmless:
            os._exit(128 + number)
        really_kill(pid, number)

    really_kill = os.kill
    harmless = {getattr(signal, name, None) for name in ("SIGCHLD", "SIGCONT", "SIGURG")}  # Windows has none of them
    vars(os)["kill"] = kill
    vars(signal)["raise_signal"] = lambda number: kill(os.getpid(), number)


@contextlib.contextmanager
def in_scratch_folder(folder: str) -> Iterator[None]:
    """Run a block in `folder`, the scratch folder with the submission's files; change to it again at the end, even on an error."""
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(folder)
