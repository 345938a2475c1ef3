"""Stubs of what a program finds on a student's computer and not here: windows, a notebook, an installer.

Whoever asks for one gets an answer that lets the program go on: a window was closed again, what is to be installed is there.
"""

from __future__ import annotations

import atexit
import builtins
import contextlib
import functools
import io
import os
import subprocess
import sys
import time
import types
from collections.abc import Callable
from typing import Any

import numpy as np

_GUI_BACKENDS = ("tk", "qt", "gtk", "wx", "macosx", "webagg", "nbagg", "ipympl", "inline", "notebook", "widget")
_GLANCES = 5000  # at a viewer's window before it is closed: a loop that records 5 s needs 2,500
_PATIENCE_S = 2.0  # of CPU time before it is closed: such a loop needs 0.2, one that draws at every step never ends
_CPU_CLOCK = time.process_time  # student code finds another one, see `world`
_MAX_MARKS = 1000  # geoms that a program draws into the viewer's scene
_RUN_CELLS = ("time", "timeit", "capture", "prun")
_INSTALLERS = frozenset(["pip", "pip3", "conda", "mamba", "uv", "apt", "apt-get", "brew"])
_OPENERS = frozenset(["open", "xdg-open", "start", "explorer", "explorer.exe", "eog", "feh"])


RunMagic = Callable[[str, dict[str, Any]], None]
"""Does what ``%run LINE`` does, among the names of who asks for it."""


def furnish(run_magic: RunMagic) -> None:
    """Put the stand-ins in place."""
    _take_the_screen_away()
    _set_without_tex()
    _render_nothing()
    _be_any_system()
    _offer_glfw()
    _offer_notebook_names(run_magic)
    _send_debuggers_on()
    _say_installed()
    vars(atexit).update(register=_at_exit)


_AT_EXIT: list[Callable[[], Any]] = []
"""What programs have left to be done when they end."""


def _at_exit(function: Callable[..., Any], *args: Any, **kwargs: Any) -> Callable[..., Any]:
    """Stands in for `atexit.register`: the process goes on when a program is over."""
    _AT_EXIT.append(functools.partial(function, *args, **kwargs))
    return function


def end_program() -> None:
    """Do what a program has left to be done, the last first; what raises there is told by nobody, as at the end of a process."""
    while _AT_EXIT:
        with contextlib.suppress(BaseException):
            _AT_EXIT.pop()()


def _take_the_screen_away() -> None:
    """GUI back ends quietly become Agg; `show()` closes what it showed, as a window that the user closes does."""
    import matplotlib
    import matplotlib.pyplot as plt
    import mujoco

    def unless_gui(choose: Callable[..., Any]) -> Callable[..., Any]:
        def chosen(backend: Any, *args: Any, **kwargs: Any) -> Any:
            gui = isinstance(backend, str) and any(name in backend.lower() for name in _GUI_BACKENDS)
            return choose("Agg" if gui else backend, *args, **kwargs)

        return chosen

    matplotlib.use = unless_gui(matplotlib.use)
    plt.switch_backend = unless_gui(plt.switch_backend)

    # The real module loads GLFW, see below.
    viewer: Any = types.ModuleType("mujoco.viewer")
    viewer.launch = viewer.launch_from_path = lambda *args, **kwargs: None
    viewer.launch_passive = viewer.Handle = _Viewer
    sys.modules["mujoco.viewer"] = mujoco.viewer = viewer


class _Window:
    """The window of a figure, of whatever back end: it takes any wish for its place and size."""

    def maxsize(self) -> tuple[int, int]:
        return 1920, 1080

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return self

    def __call__(self, *args: object, **kwargs: object) -> _Window:
        return self


class _Renderer:
    """A renderer of the simulation whose pictures are black: there is no graphics card to draw them with."""

    def __init__(self, model: Any, height: int = 240, width: int = 320, max_geom: int = 10_000, **_: object) -> None:
        import mujoco

        self.model, self.height, self.width = model, height, width
        self.scene = mujoco.MjvScene(model, max_geom)
        self._depth = False

    def render(self, *, out: Any = None) -> Any:
        shape = (self.height, self.width) if self._depth else (self.height, self.width, 3)
        picture = np.zeros(shape, np.float32 if self._depth else np.uint8) if out is None else out
        picture[...] = 0
        return picture

    def enable_depth_rendering(self) -> None:
        self._depth = True

    def disable_depth_rendering(self) -> None:
        self._depth = False

    def update_scene(self, *args: object, **kwargs: object) -> None:
        """Do nothing: there is no window."""

    enable_segmentation_rendering = disable_segmentation_rendering = close = update_scene

    def __enter__(self) -> _Renderer:
        return self

    def __exit__(self, *args: object) -> None:
        """There is nothing to give back."""


class _Context:
    """Stub of a graphics context."""

    def __init__(self, max_width: int, max_height: int) -> None:
        """Accept any size."""

    def make_current(self) -> None:
        """Do nothing: nothing is drawn."""

    free = make_current


def _render_nothing() -> None:
    import mujoco
    from matplotlib.backend_bases import FigureManagerBase

    setattr(FigureManagerBase, "window", _Window())  # noqa: B010 - a manager of Agg has none
    setattr(FigureManagerBase, "frame", _Window())  # noqa: B010
    mujoco.Renderer, mujoco.GLContext = _Renderer, _Context


def _be_any_system() -> None:
    """Add the functions that only a terminal or Windows has."""
    vars(os)["get_terminal_size"] = lambda *_: os.terminal_size((80, 24))
    vars(os).setdefault("startfile", lambda *args, **kwargs: None)
    for name in ("msvcrt", "winsound"):
        sys.modules.setdefault(name, _Silent(name))


def _set_without_tex() -> None:
    """Let matplotlib set texts itself where a program asks for TeX, which is not installed here."""
    from matplotlib.text import Text

    setattr(Text, "get_usetex", lambda text: False)  # noqa: B010 - a method is replaced on purpose


class _Viewer:
    """A viewer that shows nothing, and whose window is closed after a while."""

    def __init__(self, model: Any, data: Any, **_: object) -> None:
        import mujoco

        self.m, self.d = model, data
        self.cam, self.opt, self.perturb = mujoco.MjvCamera(), mujoco.MjvOption(), mujoco.MjvPerturb()
        self.user_scn = mujoco.MjvScene(model, _MAX_MARKS)
        self.viewport = mujoco.MjrRect(0, 0, 1280, 960)
        self._glances, self._until_s = _GLANCES, _CPU_CLOCK() + _PATIENCE_S

    def is_running(self) -> bool:
        self._glances -= 1
        return self._glances >= 0 and _CPU_CLOCK() < self._until_s

    def close(self) -> None:
        self._glances = 0

    def sync(self, *args: object, **kwargs: object) -> None:
        """Do nothing: nothing is shown."""

    set_figures = set_images = set_texts = clear_figures = clear_images = clear_texts = sync
    update_hfield = update_mesh = update_texture = sync

    def lock(self) -> Any:
        return contextlib.nullcontext()

    def __enter__(self) -> _Viewer:
        return self

    def __exit__(self, *args: object) -> None:
        self.close()


def _offer_notebook_names(run_magic: RunMagic) -> None:
    """`display`, `get_ipython`, `IPython.display` and what Colab has, which notebook code uses without asking."""

    def display(*values: object, **_: object) -> None:
        for value in values:
            print(type(value).__name__)

    package, module = types.ModuleType("IPython"), _Silent("IPython.display")
    module.display = display  # type: ignore[attr-defined]
    package.display, package.get_ipython = module, lambda: None  # type: ignore[attr-defined]  # matplotlib asks: no shell
    package.version_info = (9, 0, 0)  # type: ignore[attr-defined]  # and which version it need not repair, once a canvas class
    for stub in (package, module, *_colab()):
        sys.modules.setdefault(stub.__name__, stub)
    shell = _Shell(run_magic)
    builtins.display, builtins.get_ipython = display, lambda: shell  # type: ignore[attr-defined]


class _Silent(types.ModuleType):
    """A module whose functions accept anything and show nothing."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *args, **kwargs: None


def _colab() -> list[types.ModuleType]:
    """Colab's own modules and the one that shows films there; its drive is the folder where the notebook is already.

    There is no module `google`: who tries `import google.colab` wants to know whether Colab's folders and programs are there.
    """
    colab, drive, files = (_Silent(f"google.colab{rest}") for rest in ("", ".drive", ".files"))
    vars(files)["upload"] = dict
    vars(colab).update(drive=drive, files=files)
    really_change = os.chdir

    def chdir(path: Any) -> None:
        if not str(path).startswith("/content") or os.path.isdir(path):
            really_change(path)

    vars(os)["chdir"] = chdir
    return [colab, drive, files, _Silent("mediapy")]


class _Shell:
    """The shell around a notebook, or one that was exported as a program: its magics do nothing, but for those that run code."""

    def __init__(self, run_magic: RunMagic) -> None:
        self._run_magic = run_magic

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return lambda *args, **kwargs: None

    def getoutput(self, command: str, **_: object) -> list[str]:
        return []

    def run_line_magic(self, name: str, line: str, *_: object) -> None:
        if name == "run":
            self._run_magic(line, sys._getframe(1).f_globals)

    def run_cell_magic(self, name: str, line: str, cell: str) -> None:
        if name in _RUN_CELLS:
            exec(compile(cell, "<cell>", "exec"), sys._getframe(1).f_globals)


def _send_debuggers_on() -> None:
    """A break point that was left in goes on at once: nobody is there who would type `c`."""
    import code
    import pdb

    def go_on(*args: object, **kwargs: object) -> None:
        """Nobody looks."""

    vars(sys)["breakpointhook"] = vars(sys)["__breakpointhook__"] = go_on
    vars(pdb)["set_trace"] = vars(pdb)["post_mortem"] = vars(pdb)["pm"] = go_on
    vars(code)["interact"] = go_on
    for name in ("set_trace", "interaction"):
        setattr(pdb.Pdb, name, go_on)
    for name in ("ipdb", "pudb"):
        sys.modules.setdefault(name, _Silent(name))


class _Glfw(types.ModuleType):
    """GLFW for a program that needs no more of it than a loop that ends; the real one starts a process to look at its library."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return 0 if name.isupper() else lambda *args, **kwargs: _GLFW_ANSWERS.get(name)


_GLFW_ANSWERS = {
    "init": True,
    "create_window": "window",
    "window_should_close": True,
    "get_framebuffer_size": (640, 480),
    "get_window_size": (640, 480),
    "get_cursor_pos": (0.0, 0.0),
    "get_time": 0.0,
}


def _offer_glfw() -> None:
    import mujoco

    package: Any = types.ModuleType("mujoco.glfw")
    package.glfw = _Glfw("glfw")
    sys.modules["glfw"] = package.glfw
    sys.modules["mujoco.glfw"] = mujoco.glfw = package


def _say_installed() -> None:
    """Let a program that installs what it needs, or shows what it drew, go on as if that had been done."""
    really_open, really_system = subprocess.Popen, os.system

    class Popen(really_open):  # type: ignore[valid-type,misc]
        def __new__(cls, args: Any, *rest: Any, **options: Any) -> Any:
            return _Installed(args, **options) if _is_done(args) else super().__new__(cls)

    vars(subprocess)["Popen"] = Popen
    vars(os)["system"] = lambda command: 0 if _is_done(command) else really_system(command)


class _Installed:
    """A process that has ended well and said nothing."""

    def __init__(self, args: Any, **options: Any) -> None:
        self.args, self.pid, self.returncode = args, 0, 0
        text = any(options.get(name) for name in ("text", "universal_newlines", "encoding", "errors"))
        self.stdin = self.stdout = self.stderr = io.StringIO() if text else io.BytesIO()

    def __enter__(self) -> _Installed:
        return self

    def __exit__(self, *args: object) -> None:
        """Do nothing: there is no window to close."""

    def communicate(self, *args: Any, **options: Any) -> Any:
        return self.stdout.read(), self.stderr.read()

    def wait(self, timeout: float | None = None) -> int:
        return self.returncode

    def poll(self) -> int:
        return self.returncode


def _is_done(command: Any) -> bool:
    """Return whether the command installs something, or shows a file in a window."""
    words = command.split() if isinstance(command, str) else command if isinstance(command, list | tuple) else []
    names = [os.path.basename(word) for word in words if isinstance(word, str)]
    return ("install" in names and not _INSTALLERS.isdisjoint(names)) or (bool(names) and names[0] in _OPENERS)
