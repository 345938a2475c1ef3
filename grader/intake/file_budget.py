"""Collect the files of one submission, limited in number and bytes, with a note about all that is left out."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field

from grader.base.text import some
from grader.intake.names import ARCHIVES, FOREIGN_ARCHIVES, has_suffix, is_code, is_litter, joined
from grader.intake.placeholders import placeholder

MB = 1_000_000
MAX_FILE = 16 * MB
# 2,000 files and 64 MB, half of each for code: a data set never crowds out the programs that come after it. Files with a name that
# the lab asks for have room of their own beside it.
MAX_FILES = 1_000
MAX_REQUIRED = 64  # copies of the required files, in folders of their own
MAX_BYTES = 32 * MB
MAX_NAMED = 3  # names in one note
MAX_OPENINGS = 2

REFUSED = "the system refused it"
LINK = "links are never followed"
SPECIAL = "devices, pipes and sockets are never opened"
UNSAFE = "the path leads out of the archive or names a drive"
LONG = "the path is too long or too deep"
TOO_LARGE = f"the file is larger than {MAX_FILE // MB} MB"
TOO_MUCH = f"the submission holds more than {2 * MAX_FILES:,} files or {2 * MAX_BYTES // MB} MB"
TWICE = "the name stands twice in the archive, and the last one counts"
UNPORTABLE = "not every system can have a file of that name"
CASE = "another name differs from it in upper and lower case only"
DAMAGED = "the file is damaged in the archive"
LOCKED = "the file is encrypted"
GAPS = "the file is stored with gaps"
METHOD = "the file is packed with a method that is not read"


class Unreadable(Exception):  # noqa: N818 - a verdict on a submission, not an error of ours
    """Exception: nothing of a submission can be read, such as a broken archive; the message is a sentence for the report."""


@dataclass
class Room:
    """Remaining limits for one kind of a submission's files (required, code, other): how many files and bytes may still be read."""

    files: int = MAX_FILES
    bytes: int = MAX_BYTES


@dataclass
class FileBudget:
    """The files of one submission that were read so far, within limits, so that no hand-in can fill the memory.

    `files` maps paths to bytes, `left` each reason to the names left out for it, and `broken` says whether any reading failed.
    `remarks` are sentences on files that were read. `required` are the names of the files that the lab asks for: any number of
    other files leaves room for these.
    """

    files: dict[str, bytes] = field(default_factory=dict)
    left: dict[str, list[str]] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)
    broken: bool = False
    required: Collection[str] = ()
    _room: dict[bool, Room] = field(default_factory=lambda: {True: Room(), False: Room()})
    _reserved: Room = field(default_factory=lambda: Room(MAX_REQUIRED, MAX_FILE))

    def leave(self, name: str, why: str) -> None:
        self.left.setdefault(why, []).append(name)
        self.broken |= why in (DAMAGED, LOCKED, METHOD)

    def take(self, parts: tuple[str, ...], size: int, read: Callable[[], bytes]) -> None:
        """Read one file of a submission into the budget, or note why it is left out; ignore files that tools leave behind.

        Parameters
        ----------
        parts : the parts of the file's path
        size : the declared size in bytes
        read : returns the file's bytes, at most `MAX_FILE` + 1, whatever size was declared; what it raises passes through
        """
        if is_litter(parts):
            return
        path = joined(parts)
        why = LONG if path is None else self._no_room(path, size)
        if path is None or why:
            self.leave("/".join(parts), why)
            return
        data = read()
        why = self._no_room(path, len(data))
        if why:
            self.leave(path, why)
            return
        if why := placeholder(path, data):
            self.leave(path, why)
            return
        if path in self.files:
            self.leave(path, TWICE)
        room = self._room_for(path, len(data))
        room.files -= 1
        room.bytes -= len(data)
        self.files[path] = data

    def _no_room(self, path: str, size: int) -> str:
        """Return why a file of this size cannot be taken; "" if it can."""
        if size > MAX_FILE:
            return TOO_LARGE
        room = self._room_for(path, size)
        return "" if room.files > 0 and size <= room.bytes else TOO_MUCH

    def _room_for(self, path: str, size: int) -> Room:
        reserved = self._reserved
        named = path.rpartition("/")[2].casefold() in self.required
        asked_for = named and reserved.files > 0 and size <= reserved.bytes
        return reserved if asked_for else self._room[is_code(path)]

    def lone_archive(self) -> str | None:
        """Return the name of the only archive, to open it, if no code lies beside it, else None; other files do not matter."""
        archives = [name for name in self.files if has_suffix(name, ARCHIVES)]
        return archives[0] if len(archives) == 1 and not any(map(is_code, self.files)) else None

    def unopened(self) -> list[str]:
        """Return the sorted names of the archives among the files, for a note that they were not opened."""
        return sorted(name for name in self.files if has_suffix(name, (*ARCHIVES, *FOREIGN_ARCHIVES)))

    def notes(self) -> Iterator[str]:
        """Yield sentences for the report: remarks on the files in order, then one for each reason why files were left out."""
        yield from self.remarks
        for why, names in self.left.items():
            yield f"Not read, because {why}: {listing(names)}."


def listing(names: list[str]) -> str:
    """Return the first few names as printable text, and the number of the others, so that a note stays short."""
    return some(names, MAX_NAMED)
