"""Find what a sandbox needs of this machine, from the running interpreter: Python, packages, shared libraries, fonts."""

from __future__ import annotations

import contextlib
import glob
import importlib.util
import os
import py_compile
import sys
import sysconfig
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

from grader.base import errors

from . import packages
from .paths import is_below

LIBRARIES = ("/lib", "/lib64", "/usr/lib", "/usr/lib64", "/usr/local/lib", "/nix/store", "/gnu/store")
"""Folders of the system with shared libraries: shown whole, but for the packages of any Python in them."""
SYSTEM = (
    "/etc/alternatives",  # links from one library to another
    "/etc/ld.so.cache",
    "/usr/local/share/fonts",
    "/usr/share/fonts",
    "/usr/share/zoneinfo",
)
_PACKAGE_FOLDERS = ("*/{}", "*/lib/*/{}")  # below a folder of libraries; the second in a store of packages
_MODULES_OF_THE_SANDBOX = (
    "arrays",
    "confine",
    "imports",
    "isolation_levels",
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


def visible(extra: Sequence[Path] = (), libraries: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Return the paths that a sandbox shows read-only: system, Python, packages (the lab's `libraries`, too), and `extra`."""
    entries = packages.shown(packages.folders(), libraries)
    return tuple(sorted({*_libraries(), *SYSTEM, *_standard(), *entries, *(os.path.abspath(path) for path in extra)}))


def _libraries() -> tuple[str, ...]:
    """Return the folders of shared libraries, which a sandbox shows: of the system, of Python, and those in LD_LIBRARY_PATH."""
    prefixes = {sys.base_prefix, sys.base_exec_prefix}
    named = filter(os.path.isabs, os.environ.get("LD_LIBRARY_PATH", "").split(":"))
    return (*LIBRARIES, *(os.path.join(prefix, name) for prefix in prefixes for name in ("lib", "lib64")), *named)


def _standard() -> tuple[str, ...]:
    """Return the paths of the standard library: its folder, two if C modules have their own, and an archive if there is one."""
    folders = {os.path.dirname(path) for path in sys.path if os.path.basename(path) == "lib-dynload"}
    archives = {path for path in sys.path if path.endswith(".zip") and os.path.basename(path).startswith("python")}
    return tuple(sorted({sysconfig.get_path("stdlib"), os.path.dirname(os.__file__), *folders, *archives}))


def search(shown: Sequence[str]) -> tuple[str, ...]:
    """Return `sys.path` on levels `full`, `bubblewrap`: the grader's entries at or below `shown` (`visible`), and site-packages."""
    return (*_search_whole(shown), *packages.folders())


def search_by_links(shown: Sequence[str], links: str) -> tuple[str, ...]:
    """Return `sys.path` for level `landlock`: as `search`, but with the folder `links` (`link_packages`) for site-packages."""
    return (*_search_whole(shown), links)


def _search_whole(shown: Sequence[str]) -> tuple[str, ...]:
    real, folders = [os.path.realpath(path) for path in shown], packages.folders()
    others = (path for path in sys.path if path and os.path.abspath(path) not in folders)
    return tuple(path for path in others if os.path.exists(path) and is_below(os.path.realpath(path), real))


def link_packages(folder: str, libraries: tuple[str, ...]) -> None:
    """Make `folder` with links to the packages shown (`libraries`, too): on level `landlock`, Python cannot list site-packages."""
    os.makedirs(os.path.join(folder, "__pycache__"), 0o755)
    for path in packages.shown(packages.folders(), libraries):
        parent, name = os.path.split(path)
        compiled = os.path.basename(parent) == "__pycache__"
        with contextlib.suppress(FileExistsError):
            os.symlink(path, os.path.join(folder, "__pycache__", name) if compiled else os.path.join(folder, name))


def search_without_isolation() -> tuple[str, ...]:
    """Return this interpreter's `sys.path` without the grader's source tree, for workers of the level `none`."""
    source = os.path.normcase(_HERE.parents[1])
    return tuple(
        path
        for path in map(os.path.abspath, filter(None, sys.path))
        if os.path.normcase(os.path.realpath(path)) != source or os.path.basename(path) in packages.FOLDER_NAMES
    )


def hidden() -> tuple[str, ...]:
    """Return the folders that a sandbox shows empty but for paths of `visible()` in them: grader, reference, package folders."""
    grader = _HERE.parent
    return str(grader), str(grader.parent / "reference"), *packages.folders(), *_package_folders(_libraries())


@lru_cache(maxsize=2)
def _package_folders(libraries: Sequence[str]) -> list[str]:
    """Return the folders of installed packages, of whichever Python, below these folders of libraries, to hide them."""
    patterns = [pattern.format(name) for pattern in _PACKAGE_FOLDERS for name in packages.FOLDER_NAMES]
    found = (glob.glob(f"{glob.escape(folder)}/{pattern}") for folder in libraries for pattern in patterns)
    return sorted(path for paths in found for path in paths)


def decoy() -> str:
    """Return the path of a module of the grader that no sandbox may read: the isolation is tested by opening it."""
    return str(Path(errors.__file__).resolve())


def code() -> tuple[str, ...]:
    """Return the host paths of this package's modules that a sandbox runs: in place, or from /sandbox if it has its own root."""
    return tuple(str(_HERE / f"{name}.py") for name in _MODULES_OF_THE_SANDBOX)


def compile_once(folders: Sequence[str]) -> None:
    """Compile the modules in these folders and in this package, and store the bytecode in ``__pycache__``.

    A sandbox may not write, and nothing else imports these modules, so otherwise each sandbox would compile them again.
    """
    for folder in (*map(Path, folders), _HERE):
        if sys.dont_write_bytecode or not os.access(folder, os.W_OK):
            continue
        for module in folder.glob("*.py"):
            if not os.path.exists(importlib.util.cache_from_source(str(module))):
                with contextlib.suppress(OSError):
                    py_compile.compile(str(module), quiet=2)


def zygote() -> str:
    """Return the path of the script with which a zygote (the parent process of workers) is started."""
    return str(_HERE / "zygote.py")


def font_lists() -> tuple[str, ...]:
    """Return the files with matplotlib's lists of fonts, at most eight, to copy into each sandbox: making them takes 150 ms."""
    folder = os.path.expanduser("~/.matplotlib")
    if sys.platform == "linux":
        folder = os.path.join(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "matplotlib")
    folder = os.environ.get("MPLCONFIGDIR") or folder
    return tuple(sorted(glob.glob(os.path.join(glob.escape(folder), "fontlist-*.json")))[:8])


def environment(scratch: str, cache: str) -> dict[str, str]:
    """Return all environment variables of a sandboxed process: none of the grader's own, but LD_LIBRARY_PATH if there is one.

    `scratch` is its home and temporary folder, `cache` the folder for matplotlib's cache.
    """
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
    }
    # Some Pythons find their own libpython by it only.
    libraries = os.environ.get("LD_LIBRARY_PATH")
    return {**literal, "LD_LIBRARY_PATH": libraries} if libraries else literal
