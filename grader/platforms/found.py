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
    """One hand-in.

    Attributes
    ----------
    student
        The same for two attempts of the same people, and for no others.
    wish
        What its id is made from: the same whenever these people hand in again.
    name
        What results call it.
    order
        A later attempt has a greater one.
    """

    student: str
    wish: str
    name: str
    path: Path
    sources: Sources = ()
    hand_in: HandIn = NOTHING_KNOWN
    order: tuple[str, int, str] = ("", 0, "")


@dataclass(frozen=True)
class Shape:
    """A kind of download: what it holds, and files that are nobody's with a reason."""

    title: str
    found: tuple[Found, ...]
    left: tuple[tuple[str, str], ...] = ()


def mostly(fits: Iterable[bool]) -> bool:
    """Return whether at least half of them fit, and there are some: one stray file changes nothing."""
    answers = list(fits)
    return bool(answers) and 2 * sum(answers) >= len(answers)
