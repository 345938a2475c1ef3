"""Versions of the libraries that a class uses: the instructor's, which `kit` writes into what students install.

The same code may raise with one release of a library and not with another, so all machines of a class should have the same.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, metadata, requires, version
from pathlib import Path

from packaging.requirements import Requirement

FILE = "constraints.txt"
"""Constraints file of pip, in the kit and in the students' wheel."""
_BOUND = re.compile(r"([<>=!]=|[<>])\s*([\d.]+)")
_PINNED = re.compile(r"^([\w-]{1,40})==([\w.+]{1,20})", re.MULTILINE | re.ASCII)


def constraints(packages: Sequence[str]) -> str:
    """Return a constraints file with the versions of this machine, each for the releases of Python that it supports."""
    lines = []
    for package in packages:
        bounds = _BOUND.findall(metadata(package)["Requires-Python"] or "")
        where = " and ".join(f'python_version {sign} "{release}"' for sign, release in bounds)
        lines.append(f"{package}=={version(package)}{f'; {where}' if where else ''}\n")
    return "".join(lines)


def differences(pinned: str) -> list[tuple[str, str, str]]:
    """Return the packages whose version here is another one than in a constraints file: name, version here or "", version there."""
    found = ((package, _installed(package), there) for package, there in _PINNED.findall(pinned))
    return [each for each in found if each[1] != each[2]]


def of_ours(pinned: str) -> str:
    """Return the lines of a student's file on packages that the grader needs: others could ask what else is installed here."""
    needed = {Requirement(each).name for each in requires("imugrade") or () if "extra ==" not in each}
    return "".join(
        f"{package}=={there}\n" for package, there in dict(_PINNED.findall(pinned)).items() if package in needed
    )


def here(packages: Sequence[str]) -> str:
    """Return the versions on this machine, a line for each installed package: ``numpy==2.3.5``."""
    return "".join(f"{package}=={_installed(package)}\n" for package in packages if _installed(package))


def line(folder: Path) -> str:
    """Return what to tell a student whose versions differ from those in a folder's constraints file.

    Return "" if they do not differ, or without such a file, as where an instructor installed the package.
    """
    file = folder / FILE
    found = differences(file.read_text(encoding="utf-8")) if file.is_file() else []
    if not found:
        return ""
    differing = ", ".join(f"{package} {here or 'is missing'} (class: {there})" for package, here, there in found)
    return f"Your versions differ from your class: {differing}. python -m pip install -r {FILE} installs the same."


def _installed(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""
