"""Find the line at which a CI server shows a message: the line that raised, else the line where the function is defined.

Sources are searched as bytes and never parsed, because a student's text can make a parser fail.
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
class FileLine:
    """A line of a student's file, by its path in the repository, where the CI shows a message; `line` None is the whole file."""

    file: str
    line: int | None = None


@dataclass(frozen=True)
class Places:
    """Lines of a submission at which the CI can show messages, as `find_places` found them.

    `files` maps a file's name in messages to its path in the repository; `definitions` says where each required name is defined.
    """

    lab: Lab
    files: Mapping[str, str] = field(default_factory=dict)
    definitions: Mapping[str, FileLine] = field(default_factory=dict)

    def line_for(self, check: CheckResult) -> FileLine | None:
        """Return the line where the CI shows a check's message: its own place (`where`), else the checked definition, else None."""
        return self._named_line(check) or self.definitions.get(self.lab.name_of(check.id))

    def _named_line(self, check: CheckResult) -> FileLine | None:
        """Return the line that a check names; None if it names none, or a file that the submission lacks, as student code could."""
        if check.where is None or check.where.file not in self.files:
            return None
        return FileLine(self.files[check.where.file], check.where.line)


def find_places(lab: Lab, submission: Submission, path: Path, root: Path) -> Places:
    """Find the lines at which the CI can show messages about a submission.

    Parameters
    ----------
    lab
        The lab, which lists the required names.
    submission
        The submission as it was read from `path`.
    path
        The graded folder or archive. There are no lines to point to in an archive.
    root
        The root of the checkout, from which the CI's paths start.
    """
    files = submission.files
    there = {name: path / submission.origin(name) for name in files}
    names = {name: _relative(file, root) for name, file in there.items() if _has_size(file, len(files[name]))}
    found = {name: _defining_line(name, home, files, names) for name, home in lab.homes.items()}
    return Places(lab, names, {name: place for name, place in found.items() if place})


def _relative(path: Path, root: Path) -> str:
    return PurePosixPath(os.path.relpath(path, root).replace(os.sep, "/")).as_posix()


def _defining_line(name: str, home: str, files: Mapping[str, bytes], names: Mapping[str, str]) -> FileLine | None:
    """Return the line where a name is defined, first in its `home` (the sheet's file), then in others; else the start of `home`.

    None if there is no such file either.
    """
    pattern = re.compile(rb"^[ \t]*(?:def|class)[ \t]+%s\b" % name.encode(), re.MULTILINE)
    programs = sorted((file for file in names if file.endswith(".py")), key=lambda file: (file != home, file))
    for file in programs:
        if hit := pattern.search(files[file]):
            return FileLine(names[file], files[file].count(b"\n", 0, hit.start()) + 1)
    return FileLine(names[home]) if home in names else None


def _has_size(path: Path, size: int) -> bool:
    try:
        return path.lstat().st_size == size
    except (OSError, ValueError):
        return False
