"""MuJoCo as student code finds it: the robot where the sheet loads it, steps that advance the clock and are recorded, no window."""

from __future__ import annotations

import builtins
import os
import pathlib
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

import mujoco
import numpy as np

from grader.worker import environment, repeatability
from grader.worker.desktop_stubs import Stub

_STEP_S = 2e-4  # about what a step and the reading of two sensors take
_MAX_RUNNING_CALLS = 5000  # at a viewer's window before it is closed: a loop that records 5 s needs 2,500
_MAX_VIEWER_CPU_S = 2.0  # before it is closed: such a loop needs 0.2 s, one that draws at every step never ends
_CPU_CLOCK = time.process_time  # student code finds another one, see `repeatability`
_MAX_MARKS = 1000  # geoms that a program draws into the viewer's scene


def warm_up(thorough: bool) -> None:
    """Prepare MuJoCo once in the parent process; with `thorough`, also simulate a step, as the first step of a process is slow.

    MuJoCo looks for its wrapper classes in the ``__builtins__`` of its caller. The caller of each step is this module (see
    `_watch_steps`), which has a ``__builtins__`` of its own, so MuJoCo's classes are copied into it.
    """
    own = globals()["__builtins__"]
    own.update({name: value for name, value in vars(builtins).items() if name.startswith("__MUJOCO_")})
    if thorough:
        model = mujoco.MjModel.from_xml_string(
            "<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>"
        )
        mujoco.mj_step(model, mujoco.MjData(model))


def install(lab_configuration: Mapping[str, Any]) -> None:
    """Put the robot's model file where the lab sheet loads it, and replace MuJoCo functions, so that student code runs unchanged.

    Loaders then find the model under any missing path, steps are recorded, and viewers and renderers open no window.

    Parameters
    ----------
    lab_configuration
        With ``model`` (MJCF), the name of its file ``model_file``, and ``sheet_model``, the path from which the sheet loads it.
    """
    _place_model(
        pathlib.PurePosixPath(lab_configuration["sheet_model"]),
        lab_configuration["model_file"],
        lab_configuration["model"],
    )
    _open_no_window()
    _watch_steps()


def _place_model(sheet: pathlib.PurePosixPath, file: str, model: str) -> None:
    """Write the model where the lab sheet expects it, and make MuJoCo's loaders find it under any missing path with its file name.

    This holds for the file name on the sheet, too, if an instructor's robot has another one.
    """
    path = pathlib.Path(sheet.parent, file)
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(model, encoding="utf-8")
    for name in (sheet.name, file):
        environment.redirect_missing(name, path.as_posix())
    place = path.resolve()

    def redirecting(load: Callable[..., Any]) -> Callable[..., Any]:
        def from_path(filename: Any = None, *args: Any, **kwargs: Any) -> Any:
            asked = kwargs.pop("filename") if filename is None else filename
            try:
                return load(os.fsdecode(environment.redirected(asked)), *args, **kwargs)
            except ValueError:
                if not environment.is_redirected(asked):
                    raise
                return load(str(place), *args, **kwargs)  # a copy that was handed in without the files that it includes

        return from_path

    mujoco.MjModel.from_xml_path = staticmethod(redirecting(mujoco.MjModel.from_xml_path))
    if hasattr(mujoco, "MjSpec"):
        mujoco.MjSpec.from_file = staticmethod(redirecting(mujoco.MjSpec.from_file))


class _Viewer(Stub):
    """MuJoCo viewer without a window; `is_running` becomes false after a number of calls or some CPU time, so that loops end."""

    def __init__(self, model: Any, data: Any, **_: object) -> None:
        scene = mujoco.MjvScene(model, _MAX_MARKS)
        super().__init__("viewer", m=model, d=data, cam=mujoco.MjvCamera(), opt=mujoco.MjvOption(), user_scn=scene)
        self._glances, self._until_s = _MAX_RUNNING_CALLS, _CPU_CLOCK() + _MAX_VIEWER_CPU_S

    def is_running(self) -> bool:
        self._glances -= 1
        return self._glances >= 0 and _CPU_CLOCK() < self._until_s

    def close(self) -> None:
        self._glances = 0


def _open_no_window() -> None:
    """Replace MuJoCo's viewer and renderer by stubs that accept any call, as no display is there."""
    viewer = Stub("mujoco.viewer", launch_passive=_Viewer, Handle=_Viewer)
    for name, stub in (("glfw", Stub("mujoco.glfw")), ("viewer", viewer)):
        setattr(mujoco, name, stub)
        sys.modules[f"mujoco.{name}"] = stub
    for name in ("Renderer", "GLContext"):
        setattr(mujoco, name, Stub(name))
    sys.modules["glfw"] = Stub("glfw")


_MOST_CHANGES = 2000
_ROUNDING = 1e-12  # a quaternion that was made a unit again is not set from outside


class _RunRecorder:
    """Recorder of a simulation run: its start, and each change of its state between two steps, which student code made."""

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
        """Return the first state, the number of steps, and the states set later with the steps before them; {} without a step."""
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
    state, read = mujoco.mjtState, mujoco.mj_getState
    parts = (state.mjSTATE_QPOS, state.mjSTATE_QVEL, state.mjSTATE_QFRC_APPLIED, state.mjSTATE_XFRC_APPLIED)
    wanted = sum(map(int, parts))  # put together once: that takes ten times as long as the reading
    return lambda model, data, into: read(model, data, into, wanted)


_RECORDER: _RunRecorder | None = None


def watch_next_run() -> None:
    """Record the next simulation run, for `replay`: a worker without student code repeats the run before the grader uses it."""
    global _RECORDER  # noqa: PLW0603 - one process, one submission
    _RECORDER = _RunRecorder()


def watched_run() -> dict[str, np.ndarray]:
    """Stop recording and return the run for `replay`: start, number of steps, and states that code set later; {} without a run."""
    global _RECORDER
    course, _RECORDER = _RECORDER, None
    return course.arrays() if course else {}


def _watch_steps() -> None:
    """Replace MuJoCo's step functions by ones that advance the clock that student code sees, and record the run."""

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
