"""Versions of the libraries that a class uses: the instructor's, which `kit` writes into what students install.

The same code may raise with one release of a library and not with another, so all machines of a class should have the same.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, metadata, version
from pathlib import Path

FILE = "constraints.txt"
"""Constraints file of pip, in the kit and in the students' wheel."""
_BOUND = re.compile(r"([<>=!]=|[<>])\s*([\d.]+)")
_PINNED = re.compile(r"^([\w-]+)==([\w.]+)", re.MULTILINE)


def constraints(packages: Sequence[str]) -> str:
    """Return a constraints file with the versions of this machine, each for the releases of Python that it supports."""
    lines = []
    for package in packages:
        bounds = _BOUND.findall(metadata(package)["Requires-Python"] or "")
        where = " and ".join(f'python_version {sign} "{release}"' for sign, release in bounds)
        lines.append(f"{package}=={version(package)}{f'; {where}' if where else ''}\n")
    return "".join(lines)


def differences(pinned: str) -> Sequence[str]:
    """Return what differs on this machine from a constraints file: ``numpy 2.4.1 (class: 2.3.5)``."""
    found = ((package, _installed(package), wanted) for package, wanted in _PINNED.findall(pinned))
    return [f"{package} {here or 'is missing'} (class: {wanted})" for package, here, wanted in found if here != wanted]


def line(folder: Path) -> str:
    """Return what to tell a student whose versions differ from those in a folder's constraints file.

    Return "" if they do not differ, or without such a file, as where an instructor installed the package.
    """
    file = folder / FILE
    differing = differences(file.read_text(encoding="utf-8")) if file.is_file() else []
    if not differing:
        return ""
    return f"Your versions differ from your class: {', '.join(differing)}. python -m pip install -r {FILE} installs the same."


def _installed(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""
