"""Worker code that looks around in a sandbox as a submission could: which files can be opened, and which of them are ours."""

from __future__ import annotations

import os
import re
import stat
import zipfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

_MOST_BYTES = 1 << 20  # of a file: our longest has a tenth of that
_NOT_FILES = ("/dev", "/proc", "/sys")
_OWN_FOLDERS = ("grader", "reference")
_OWN_RECORD = re.compile(r".*imugrade.*\.(dist-info|egg-info|egg|egg-link|pth|whl|zip)")
_ARCHIVES = (".zip", ".whl", ".egg")


def warm_up(thorough: bool) -> None:
    del thorough


def answer(op: str, fields: Mapping[str, Any], arrays: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Search every file that can be opened below `roots` for `phrases`, and for what bears a name of ours."""
    del op, arrays
    phrases = [phrase.encode() for phrase in fields["phrases"]]
    opened, found = 0, []
    for path in _files(fields["roots"], set(fields["own"])):
        content = _content(path)
        if content is None:
            continue
        opened += 1
        if _named(path) or any(phrase in content for phrase in phrases):
            found.append(path)
    return {"opened": opened, "found": sorted(found)[:100]}, {}


def _files(roots: Sequence[str], own: Collection[str]) -> Iterator[str]:
    """Yield every regular file once, without the sandbox's own mounts."""
    seen: set[tuple[int, int]] = set()
    for root in roots:
        for top, folders, names in os.walk(root):
            at = os.stat(top)
            if (at.st_dev, at.st_ino) in seen or top in own or top.startswith(_NOT_FILES):
                folders.clear()
                continue
            seen.add((at.st_dev, at.st_ino))
            yield from (path for name in names if (path := os.path.join(top, name)) not in own)


def _content(path: str) -> bytes | None:
    """Return the beginning of a file; None if it is no file, cannot be opened, or is a shared library."""
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            return None
        with open(path, "rb", buffering=0) as file:
            return b"" if ".so" in path else file.read(_MOST_BYTES)
    except OSError:
        return None


def _named(path: str) -> bool:
    """Return whether a file belongs to the grader, to its installation record, or to an archive that holds it."""
    *folders, name = path.split("/")
    if any(_OWN_RECORD.fullmatch(part) for part in (*folders, name)):
        return True
    if name == "__init__.py" and folders[-1] in _OWN_FOLDERS:
        return True
    return name.endswith(_ARCHIVES) and any(_is_ours(member) for member in _members(path))


def _is_ours(member: str) -> bool:
    return any(member.endswith(f"{folder}/__init__.py") for folder in _OWN_FOLDERS)


def _members(path: str) -> list[str]:
    try:
        with zipfile.ZipFile(path) as archive:
            return archive.namelist()
    except (OSError, zipfile.BadZipFile):
        return []
