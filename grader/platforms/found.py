"""Facts that a platform's download gives about one submission, before it has an id."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from grader.intake.downloads import Sources
from grader.people.final_grade import NOTHING_KNOWN, HandIn

AMBIGUOUS = "its name can mean several people; give --roster with the platform's numbers, and it is who stands there"


@dataclass(frozen=True)
class Found:
    """One submission that a platform's download contains, before it is read.

    Attributes
    ----------
    student
        Key of the people, equal for all attempts of the same people.
    id_source
        Text that the id is made from, equal whenever these people hand in again.
    name
        Name of the submission in results.
    order
        Sort key of attempts; a later attempt has a greater one.
    """

    student: str
    id_source: str
    name: str
    path: Path
    sources: Sources = ()
    hand_in: HandIn = NOTHING_KNOWN
    order: tuple[str, int, str] = ("", 0, "")


@dataclass(frozen=True)
class Shape:
    """Contents of a download: its kind, the submissions, and the files that belong to nobody, each with a reason."""

    title: str
    found: tuple[Found, ...]
    left: tuple[tuple[str, str], ...] = ()


def at_least_half(fits: Iterable[bool]) -> bool:
    """Return whether at least half of the values are true, so that a few stray files do not matter; False if there are none."""
    answers = list(fits)
    return bool(answers) and 2 * sum(answers) >= len(answers)
