"""The catalogue of known mistakes: `imugrade explain` reads it, too, so nothing slow is imported here."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import yaml

from grader.engine.lab import Lab
from grader.ground.errors import GraderError


@dataclass(frozen=True)
class Mistake:
    """One entry of the catalogue: what the code does, how to go on, and an explanation for `imugrade explain`.

    `raised` is a pattern of the exceptions that show it, as ``Type: message``; empty where none does.
    """

    id: str
    group: str
    means: str
    hint: str
    explanation: str
    step: int | None
    wrong: str
    right: str
    raised: str = ""


NEEDED = (
    "file-missing", "name-missing", "does-not-import", "missing-package", "raises", "never-returns", "kills-its-process",
    "tampering",
)  # fmt: skip
"""What the engine itself finds out, whatever the lab is: each catalogue has the words for it."""


@functools.cache
def catalogue(lab: Lab) -> Mapping[str, Mistake]:
    """Every mistake of a lab that has a name, by id, read from the file that the handbook is made from.

    Raises
    ------
    GraderError
        If one is missing that the engine finds out by itself.
    """
    loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    text = (lab.folder / "mistakes.yaml").read_text(encoding="utf-8")
    groups = yaml.load(text, Loader=loader)
    found = {key: Mistake(key, group, **entry) for group, entries in groups.items() for key, entry in entries.items()}
    if missing := [id_ for id_ in NEEDED if id_ not in found]:
        raise GraderError(f"the mistakes of {lab.label} lack {', '.join(missing)}")
    return found
