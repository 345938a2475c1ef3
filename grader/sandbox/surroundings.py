"""What a box needs of this machine: Python, packages, shared libraries, fonts; found from the running interpreter."""

from __future__ import annotations

import glob
import importlib.util
import os
import sys
import sysconfig
from collections.abc import Sequence
from pathlib import Path

from .paths import is_below

_PACKAGE_FOLDERS = ("site-packages", "dist-packages")
_SYSTEM = (
    "/lib",
    "/lib32",
    "/lib64",
    "/usr/lib",
    "/usr/lib32",
    "/usr/lib64",
    "/usr/local/lib",
    "/etc/ld.so.cache",
    "/etc/fonts",
    "/usr/share/fonts",
    "/usr/local/share/fonts",
    "/usr/share/fontconfig",
    "/usr/share/zoneinfo",
    "/nix/store",
    "/gnu/store",
)
_MODULES_OF_THE_BOX = (
    "arrays",
    "confine",
    "imports",
    "landlock",
    "limits",
    "linux",
    "namespaces",
    "paths",
    "plain_worker",
    "plan",
    "rootfs",
    "seccomp",
    "serve",
    "syscalls",
    "wire",
    "worker",
    "zygote",
)
_HERE = Path(__file__).resolve().parent


def visible(extra: Sequence[Path] = ()) -> tuple[str, ...]:
    """Paths that a box shows read-only. Never a whole prefix: /usr/src or /opt/lab/submissions may lie in one."""
    prefixes = {sys.prefix, sys.base_prefix, sys.exec_prefix, sys.base_exec_prefix}
    libraries = {os.path.join(prefix, name) for prefix in prefixes for name in ("lib", "lib64")}
    standard = {sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")}
    asked = {os.path.abspath(path) for path in extra}
    return tuple(sorted({*_SYSTEM, *libraries, *standard, *_packages(), *asked}))


def _packages() -> set[str]:
    """Folders of installed packages, also a user's own or one of PYTHONPATH, which `-s` and a bare environment hide."""
    spec = importlib.util.find_spec("numpy")
    numpy = {str(Path(spec.origin).parents[1])} if spec and spec.origin else set()
    return numpy | {os.path.abspath(path) for path in sys.path if os.path.basename(path) in _PACKAGE_FOLDERS}


def search(shown: Sequence[str]) -> tuple[str, ...]:
    """This interpreter's `sys.path` as far as a box shows it."""
    real = [os.path.realpath(path) for path in shown]
    return tuple(path for path in sys.path if path and os.path.exists(path) and is_below(os.path.realpath(path), real))


def search_without_walls() -> tuple[str, ...]:
    """This interpreter's `sys.path` without the grader's source tree, on any system."""
    source = os.path.normcase(_HERE.parents[1])
    return tuple(
        path
        for path in map(os.path.abspath, filter(None, sys.path))
        if os.path.normcase(os.path.realpath(path)) != source or os.path.basename(path) in _PACKAGE_FOLDERS
    )


def hidden() -> tuple[str, ...]:
    """The grader and the reference solution, which may be installed among the packages that a box shows."""
    grader = _HERE.parent
    return str(grader), str(grader.parent / "reference")


def decoy() -> str:
    """A file of the grader that no box may read."""
    return str(_HERE.parent / "errors.py")


def code() -> tuple[str, ...]:
    """The sandbox's modules that run in a box."""
    return tuple(str(_HERE / f"{name}.py") for name in _MODULES_OF_THE_BOX)


def zygote() -> str:
    """The script that a zygote is."""
    return str(_HERE / "zygote.py")


def font_lists() -> tuple[str, ...]:
    """matplotlib's lists of fonts that this user already has, where `matplotlib.get_cachedir()` is."""
    folder = os.path.expanduser("~/.matplotlib")
    if sys.platform == "linux":
        folder = os.path.join(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "matplotlib")
    folder = os.environ.get("MPLCONFIGDIR") or folder
    return tuple(sorted(glob.glob(os.path.join(glob.escape(folder), "fontlist-*.json")))[:8])


def environment(scratch: str, cache: str) -> dict[str, str]:
    """Everything that a boxed process finds in its environment; nothing of the grader's own."""
    literal = {
        "PATH": "/usr/bin:/bin",
        "HOME": scratch,
        "TMPDIR": scratch,
        "USER": "student",
        "LOGNAME": "student",
        "LANG": "C.UTF-8",
        "LC_ALL": "C.UTF-8",
        "TZ": "UTC",
        "PYTHONHASHSEED": "0",
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYTHONUTF8": "1",
        "OPENBLAS_NUM_THREADS": "1",  # one thread: the same sums every time, and no pool to fork
        "OMP_NUM_THREADS": "1",
        "MKL_NUM_THREADS": "1",
        "MPLBACKEND": "Agg",
        "MPLCONFIGDIR": cache,
        "MUJOCO_GL": "disable",
    }
    # Some Pythons find their own libpython by it only.
    libraries = os.environ.get("LD_LIBRARY_PATH")
    return {**literal, "LD_LIBRARY_PATH": libraries} if libraries else literal
