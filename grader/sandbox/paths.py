"""Paths of the host: follow their links, and choose what a sandbox shows so that nothing hidden is seen."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable, Mapping
from pathlib import PurePosixPath
from typing import NamedTuple

Link = tuple[str, str]  # where it is, what it says


class Step(NamedTuple):
    """Step of building a sandbox's root; `kind`: "show" path `place`, "hide" it (it appears empty), or "link" it to `target`."""

    kind: str
    place: str
    target: str = ""


def is_below(path: str, folders: Iterable[str]) -> bool:
    """Return whether `path` is one of the folders or lies in one. Links are not followed: the paths must contain none."""
    return any(path == folder or path.startswith(folder.rstrip("/") + "/") for folder in folders)


def follow(path: str, root: str = "") -> tuple[str | None, list[Link]]:
    """Resolve a path's symbolic links: return the path that it leads to, and a pair (link, target) for each link on the way.

    Paths count from the folder `root`, where the host's files lie. The path is None if nothing exists there. A sandbox repeats
    the links, such as /lib to usr/lib.
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


def mount_steps(visible: Iterable[str], hidden: Iterable[str], root: str = "") -> list[Step]:
    """Return the steps by which a sandbox's root shows `visible` without `hidden`, outer folders first.

    A visible path below a hidden one is shown. Paths that do not exist below `root`, where the host's files lie, are left out.
    """
    wanted = [("hide", path) for path in hidden] + [("show", path) for path in visible]
    done: dict[str, str] = {}
    steps: dict[Step, None] = {}
    followed = [(kind, *follow(path, root)) for kind, path in wanted]
    for kind, place, links in sorted(followed, key=lambda found: (found[1] or "").count("/")):
        if kind == "show":
            steps.update({Step("link", *link): None for link in links if _kind_over(link[0], done) != "show"})
        if place is not None and place not in done and (kind == "show") != (_kind_over(place, done) == "show"):
            done[place] = kind
            steps[Step(kind, place)] = None
    return list(steps)


def _kind_over(path: str, done: Mapping[str, str]) -> str:
    """Return which step ("show", "hide") already covers a path, by itself or by a folder around it; "" if none does."""
    while path not in done and path != "/":
        path = os.path.dirname(path)
    return done.get(path, "")


def shown_and_listed(steps: Iterable[Step]) -> tuple[list[str], list[str]]:
    """Return the paths that a sandbox shows whole, and the folders that it may only list, as hidden paths lie below them.

    Landlock needs both lists, because its rules allow paths and cannot exclude any.
    """
    steps = list(steps)
    hidden = [step.place for step in steps if step.kind == "hide"]
    whole: list[str] = []
    split: list[str] = []
    waiting = [step.place for step in steps if step.kind == "show"]
    while waiting:
        path = waiting.pop()
        if path in hidden:
            continue
        if any(is_below(secret, [path]) for secret in hidden):
            split.append(path)
            waiting.extend(entry.path for entry in os.scandir(path))
        else:
            whole.append(path)
    return sorted(whole), sorted(split)


def empty_folder(folder: str) -> None:
    """Delete all in `folder`, even a hostile program's deep trees and locked folders; follow no links. May raise OSError."""
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
