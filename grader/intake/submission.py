"""One submission: its files, read whole into memory, and which of its folders is the lab."""

from __future__ import annotations

import hashlib
import io
import os
import posixpath
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from grader.errors import RequestError
from grader.intake.archives import gather_archive
from grader.intake.downloads import Sources, gather_sources
from grader.intake.folders import gather_file, gather_folder
from grader.intake.names import (
    ARCHIVES,
    FOREIGN_ARCHIVES,
    REQUIRED,
    folded,
    has_suffix,
    is_code,
    original,
    portable,
    safe_id,
)
from grader.intake.pile import CASE, MAX_OPENINGS, UNPORTABLE, Pile, Unreadable, listing
from grader.text import printable

MAX_LEVELS = 4  # how far down the lab's folder may lie


@dataclass(frozen=True)
class Submission:
    """What was handed in.

    Attributes
    ----------
    id
        Its folder name under ``OUT/submissions/``: safe, and distinct within a class.
    name
        Its original name.
    files
        Relative posix path to the file's bytes: first what is inside the lab's folder, then what lies beside it and above,
        by its path there. Empty unless `status` is "ready".
    notes
        Sentences for the report, safe to print.
    status
        "ready", "empty" (nothing recognisable in it) or "unreadable" (a broken archive).
    sha256
        Of paths and bytes: the same for a folder and an archive of it, whatever the time stamps.
    folder
        The lab's folder below what was handed in, or below the archive in it; "" is that itself.
    above
        Of the files that lie outside the lab's folder: the number of folders between it and the one they lie in.
    """

    id: str
    name: str
    files: Mapping[str, bytes]
    notes: tuple[str, ...]
    status: Literal["ready", "empty", "unreadable"]
    sha256: str
    folder: str = ""
    above: Mapping[str, int] = field(default_factory=dict)

    def origin(self, path: str) -> str:
        """Where one of the files lies below what was handed in."""
        return _outwards(self.folder, self.above.get(path, 0)) + path


@dataclass(frozen=True)
class _Choice:
    """The lab's folder ("" is the root), and the folders that hold the same files once more."""

    folder: str
    others: tuple[str, ...]


def original_name(path: Path) -> str:
    """What a submission is called: its folder's name, or its file's without the suffix."""
    name = Path(os.path.abspath(path)).name  # "." has a name too
    suffix = next((suffix for suffix in ARCHIVES if has_suffix(name, (suffix,))), "")
    return original(name[: len(name) - len(suffix)] if suffix and not os.path.isdir(path) else name) or "submission"


def read_submission(path: Path, *, id: str | None = None, name: str | None = None, sources: Sources = ()) -> Submission:
    """Read what was handed in.

    Parameters
    ----------
    path
        A folder, an archive (.zip, .tar.gz, .tgz, .tar), or a single program or notebook.
    id, name
        As an `Entry` of a class has them; made from the path otherwise.
    sources
        If `path` is the download of a whole class: which of its files and folders are this submission, and their paths in it.

    Raises
    ------
    RequestError
        If there is nothing at `path`. Whatever is inside ends in a `Submission`.
    """
    name = original_name(path) if name is None else name
    id = safe_id(name) if id is None else id
    try:
        pile = _gather(path, sources)
    except Unreadable as reason:
        return _without_files(id, name, "unreadable", (str(reason),))
    choice = _choose(pile.files)
    if choice is None:
        return _without_files(id, name, *_nothing_found(pile))
    inside = _inside(choice.folder, pile)
    above = _outside(choice, pile, inside)
    files = {path: pile.files[_outwards(choice.folder, above.get(path, 0)) + path] for path in (*inside, *above)}
    notes = (*_choice_notes(choice, pile.files, above), *pile.notes())
    digest = _digest(("../" * above.get(path, 0) + path, content) for path, content in files.items())
    return Submission(id, name, files, notes, "ready", digest, choice.folder, above)


def _gather(path: Path, sources: Sources) -> Pile:
    """All files, through the archives that are alone in their folder."""
    if not os.path.exists(path):  # Path.exists raises where a folder above may not be entered
        raise RequestError(f"{printable(str(path), 500)}: there is no such file or folder; check the path")
    pile = gather_sources(path, sources) if sources else _gather_outermost(path)
    notes: list[str] = []
    openings = 0
    while (inner := pile.lone_archive()) is not None:
        if openings == MAX_OPENINGS:
            raise Unreadable(f"{printable(inner)} is an archive in an archive in an archive; hand in the files.")
        openings += 1
        notes += [*pile.notes(), f"The submission is in {printable(inner)}, which was opened."]
        pile = gather_archive(io.BytesIO(pile.files[inner]), printable(inner))
    pile.remarks[:0] = notes
    return pile


def _gather_outermost(path: Path) -> Pile:
    if os.path.isdir(path):
        return gather_folder(path)
    name = printable(path.name)
    if not os.path.isfile(path):
        raise Unreadable(f"{name} is neither a file nor a folder; hand in a folder or a .zip of it.")
    if is_code(path.name):
        return gather_file(path)
    if has_suffix(path.name, ARCHIVES):
        try:
            with open(path, "rb") as stream:
                return gather_archive(stream, name)
        except OSError as error:
            raise Unreadable(f"{name} cannot be read ({error.strerror}).") from error
    raise Unreadable(f"{name} is not a folder, a .zip or a .tar.gz; hand in one of these.")


def _nothing_found(pile: Pile) -> tuple[Literal["empty", "unreadable"], tuple[str, ...]]:
    """Why there is no lab here: the status and the notes."""
    archives = pile.unopened()
    foreign = len(pile.files) == 1 and has_suffix(next(iter(pile.files)), FOREIGN_ARCHIVES)
    if foreign:
        said = [f"{listing(archives)} is an archive of a kind that is not opened; hand in a .zip."]
    else:
        said = [f"No .py or .ipynb file was found up to {MAX_LEVELS} folders down."]
        if archives:
            said.append(f"Not opened, because an archive must be alone in its folder: {listing(archives)}.")
    return ("unreadable" if pile.broken or foreign else "empty"), (*said, *pile.notes())


def _without_files(id: str, name: str, status: Literal["empty", "unreadable"], notes: tuple[str, ...]) -> Submission:
    """No files to hash: the notes stand in, so that another fault makes another record."""
    digest = _digest((note, status.encode()) for note in notes)
    return Submission(id, name, {}, notes, status, digest)


def _choose(paths: Iterable[str]) -> _Choice | None:
    """The folder with required files, or else with any code: the shallower, then the more complete, then by name."""
    code = sorted(path for path in paths if is_code(path))
    folders: dict[str, set[str]] = {}
    for path in code:
        folder, _, name = path.rpartition("/")
        if _level(folder) <= MAX_LEVELS:
            folders.setdefault(folder, set()).add(name)
    complete = {folder: len(names.intersection(REQUIRED)) for folder, names in folders.items()}
    qualified = [folder for folder in folders if complete[folder]] or list(folders)
    if not qualified:
        return None
    chosen, *rest = sorted(qualified, key=lambda f: (_level(f), -complete[f], -len(folders[f]), f))
    others, there = [], folders[chosen]
    for folder in rest:
        if folders[folder].intersection(there, REQUIRED) or not (complete[folder] or _within(folder, chosen)):
            others.append(folder)
        else:  # the lab's files lie in more than one folder
            there = there | folders[folder]
    return _Choice(chosen, tuple(others))


def _level(folder: str) -> int:
    return folder.count("/") + 1 if folder else 0


def _within(path: str, folder: str) -> bool:
    return not folder or path.startswith(f"{folder}/")


def _outwards(folder: str, levels: int) -> str:
    """The folder that lies so many levels above this one, with a slash, or "" for the outermost."""
    parts = folder.split("/") if folder else []
    return "".join(f"{part}/" for part in parts[: len(parts) - levels])


def _choice_notes(choice: _Choice, paths: Iterable[str], above: Mapping[str, int]) -> Iterable[str]:
    here = printable(choice.folder) or "the top folder"
    if choice.others:
        others = listing(list(choice.others))
        yield f"More than one folder holds the lab's files: {here} was graded, not {others}."
    taken = sorted(_outwards(choice.folder, levels) + path for path, levels in above.items() if is_code(path))
    if taken:
        yield f"The lab's files were found in {here}; looked at with them: {listing(taken)}."
    elif _level(choice.folder) > 1 and not choice.others:
        yield f"The lab's files were found in {here}."
    elsewhere = [p for p in _elsewhere(choice, paths) if is_code(p) and posixpath.basename(p) != "__init__.py"]
    if left := sorted(set(elsewhere).difference(taken)):
        yield f"Not looked at, because the lab's files are in {here}: {listing(left)}."


def _elsewhere(choice: _Choice, paths: Iterable[str]) -> list[str]:
    """What lies neither in the lab's folder nor in another one of the kind."""
    return [path for path in paths if not any(_within(path, folder) for folder in (choice.folder, *choice.others))]


def _inside(folder: str, pile: Pile) -> list[str]:
    """The paths in the lab's folder, sorted: names that every system can hold, side by side."""
    start = len(folder) + 1 if folder else 0
    inside = sorted(path[start:] for path in pile.files if _within(path, folder))
    kept: dict[str, str] = {}
    for path in sorted(inside, key=lambda p: p not in REQUIRED):
        if not portable(path):
            pile.leave(path, UNPORTABLE)
        elif kept.setdefault(folded(path), path) != path:
            pile.leave(path, CASE)
    folders = {above for key in kept for above in _above(key)}  # a file of that name would stand in their way
    return sorted(path for key, path in kept.items() if key not in folders)


def _outside(choice: _Choice, pile: Pile, inside: Iterable[str]) -> dict[str, int]:
    """What lies beside the lab's folder and above it: the path there, and how many levels above the lab's folder that is.

    A program that is started in a folder above finds what is there and imports the lab's files out of their folder. So both
    are one submission, and a name further inside goes before one further outside. Notebooks of other folders are left,
    because notebooks are run, and so is an ``__init__.py``: it would speak for the lab's folder.
    """
    files = set(map(folded, inside))
    folders = {above for key in files for above in _above(key)}
    outside: dict[str, int] = {}
    for levels, path in sorted(_from_above(path, choice.folder) for path in _elsewhere(choice, pile.files)):
        key = folded(path)
        barred = path == "__init__.py" or (path.endswith(".ipynb") and "/" in path) or not portable(path)
        if not barred and key not in files | folders and files.isdisjoint(_above(key)):
            outside[path] = levels
            files.add(key)
            folders.update(_above(key))
    return outside


def _from_above(path: str, folder: str) -> tuple[int, str]:
    """The lowest of the folders above the lab's that holds this path, by its level above the lab's, and the path in it."""
    shared = posixpath.commonpath((posixpath.dirname(path), folder))
    return _level(folder) - _level(shared), path[len(shared) + 1 :] if shared else path


def _above(path: str) -> Iterable[str]:
    parts = path.split("/")
    return ("/".join(parts[:n]) for n in range(1, len(parts)))


def _digest(items: Iterable[tuple[str, bytes]]) -> str:
    """SHA-256 over sorted paths and bytes, each with its length, so that no two sets of files read alike."""
    digest = hashlib.sha256()
    for path, data in sorted(items):
        for part in (path.encode(), data):
            digest.update(b"%d:" % len(part) + part)
    return digest.hexdigest()
