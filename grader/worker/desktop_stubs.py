"""Stubs of what a student's computer has and the sandbox lacks: windows, a notebook shell, a debugger's prompt.

With a stub, a function that uses such a thing runs on. A failing statement at module level needs no stub: `statements` skips it.
"""

from __future__ import annotations

import builtins
import os
import pdb
import sys
import types
from collections.abc import Callable
from typing import Any

_GUI_BACKENDS = ("tk", "qt", "gtk", "wx", "macosx", "webagg", "nbagg", "ipympl", "inline", "notebook", "widget")
_RUN_CELLS = ("time", "timeit", "capture", "prun")
_MODULES = ("IPython.display", "ipdb", "msvcrt", "pudb", "winsound")


RunMagic = Callable[[str, dict[str, Any]], None]
"""Function that does what ``%run LINE`` does in a namespace."""


class Stub(types.ModuleType):
    """Stub of a module, window or device: it accepts every call, returns itself and shows nothing, so that code using it runs on.

    Parameters
    ----------
    name : the name of what is stubbed
    members : keyword arguments: attributes with these values; any other attribute is the stub itself
    """

    def __init__(self, name: str, **members: Any) -> None:
        super().__init__(name)
        vars(self).update(members)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return self

    def __call__(self, *args: object, **kwargs: object) -> Stub:
        return self

    def __enter__(self) -> Stub:
        return self

    def __exit__(self, *args: object) -> None:
        """Leave a ``with`` block: there is nothing to close, and an exception goes on."""


def install(run_magic: RunMagic) -> None:
    """Install the stubs (IPython, debuggers, Windows console), so that code which uses them runs.

    `run_magic` does what ``%run`` does: it gets the rest of the line, and the namespace to run in.
    """
    for name in _MODULES:
        sys.modules[name] = Stub(name)
    vars(sys.modules["msvcrt"])["kbhit"] = lambda: False
    vars(os)["get_terminal_size"] = lambda *_: os.terminal_size((80, 24))
    vars(os).setdefault("startfile", Stub("startfile"))
    _use_headless_backends()
    _install_notebook_names(run_magic)
    _disable_debuggers()


def _use_headless_backends() -> None:
    """Replace GUI back ends by Agg, TeX by matplotlib's own text, and windows by a stub, because the sandbox has none of them."""
    import matplotlib
    import matplotlib.pyplot as plt
    from matplotlib.backend_bases import FigureManagerBase
    from matplotlib.text import Text

    def unless_gui(choose: Callable[..., Any]) -> Callable[..., Any]:
        def chosen(backend: Any, *args: Any, **kwargs: Any) -> Any:
            gui = isinstance(backend, str) and any(name in backend.lower() for name in _GUI_BACKENDS)
            return choose("Agg" if gui else backend, *args, **kwargs)

        return chosen

    matplotlib.use = unless_gui(matplotlib.use)
    plt.switch_backend = unless_gui(plt.switch_backend)
    window = Stub("window", maxsize=lambda: (1920, 1080))
    for owner, name, value in (
        (FigureManagerBase, "window", window),
        (FigureManagerBase, "frame", window),
        (Text, "get_usetex", lambda text: False),
    ):
        setattr(owner, name, value)


def _install_notebook_names(run_magic: RunMagic) -> None:
    """Provide `display`, `get_ipython` and `IPython`, which notebook code uses without an import; `run_magic` does ``%run``."""
    display, shell = sys.modules["IPython.display"], _Shell(run_magic)
    # matplotlib asks for a shell, and for the version, which says what it need not repair
    sys.modules["IPython"] = Stub("IPython", display=display, get_ipython=lambda: None, version_info=(9, 0, 0))
    builtins.display, builtins.get_ipython = display, lambda: shell  # type: ignore[attr-defined]


class _Shell(Stub):
    """Stub of the IPython shell: magics do nothing, except `%run` and those that run a cell, such as `%%time`."""

    def __init__(self, run_magic: RunMagic) -> None:
        super().__init__("shell")
        self._run_magic = run_magic

    def getoutput(self, command: str, **_: object) -> list[str]:
        return []

    def run_line_magic(self, name: str, line: str, *_: object) -> None:
        if name == "run":
            self._run_magic(line, sys._getframe(1).f_globals)

    def run_cell_magic(self, name: str, line: str, cell: str) -> None:
        if name in _RUN_CELLS:
            exec(compile(cell, "<cell>", "exec"), sys._getframe(1).f_globals)


def _disable_debuggers() -> None:
    """Make breakpoints do nothing, because nobody can type at a debugger's prompt during grading."""
    go_on = Stub("debugger")
    vars(sys)["breakpointhook"] = vars(sys)["__breakpointhook__"] = go_on
    vars(pdb)["set_trace"] = go_on
    for name in ("set_trace", "interaction"):
        setattr(pdb.Pdb, name, go_on)
