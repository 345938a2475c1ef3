"""Find the lab's files in a submission: the folder that holds them, and the files around it."""

from __future__ import annotations

import posixpath
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from grader.base.text import printable
from grader.intake.file_budget import CASE, UNPORTABLE, FileBudget, listing
from grader.intake.names import folded, is_code, portable

MAX_LEVELS = 4  # how far down the lab's folder may lie


@dataclass(frozen=True)
class Layout:
    """Which files of a submission are graded: those in the folder with the lab's files, and files around it that these may import.

    Attributes
    ----------
    folder : the folder with the lab's files; "" is the top of the submission
    inside : paths of the files in that folder, relative to it, sorted
    above : files outside `folder`: each file's path from the nearest folder that holds both the file and `folder`, and how many
        levels above `folder` that folder lies
    notes : sentences for the report
    """

    folder: str
    inside: tuple[str, ...]
    above: Mapping[str, int]
    notes: tuple[str, ...]


def lay_out(budget: FileBudget, required: Collection[str]) -> Layout | None:
    """Choose the lab's folder in a submission, and return it with its files; None without code up to `MAX_LEVELS` folders down.

    It is a folder with files that the lab asks for (`required`), or if there is none, with any code; of several the shallowest,
    then that with most such files. A file in it whose name some systems cannot store, or confuse with another file's, is left out
    and listed in `budget.left`.
    """
    found = _choose(budget.files, required)
    if found is None:
        return None
    folder, others = found
    elsewhere = [path for path in budget.files if not any(_within(path, f) for f in (folder, *others))]
    inside = _inside(folder, budget, required)
    above = _around(folder, elsewhere, inside)
    return Layout(folder, inside, above, tuple(_notes(folder, others, filter(is_code, elsewhere), above)))


def outwards(folder: str, levels: int) -> str:
    """Return the folder that lies `levels` above `folder`, with a slash at its end, to put before a path; "" for the top."""
    parts = folder.split("/") if folder else []
    return "".join(f"{part}/" for part in parts[: len(parts) - levels])


def _choose(paths: Iterable[str], required: Collection[str]) -> tuple[str, list[str]] | None:
    """Return the lab's folder, and the other folders that hold files of the same names; None without any code.

    The lab's folder is one with required files, or else with any code: the shallower, then the more complete, then by name.
    """
    folders: dict[str, set[str]] = {}
    for path in filter(is_code, paths):
        folder, _, name = path.rpartition("/")
        if _level(folder) <= MAX_LEVELS:
            folders.setdefault(folder, set()).add(name)
    complete = {folder: len(names.intersection(required)) for folder, names in folders.items()}
    qualified = [folder for folder in folders if complete[folder]] or list(folders)
    if not qualified:
        return None
    chosen, *rest = sorted(qualified, key=lambda f: (_level(f), -complete[f], -len(folders[f]), f))
    others, there = [], folders[chosen]
    for folder in rest:
        if folders[folder].intersection(there, required):
            others.append(folder)
        else:  # the lab's files lie in more than one folder
            there = there | folders[folder]
    return chosen, others


def _level(folder: str) -> int:
    return folder.count("/") + 1 if folder else 0


def _within(path: str, folder: str) -> bool:
    return not folder or path.startswith(f"{folder}/")


def _inside(folder: str, budget: FileBudget, required: Collection[str]) -> tuple[str, ...]:
    """Return the paths in the lab's folder, sorted, without names that some systems cannot store or confuse with another."""
    start = len(folder) + 1 if folder else 0
    inside = sorted(path[start:] for path in budget.files if _within(path, folder))
    kept: dict[str, str] = {}
    for path in sorted(inside, key=lambda p: p not in required):
        if not portable(path):
            budget.leave(path, UNPORTABLE)
        elif kept.setdefault(folded(path), path) != path:
            budget.leave(path, CASE)
    folders = {above for key in kept for above in _folders(key)}  # a file of that name would stand in their way
    return tuple(sorted(path for key, path in kept.items() if key not in folders))


def _around(folder: str, elsewhere: Iterable[str], inside: Iterable[str]) -> dict[str, int]:
    """Return the files that belong to the lab's folder from above it, as in `Layout.above`.

    A program that is started in a folder above finds what is there and imports the lab's files out of their folder. So both are one
    submission, and a name further inside goes before one further outside. Notebooks of other folders are left, because notebooks
    are run, and so is an ``__init__.py``: it would speak for the lab's folder.
    """
    files = set(map(folded, inside))
    folders = {above for key in files for above in _folders(key)}
    around: dict[str, int] = {}
    for levels, path in sorted(_from_above(path, folder) for path in elsewhere):
        key = folded(path)
        barred = path == "__init__.py" or (path.endswith(".ipynb") and "/" in path) or not portable(path)
        if not barred and key not in files | folders and files.isdisjoint(_folders(key)):
            around[path] = levels
            files.add(key)
            folders.update(_folders(key))
    return around


def _from_above(path: str, folder: str) -> tuple[int, str]:
    """Return how many levels above the lab's folder the nearest folder around `path` lies, and the path seen from there."""
    shared = posixpath.commonpath((posixpath.dirname(path), folder))
    return _level(folder) - _level(shared), path[len(shared) + 1 :] if shared else path


def _folders(path: str) -> Iterable[str]:
    """Return the folders in a path, the outermost first, such as to see whether a file has the name of one."""
    parts = path.split("/")
    return ("/".join(parts[:n]) for n in range(1, len(parts)))


def _notes(folder: str, others: list[str], elsewhere: Iterable[str], above: Mapping[str, int]) -> Iterable[str]:
    """Yield the notes on the chosen folder, and on the code that lies `elsewhere`, graded with it or not."""
    here = printable(folder) or "the top folder"
    if others:
        yield f"More than one folder holds the lab's files: {here} was graded, not {listing(others)}."
    taken = {outwards(folder, levels) + path for path, levels in above.items()}
    code = sorted(path for path in elsewhere if path in taken or posixpath.basename(path) != "__init__.py")
    if used := [path for path in code if path in taken]:
        yield f"The lab's files were found in {here}; looked at with them: {listing(used)}."
    elif _level(folder) > 1 and not others:
        yield f"The lab's files were found in {here}."
    if left := [path for path in code if path not in taken]:
        yield f"Not looked at, because the lab's files are in {here}: {listing(left)}."
