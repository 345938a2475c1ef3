"""One submission: its files, read whole into memory, and which of its folders is the lab."""

from __future__ import annotations

import hashlib
import io
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
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
        Relative posix path inside the lab's folder to the file's bytes. Empty unless `status` is "ready".
    notes
        Sentences for the report, safe to print.
    status
        "ready", "empty" (nothing recognisable in it) or "unreadable" (a broken archive).
    sha256
        Of paths and bytes: the same for a folder and an archive of it, whatever the time stamps.
    """

    id: str
    name: str
    files: Mapping[str, bytes]
    notes: tuple[str, ...]
    status: Literal["ready", "empty", "unreadable"]
    sha256: str


@dataclass(frozen=True)
class _Choice:
    """The lab's folder ("" is the root), others that qualify, and the files in none of them."""

    folder: str
    others: tuple[str, ...]
    outside: tuple[str, ...]


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
    files = _inside(choice.folder, pile)
    notes = (*_choice_notes(choice), *pile.notes())
    return Submission(id, name, files, notes, "ready", _digest(files.items()))


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
    others = tuple(folder for folder in rest if complete[folder] or not _within(folder, chosen))
    named = (chosen, *others)
    outside = tuple(path for path in code if not any(_within(path, folder) for folder in named))
    return _Choice(chosen, others, outside)


def _level(folder: str) -> int:
    return folder.count("/") + 1 if folder else 0


def _within(path: str, folder: str) -> bool:
    return not folder or path.startswith(f"{folder}/")


def _choice_notes(choice: _Choice) -> Iterable[str]:
    here = printable(choice.folder) or "the top folder"
    if choice.others:
        others = listing(list(choice.others))
        yield f"More than one folder holds the lab's files: {here} was graded, not {others}."
    elif _level(choice.folder) > 1:
        yield f"The lab's files were found in {here}."
    if choice.outside:
        yield f"Not looked at, because the lab's files are in {here}: {listing(list(choice.outside))}."


def _inside(folder: str, pile: Pile) -> dict[str, bytes]:
    """The files of the chosen folder by their path in it, sorted: names that every system can hold, side by side."""
    start = len(folder) + 1 if folder else 0
    inside = {path[start:]: data for path, data in pile.files.items() if _within(path, folder)}
    kept: dict[str, str] = {}
    for path in sorted(inside, key=lambda p: (p not in REQUIRED, p)):
        if not portable(path):
            pile.leave(path, UNPORTABLE)
        elif kept.setdefault(folded(path), path) != path:
            pile.leave(path, CASE)
    folders = {above for key in kept for above in _above(key)}  # a file of that name would stand in their way
    return {path: inside[path] for key, path in sorted(kept.items(), key=lambda item: item[1]) if key not in folders}


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
