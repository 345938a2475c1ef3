"""Choose the installed packages that a sandbox shows: the lab's libraries and those installed for students, entry by entry.

A package folder is never shown whole: another copy of the grader may lie in it, or a path file that leads to one. What lies in it
and belongs to no installed distribution is not shown either.
"""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import Distribution
from pathlib import Path

from packaging.requirements import InvalidRequirement, Requirement
from packaging.utils import canonicalize_name

OF_THE_WORKER = ("matplotlib", "numpy")
OWN = "imugrade"
OWN_FOLDERS = frozenset({"grader", "reference"})
FOLDER_NAMES = ("site-packages", "dist-packages")
_INSTALLERS = frozenset({"pip", "setuptools", "uv", "wheel"})
_COMPILED = "__pycache__"
_NO_ENTRIES = frozenset({"", "..", _COMPILED})


@dataclass(frozen=True)
class Installed:
    """One installed distribution (what pip calls a package), as its metadata describes it.

    Attributes
    ----------
    name
        In canonical form: in small letters, with hyphens.
    record
        The path of its ``.dist-info`` or ``.egg-info`` folder.
    asked_for
        Whether a person installed it by its name, and not only because another one needs it.
    needs
        Its requirements, those of its extras included.
    """

    name: str
    record: str
    asked_for: bool
    needs: tuple[Requirement, ...]


def folders() -> tuple[str, ...]:
    """Return this Python's package folders (site-packages), with the user's own and the one that holds numpy, whatever its name."""
    found = [os.path.abspath(path) for path in sys.path if os.path.basename(path) in FOLDER_NAMES]
    spec = importlib.util.find_spec("numpy")
    if spec and spec.origin:
        found.append(str(Path(spec.origin).parents[1]))
    return tuple(dict.fromkeys(found))


@lru_cache(maxsize=8)
def shown(folders: tuple[str, ...], libraries: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Return the paths in package `folders` that a sandbox shows: packages for students, the lab's `libraries` included."""
    kept = for_students([one for folder in folders for one in installed(folder)], libraries)
    entries = (entries_of(one) for one in kept)
    return tuple(path for own in entries if OWN_FOLDERS.isdisjoint(map(os.path.basename, own)) for path in own)


def for_students(distributions: Sequence[Installed], libraries: Iterable[str] = ()) -> list[Installed]:
    """Return the distributions that student code may import: NumPy, matplotlib, the lab's `libraries`, others, and what these need.

    Others are all that the grader does not need or that a person installed by name; the grader and installers (pip) are left out.
    """
    known: dict[str, list[Installed]] = {}
    for one in distributions:
        known.setdefault(one.name, []).append(one)
    own = _with_needs([OWN], known, extras=True)
    roots = {name for name, of in known.items() if name not in own or any(one.asked_for for one in of)}
    kept = _with_needs({*OF_THE_WORKER, *libraries, *roots} - _INSTALLERS - {OWN}, known) - {OWN}
    return [one for one in distributions if one.name in kept]


def _with_needs(names: Iterable[str], known: Mapping[str, Sequence[Installed]], *, extras: bool = False) -> set[str]:
    """Return these names and those of all distributions that they need, directly or not; with `extras`, those of extras, too."""
    waiting = [(name, "") for name in sorted(names)]
    done: set[tuple[str, str]] = set()
    while waiting:
        name, extra = waiting.pop()
        if (name, extra) in done:
            continue
        done.add((name, extra))
        for need in (need for one in known.get(name, ()) for need in one.needs):
            if extras or need.marker is None or need.marker.evaluate({"extra": extra}):
                waiting += [(canonicalize_name(need.name), wanted) for wanted in ("", *need.extras)]
    return {name for name, _ in done}


# Reading what is installed --------------------------------------------------------------------------------------------


def installed(folder: str) -> list[Installed]:
    """Return the distributions of a package folder, from their metadata folders; an empty list if the folder is unreadable."""
    try:
        names = sorted(os.listdir(folder))
    except OSError:
        return []
    return [_installed(os.path.join(folder, name)) for name in names if name.endswith((".dist-info", ".egg-info"))]


def _installed(record: str) -> Installed:
    """Read the metadata folder of one distribution: its name, whether a person asked for it, and what it requires."""
    name = os.path.basename(record).partition("-")[0].removesuffix(".egg")
    asked_for = os.path.exists(os.path.join(record, "REQUESTED"))
    return Installed(canonicalize_name(name), record, asked_for, tuple(_needs(Distribution.at(record))))


def _needs(distribution: Distribution) -> Iterable[Requirement]:
    """Yield the requirements of a distribution; those that cannot be parsed are left out.

    The head of METADATA is read here: `Distribution.requires` also parses the description below it, which takes ten times as long.
    """
    head = (distribution.read_text("METADATA") or "").partition("\n\n")[0].splitlines()
    written = [line.partition(":")[2] for line in head if line.startswith("Requires-Dist:")]
    for line in written if head else distribution.requires or ():
        try:
            yield Requirement(line)
        except InvalidRequirement:  # an old package's, which pip does not read either
            continue


def entries_of(distribution: Installed) -> tuple[str, ...]:
    """Return the absolute paths of a distribution's files and folders in its package folder, which a sandbox shows one by one.

    Its metadata folder is among them. Files that only point to other folders (``.pth``, ``.egg-link``) are left out.
    """
    folder, record = os.path.split(distribution.record)
    read = Distribution.at(distribution.record).read_text
    files = [line.partition(",")[0].strip('"') for line in (read("RECORD") or "").splitlines()]
    if files:
        names = {name.partition("/")[0] for name in files} | {name for name in files if name.startswith(_COMPILED)}
    else:
        modules = (read("top_level.txt") or distribution.name.replace("-", "_")).split()
        names = {name for name in os.listdir(folder) if name.partition(".")[0] in modules}
    kept = {name for name in names if name not in _NO_ENTRIES and not name.endswith((".pth", ".egg-link"))}
    return tuple(filter(os.path.lexists, (os.path.join(folder, name) for name in sorted({*kept, record}))))
