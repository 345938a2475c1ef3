"""The world that student code finds: the lab model at the sheet's path, nobody at the keyboard, no waiting, a fixed seed."""

from __future__ import annotations

import builtins
import contextlib
import io
import os
import pathlib
import random
import signal
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from . import desktop

LAB_MODEL_NAME = "humanoid-sensors.xml"
_SHEET_PATH = f"textbook/assets/robot-models/mujoco/{LAB_MODEL_NAME}"
_MAX_INPUTS = 100


def import_libraries() -> None:
    """Import what every submission needs, pyplot's back end among it: pyplot would wait with that for the first figure."""
    import matplotlib.pyplot as plt
    import mujoco  # noqa: F401
    import PIL.Image  # noqa: F401

    plt.switch_backend("Agg")
    _share_wrappers()


def _share_wrappers() -> None:
    """Let callbacks of a simulation be called: MuJoCo keeps its wrapper classes among the built-in functions of who steps.

    All steps are made by a function of the harness (see `_watch_first_step`), and the harness' built-in functions are its own.
    """
    own = globals()["__builtins__"]
    own.update({name: value for name, value in vars(builtins).items() if name.startswith("__MUJOCO_")})


def use_libraries() -> None:
    """Use each part once, so that a forked worker pays for no first time."""
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
    PIL.Image.init()


def furnish(lab_model: str, *, run_magic: desktop.RunMagic) -> None:
    """Make the worker's process look like the machine that the lab sheet assumes."""
    path = pathlib.Path(_SHEET_PATH)
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(lab_model, encoding="utf-8")
    _redirect_lab_model()
    _answer_input()
    desktop.furnish(run_magic)
    _make_pauses_short()
    _make_signals_deadly()
    _watch_first_step()


def _redirect_lab_model() -> None:
    """A path that ends in the lab model's name and does not exist here means the lab model, to whoever loads, reads or seeks it."""
    import mujoco

    really_stat, really_open = os.stat, builtins.open

    def meant(path: Any) -> Any:
        name = os.fsdecode(path) if isinstance(path, str | bytes | os.PathLike) else ""
        if name.replace("\\", "/").endswith(LAB_MODEL_NAME):
            try:
                really_stat(name)
            except (OSError, ValueError):
                return str(pathlib.Path(_HOME, _SHEET_PATH))
        return path

    def redirecting(load: Callable[..., Any]) -> Callable[..., Any]:
        def from_path(filename: Any = None, *args: Any, **kwargs: Any) -> Any:
            return load(os.fsdecode(meant(kwargs.pop("filename") if filename is None else filename)), *args, **kwargs)

        return from_path

    def stat(path: Any, **options: Any) -> os.stat_result:
        return really_stat(meant(path), **options)

    def opened(file: Any, mode: str = "r", *args: Any, **options: Any) -> Any:
        return really_open(meant(file) if "r" in mode else file, mode, *args, **options)

    mujoco.MjModel.from_xml_path = staticmethod(redirecting(mujoco.MjModel.from_xml_path))
    if hasattr(mujoco, "MjSpec"):
        mujoco.MjSpec.from_file = staticmethod(redirecting(mujoco.MjSpec.from_file))
    vars(os)["stat"] = stat
    vars(builtins)["open"] = vars(io)["open"] = opened
    accessor = getattr(pathlib, "_NormalAccessor", None)  # Python 3.10's paths hold on to both
    if accessor is not None:
        accessor.stat, accessor.open = staticmethod(stat), staticmethod(opened)


_HOME = "."


def settle(folder: str) -> None:
    """Remember the scratch folder: student code may change the working directory."""
    global _HOME  # noqa: PLW0603 - one process, one submission
    _HOME = folder


def _answer_input() -> None:
    asked = 0

    def answer(prompt: object = "") -> str:
        nonlocal asked
        asked += 1
        if asked > _MAX_INPUTS:
            raise EOFError("input() was called more than a hundred times")
        print(prompt)
        return ""

    builtins.input = answer


def _make_pauses_short() -> None:
    """Nobody watches: a pause moves the clocks on instead of waiting, so that real-time loops end as they should."""
    skipped = 0.0
    real = {name: getattr(time, name) for name in ("time", "monotonic", "perf_counter")}

    def sleep(seconds: float) -> None:
        nonlocal skipped
        if seconds < 0:
            raise ValueError("sleep length must be non-negative")
        skipped += float(seconds)

    def moved_on(clock: Callable[[], float]) -> Callable[[], float]:
        return lambda: clock() + skipped

    vars(time)["sleep"] = sleep
    for name, clock in real.items():
        setattr(time, name, moved_on(clock))


def _make_signals_deadly() -> None:
    """A process that kills itself ends: as the first process of its namespace it would survive its own signals."""

    def kill(pid: int, number: int) -> None:
        default = number != 0 and signal.getsignal(number) in (signal.SIG_DFL, None)
        if pid == os.getpid() and default and number not in harmless:
            os._exit(128 + number)
        really_kill(pid, number)

    really_kill = os.kill
    harmless = {getattr(signal, name, None) for name in ("SIGCHLD", "SIGCONT", "SIGURG")}  # Windows has none of them
    vars(os)["kill"] = kill
    vars(signal)["raise_signal"] = lambda number: kill(os.getpid(), number)


FIRST_STEP: dict[str, np.ndarray] = {}
"""The state in which the simulation was when it was first stepped, if `watch_next_run` asked for it."""
_watching = False


def watch_next_run() -> None:
    """Note the state before the next step: a hint for the grader, which runs it again elsewhere before it believes it."""
    global _watching  # noqa: PLW0603 - one process, one submission
    FIRST_STEP.clear()
    _watching = True


def _watch_first_step() -> None:
    import mujoco

    def watched(step: Callable[..., Any]) -> Callable[..., Any]:
        def stepping(model: Any, data: Any, *args: Any, **kwargs: Any) -> Any:
            global _watching  # noqa: PLW0603
            if _watching:
                _watching = False
                FIRST_STEP.update(
                    qpos=np.array(data.qpos), qvel=np.array(data.qvel), gravity=np.array(model.opt.gravity),
                    timestep=np.array([model.opt.timestep], dtype=np.float64),
                    force=np.concatenate([data.qfrc_applied, data.xfrc_applied.ravel()]),
                )  # fmt: skip
            return step(model, data, *args, **kwargs)

        return stepping

    for name in ("mj_step", "mj_step1"):
        setattr(mujoco, name, watched(getattr(mujoco, name)))


def seed(number: int) -> None:
    """Seed every generator that can be seeded, so that a regrade draws the same numbers. No verdict rests on it."""
    random.seed(number)
    np.random.seed(number)
    stream = random.Random(number + 1)
    bit_generator: Any = sys.modules.get("numpy.random.bit_generator")
    if bit_generator is not None and hasattr(bit_generator, "randbits"):
        bit_generator.randbits = stream.getrandbits  # default_rng() without a seed takes its entropy from here


@contextlib.contextmanager
def at_home(folder: str) -> Iterator[None]:
    """Run with the scratch folder as the working directory, whatever an earlier call changed it to."""
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(folder)
