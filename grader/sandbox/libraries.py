"""Find the shared libraries that a sandbox shows: those that Python and the shown packages are linked with.

A library folder is never shown whole, because /usr/lib may hold anything. The search is that of the dynamic loader, ld.so(8); the
numbers are those of elf.h.
"""

from __future__ import annotations

import mmap
import os
import struct
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from .paths import is_below

_CACHE = "/etc/ld.so.cache"
_DEFAULT_FOLDERS = ("/lib64", "/usr/lib64", "/lib", "/usr/lib", "/usr/local/lib")
_OPENED_BY_NAME = ("libgcc_s.so.1", "libnss_files.so.2")  # by the C library, to end a thread and to find a user
_PT_LOAD, _PT_DYNAMIC, _PT_INTERP = 1, 2, 3
_DT_NEEDED, _DT_STRTAB, _DT_RPATH, _DT_RUNPATH = 1, 5, 15, 29


@dataclass(frozen=True)
class Linked:
    """The libraries that one ELF file asks the dynamic loader for.

    Attributes
    ----------
    machine
        The processor; a library of another one is passed over.
    needed
        Names of libraries.
    search
        Folders that it names itself, with its own in place of ``$ORIGIN``.
    interpreter
        The loader itself, of a program; empty for a library.
    """

    machine: int
    needed: tuple[str, ...]
    search: tuple[str, ...]
    interpreter: str


def needed_by(program: str, objects: Iterable[str], shown: Sequence[str]) -> set[str]:
    """Return the libraries that a program and the shared objects that it loads need, without those already shown."""
    program = os.path.realpath(program)  # the loader's own idea of $ORIGIN
    own = linked(program)
    found = {own.interpreter} if own else set()
    machine = own.machine if own else 0
    first = [program, *objects]
    waiting = [(path, name) for path in first for name in _names(path)] + [("", name) for name in _OPENED_BY_NAME]
    done: set[tuple[str, tuple[str, ...]]] = set()
    while waiting:
        asking, name = waiting.pop()
        request = (name, _search_of(asking))
        if request in done:
            continue
        done.add(request)
        for path in _resolved(name, request[1], machine):
            if not is_below(path, shown):
                found.update(_with_companions(path, request[1]))
            waiting += [(path, other) for other in _names(path)]
    return found - {""}


def _names(path: str) -> tuple[str, ...]:
    """Return the names of the libraries that a file is linked with."""
    read = linked(path)
    return read.needed if read else ()


def _search_of(path: str) -> tuple[str, ...]:
    """Return the folders that a file asks the loader to search (RPATH, RUNPATH)."""
    read = linked(path) if path else None
    return read.search if read else ()


def _resolved(name: str, search: Sequence[str], machine: int) -> list[str]:
    """Return the files that the loader may load for a library name.

    These are the first match in the searched folders, else all matches in the loader's cache, else the first match in the
    default folders.
    """
    own = os.environ.get("LD_LIBRARY_PATH", "").split(":")
    for folder in (*search, *filter(None, own)):
        if _fits(path := os.path.normpath(os.path.join(folder, name)), machine):
            return [path]
    cached = [path for path in _cache().get(name, ()) if _fits(path, machine)]
    default = (f"{folder}/{name}" for folder in _DEFAULT_FOLDERS)
    return cached or [path for path in default if _fits(path, machine)][:1]


def _fits(path: str, machine: int) -> bool:
    """Return whether a file is a library for this processor."""
    read = linked(path)
    return read is not None and read.machine == machine


def _with_companions(path: str, search: Sequence[str]) -> Iterator[str]:
    """Yield a library; if it lies in a folder that its user searches, also the others there: MKL opens some of them by name."""
    yield path
    folder = os.path.dirname(path)
    if folder in map(os.path.normpath, search):
        yield from (entry.path for entry in os.scandir(folder) if ".so" in entry.name and entry.is_file())


@lru_cache(maxsize=1)
def _cache() -> Mapping[str, Sequence[str]]:
    """Return the paths of each library name in the dynamic loader's cache, /etc/ld.so.cache; empty if it cannot be read."""
    try:
        with open(_CACHE, "rb") as file:
            data = file.read()
        data = data[data.index(b"glibc-ld.so.cache1.1") :]
    except (OSError, ValueError):
        return {}
    (count,) = struct.unpack_from("<I", data, 20)
    known: dict[str, list[str]] = {}
    for _, name, path, _, _ in struct.iter_unpack("<iIIIQ", data[48 : 48 + 24 * count]):
        known.setdefault(_string(data, name), []).append(_string(data, path))
    return known


def _string(data: bytes | mmap.mmap, at: int) -> str:
    """Return the null-terminated string at an offset."""
    return os.fsdecode(data[at : data.find(b"\0", at)])


# Reading ELF ----------------------------------------------------------------------------------------------------------


@lru_cache(maxsize=8192)
def linked(path: str) -> Linked | None:
    """Return what a 64-bit little-endian ELF file is linked with; None for any other file."""
    try:
        with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
            return _parsed(data, os.path.dirname(path)) if data[:6] == b"\x7fELF\x02\x01" else None
    except (OSError, ValueError, struct.error):
        return None


def _parsed(data: mmap.mmap, origin: str) -> Linked:
    """Parse the program headers and the dynamic section of an ELF file in the folder `origin`."""
    (machine,) = struct.unpack_from("<H", data, 18)
    (table,) = struct.unpack_from("<Q", data, 32)
    size, count = struct.unpack_from("<HH", data, 54)
    segments = [struct.unpack_from("<IIQQQQ", data, table + size * number) for number in range(count)]
    loads = [(address, length, offset) for kind, _, offset, address, _, length in segments if kind == _PT_LOAD]
    interpreter = next((_string(data, offset) for kind, _, offset, *_ in segments if kind == _PT_INTERP), "")
    dynamic = next(((offset, length) for kind, _, offset, _, _, length in segments if kind == _PT_DYNAMIC), (0, 0))
    tags = list(struct.iter_unpack("<QQ", data[dynamic[0] : dynamic[0] + dynamic[1] // 16 * 16]))
    address = next((value for tag, value in tags if tag == _DT_STRTAB), 0)
    strings = next((address - start + at for start, length, at in loads if start <= address < start + length), 0)
    needed = tuple(_string(data, strings + value) for tag, value in tags if tag == _DT_NEEDED)
    paths = [_string(data, strings + value) for tag, value in tags if tag in (_DT_RPATH, _DT_RUNPATH)]
    search = (folder for path in paths for folder in path.split(":") if folder)
    return Linked(machine, needed, tuple(_expanded(folder, origin) for folder in search), interpreter)


def _expanded(folder: str, origin: str) -> str:
    """Return a search folder with ``$ORIGIN`` replaced by the folder of the file."""
    return folder.replace("${ORIGIN}", origin).replace("$ORIGIN", origin)
