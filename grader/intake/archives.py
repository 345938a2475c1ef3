"""Zip and tar archives, read as streams into memory. Nothing is unpacked to disk, and no declared size is believed.

`FileBudget` limits what is kept; the limits here are on the work for all the rest: decompression, tables of contents.
"""

from __future__ import annotations

import gzip
import io
import stat
import tarfile
import zipfile
from collections.abc import Callable, Collection, Iterable
from contextlib import suppress
from typing import BinaryIO, Protocol

from grader.intake.file_budget import (
    DAMAGED,
    GAPS,
    LINK,
    LOCKED,
    MAX_FILE,
    MB,
    METHOD,
    SPECIAL,
    UNSAFE,
    FileBudget,
    Unreadable,
)
from grader.intake.names import archive_parts, is_code, is_litter

MAX_ARCHIVE = 256 * MB  # on disk: a virtual environment handed in by mistake must not hide the lab's three files
MAX_UNPACKED = 512 * MB  # decompressed, wanted or not: two seconds of work
MAX_DIRECTORY = 8 * MB  # of a zip's table of contents: some 100,000 entries
MAX_ENTRIES = 50_000
MAX_HEADER = 16_384  # of a tar's long name or pax record, which tarfile reads whole
# Before Python 3.10.15, 3.11.10 and 3.12.6 tarfile takes quadratic time on hostile ones (CVE-2024-6232): sum of squared
# sizes, four seconds at the worst; 2,000 files with an honest kilobyte each stay below.
MAX_HEADER_WORK = 2_100_000_000
MAX_IN_VAIN = 100  # reads behind the end of a tar: tarfile looks there for the next file, block by block, wherever it is said to be

_UTF8 = 0x800  # flag: the name is UTF-8
_HEADERS = (
    tarfile.GNUTYPE_LONGNAME,
    tarfile.GNUTYPE_LONGLINK,
    tarfile.XHDTYPE,
    tarfile.XGLTYPE,
    tarfile.SOLARIS_XHDTYPE,
)


_FOREIGN = (b"Rar!", b"7z\xbc\xaf")


class _Exhausted(Exception):  # noqa: N818 - an end of reading, not an error of ours
    """Exception: the archive reached a limit of this module, such as on unpacked bytes; what was read before it counts."""


def gather_archive(stream: BinaryIO, name: str, required: Collection[str] = ()) -> FileBudget:
    """Return a `FileBudget` with the files of a submitted archive; its first bytes tell its kind, as its name may be wrong.

    Parameters
    ----------
    stream : the archive, seekable
    name : the archive's printable name, for notes in the report
    required : names of the files that the lab asks for; the budget keeps room for these

    Raises
    ------
    Unreadable
        If nothing of it can be read.
    """
    if stream.seek(0, io.SEEK_END) > MAX_ARCHIVE:
        raise Unreadable(f"{name} is larger than {MAX_ARCHIVE // MB} MB; hand in only the lab's files.")
    stream.seek(0)
    magic = stream.read(4)
    stream.seek(0)
    if magic in _FOREIGN:
        raise Unreadable(foreign(name))
    budget = FileBudget(required=required)
    read = _read_zip if magic[:2] == b"PK" else _read_gzip if magic[:2] == b"\x1f\x8b" else _read_tar
    try:
        read(stream, budget)
    except _Exhausted as end:
        budget.remarks.append(f"{name} was read in part: {end}.")
        budget.broken = True
    except Exception as error:  # the standard library's readers raise whatever their parsing trips over
        if not budget.files:
            raise Unreadable(f"{name} is not a readable zip or tar archive; make it again.") from error
        budget.remarks.append(f"{name} is damaged; the files before the damage were read.")
        budget.broken = True
    return budget


def foreign(name: str) -> str:
    """Return the note that the archive `name`, a .rar or the like, is not opened: reading it has no bound on time or memory."""
    return f"{name} is an archive of a kind that is not opened; hand in a .zip, or ask whoever marks to unpack it."


class _Readable(Protocol):
    def read(self, size: int, /) -> bytes: ...


class _Counted(io.RawIOBase):
    """The decompressed bytes of a tar as a stream that counts them, so that a small archive cannot unpack without end."""

    def __init__(self, stream: _Readable) -> None:
        self._stream = stream
        self._left = MAX_UNPACKED
        self._in_vain = 0

    def read(self, size: int = -1) -> bytes:
        """Read from the stream; raise `_Exhausted` if it unpacks to more than the limit or claims more bytes than it has."""
        data = self._stream.read(size)
        self._left -= len(data)
        self._in_vain += not data
        if self._in_vain > MAX_IN_VAIN:
            raise _Exhausted("it says that it is longer than it is")
        if self._left < 0:
            raise _Exhausted(f"it unpacks to more than {MAX_UNPACKED // MB} MB")
        return data


class _Narrow(io.RawIOBase):
    """A zip as a stream that refuses large reads, because `zipfile` reads the table of contents, of any declared size, at once."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._size = stream.seek(0, io.SEEK_END)

    def read(self, size: int | None = -1) -> bytes:
        rest = self._size - self._stream.tell()
        if (rest if size is None or size < 0 else min(size, rest)) > MAX_DIRECTORY:
            raise zipfile.BadZipFile("the table of contents is too large")
        return self._stream.read(-1 if size is None else size)

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        return self._stream.seek(offset, whence)

    def tell(self) -> int:
        return self._stream.tell()

    def seekable(self) -> bool:
        return True


def gather_members(
    archive: zipfile.ZipFile, members: Iterable[tuple[str, zipfile.ZipInfo]], name: str, required: Collection[str] = ()
) -> FileBudget:
    """Return a `FileBudget` with the files of one submission in the zip of a whole class; `name` is the zip's name in notes.

    `members` are pairs of a file's path in the submission and its entry. The budget keeps room for the lab's `required` files.
    """
    budget = FileBudget(required=required)
    try:
        _take_members(archive, members, budget)
    except _Exhausted as end:
        budget.remarks.append(f"{name} was read in part: {end}.")
        budget.broken = True
    return budget


def _read_zip(stream: BinaryIO, budget: FileBudget) -> None:
    with zipfile.ZipFile(_Narrow(stream)) as archive:
        _take_members(archive, ((zip_name(entry), entry) for entry in archive.infolist()), budget)


def _take_members(archive: zipfile.ZipFile, members: Iterable[tuple[str, zipfile.ZipInfo]], budget: FileBudget) -> None:
    """Take the members of a zip archive into the budget, code first, until too many bytes were unpacked."""
    unpacked = 0

    def bytes_of(entry: zipfile.ZipInfo) -> bytes:
        nonlocal unpacked
        unpacked += min(entry.file_size, MAX_FILE)
        if unpacked > MAX_UNPACKED:
            raise _Exhausted(f"it unpacks to more than {MAX_UNPACKED // MB} MB")
        with archive.open(entry) as member:
            return member.read(MAX_FILE + 1)

    # Code first, so that no other file takes its share of the work; the sort keeps the order of equal names.
    for name, entry in sorted(members, key=lambda member: not is_code(member[0])):
        _take_member(name, entry, budget, bytes_of)


def _take_member(
    name: str, entry: zipfile.ZipInfo, budget: FileBudget, bytes_of: Callable[[zipfile.ZipInfo], bytes]
) -> None:
    """Take one member of a zip archive, or note why it is left out; ignore folders and what tools leave behind."""
    parts = archive_parts(name)
    if parts is None:
        budget.leave(name, UNSAFE)
    elif name.endswith("/") or stat.S_ISDIR(entry.external_attr >> 16) or is_litter(parts):
        return
    elif why := _zip_objection(entry):
        budget.leave("/".join(parts), why)
    else:
        try:
            budget.take(parts, entry.file_size, lambda: bytes_of(entry))
        except _Exhausted:
            raise
        except Exception:  # a bad checksum, a bad stream, a header that contradicts the table of contents
            budget.leave("/".join(parts), DAMAGED)


def zip_name(entry: zipfile.ZipInfo) -> str:
    """Return the path of a zip's entry, with slashes. A NUL stays in it, so that `archive_parts` refuses it."""
    name = entry.orig_filename
    if not entry.flag_bits & _UTF8:  # zipfile takes these names for code page 437; Finder writes UTF-8
        with suppress(UnicodeError):
            name = name.encode("cp437").decode("utf-8")
    return name.replace("\\", "/")  # whatever tool made it: students have no file with a backslash in its name


def _zip_objection(entry: zipfile.ZipInfo) -> str:
    """Return why an entry of a zip is not read (a link, a device, encryption, a rare compression); "" if it is read."""
    kind = stat.S_IFMT(entry.external_attr >> 16)
    if kind not in (0, stat.S_IFREG):
        return LINK if kind == stat.S_IFLNK else SPECIAL
    if entry.flag_bits & 0x1:
        return LOCKED
    # LZMA and bzip2 decoders take as much memory as the archive says.
    return "" if entry.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) else METHOD


def _read_gzip(stream: BinaryIO, budget: FileBudget) -> None:
    with gzip.GzipFile(fileobj=stream, mode="rb") as unpacked:
        _read_tar(unpacked, budget)


def _bounded_headers() -> type[tarfile.TarInfo]:
    """Return a TarInfo class that refuses long names and attributes, because tarfile would read them whole into memory."""
    work = 0

    class Bounded(tarfile.TarInfo):
        @classmethod
        def frombuf(cls, buf: bytes | bytearray, encoding: str, errors: str) -> Bounded:
            nonlocal work
            info = super().frombuf(buf, encoding, errors)
            if info.type in _HEADERS:
                work += info.size**2
                if not 0 <= info.size <= MAX_HEADER or work > MAX_HEADER_WORK:
                    raise _Exhausted("its names and attributes are too long")
            return info

    return Bounded


def _read_tar(stream: _Readable, budget: FileBudget) -> None:
    """Take the members of a tar archive into the budget, up to a number of entries, and read it to its checksum."""
    counted = _Counted(stream)
    with tarfile.open(fileobj=counted, mode="r|", tarinfo=_bounded_headers()) as archive:
        for number, entry in enumerate(archive):
            if number >= MAX_ENTRIES:
                raise _Exhausted(f"it holds more than {MAX_ENTRIES:,} files and folders")
            _take_from_tar(archive, entry, budget)
    while counted.read(65_536):  # to the end, where gzip's checksum stands
        pass


def _take_from_tar(archive: tarfile.TarFile, entry: tarfile.TarInfo, budget: FileBudget) -> None:
    """Take one member of a tar archive, or note why it is left out; ignore folders and what tools leave behind."""
    parts = archive_parts(entry.name)
    if parts is None:
        budget.leave(entry.name, UNSAFE)
    elif entry.isdir() or is_litter(parts):
        return
    elif entry.issparse():
        budget.leave("/".join(parts), GAPS)
    elif not entry.isreg():
        budget.leave("/".join(parts), LINK if entry.issym() or entry.islnk() else SPECIAL)
    else:
        budget.take(parts, entry.size, lambda: _tar_bytes(archive, entry))


def _tar_bytes(archive: tarfile.TarFile, entry: tarfile.TarInfo) -> bytes:
    member = archive.extractfile(entry)
    return b"" if member is None else member.read(MAX_FILE + 1)
