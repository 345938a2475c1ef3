"""The catalogue of known mistakes: `imugrade explain` reads it, too, so nothing slow is imported here."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import yaml

from grader.engine.lab import Lab


@dataclass(frozen=True)
class Mistake:
    """One entry of the catalogue: what the code does, how to go on, and an explanation for `imugrade explain`."""

    id: str
    group: str
    means: str
    hint: str
    explanation: str
    step: int | None
    wrong: str
    right: str


@functools.cache
def catalogue(lab: Lab) -> Mapping[str, Mistake]:
    """Every mistake of a lab that has a name, by id, read from the file that the handbook is made from."""
    loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    text = (lab.folder / "mistakes.yaml").read_text(encoding="utf-8")
    groups = yaml.load(text, Loader=loader)
    return {key: Mistake(key, group, **entry) for group, entries in groups.items() for key, entry in entries.items()}
