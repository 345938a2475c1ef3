"""Branches of a git clone, read from its files.

No git command runs in the clone, and its settings and hooks are never read, because they can name programs that git would start.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

from grader.base.text import printable, some

_MAX_BYTES = 1_000_000
_MAX_NAMES = 1_000
_PACKED = re.compile(r"^[0-9a-f]{40,64} refs/(?:heads|remotes/[^/\n]+)/(.+)$", re.MULTILINE)
_A_FEW = 5


def branches_note(folder: Path) -> str:
    """Return a note on the other branches of a clone whose checked-out branch has no files of the lab; "" if it has none."""
    git = folder / ".git"
    head = _read(git / "HEAD").strip().removeprefix("ref: refs/heads/")
    branches = {*_PACKED.findall(_read(git / "packed-refs"))}
    for kind in ("heads", *_remotes(git)):
        branches |= _loose(git / "refs" / kind)
    others = [printable(name, 80) for name in sorted(branches - {head, "HEAD"})]
    if not head or not others:
        return ""
    return (
        f"The checked-out branch {printable(head, 80)} of this git clone has no files of the lab. "
        f"Its other branches: {some(others, _A_FEW)}. If one of them has the files, check it out, and grade again."
    )


def _remotes(git: Path) -> list[str]:
    return [f"remotes/{name}" for name in _names(git / "refs" / "remotes", folders=True)]


def _loose(folder: Path) -> set[str]:
    """Return the branches that have a file of their own; a slash in a name makes a folder, one of which is searched."""
    inner = {f"{name}/{last}" for name in _names(folder, folders=True) for last in _names(folder / name)}
    return {*_names(folder), *inner}


def _names(folder: Path, *, folders: bool = False) -> list[str]:
    """Return the first names of files, or of folders, in a folder; links are left out."""
    try:
        with os.scandir(folder) as entries:
            kinds = [
                each.name for each in entries if each.is_dir(follow_symlinks=False) == folders and not each.is_symlink()
            ]
            return sorted(kinds)[:_MAX_NAMES]
    except OSError:
        return []


def _read(path: Path) -> str:
    """Return the beginning of a plain file as text; nothing if there is none."""
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))
        with os.fdopen(handle, "rb") as stream:
            return stream.read(_MAX_BYTES).decode("utf-8", "replace")
    except OSError:
        return ""
