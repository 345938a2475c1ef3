"""Choose the installed packages that a sandbox shows: the lab's libraries and those installed for students, entry by entry.

A package folder is never shown whole: another copy of the grader may lie in it, or the path file of one. What stands in
it and belongs to no distribution is not shown either.
"""

from __future__ import annotations

import importlib.util
import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

LIBRARIES = ("matplotlib", "mujoco", "numpy", "scipy")
OWN = "imugrade"
OWN_FOLDERS = frozenset({"grader", "reference"})
_INSTALLERS = frozenset({"pip", "setuptools", "uv", "wheel"})
FOLDER_NAMES = ("site-packages", "dist-packages")

Needed = tuple[str, frozenset[str], str]  # a distribution, the extras of it that are wanted, the extra that wants them

_REQUIRES = re.compile(r" *([\w.-]+) *(?:\[([^\]]*)\])?(.*)")
_COMPILED = "__pycache__"
_NO_ENTRIES = frozenset({"", "..", _COMPILED})
_OF_EXTRA = re.compile(r"""extra *== *["']([^"']+)""")


@dataclass(frozen=True)
class Distribution:
    """One installed distribution.

    Attributes
    ----------
    name
        Normalised: in small letters, with hyphens.
    folder, record
        The package folder, and the name in it of the distribution's own record.
    asked_for
        Whether it was installed by its own name, not because another one needs it.
    needs
        Its requirements.
    """

    name: str
    folder: str
    record: str
    asked_for: bool
    needs: tuple[Needed, ...]


@dataclass(frozen=True)
class Contents:
    """The absolute paths that distributions put into a package folder: entries, and files that the dynamic loader reads."""

    entries: tuple[str, ...]
    shared_objects: tuple[str, ...]


def folders() -> tuple[str, ...]:
    """Folders of installed packages, also a user's own or one of PYTHONPATH, which `-s` and a bare environment hide."""
    found = [os.path.abspath(path) for path in sys.path if os.path.basename(path) in FOLDER_NAMES]
    spec = importlib.util.find_spec("numpy")
    if spec and spec.origin:
        found.append(str(Path(spec.origin).parents[1]))
    return tuple(dict.fromkeys(found))


def for_students(distributions: Sequence[Distribution]) -> list[Distribution]:
    """Return the lab's libraries and the packages installed for students, with what these need.

    Packages that the grader itself needs are left out, unless a person installed them by name.
    """
    known = _by_name(distributions)
    own = _closure([(OWN, frozenset({"*"}), "")], known)
    roots = [name for name, of in known.items() if name not in own or any(one.asked_for for one in of)]
    wanted = {*LIBRARIES, *roots} - _INSTALLERS - {OWN}
    kept = _closure([(name, frozenset(), "") for name in sorted(wanted)], known) - {OWN}
    return [one for one in distributions if one.name in kept]


def _by_name(distributions: Iterable[Distribution]) -> dict[str, list[Distribution]]:
    known: dict[str, list[Distribution]] = {}
    for one in distributions:
        known.setdefault(one.name, []).append(one)
    return known


def _closure(first: Iterable[Needed], known: Mapping[str, Sequence[Distribution]]) -> set[str]:
    """Return the names of all distributions that these need, directly or not; the extra "*" stands for all extras."""
    waiting, done = [(name, extras) for name, extras, _ in first], set()
    while waiting:
        name, extras = waiting.pop()
        if (name, extras) in done:
            continue
        done.add((name, extras))
        needs = (need for one in known.get(name, ()) for need in one.needs)
        waiting += [(needed, wants) for needed, wants, extra in needs if not extra or extra in extras or "*" in extras]
    return {name for name, _ in done}


# Reading what is installed --------------------------------------------------------------------------------------------


@lru_cache(maxsize=8)
def shown(folders: tuple[str, ...]) -> Contents:
    """Return what a sandbox shows of some package folders. A distribution with a folder of the grader's name is left out."""
    kept = for_students([one for folder in folders for one in installed(folder)])
    contents = [found for one in kept if not _is_ours(found := contents_of(one))]
    return Contents(
        tuple(path for one in contents for path in one.entries),
        tuple(path for one in contents for path in one.shared_objects),
    )


def _is_ours(contents: Contents) -> bool:
    """Return whether a distribution holds a folder with a name of the grader's own packages."""
    return any(os.path.basename(path) in OWN_FOLDERS for path in contents.entries)


def installed(folder: str) -> list[Distribution]:
    """Return the distributions of a package folder, from their ``.dist-info`` and ``.egg-info`` records."""
    try:
        names = sorted(os.listdir(folder))
    except OSError:
        return []
    return [_distribution(folder, name) for name in names if name.endswith((".dist-info", ".egg-info"))]


def _distribution(folder: str, record: str) -> Distribution:
    """Read the record of one distribution: its name, whether a person asked for it, and what it requires."""
    place = os.path.join(folder, record)
    metadata = _text(place, "METADATA") or _text(place, "PKG-INFO")
    return Distribution(
        _normal(record.partition("-")[0].removesuffix(".egg")),
        folder,
        record,
        os.path.exists(os.path.join(place, "REQUESTED")),
        (*_needs(metadata), *_old_needs(_text(place, "requires.txt"))),
    )


def contents_of(distribution: Distribution) -> Contents:
    """Return a distribution's entries in the package folder, its record included, and its shared objects.

    Files that only point to other folders (``.pth``, ``.egg-link``) are left out.
    """
    folder = distribution.folder
    files = _text(os.path.join(folder, distribution.record), "RECORD").splitlines()
    names = _first_parts(files) if files else _modules(distribution)
    kept = {name for name in names if name not in _NO_ENTRIES and not name.endswith((".pth", ".egg-link"))}
    entries = sorted(os.path.join(folder, name) for name in {*kept, distribution.record})
    objects = [os.path.join(folder, line.split(",")[0].strip('"')) for line in files if ".so" in line]
    objects = objects if files else [path for entry in entries for path in _objects_below(entry)]
    return Contents(tuple(filter(os.path.lexists, entries)), tuple(objects))


def _first_parts(files: Iterable[str]) -> set[str]:
    """Return the first part of each path in RECORD, and of compiled modules the path below ``__pycache__``."""
    first = {line.partition("/")[0].strip('"') for line in files}
    compiled = (
        {line.partition(",")[0] for line in files if line.startswith("__pycache__/")} if _COMPILED in first else set()
    )
    return {name.partition(",")[0] for name in first} | compiled


def _modules(distribution: Distribution) -> set[str]:
    """Return the modules that a distribution without a RECORD declares, by default the one of its own name."""
    modules = _text(os.path.join(distribution.folder, distribution.record), "top_level.txt").split()
    modules = modules or [distribution.name.replace("-", "_")]
    return {name for name in os.listdir(distribution.folder) if name.partition(".")[0] in modules}


def _objects_below(path: str) -> Iterator[str]:
    """Yield the shared objects at or below a path."""
    if ".so" in os.path.basename(path):
        yield path
    for top, _, files in os.walk(path):
        yield from (os.path.join(top, name) for name in files if ".so" in name)


def _text(place: str, name: str) -> str:
    """Return the text of a file; "" if it cannot be read."""
    try:
        with open(os.path.join(place, name), encoding="utf-8", errors="replace") as file:
            return file.read()
    except OSError:
        return ""


def _normal(name: str) -> str:
    """Return a distribution's name as PEP 503 normalizes it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def _needs(metadata: str) -> list[Needed]:
    """Return the requirements in the ``Requires-Dist`` lines of a METADATA file."""
    found = (_REQUIRES.match(part.partition("\n")[0]) for part in metadata.split("\nRequires-Dist:")[1:])
    return [_need(*need.groups(default="")) for need in found if need]


def _need(name: str, extras: str, marker: str) -> Needed:
    """Return one requirement: the name, the extras that it asks for, and the extra of the distribution that it belongs to."""
    of_extra = _OF_EXTRA.search(marker)
    wanted = frozenset(part.strip() for part in extras.split(",") if part.strip())
    return _normal(name), wanted, of_extra[1] if of_extra else ""


def _old_needs(requires: str) -> list[Needed]:
    """Return the requirements in an egg's ``requires.txt``, without those of its extras."""
    names = (re.match(r"[\w.-]+", line) for line in requires.partition("[")[0].splitlines())
    return [(_normal(name[0]), frozenset(), "") for name in names if name]
