"""Stubs of what a student's computer has and the sandbox lacks: windows, a notebook shell, a debugger's prompt.

With a stub, a function that uses it runs on. A failing statement at module level needs no stub: `statements` skips it.
"""

from __future__ import annotations

import builtins
import os
import pdb
import sys
import time
import types
from collections.abc import Callable
from typing import Any

_GUI_BACKENDS = ("tk", "qt", "gtk", "wx", "macosx", "webagg", "nbagg", "ipympl", "inline", "notebook", "widget")
_MAX_RUNNING_CALLS = 5000  # at a viewer's window before it is closed: a loop that records 5 s needs 2,500
_MAX_VIEWER_CPU_S = (
    2.0  # of CPU time before it is closed: such a loop needs 0.2, one that draws at every step never ends
)
_CPU_CLOCK = time.process_time  # student code finds another one, see `repeatability`
_MAX_MARKS = 1000  # geoms that a program draws into the viewer's scene
_RUN_CELLS = ("time", "timeit", "capture", "prun")
_MODULES = ("glfw", "IPython.display", "ipdb", "msvcrt", "pudb", "winsound")


RunMagic = Callable[[str, dict[str, Any]], None]
"""Function that does what ``%run LINE`` does in a namespace."""


class _Stub(types.ModuleType):
    """A module, window or device that accepts every call, answers with itself and shows nothing.

    Parameters
    ----------
    members : its real attributes
    """

    def __init__(self, name: str, **members: Any) -> None:
        super().__init__(name)
        vars(self).update(members)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return self

    def __call__(self, *args: object, **kwargs: object) -> _Stub:
        return self

    def __enter__(self) -> _Stub:
        return self

    def __exit__(self, *args: object) -> None:
        """Do nothing: nothing is held."""


def install(run_magic: RunMagic) -> None:
    """Install stubs of desktop packages (tqdm, seaborn styles, IPython), so that code which imports them runs."""
    for name in _MODULES:
        sys.modules[name] = _Stub(name)
    vars(sys.modules["msvcrt"])["kbhit"] = lambda: False
    vars(os)["get_terminal_size"] = lambda *_: os.terminal_size((80, 24))
    vars(os).setdefault("startfile", _Stub("startfile"))
    _use_headless_backends()
    _install_notebook_names(run_magic)
    _disable_debuggers()


def _use_headless_backends() -> None:
    """Replace GUI back ends by Agg, TeX by matplotlib's own text, and windows by a stub that accepts any call."""
    import matplotlib
    import matplotlib.pyplot as plt
    import mujoco
    from matplotlib.backend_bases import FigureManagerBase
    from matplotlib.text import Text

    def unless_gui(choose: Callable[..., Any]) -> Callable[..., Any]:
        def chosen(backend: Any, *args: Any, **kwargs: Any) -> Any:
            gui = isinstance(backend, str) and any(name in backend.lower() for name in _GUI_BACKENDS)
            return choose("Agg" if gui else backend, *args, **kwargs)

        return chosen

    matplotlib.use = unless_gui(matplotlib.use)
    plt.switch_backend = unless_gui(plt.switch_backend)
    window = _Stub("window", maxsize=lambda: (1920, 1080))
    for owner, name, value in (
        (FigureManagerBase, "window", window),
        (FigureManagerBase, "frame", window),
        (Text, "get_usetex", lambda text: False),
        (mujoco, "Renderer", _Stub("Renderer")),
        (mujoco, "GLContext", _Stub("GLContext")),
        (mujoco, "glfw", _Stub("mujoco.glfw")),
        (mujoco, "viewer", _Stub("mujoco.viewer", launch_passive=_Viewer, Handle=_Viewer)),
    ):
        setattr(owner, name, value)
    sys.modules.update({"mujoco.glfw": mujoco.glfw, "mujoco.viewer": mujoco.viewer})


class _Viewer(_Stub):
    """MuJoCo viewer without a window; `is_running` becomes false after a number of calls or some CPU time."""

    def __init__(self, model: Any, data: Any, **_: object) -> None:
        import mujoco

        scene = mujoco.MjvScene(model, _MAX_MARKS)
        super().__init__("viewer", m=model, d=data, cam=mujoco.MjvCamera(), opt=mujoco.MjvOption(), user_scn=scene)
        self._glances, self._until_s = _MAX_RUNNING_CALLS, _CPU_CLOCK() + _MAX_VIEWER_CPU_S

    def is_running(self) -> bool:
        self._glances -= 1
        return self._glances >= 0 and _CPU_CLOCK() < self._until_s

    def close(self) -> None:
        self._glances = 0


def _install_notebook_names(run_magic: RunMagic) -> None:
    """Provide `display`, `get_ipython` and `IPython`, which notebook code uses without an import."""
    display, shell = sys.modules["IPython.display"], _Shell(run_magic)
    # matplotlib asks for a shell, and for the version, which says what it need not repair
    sys.modules["IPython"] = _Stub("IPython", display=display, get_ipython=lambda: None, version_info=(9, 0, 0))
    builtins.display, builtins.get_ipython = display, lambda: shell  # type: ignore[attr-defined]


class _Shell(_Stub):
    """Stub of the IPython shell: magics do nothing, except `%run`, `%%time` and others that run code."""

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
    """Make breakpoints do nothing, as nobody can type `c` during grading."""
    go_on = _Stub("debugger")
    vars(sys)["breakpointhook"] = vars(sys)["__breakpointhook__"] = go_on
    vars(pdb)["set_trace"] = go_on
    for name in ("set_trace", "interaction"):
        setattr(pdb.Pdb, name, go_on)
