"""Locate a finding in a student's files: the line that raised, else the line where the part is defined.

Sources are searched as bytes and never parsed: a parser can be made to fail by what it reads.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from grader.engine.lab import Lab
from grader.engine.results import CheckResult
from grader.intake import Submission


@dataclass(frozen=True)
class Place:
    """A file, as the CI names it, and a line in it."""

    file: str
    line: int | None = None


@dataclass(frozen=True)
class Places:
    """The files of a submission by the name that messages use, and where each name that the lab asks for is defined."""

    lab: Lab
    files: Mapping[str, str] = field(default_factory=dict)
    definitions: Mapping[str, Place] = field(default_factory=dict)

    def of(self, check: CheckResult) -> Place | None:
        """Return the place to show for this check; None where nothing is known."""
        return self._named(check) or self.definitions.get(self.lab.name_of(check.id))

    def _named(self, check: CheckResult) -> Place | None:
        """The line that the check names, if the file is one of the submission: a process may say anything."""
        if check.where is None or check.where.file not in self.files:
            return None
        return Place(self.files[check.where.file], check.where.line)


def find_places(lab: Lab, submission: Submission, path: Path, root: Path) -> Places:
    """Look up the places of a submission.

    Parameters
    ----------
    lab
        Whose names are looked for.
    submission
        As it was read from `path`.
    path
        What was given to be graded: a folder, or an archive (then there are no lines to point to).
    root
        What the CI's file names start from: the root of the checkout.
    """
    files = submission.files
    there = {name: path / submission.origin(name) for name in files}
    names = {name: _relative(file, root) for name, file in there.items() if _holds(file, len(files[name]))}
    found = {name: _definition(name, home, files, names) for name, home in lab.homes.items()}
    return Places(lab, names, {name: place for name, place in found.items() if place})


def _relative(path: Path, root: Path) -> str:
    return PurePosixPath(os.path.relpath(path, root).replace(os.sep, "/")).as_posix()


def _definition(name: str, home: str, files: Mapping[str, bytes], names: Mapping[str, str]) -> Place | None:
    """The first definition: in the file where the sheet expects it, else in any other; else that file, if it is there."""
    pattern = re.compile(rb"^[ \t]*(?:def|class)[ \t]+%s\b" % name.encode(), re.MULTILINE)
    programs = sorted((file for file in names if file.endswith(".py")), key=lambda file: (file != home, file))
    for file in programs:
        if hit := pattern.search(files[file]):
            return Place(names[file], files[file].count(b"\n", 0, hit.start()) + 1)
    return Place(names[home]) if home in names else None


def _holds(path: Path, size: int) -> bool:
    try:
        return path.lstat().st_size == size
    except (OSError, ValueError):
        return False
