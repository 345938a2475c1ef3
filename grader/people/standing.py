"""Where a submission stands: its automatic marks, and beside them, never mixed in, what people and dates add."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from grader.engine.results import CriterionResult, Result


@dataclass(frozen=True)
class Person:
    """Who handed in. `key` is the platform's own name for them: a Canvas user id, a Moodle participant number, a user name.

    `platform` says whose name that is; "" where it is the name of a folder or an archive.
    """

    name: str
    key: str = ""
    platform: str = ""
    sid: str = ""
    email: str = ""
    section: str = ""


@dataclass(frozen=True)
class Lateness:
    """What the late policy says of one submission.

    Attributes
    ----------
    due
        When it was due for these people, ISO 8601 with its offset; "" where no policy is in force.
    seconds
        How long after that it came; None where the platform says "late" and not how late.
    days
        Days that were begun after `due`, as they are deducted; 0 within the grace period.
    deduction
        Points that the policy takes off, before they are limited to what there is.
    refused
        It came after the cut-off: nothing of it counts.
    """

    due: str
    seconds: int | None
    days: int = 0
    deduction: float = 0.0
    refused: bool = False


@dataclass(frozen=True)
class HandIn:
    """What is known of a hand-in beside its files.

    Attributes
    ----------
    people
        One, or all members of a group.
    submitted
        The platform's time stamp, ISO 8601 with its offset; "" where there is none.
    late
        None if it is not late, or nothing is known about it.
    reply
        What a file's name begins with, in the platform's own upload, to come back to these people; "" if it has no such thing.
    number
        The platform's number of the submission; "" if it has none.
    """

    people: tuple[Person, ...] = ()
    submitted: str = ""
    late: Lateness | None = None
    reply: str = ""
    number: str = ""


NOTHING_KNOWN = HandIn()


@dataclass(frozen=True)
class Adjustment:
    """Points that a person gives a criterion in place of the automatic ones: who, when and why.

    `points` None withdraws the adjustment before it. `beneath` holds the automatic points of each check at that time.
    """

    criterion: str
    points: float | None
    comment: str
    author: str
    at: str
    beneath: Mapping[str, float | None] = field(default_factory=dict)


@dataclass(frozen=True)
class Standing:
    """Everything that a gradebook or a page tells of one submission: what it is handed in place of a bare `Result`.

    `result` is what was marked, and stays as it is. `adjusted` is its total with the adjustments, `final` what is left of that
    by the late policy. Both are None while points are open through a fault of the grader.
    """

    id: str
    result: Result
    hand_in: HandIn = NOTHING_KNOWN
    adjustments: tuple[Adjustment, ...] = ()

    @property
    def people(self) -> tuple[Person, ...]:
        """Who handed in; where no platform tells, the name of what was handed in stands for them. Hostile text, as it came."""
        return self.hand_in.people or (Person(self.result.submission, self.id),)

    @property
    def name(self) -> str:
        return "; ".join(person.name for person in self.people if person.name)

    @property
    def section(self) -> str:
        return "; ".join(dict.fromkeys(person.section for person in self.people if person.section))

    @property
    def late(self) -> Lateness | None:
        return self.hand_in.late

    @property
    def adjusted(self) -> float | None:
        """Score with the adjustments, and extra credit; None while points are open."""
        points = [self.points(criterion) for criterion in self.result.criteria]
        if None in points or self._credit_is_open():
            return None
        return round(sum(p for p in points if p is not None) + self.result.extra_credit, 2)

    @property
    def deduction(self) -> float:
        """Points that lateness takes off, at most what there is."""
        if self.late is None or self.adjusted is None:
            return 0.0
        return self.adjusted if self.late.refused else min(self.late.deduction, self.adjusted)

    @property
    def final(self) -> float | None:
        """What goes to a platform."""
        return None if self.adjusted is None else round(self.adjusted - self.deduction, 2)

    def adjustment(self, criterion: str) -> Adjustment | None:
        return next((each for each in self.adjustments if each.criterion == criterion), None)

    def points(self, criterion: CriterionResult) -> float | None:
        """Points by hand, or else the automatic ones; None where they are open."""
        by_hand = self.adjustment(criterion.id)
        if by_hand is not None:
            return by_hand.points
        return None if None in beneath(criterion).values() else criterion.points

    def outdated(self) -> list[Adjustment]:
        """Adjustments whose automatic marks have changed since: someone has to look again."""
        now = {criterion.id: beneath(criterion) for criterion in self.result.criteria}
        return [each for each in self.adjustments if each.beneath != now.get(each.criterion)]

    def _credit_is_open(self) -> bool:
        rows = (check for extension in self.result.extensions for check in extension.checks)
        return self.result.extra_credit_cap is not None and any(check.points is None for check in rows)


def beneath(criterion: CriterionResult) -> dict[str, float | None]:
    """The automatic points of each check of a criterion."""
    return {check.id: check.points for check in criterion.checks}


def hand_in_to_dict(hand_in: HandIn) -> dict[str, Any]:
    return asdict(hand_in)


def hand_in_from_dict(record: Mapping[str, Any]) -> HandIn:
    """The inverse, for records read back from the store."""
    people = tuple(Person(**person) for person in record["people"])
    late = None if record["late"] is None else Lateness(**record["late"])
    return HandIn(**{**record, "people": people, "late": late})
