"""The platforms, in the order in which they are recognised. Whoever lists platforms asks here.

Help texts want names at once, and a platform's module takes its time to import, so a line here says what its record does; a
record that does anything else is refused when it is asked for.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from grader.base.errors import GraderError

if TYPE_CHECKING:
    from grader.platforms.platform import Platform

Deed = Literal["respond", "read", "fill", "write"]
"""What a platform can do: the fields of its record that say so."""

DEEDS: tuple[Deed, ...] = ("respond", "read", "fill", "write")
AUTO = "auto"  # as a `--format`: whichever is recognised
FOLDERS = "folders"  # as a `--from`: the shape of no platform


@dataclass(frozen=True)
class Listed:
    """A platform's module, which holds its record as `PLATFORM`, and what the platform supports."""

    module: str
    does: tuple[Deed, ...]


LISTED: dict[str, Listed] = {
    # Classroom 50 runs inside GitHub Actions, and its downloads are git clones; result.json is what remains
    "classroom50": Listed("grader.platforms.classroom50", ("respond", "read")),
    "github": Listed("grader.platforms.github", ("respond",)),
    "gradescope": Listed("grader.platforms.gradescope", ("respond", "read", "write")),
    "prairielearn": Listed("grader.platforms.prairielearn", ("respond",)),
    "moodle": Listed("grader.platforms.moodle", ("read", "fill")),
    "canvas": Listed("grader.platforms.canvas", ("read", "fill")),
    "git": Listed("grader.platforms.git", ("read",)),
    "csv": Listed("grader.platforms.gradebook", ("write",)),
    "json": Listed("grader.platforms.result_json", ("respond",)),
    "junit": Listed("grader.platforms.junit", ("respond",)),  # of any that is not recognised
}


def names(*deeds: Deed) -> tuple[str, ...]:
    """Return the names of the platforms that support one of these."""
    return tuple(name for name, listed in LISTED.items() if set(deeds) & set(listed.does))


def platform(name: str) -> Platform:
    """The record of a platform that is listed.

    Raises
    ------
    GraderError
        If it does not do what its line says.
    """
    listed = LISTED[name]
    record: Platform = importlib.import_module(listed.module).PLATFORM
    does = tuple(deed for deed in DEEDS if getattr(record, deed) is not None)
    if (record.name, does) != (name, listed.does):
        raise GraderError(f"{listed.module}: {record.name} does {does}, and its line in the registry says {listed}")
    return record


def platforms(*deeds: Deed) -> Iterator[Platform]:
    """The records of those that do one of these."""
    return (platform(name) for name in names(*deeds))
