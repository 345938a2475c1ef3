"""The file system of a sandbox: a read-only root with Python and its packages; no /proc, no /dev/shm, no /tmp, no /home.

After pivot_root the host lies under /old for as long as the binds are made, so that no path of the host is hidden by a mount of
ours: Python itself may lie below /tmp or /root.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

from . import linux
from .paths import mount_steps
from .plan import Plan

OLD = "/old"
SCRATCH = "/box"
CACHE = "/cache"  # the zygote's: matplotlib's list of fonts; read-only before the first worker
SANDBOX = "/sandbox"
WORKER_CODE = "/worker"
QUESTIONS = "/questions"
DEVICES = ("/dev/null", "/dev/zero", "/dev/urandom", "/dev/random")

_READ_ONLY = linux.MS_RDONLY | linux.MS_NOSUID | linux.MS_NODEV
_SCRATCH_OPTIONS = "size=64m,nr_inodes=4096,mode=700"


def enter_new_root() -> None:
    """Make an empty file system in memory the root, the host's root now being /old; the process needs its own mount namespace."""
    linux.mount("none", "/", flags=linux.MS_REC | linux.MS_PRIVATE)
    base = "/tmp" if os.path.isdir("/tmp") else "/dev"
    linux.mount("tmpfs", base, "tmpfs", linux.MS_NOSUID | linux.MS_NODEV, "size=16m,mode=755")
    os.mkdir(base + OLD)
    linux.pivot_root(base, base + OLD)
    os.chdir("/")


def fill_root(visible: Sequence[str], hidden: Sequence[str], code: Sequence[str], folders: Mapping[str, str]) -> None:
    """Mount what a sandbox may see at its new root; the host's files lie below /old until `close_root`.

    Parameters
    ----------
    visible
        Absolute paths of the host, shown read-only at the same place; those that do not exist are left out.
    hidden
        Files and folders below the visible ones that appear empty.
    code
        Paths of the sandbox's own modules, copied to `SANDBOX`.
    folders
        Folders to copy, by their new path (`WORKER_CODE`, `QUESTIONS`): the original may be readable by root alone.
    """
    _show_all(visible, hidden)
    for device in DEVICES:
        _bind(OLD + device, device, linux.MS_NOSUID | linux.MS_NOEXEC)
    for path in code:
        _write(f"{SANDBOX}/{os.path.basename(path)}", _read(OLD + path))
    for place, folder in folders.items():
        _copy_folder(OLD + folder, place)
    _write("/etc/passwd", b"student:x:1000:1000::/box:/bin/false\n")
    _write("/etc/group", b"student:x:1000:\n")
    os.mkdir(SCRATCH, 0o755)
    _mount_cache()


def copies(plan: Plan) -> Mapping[str, str]:
    """Return {path in the sandbox: path on the host} of the folders of worker code (ours and the lab's), which are copied there."""
    return {WORKER_CODE: plan.worker_code, **({QUESTIONS: plan.questions} if plan.questions else {})}


def close_root() -> None:
    """Unmount the host's files and make the root read-only, so that no worker sees those files or changes the root."""
    linux.umount(OLD)
    os.rmdir(OLD)
    linux.mount_setattr("/", _READ_ONLY, recursive=False)


def _mount_cache() -> None:
    os.mkdir(CACHE, 0o755)
    flags = linux.MS_NOSUID | linux.MS_NODEV | linux.MS_NOEXEC
    linux.mount("tmpfs", CACHE, "tmpfs", flags, "size=16m,mode=777")


def freeze_cache() -> None:
    """Make the folder with matplotlib's lists of fonts read-only: a worker could otherwise leave data there for the next one."""
    linux.mount_setattr(CACHE, _READ_ONLY | linux.MS_NOEXEC, recursive=False)


def mount_scratch() -> None:
    """Mount an empty folder in memory at `SCRATCH`, which only this worker can write; it ends with the worker's mount namespace."""
    flags = linux.MS_NOSUID | linux.MS_NODEV | linux.MS_NOEXEC
    linux.mount("tmpfs", SCRATCH, "tmpfs", flags, _SCRATCH_OPTIONS)


# Binding --------------------------------------------------------------------------------------------------------------


def _show_all(visible: Sequence[str], hidden: Sequence[str]) -> None:
    steps = mount_steps(visible, hidden, OLD)
    for kind, place, target in steps:
        if kind == "link":
            _link(target, place)
        elif kind == "show":
            _bind(OLD + place, place, _READ_ONLY)
        else:
            _cover(place)
    for step in steps:
        if step.kind == "hide":
            linux.mount_setattr(step.place, _READ_ONLY | linux.MS_NOEXEC, recursive=False)


def _link(target: str, here: str) -> None:
    """Repeat a symbolic link of the host in the sandbox, unless its path exists there already."""
    if not os.path.lexists(here):
        os.makedirs(os.path.dirname(here), exist_ok=True)
        os.symlink(target, here)


def _cover(place: str) -> None:
    """Hide a path: mount an empty file system over a folder, or /dev/null over a file."""
    if os.path.isdir(place):
        linux.mount("tmpfs", place, "tmpfs", options="size=4k,mode=755")
    else:
        linux.mount(OLD + "/dev/null", place, flags=linux.MS_BIND)


def _bind(source: str, target: str, attributes: int) -> None:
    if os.path.isdir(source):
        os.makedirs(target, exist_ok=True)
    else:
        _write(target, b"")
    linux.mount(source, target, flags=linux.MS_BIND | linux.MS_REC)
    linux.mount_setattr(target, attributes, recursive=True)


def _copy_folder(source: str, target: str) -> None:
    os.mkdir(target)
    for entry in os.scandir(source):
        place = f"{target}/{entry.name}"
        if entry.is_dir() and entry.name != "__pycache__":
            _copy_folder(entry.path, place)
        elif entry.is_file():
            _write(place, _read(entry.path))


def _read(path: str) -> bytes:
    with open(path, "rb") as file:
        return file.read()


def _write(path: str, data: bytes) -> None:
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "xb") as file:
        file.write(data)
