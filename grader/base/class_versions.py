"""Library versions that all students of a course should share: the instructor's, handed out as a constraints file of pip.

The same code may raise with one release of a library and not with another. So a student's versions are compared with that file.
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
    """Return a pip constraints file that pins the installed version of each package, for students to install the same.

    A line holds only for the Python releases that the pinned version supports; with another Python, pip chooses a version itself.
    Raises `PackageNotFoundError` if a package is not installed.
    """
    lines = []
    for package in packages:
        about = metadata(package)
        bounds = _BOUND.findall(about["Requires-Python"] or "")
        where = " and ".join(f'python_version {sign} "{release}"' for sign, release in bounds)
        lines.append(f"{package}=={about['Version']}{f'; {where}' if where else ''}\n")
    return "".join(lines)


def differences(pinned: str) -> list[tuple[str, str, str]]:
    """Return (name, version here, version pinned) of each package whose installed version differs from that in `pinned`.

    `pinned` is the text of a constraints file. The version here is "" if the package is not installed.
    """
    found = ((package, _installed(package), there) for package, there in _PINNED.findall(pinned))
    return [each for each in found if each[1] != each[2]]


def of_ours(pinned: str) -> str:
    """Return the lines ``name==version`` of `pinned`, text from a submission, that name packages which the grader requires.

    The report tells students which versions differ here, so lines forged for other packages would show what else is installed.
    """
    needed = {Requirement(each).name for each in requires("imugrade") or () if "extra ==" not in each}
    return "".join(
        f"{package}=={there}\n" for package, there in dict(_PINNED.findall(pinned)).items() if package in needed
    )


def here(packages: Sequence[str]) -> str:
    """Return the installed version of each package, one line each (``numpy==2.3.5``); packages that are not installed are left out.

    `imugrade check` writes the text into the submission, so that grading elsewhere can tell the student which versions differ.
    """
    return "".join(f"{package}=={_installed(package)}\n" for package in packages if _installed(package))


def line(folder: Path) -> str:
    """Return the warning that `imugrade check` prints if library versions differ from the class's file ``constraints.txt``.

    Return "" if none differs, or if the lab's folder, `folder`, has no such file: only the students' installation has it.
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
