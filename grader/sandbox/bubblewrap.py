"""Run a zygote (the parent process of the workers) in bubblewrap, which may create namespaces where this user may not."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterable

from . import rootfs
from .paths import mount_steps
from .plan import Plan

_SCRATCH_BYTES = 64 << 20


def command(plan: Plan, control_fd: int) -> list[str]:
    """Return the command that starts a zygote (parent process of workers) in bubblewrap, with the files that `plan` makes visible.

    `control_fd` is the descriptor of the socket by which the zygote and the grader communicate.
    """
    arguments = ["--unshare-all", "--chdir", "/"]
    if plan.end_with_parent:
        arguments.append("--die-with-parent")
    for device in rootfs.DEVICES:
        arguments += ["--dev-bind", device, device]
    arguments += _shown([*plan.visible, *_python()], plan.hidden)
    for path in plan.code:
        arguments += ["--ro-bind", path, f"{rootfs.SANDBOX}/{os.path.basename(path)}"]
    for place, folder in rootfs.copies(plan).items():
        arguments += ["--ro-bind", folder, place]
    for folder in (*plan.scratch, plan.cache):
        arguments += ["--size", str(_SCRATCH_BYTES), "--tmpfs", folder]
    for path in plan.fonts:
        arguments += ["--ro-bind-try", path, f"{plan.cache}/{os.path.basename(path)}"]
    arguments += ["--remount-ro", "/"]
    zygote = [_program(), "-B", "-s", f"{rootfs.SANDBOX}/zygote.py", str(control_fd)]
    return [shutil.which("bwrap") or "bwrap", *arguments, "--", *zygote]


def _python() -> Iterable[str]:
    """Return the files to show that Python needs beside its libraries: the program, and a virtual environment's marker."""
    return _program(), os.path.join(sys.prefix, "pyvenv.cfg")


def _program() -> str:
    """Return Python's path without ``..``: the sandbox has no folders on the way up."""
    return os.path.abspath(sys.executable)


def _shown(visible: Iterable[str], hidden: Iterable[str]) -> list[str]:
    arguments: list[str] = []
    steps = mount_steps(visible, hidden)
    for kind, place, target in steps:
        if kind == "link":
            arguments += ["--symlink", target, place]
        elif kind == "show":
            arguments += ["--ro-bind", place, place]
        elif os.path.isdir(place):
            arguments += ["--tmpfs", place]
        else:
            arguments += ["--ro-bind", "/dev/null", place]
    for step in steps:
        if step.kind == "hide" and os.path.isdir(step.place):
            arguments += ["--remount-ro", step.place]
    return arguments
