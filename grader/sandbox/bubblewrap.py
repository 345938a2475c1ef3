"""Running a zygote in bubblewrap, which may make namespaces where this user may not."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterable

from . import rootfs
from .paths import follow, is_below
from .plan import Plan

_SCRATCH_BYTES = 64 << 20


def is_installed() -> bool:
    return shutil.which("bwrap") is not None


def command(plan: Plan, control_fd: int) -> list[str]:
    """The command line of a zygote in bubblewrap, with the same root as `rootfs` makes."""
    arguments = ["--unshare-all", "--chdir", "/"]
    if plan.end_with_parent:
        arguments.append("--die-with-parent")
    for device in rootfs.DEVICES:
        arguments += ["--dev-bind", device, device]
    arguments += _shown([*plan.visible, *_python()], plan.hidden)
    for path in plan.code:
        arguments += ["--ro-bind", path, f"{rootfs.SANDBOX}/{os.path.basename(path)}"]
    arguments += ["--ro-bind", plan.harness, rootfs.HARNESS]
    for folder in (*plan.scratch, plan.cache):
        arguments += ["--size", str(_SCRATCH_BYTES), "--tmpfs", folder]
    for path in plan.fonts:
        arguments += ["--ro-bind-try", path, f"{plan.cache}/{os.path.basename(path)}"]
    arguments += ["--remount-ro", "/"]
    zygote = [sys.executable, "-B", "-s", f"{rootfs.SANDBOX}/zygote.py", str(control_fd)]
    return [shutil.which("bwrap") or "bwrap", *arguments, "--", *zygote]


def _python() -> Iterable[str]:
    """What starting the interpreter needs beside its libraries: the program and a virtual environment's marker."""
    return sys.executable, os.path.join(sys.prefix, "pyvenv.cfg")


def _shown(visible: Iterable[str], hidden: Iterable[str]) -> list[str]:
    arguments: list[str] = []
    shown: list[str] = []
    repeated: set[str] = set()
    for path in sorted(visible, key=lambda p: p.count("/")):
        place, links = follow(path)
        for here, target in links:
            if here not in repeated and not is_below(here, shown):
                arguments += ["--symlink", target, here]
                repeated.add(here)
        if place is not None and not is_below(place, shown):
            arguments += ["--ro-bind", place, place]
            shown.append(place)
    for path in hidden:
        if is_below(path, shown) and os.path.isdir(path):
            arguments += ["--tmpfs", path, "--remount-ro", path]
    return arguments
