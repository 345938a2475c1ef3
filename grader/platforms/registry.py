"""The only list of platforms, in detection order.

A line here names what a platform supports, because help texts need the names at once and a platform's module is slow to import. A
record that supports anything else is refused when it is loaded.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Literal

from grader.base.errors import GraderError

if TYPE_CHECKING:
    from grader.platforms.platform import Platform

Deed = Literal["respond", "read", "fill", "write"]
"""Fields of a platform's record that say what it supports."""

DEEDS: tuple[Deed, ...] = ("respond", "read", "fill", "write")
AUTO = "auto"  # value of `--format` that recognises the platform
FOLDERS = "folders"  # value of `--from` for folders of no platform


LISTED: dict[str, tuple[str, tuple[Deed, ...]]] = {
    # Classroom 50 runs inside GitHub Actions, and its downloads are git clones; it has to be recognised before both
    "classroom50": ("grader.platforms.classroom50", ("respond", "read")),
    "github": ("grader.platforms.github", ("respond",)),
    "gradescope": ("grader.platforms.gradescope", ("respond", "read", "write")),
    "prairielearn": ("grader.platforms.prairielearn", ("respond",)),
    "moodle": ("grader.platforms.moodle", ("read", "fill")),
    "canvas": ("grader.platforms.canvas", ("read", "fill")),
    "git": ("grader.platforms.git", ("read",)),
    "csv": ("grader.platforms.gradebook", ("write",)),
    "json": ("grader.platforms.result_json", ("respond",)),
    "junit": ("grader.platforms.junit", ("respond",)),  # the default if no platform is recognised
}
"""A platform's module, which holds its record as `PLATFORM`, and what the platform supports."""


def names(*deeds: Deed) -> tuple[str, ...]:
    """Return the names of the platforms that support at least one of these capabilities, such as "respond" (CI output)."""
    return tuple(name for name, (_, does) in LISTED.items() if set(deeds) & set(does))


def platform(name: str) -> Platform:
    """Return the record of a platform in `LISTED`, by its name there; its module is imported only now.

    Raise GraderError if the record does not support exactly what its line in `LISTED` says.
    """
    module, listed = LISTED[name]
    record: Platform = importlib.import_module(module).PLATFORM
    does = tuple(deed for deed in DEEDS if getattr(record, deed) is not None)
    if (record.name, does) != (name, listed):
        raise GraderError(f"{module}: {record.name} does {does}, and its line in the registry says {name}: {listed}")
    return record


def platforms(*deeds: Deed) -> Iterator[Platform]:
    """Yield the records of the platforms that support at least one of these capabilities, such as "read" (downloads)."""
    return (platform(name) for name in names(*deeds))
