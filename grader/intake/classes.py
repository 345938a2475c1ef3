"""A class: which submissions there are, found without reading them."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.errors import RequestError
from grader.intake.folders import is_link, status_of
from grader.intake.names import ARCHIVES, CODE, REQUIRED, distinct_ids, has_suffix, is_code, is_litter, original
from grader.intake.pile import LINK
from grader.intake.submission import MAX_LEVELS, Submission, original_name, read_submission
from grader.text import printable

UNPLACED = "not a folder, a .zip or a .tar.gz, so whose it is cannot be told"
MAX_LOOKED_AT = 50_000  # entries, to tell a class from a submission


@dataclass(frozen=True)
class Entry:
    """Where a submission is and what it is called: small, picklable, read where it is graded."""

    id: str
    name: str
    path: Path

    def read(self) -> Submission:
        """Read it; RequestError if it has gone meanwhile."""
        return read_submission(self.path, id=self.id, name=self.name)


@dataclass(frozen=True)
class Intake:
    """The submissions of a class in the order of their names, and what could not be placed (with a reason)."""

    entries: tuple[Entry, ...]
    leftovers: tuple[str, ...]


def read_class(paths: Sequence[Path]) -> Intake:
    """Find the submissions; none of them is read.

    Parameters
    ----------
    paths
        Each a folder of submissions (folders and archives), one submission, or an archive of one.

    Raises
    ------
    RequestError
        If there is nothing at a path, or its folder cannot be listed.
    """
    found: dict[str, Path] = {}  # by real path: a submission that is named twice is graded once
    leftovers: list[str] = []
    for path in paths:
        for place, objection in _found_at(path):
            if objection:
                leftovers.append(f"{printable(str(place), 500)}: {objection}")
            else:
                found.setdefault(os.path.realpath(place), place)
    places = sorted(found.values(), key=lambda place: (original_name(place), str(place)))
    return Intake(_entries(places), tuple(sorted(leftovers)))


def _entries(places: list[Path]) -> tuple[Entry, ...]:
    """Names are without the archive's suffix, unless that would give two submissions one name."""
    shared = Counter(original_name(place) for place in places)
    names = [_name(place, shared) for place in places]
    return tuple(Entry(*row) for row in zip(distinct_ids(names), names, places, strict=True))


def _name(place: Path, shared: Counter[str]) -> str:
    short = original_name(place)
    return short if shared[short] == 1 or os.path.isdir(place) else original(place.name)


def _found_at(path: Path) -> Iterator[tuple[Path, str]]:
    """Submissions at a path that was asked for, with ""; leftovers with their reason."""
    if not os.path.exists(path):
        raise RequestError(f"{printable(str(path), 500)}: there is no such file or folder; check the path")
    if not os.path.isdir(path):
        yield path, "" if has_suffix(path.name, (*ARCHIVES, *CODE)) else UNPLACED
        return
    if _is_submission(path):
        yield path, ""
        return
    for entry in _listed(path):
        place = path / entry.name
        if not _is_ignored(entry):
            yield place, _objection(entry)


def _listed(folder: Path) -> list[os.DirEntry[str]]:
    try:
        with os.scandir(folder) as entries:
            return sorted(entries, key=lambda entry: entry.name)
    except OSError as error:
        shown = printable(str(folder), 500)
        raise RequestError(f"{shown}: the folder cannot be listed ({error.strerror}); check its permissions") from error


def _is_ignored(entry: os.DirEntry[str]) -> bool:
    """Hidden files, what tools leave behind, and the OUT of an earlier run."""
    graded = os.path.isfile(os.path.join(entry.path, "results.sqlite"))
    return entry.name.startswith(".") or is_litter((entry.name,)) or graded


def _objection(entry: os.DirEntry[str]) -> str:
    """Why this entry of a class folder is no submission, or ""."""
    status = status_of(entry)
    if status is None or is_link(status):
        return "the system refused it" if status is None else LINK
    if entry.is_dir() or (entry.is_file() and has_suffix(entry.name, ARCHIVES)):
        return ""
    return UNPLACED


def _is_submission(folder: Path) -> bool:
    """Whether a folder is one submission: a required file lies in it, or code does and no submissions do."""
    entries = [entry for entry in _listed(folder) if not _is_ignored(entry)]
    names = [entry.name for entry in entries if entry.is_file(follow_symlinks=False)]
    if any(name in REQUIRED for name in names):
        return True
    if not any(is_code(name) for name in names):
        return False
    return not any(has_suffix(name, ARCHIVES) for name in names) and not _holds_required(folder)


def _holds_required(folder: Path) -> bool:
    """Whether a required file lies up to four folders down in a folder of this one."""
    looked_at = 0
    for here, folders, names in os.walk(folder):
        level = len(Path(here).relative_to(folder).parts)
        looked_at += len(folders) + len(names)
        if any(name in REQUIRED for name in names):
            return True
        if level > MAX_LEVELS or looked_at > MAX_LOOKED_AT:
            folders.clear()
        folders[:] = [name for name in folders if not is_litter((name,))]
    return False
