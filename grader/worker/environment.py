"""Runtime environment of student code: the robot at the sheet's path, empty answers to `input`, no waiting, a fixed seed."""

from __future__ import annotations

import builtins
import contextlib
import io
import os
import pathlib
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from . import compat, desktop_stubs, repeatability

_MAX_INPUTS = 100


def import_libraries() -> None:
    """Import the libraries of every submission and pyplot's back end in the zygote, so that no worker pays for them."""
    with contextlib.suppress(ImportError):
        import _ssl  # noqa: F401 - see `repeatability`

    import matplotlib.pyplot as plt
    import mujoco  # noqa: F401
    import numpy.random  # noqa: F401
    import PIL.Image  # noqa: F401

    plt.switch_backend("Agg")
    _share_wrappers()


def _share_wrappers() -> None:
    """Let callbacks of a simulation be called: MuJoCo keeps its wrapper classes among the built-in functions of who steps.

    All steps are made by a function of the worker code (see `_watch_steps`), and the worker's built-in functions are its own.
    """
    own = globals()["__builtins__"]
    own.update({name: value for name, value in vars(builtins).items() if name.startswith("__MUJOCO_")})


def use_libraries() -> None:
    """Use each library once, so that no forked worker pays for its first use."""
    import matplotlib.pyplot as plt
    import mujoco
    import PIL.Image

    figure, axes = plt.subplots(2, 1, sharex=True)
    axes[0].plot([0, 1], [0, 1], label=r"m/s² $m/s^2$")
    axes[0].set_title("warm up")
    axes[0].legend()
    figure.tight_layout()
    figure.canvas.draw()
    plt.close("all")
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>"
    )
    mujoco.mj_step(model, mujoco.MjData(model))
    PIL.Image.preinit()


def install(lab_configuration: Mapping[str, Any], *, run_magic: desktop_stubs.RunMagic) -> None:
    """Make the worker's process look like the machine that the lab sheet assumes.

    Parameters
    ----------
    lab_configuration
        With ``model`` (MJCF), the name of its file ``model_file``, and ``sheet_model``, the path from which the sheet loads it.
    run_magic
        Runs the file of a notebook's ``%run``.
    """
    if "model" in lab_configuration:
        _place_model(
            pathlib.PurePosixPath(lab_configuration["sheet_model"]),
            lab_configuration["model_file"],
            lab_configuration["model"],
        )
    _answer_input()
    compat.install()
    desktop_stubs.install(run_magic)
    repeatability.install(_HOME)
    _disable_hooks()
    _exit_on_own_signals()
    _watch_steps()


def _place_model(sheet: pathlib.PurePosixPath, file: str, model: str) -> None:
    """Write the model where the sheet expects it, and redirect other paths with its name to that file."""
    path = pathlib.Path(sheet.parent, file)
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(model, encoding="utf-8")
    _redirect_model(path.as_posix(), sheet.name)


def _redirect_model(place: str, sheets_name: str) -> None:
    """Redirect each missing path that ends in the model's name to the model, in `open`, `os.stat` and MuJoCo's loaders.

    The name on the sheet is redirected, too, if an instructor's robot has another name.
    """
    import mujoco

    really_stat, really_open = os.stat, builtins.open
    names = (sheets_name, place.rpartition("/")[2])

    def named(path: Any) -> str:
        name = os.fsdecode(path) if isinstance(path, str | bytes | os.PathLike) else ""
        return name if name.replace("\\", "/").endswith(names) else ""

    def meant(path: Any) -> Any:
        if name := named(path):
            try:
                really_stat(name)
            except (OSError, ValueError):
                return str(pathlib.Path(_HOME, place))
        return path

    def redirecting(load: Callable[..., Any]) -> Callable[..., Any]:
        def from_path(filename: Any = None, *args: Any, **kwargs: Any) -> Any:
            asked = kwargs.pop("filename") if filename is None else filename
            try:
                return load(os.fsdecode(meant(asked)), *args, **kwargs)
            except ValueError:
                if not named(asked):
                    raise
                # A copy that was handed in without the files that it includes.
                return load(str(pathlib.Path(_HOME, place)), *args, **kwargs)

        return from_path

    def stat(path: Any, **options: Any) -> os.stat_result:
        return really_stat(meant(path), **options)

    def opened(file: Any, mode: str = "r", *args: Any, **options: Any) -> Any:
        if "r" not in mode:
            _make_parent_folder(file)
        return really_open(meant(file) if "r" in mode else file, mode, *args, **options)

    mujoco.MjModel.from_xml_path = staticmethod(redirecting(mujoco.MjModel.from_xml_path))
    if hasattr(mujoco, "MjSpec"):
        mujoco.MjSpec.from_file = staticmethod(redirecting(mujoco.MjSpec.from_file))
    vars(os)["stat"] = stat
    vars(builtins)["open"] = vars(io)["open"] = opened
    accessor = getattr(pathlib, "_NormalAccessor", None)  # Python 3.10's paths hold on to both
    if accessor is not None:
        accessor.stat, accessor.open = staticmethod(stat), staticmethod(opened)


def _make_parent_folder(file: Any) -> None:
    """Create the folder of a file that student code writes. It may exist on the student's computer; archives lack empty folders."""
    if isinstance(file, str | os.PathLike):
        with contextlib.suppress(OSError, ValueError, TypeError, RecursionError):
            os.makedirs(os.path.dirname(os.fspath(file)) or ".", exist_ok=True)


_HOME = "."


def remember_folder(folder: str) -> None:
    """Remember the scratch folder, because student code may change the working directory."""
    global _HOME  # noqa: PLW0603 - one process, one submission
    _HOME = folder


def _answer_input() -> None:
    """Make `input` print its prompt and return an empty line, a hundred times at most."""
    asked = 0

    def answer(prompt: object = "") -> str:
        nonlocal asked
        asked += 1
        if asked > _MAX_INPUTS:
            raise EOFError("input() was called more than a hundred times")
        print(prompt)
        return ""

    builtins.input = answer


_STEP_S = 2e-4  # about what a step and the reading of two sensors take


def _disable_hooks() -> None:
    """Ignore trace, profile and audit hooks of student code: an error in one would end a statement of the grader's."""
    vars(sys).update(settrace=_no_hook, setprofile=_no_hook, addaudithook=_no_hook)
    monitoring = getattr(sys, "monitoring", None)  # since Python 3.12
    if monitoring is not None:
        vars(monitoring)["register_callback"] = _no_hook


def _no_hook(*args: Any) -> None:
    """Stand in for a function that registers a hook."""


def _exit_on_own_signals() -> None:
    """Make a process that signals itself exit: the first process of a PID namespace would ignore its own signals."""

    def kill(pid: int, number: int) -> None:
        default = number != 0 and signal.getsignal(number) in (signal.SIG_DFL, None)
        if pid in (os.getpid(), repeatability.PID) and default and number not in harmless:
            os._exit(128 + number)
        really_kill(pid, number)

    really_kill = os.kill
    harmless = {getattr(signal, name, None) for name in ("SIGCHLD", "SIGCONT", "SIGURG")}  # Windows has none of them
    vars(os)["kill"] = kill
    vars(signal)["raise_signal"] = lambda number: kill(os.getpid(), number)


_MOST_CHANGES = 2000
_ROUNDING = 1e-12  # a quaternion that was made a unit again is not set from outside


class _RunRecorder:
    """Recorder of a simulation run: its start, and each change of its state between two steps."""

    def __init__(self) -> None:
        self._read_state = _state_reader()
        self._steps = 0
        self._data: Any = None
        self._first: dict[str, np.ndarray] = {}
        self._left = self._found = np.empty(0)
        self._changes: list[tuple[int, np.ndarray]] = []

    def before_step(self, model: Any, data: Any) -> None:
        if self._data is None:
            self._data = data
            self._first = {
                "qpos": np.array(data.qpos), "qvel": np.array(data.qvel), "force": _forces(data),
                "gravity": np.array(model.opt.gravity), "timestep": np.array([model.opt.timestep], dtype=np.float64),
            }  # fmt: skip
            self._left = np.concatenate([self._first[name] for name in _STATE_PARTS])
            self._found = self._left.copy()
        elif data is self._data and len(self._changes) < _MOST_CHANGES:
            self._read_state(model, data, self._found)
            as_left = self._found.tobytes() == self._left.tobytes()  # as nearly always, and told in no time
            if not as_left and (np.abs(self._found - self._left) > _ROUNDING).any():
                self._changes.append((self._steps, self._found.copy()))

    def after_step(self, model: Any, data: Any, count: int) -> None:
        if data is self._data:
            self._steps += count
            self._read_state(model, data, self._left)

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the first state, the number of steps, and the later changes: before which steps, and to which states."""
        if not self._first:
            return {}
        states = np.array([state for _, state in self._changes]).reshape(-1, len(self._left))
        ends = np.cumsum([len(self._first[name]) for name in _STATE_PARTS])[:-1]
        return {
            **self._first,
            "steps": np.array([self._steps], np.float64),
            "set_at": np.array([step for step, _ in self._changes], np.float64),
            **{f"set_{name}": part for name, part in zip(_STATE_PARTS, np.split(states, ends, axis=1), strict=True)},
        }


_STATE_PARTS = ("qpos", "qvel", "force")
"""Parts of the state that code may set between two steps, in MuJoCo's order."""


def _forces(data: Any) -> np.ndarray:
    return np.concatenate([data.qfrc_applied, data.xfrc_applied.ravel()])


def _state_reader() -> Callable[[Any, Any, np.ndarray], None]:
    """Return a function that copies positions, velocities and applied forces into one array, ten times faster than separately."""
    import mujoco

    state, read = mujoco.mjtState, mujoco.mj_getState
    parts = (state.mjSTATE_QPOS, state.mjSTATE_QVEL, state.mjSTATE_QFRC_APPLIED, state.mjSTATE_XFRC_APPLIED)
    wanted = sum(map(int, parts))  # put together once: that takes ten times as long as the reading
    return lambda model, data, into: read(model, data, into, wanted)


_RECORDER: _RunRecorder | None = None


def watch_next_run() -> None:
    """Record the next simulation run. The grader simulates it again elsewhere before it uses the record."""
    global _RECORDER  # noqa: PLW0603 - one process, one submission
    _RECORDER = _RunRecorder()


def watched_run() -> dict[str, np.ndarray]:
    """Return the record of the run, and stop recording."""
    global _RECORDER
    course, _RECORDER = _RECORDER, None
    return course.arrays() if course else {}


def _watch_steps() -> None:
    """Replace MuJoCo's step functions by ones that advance the clock and record the run."""
    import mujoco

    def watched(step: Callable[..., Any], *, begins: bool, ends: bool) -> Callable[..., Any]:
        def stepping(model: Any, data: Any, *args: Any, **kwargs: Any) -> Any:
            if _RECORDER and begins:
                _RECORDER.before_step(model, data)
            made = step(model, data, *args, **kwargs)
            count = (args[0] if args else kwargs.get("nstep", 1)) if ends else 0
            repeatability.CLOCK.advance(_STEP_S * count)
            if _RECORDER and ends:
                _RECORDER.after_step(model, data, count)
            return made

        return stepping

    for name, begins, ends in (("mj_step", True, True), ("mj_step1", True, False), ("mj_step2", False, True)):
        setattr(mujoco, name, watched(getattr(mujoco, name), begins=begins, ends=ends))


@contextlib.contextmanager
def in_scratch_folder(folder: str) -> Iterator[None]:
    """Run with the scratch folder as the working directory, whatever an earlier call changed it to."""
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(folder)
