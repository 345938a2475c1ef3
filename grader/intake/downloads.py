"""Read the download of a whole class, a folder or a zip: the names at its top, and the files of one submission in it."""

from __future__ import annotations

import os
import zipfile
from collections import defaultdict
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from grader.base.errors import RequestError
from grader.base.text import printable
from grader.intake.archives import gather_members, zip_name
from grader.intake.file_budget import LINK, REFUSED, UNSAFE, FileBudget
from grader.intake.folders import entries_of, gather_places, is_link, status_of
from grader.intake.names import archive_parts, is_litter

Sources = tuple[tuple[str, str], ...]
"""Files and folders of a download, and their paths in the submission ("" for the contents of a folder)."""


@dataclass(frozen=True)
class Download:
    """The top level of a download of a whole class (folder or zip), by which each platform's code recognises its downloads.

    `path` is the download, `root` the folder in it whose content counts as the top level ("" for the download itself). `top` says
    of each name at the top level whether it is a folder; `left` pairs each name left out, such as a link, with the reason.
    `known`, filled in by the caller, has the roster's names by the platform's user number, to resolve ambiguous file names.
    """

    path: Path
    root: str
    top: dict[str, bool]
    left: tuple[tuple[str, str], ...] = ()
    known: Mapping[str, str] = field(default_factory=dict)

    def place(self, name: str) -> str:
        """Return the path of the top-level file or folder `name` in the download: inside the folder `root`, if one is set."""
        return f"{self.root}/{name}" if self.root else name

    def read(self, name: str, most: int) -> bytes | None:
        """Return a file at the download's top level, such as the list of people; None if unreadable or above `most` bytes."""
        try:
            if os.path.isdir(self.path):
                with open(self.path / self.place(name), "rb") as stream:
                    data = stream.read(most + 1)
            else:
                contents = _contents(self.path)
                ((_, entry),) = contents.below[self.place(name)]
                with contents.archive.open(entry) as member:
                    data = member.read(most + 1)
        except (OSError, ValueError, RuntimeError, EOFError, zipfile.BadZipFile, NotImplementedError):
            return None  # what zipfile raises on damage, on encryption and on methods that it lacks
        return data if len(data) <= most else None

    def holds(self, *parts: str) -> bool:
        """Return whether the download has a file or folder at the path `parts` from its top, by which a platform recognises it."""
        inner = self.place("/".join(parts))
        return os.path.lexists(self.path / inner) if os.path.isdir(self.path) else inner in _contents(self.path).below


def open_download(path: Path) -> list[Download]:
    """Return the download (folder or zip) at `path`, seen from its top; [] if there is neither.

    If it holds nothing but one folder, a second `Download` follows, seen from that folder, into which a tool may have packed it.
    Raise RequestError if the folder cannot be listed, or the zip's table of contents is damaged.
    """
    if not os.path.isdir(path) and not zipfile.is_zipfile(path):
        return []
    look = _folder if os.path.isdir(path) else _zip
    download = look(path, "")
    lone = [name for name, is_folder in download.top.items() if is_folder and len(download.top) == 1]
    return [download, *(look(path, name) for name in lone)]


def gather_sources(path: Path, sources: Sources, required: Collection[str] = ()) -> FileBudget:
    """Return a `FileBudget` with the files of one submission in a download at `path`; it keeps room for the lab's `required` files.

    `sources` pair files and folders of the submission in the download with their paths in the submission.
    """
    if os.path.isdir(path):
        return gather_places(path, sources, required)
    contents = _contents(path)
    members = [
        ("/".join(filter(None, (inside, name[len(place) :].strip("/")))), entry)
        for place, inside in sources
        for name, entry in contents.below[place]
    ]
    return gather_members(contents.archive, members, printable(path.name), required)


def _folder(path: Path, root: str) -> Download:
    """List the top level of a download that is a folder, leaving out links and what tools leave behind."""
    top: dict[str, bool] = {}
    left: list[tuple[str, str]] = []
    for entry in entries_of(path / root):
        status = status_of(entry)
        if entry.name.startswith(".") or is_litter((entry.name,)):
            continue
        if status is None or is_link(status):
            left.append((entry.name, REFUSED if status is None else LINK))
        else:
            top[entry.name] = entry.is_dir()
    return Download(path, root, top, tuple(left))


def _zip(path: Path, root: str) -> Download:
    """List the top level of a download that is a zip archive, leaving out unsafe names and what tools leave behind."""
    contents = _contents(path)
    start = f"{root}/" if root else ""
    top: dict[str, bool] = {}
    for name in contents.names:
        if name.startswith(start):
            first, *below = name[len(start) :].split("/")
            top[first] = top.get(first, False) or bool(below)
    shown = {name: top[name] for name in sorted(top) if not name.startswith(".") and not is_litter((name,))}
    return Download(path, root, shown, tuple((name, UNSAFE) for name in contents.unsafe))


@dataclass(frozen=True)
class _Contents:
    """A class's zip, kept open so that all submissions are read fast: names, unsafe names, and the files below each path."""

    archive: zipfile.ZipFile
    names: tuple[str, ...]
    unsafe: tuple[str, ...]
    below: defaultdict[str, list[tuple[str, zipfile.ZipInfo]]]


def _contents(path: Path) -> _Contents:
    """Return the contents of a zip archive; raise RequestError if it cannot be read."""
    try:
        status = os.stat(path)
        return _opened(os.fspath(path), status.st_size, status.st_mtime_ns)
    except (OSError, zipfile.BadZipFile, ValueError, NotImplementedError) as error:
        shown = printable(str(path), 500)
        raise RequestError(
            f"{shown}: the archive cannot be read ({printable(str(error))}); download it again"
        ) from error


@lru_cache(maxsize=4)
def _opened(path: str, _size: int, _stamp: int) -> _Contents:
    """Return an open zip archive with its names and the files below each path; cached until its size or time stamp changes."""
    archive = zipfile.ZipFile(path)  # the instructor's own download: its table of contents may be as long as it likes
    names: list[str] = []
    unsafe: list[str] = []
    below: defaultdict[str, list[tuple[str, zipfile.ZipInfo]]] = defaultdict(list)
    for entry in archive.infolist():
        parts = archive_parts(zip_name(entry))
        if parts is None:
            unsafe.append(zip_name(entry))
        elif parts:
            name = "/".join(parts)
            names.append(f"{name}/" if entry.is_dir() else name)
            for depth in range(1, len(parts) + 1):
                below["/".join(parts[:depth])] += [] if entry.is_dir() else [(name, entry)]
    return _Contents(archive, tuple(names), tuple(unsafe), below)
