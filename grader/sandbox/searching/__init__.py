"""Code that looks around in a sandbox as a submission could: which files can be opened, and which of them are the grader's."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from typing import Any

_NOT_FILES = ("/dev", "/proc", "/sys")
_OURS = re.compile(r"(grader|reference)/__init__\.py|imugrade[^/]*\.(dist-info|egg-info|egg|egg-link|pth|whl|zip)\b")
_MOST_BYTES = 1 << 18  # of a file: our longest has half of that
_SOURCES = (".py", ".pyc", ".txt", ".ipynb")


def warm_up(thorough: bool) -> None:
    del thorough


def answer(op: str, fields: Mapping[str, Any], arrays: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Search as student code could: open all files below ``fields["roots"]``; return the number ``opened``, and ``found`` paths.

    Of the opened files, ``found`` lists (at most 100) those whose path shows the grader, such as ``grader/__init__.py`` or
    ``imugrade*.whl``, and sources (``.py``, ``.pyc``, ``.txt``, ``.ipynb``) that hold one of ``fields["phrases"]``. Paths in
    ``fields["own"]``, which every sandbox needs, and kernel mounts are passed over; `op` and `arrays` are not used.
    """
    del op, arrays
    phrases = [phrase.encode() for phrase in fields["phrases"]]
    opened, found = 0, []
    for path in _files(fields["roots"], set(fields["own"])):
        try:
            with open(path, "rb", buffering=0) as file:
                content = file.read(_MOST_BYTES) if path.endswith(_SOURCES) else b""
        except OSError:
            continue
        opened += 1
        if _OURS.search(path) or any(phrase in content for phrase in phrases):
            found.append(path)
    return {"opened": opened, "found": sorted(found)[:100]}, {}


def _files(roots: list[str], own: set[str]) -> Iterator[str]:
    """Yield the path of every regular file, without kernel mounts and `own` paths; a folder that is shown twice counts once."""
    seen: set[tuple[int, int]] = set()
    for root in roots:
        for top, folders, names in os.walk(root):
            at = os.stat(top)
            if (at.st_dev, at.st_ino) in seen or top in own or top.startswith(_NOT_FILES):
                folders.clear()
                continue
            seen.add((at.st_dev, at.st_ino))
            paths = (os.path.join(top, name) for name in names)
            yield from (path for path in paths if path not in own and os.path.isfile(path))
