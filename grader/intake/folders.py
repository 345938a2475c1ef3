"""Read the files of a folder without following links or opening anything that is not a plain file."""

from __future__ import annotations

import os
import stat
from collections.abc import Collection, Iterable, Iterator
from itertools import islice
from pathlib import Path

from grader.base.errors import RequestError
from grader.base.text import printable
from grader.intake.file_budget import LINK, LONG, MAX_FILE, REFUSED, SPECIAL, FileBudget
from grader.intake.names import HOME_VERSIONS, MAX_PARTS, is_litter

MAX_ENTRIES = 50_000
# A pipe would block the open, a link could have come after the listing; on Windows these flags do not exist.
_FLAGS = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


def gather_folder(root: Path, required: Collection[str] = ()) -> FileBudget:
    """Return a `FileBudget` with a handed-in folder's files, sorted by path; it keeps room for the lab's `required` files."""
    budget = FileBudget(required=required)
    for parts, path, size in sorted(_listed(root, budget)):
        _take(budget, parts, path, size)
    return budget


def gather_places(root: Path, places: Iterable[tuple[str, str]], required: Collection[str] = ()) -> FileBudget:
    """Return a `FileBudget` with a submission's files in a class's folder `root`; it keeps room for the lab's `required` files.

    `places` pair files and folders of the submission, relative to `root`, with their paths in the submission.
    """
    budget = FileBudget(required=required)
    found: list[tuple[tuple[str, ...], str, int]] = []
    for place, name in places:
        above = tuple(filter(None, name.split("/")))
        path = os.path.join(root, place)
        if os.path.isdir(path):
            found += [((*above, *parts), file, size) for parts, file, size in _listed(Path(path), budget)]
        else:
            found.append((above, path, 0))
    for parts, path, size in sorted(found):
        _take(budget, parts, path, size)
    return budget


def gather_file(path: Path) -> FileBudget:
    """Return a `FileBudget` with a single program or notebook, as if it were in a folder of its own."""
    budget = FileBudget()
    _take(budget, (path.name,), os.path.realpath(path), 0)  # the caller's own path may be a link
    return budget


def _take(budget: FileBudget, parts: tuple[str, ...], path: str, size: int) -> None:
    try:
        budget.take(parts, size, lambda: _read(path))
    except OSError as error:
        budget.leave("/".join(parts), f"{REFUSED} ({error.strerror})")
        budget.broken = True


def _read(path: str) -> bytes:
    with open(path, "rb", opener=lambda name, _: os.open(name, _FLAGS)) as stream:
        return stream.read(MAX_FILE + 1)


def _listed(root: Path, budget: FileBudget) -> Iterator[tuple[tuple[str, ...], str, int]]:
    """Yield path parts, path and size of each plain file, and note the rest; skip folders that tools leave behind."""
    waiting: list[tuple[tuple[str, ...], str]] = [((), str(root))]
    seen = 0
    while waiting:
        above, folder = waiting.pop()
        for entry in _entries(folder, above, budget):
            seen += 1
            if seen > MAX_ENTRIES:
                budget.remarks.append(f"The folder holds more than {MAX_ENTRIES:,} names; the rest was not read.")
                return
            parts = (*above, entry.name)
            if is_litter(parts[-1:]) and entry.name != HOME_VERSIONS[0]:
                continue
            status = status_of(entry)
            if status is None:
                budget.leave("/".join(parts), REFUSED)
            elif is_link(status):
                budget.leave("/".join(parts), LINK)
            elif stat.S_ISREG(status.st_mode):
                yield parts, entry.path, status.st_size
            elif not stat.S_ISDIR(status.st_mode):
                budget.leave("/".join(parts), SPECIAL)
            elif len(parts) >= MAX_PARTS:
                budget.leave("/".join(parts), LONG)
            else:
                waiting.append((parts, entry.path))


def _entries(folder: str, above: tuple[str, ...], budget: FileBudget) -> list[os.DirEntry[str]]:
    """Return the entries of a folder, sorted; [] with a note if the system refuses to list them."""
    try:
        with os.scandir(folder) as entries:
            return sorted(islice(entries, MAX_ENTRIES + 1), key=lambda entry: entry.name)
    except OSError as error:
        budget.leave("/".join(above) or ".", f"{REFUSED} ({error.strerror})")
        budget.broken = True
        return []


def entries_of(folder: Path) -> list[os.DirEntry[str]]:
    """Return the entries of a folder that the instructor names, such as a class's, sorted by name.

    Raises
    ------
    RequestError
        If the folder cannot be listed: an error of the command, where one in a student's folder is only noted in the report.
    """
    try:
        with os.scandir(folder) as entries:
            return sorted(entries, key=lambda entry: entry.name)
    except OSError as error:
        shown = printable(str(folder), 500)
        raise RequestError(f"{shown}: the folder cannot be listed ({error.strerror}); check its permissions") from error


def status_of(entry: os.DirEntry[str]) -> os.stat_result | None:
    """Return the lstat of an entry; None if the system refuses it, as in a folder that may be listed but not entered."""
    try:
        return entry.stat(follow_symlinks=False)
    except OSError:
        return None


def is_link(status: os.stat_result) -> bool:
    """Return whether an lstat result is that of a symbolic link or a Windows junction, which could lead out of the submission."""
    junction = getattr(stat, "IO_REPARSE_TAG_MOUNT_POINT", -1)
    return stat.S_ISLNK(status.st_mode) or getattr(status, "st_reparse_tag", 0) == junction
