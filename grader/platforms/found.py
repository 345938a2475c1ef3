"""Facts in a platform's download about one submission, before the submission has an id."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from grader.intake.downloads import Sources
from grader.people.final_grade import NOTHING_KNOWN, HandIn

AMBIGUOUS = "its name can mean several people; give --roster with the platform's numbers, and it is who stands there"


@dataclass(frozen=True)
class Found:
    """One submission that a platform's download contains, before it is read: where its files lie, whose they are and which attempt.

    Attributes
    ----------
    student
        Key by which all attempts of one student or group are recognised, such as ``git:ada``.
    id_source
        Readable text that becomes the submission's id, such as name and number of the student; equal for all attempts.
    name
        Name of the submission in results, such as the names of all its students.
    path, sources
        The download, and files or folders in it, each with its name in the submission; empty where all of `path` is the submission.
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
    """Contents of a platform's download: its kind (`title`), the submissions, and what is not graded (`left`: names, reasons)."""

    title: str
    found: tuple[Found, ...]
    left: tuple[tuple[str, str], ...] = ()


def at_least_half(fits: Iterable[bool]) -> bool:
    """Return whether at least half of a download's entries fit a platform, so that stray files do not matter; False without any."""
    answers = list(fits)
    return bool(answers) and 2 * sum(answers) >= len(answers)
