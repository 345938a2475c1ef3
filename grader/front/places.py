"""Where in a student's files the names are defined that the checks are about, as far as their text tells; nothing is run."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from grader.engine.lab import Lab
from grader.intake import Submission


@dataclass(frozen=True)
class Place:
    """A file, and a line of it counted from 0."""

    path: Path
    line: int


class Places:
    """The places in one submission.

    Parameters
    ----------
    path
        What was handed in: of an archive, it is the place of everything in it.
    """

    def __init__(self, lab: Lab, submission: Submission, path: Path) -> None:
        self._lab, self._submission, self._path = lab, submission, path

    def of(self, name: str) -> Place:
        """Where it is defined; where no file does, the beginning of the one that the lab expects it in."""
        home = self._lab.homes[name]
        defines = re.compile(rf"^[ \t]*(?:async[ \t]+)?(?:def|class)[ \t]+{name}\b", re.MULTILINE)
        files = self._submission.files
        for file in sorted((path for path in files if path.endswith(".py")), key=lambda path: path != home):
            text = files[file].decode("utf-8", "replace")
            if found := defines.search(text):
                return self._at(file, text.count("\n", 0, found.start()))
        notebooks = (path for path in files if path.endswith(".ipynb") and f" {name}".encode() in files[path])
        return self._at(home if home in files else next(notebooks, home), 0)

    def _at(self, file: str, line: int) -> Place:
        if self._path.is_dir():
            return Place(self._path / self._submission.origin(file), line)
        return Place(self._path, line if self._path.suffix == ".py" else 0)
