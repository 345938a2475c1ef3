"""Paths of the host: where they lead, link by link, and how to go round what must not be seen."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable, Sequence
from pathlib import PurePosixPath

Link = tuple[str, str]  # where it is, what it says


def is_below(path: str, folders: Iterable[str]) -> bool:
    """Whether `path` is one of the folders or lies in one; all of them free of links."""
    return any(path == folder or path.startswith(folder.rstrip("/") + "/") for folder in folders)


def follow(path: str, root: str = "") -> tuple[str | None, list[Link]]:
    """Follow an absolute path below `root` component by component: /lib is a link to usr/lib here, a folder there.

    Returns
    -------
    tuple
        The place where it ends (without `root`), or None if there is nothing, and the links on the way.
    """
    place, waiting = "/", list(PurePosixPath(path).parts[1:])
    links: list[Link] = []
    for _ in range(1024):  # a loop of links ends here
        if not waiting:
            return place, links
        here = os.path.normpath(os.path.join(place, waiting.pop(0)))
        try:
            is_link = stat.S_ISLNK(os.lstat(root + here).st_mode)
        except OSError:
            return None, links
        if is_link:
            target = os.readlink(root + here)
            links.append((here, target))
            place = "/" if target.startswith("/") else place
            waiting = [part for part in PurePosixPath(target).parts if part != "/"] + waiting
        else:
            place = here
    return None, links


def around(visible: Sequence[str], hidden: Sequence[str]) -> list[str]:
    """The visible paths without the hidden ones: a folder that holds a hidden one is replaced by its other children."""
    kept: list[str] = []
    waiting = list(visible)
    while waiting:
        path = waiting.pop()
        if is_below(path, hidden):
            continue
        if any(is_below(secret, [path]) for secret in hidden):
            waiting.extend(entry.path for entry in os.scandir(path))
        else:
            kept.append(path)
    return sorted(kept)


def empty(folder: str) -> None:
    """Remove what a hostile program left in `folder`: however deep, whatever its modes; links are never followed."""
    fresh = 0
    while entries := list(os.scandir(folder)):
        for entry in entries:
            if not entry.is_dir(follow_symlinks=False):
                os.unlink(entry.path)
                continue
            os.chmod(entry.path, 0o700)
            for child in list(os.scandir(entry.path)):  # one level up, so that no path grows long
                if child.is_dir(follow_symlinks=False):
                    os.chmod(child.path, 0o700)
                fresh += 1
                os.rename(child.path, f"{folder}/..{fresh}")
            os.rmdir(entry.path)
