"""Final grades: a submission's automatic result and, kept apart from it, overrides and lateness."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any

from grader.engine.results import CheckResult, CriterionResult, Result


@dataclass(frozen=True)
class Person:
    """A person who handed in. `key` is the platform's identifier: a Canvas user id, a Moodle participant number, a user name.

    `platform` says whose name that is; "" where it is the name of a folder or an archive. `sid` is the student number, and `ids`
    holds every other identifier that the roster has of them: logins, user names, GitHub names.
    """

    name: str
    key: str = ""
    platform: str = ""
    sid: str = ""
    email: str = ""
    section: str = ""
    ids: tuple[str, ...] = ()

    @property
    def called(self) -> tuple[str, ...]:
        """Every known identifier and name of the person."""
        return tuple(filter(None, (self.name, self.key, self.sid, self.email, *self.ids)))


@dataclass(frozen=True)
class Lateness:
    """The late policy's verdict on one submission.

    Attributes
    ----------
    due
        When it was due for these people, ISO 8601 with its offset; "" where no policy is in force.
    seconds
        How long after that it came; None where the platform says "late" and not how late.
    days
        Days that were begun after `due`, as they are deducted; 0 within the grace period, or where grace days cover them.
    deduction
        Points that the policy takes off, before they are limited to what there is.
    refused
        It came after the cut-off: nothing of it counts.
    grace_days
        Grace days of the student that were used, and are not among `days`.
    """

    due: str
    seconds: int | None
    days: int = 0
    deduction: float = 0.0
    refused: bool = False
    grace_days: int = 0


@dataclass(frozen=True)
class HandIn:
    """Facts about a submission beside its files: time, people, platform.

    Attributes
    ----------
    people
        One, or all members of a group.
    submitted
        The platform's time stamp, ISO 8601 with its offset; "" where there is none.
    due
        When it is due for these people alone, as the roster has it, ISO 8601 with its offset; "" where they have no such date.
    grace_days
        Days that these people may be late without a deduction, as the roster has them.
    marked_late
        The platform says that it is late, and not how late.
    late
        What follows from these and the policy; None if it is not late, or nothing is known about it.
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
    due: str = ""
    marked_late: bool = False
    grace_days: int = 0


NOTHING_KNOWN = HandIn()


TOTAL, BONUS = "total", "bonus"


@dataclass(frozen=True)
class Adjustment:
    """A person's change to a submission: an override, additional points, or a comment alone.

    Attributes
    ----------
    criterion
        What it is about: a criterion, one of its checks, `TOTAL` in place of their sum, or `BONUS` on top of it.
    points
        None withdraws the one before it; words alone have none, and empty ones withdraw.
    beneath, out_of
        The automatic points of each check that it stands for, at that time, and what each was worth; older records have no worth.
    alone
        Whether it is words alone.
    decision
        The number of the decision on several submissions that it is a part of; 0 for one of its own.
    number
        Its place in the record.
    """

    criterion: str
    points: float | None
    comment: str
    author: str
    at: str
    beneath: Mapping[str, float | None] = field(default_factory=dict)
    out_of: Mapping[str, float] = field(default_factory=dict)
    alone: bool = False
    decision: int = 0
    number: int = field(default=0, compare=False, repr=False)

    @property
    def withdraws(self) -> bool:
        return not self.comment if self.alone else self.points is None


@dataclass(frozen=True)
class FinalGrade:
    """Everything that a gradebook or a page tells of one submission: what it is handed in place of a bare `Result`.

    `result` is what was marked, and stays as it is. `adjusted` is its total with the adjustments, `final` what is left of that
    by the late policy. Both are None while points are open through a fault of the grader, and `unseen` where there was nothing to
    mark and nobody has looked: such a mark is not given out. `namesake` says that somebody else of the class has the same name.
    """

    id: str
    result: Result
    hand_in: HandIn = NOTHING_KNOWN
    adjustments: tuple[Adjustment, ...] = ()
    unseen: bool = False
    namesake: bool = field(default=False, compare=False)

    @property
    def people(self) -> tuple[Person, ...]:
        """The people who handed in, or the submission's name where no platform tells. Untrusted text, unchanged."""
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

    @cached_property
    def adjusted(self) -> float | None:
        """Score with the adjustments, repairs and extra credit; None while points are open."""
        total, bonus = self.adjustment(TOTAL), self.adjustment(BONUS)
        points = self._summed() if total is None else total.points
        return None if points is None else round(points + (0.0 if bonus is None else bonus.points or 0.0), 2)

    def _summed(self) -> float | None:
        points = summed({criterion.id: self.points(criterion) for criterion in self.result.criteria})
        return (
            None
            if self.unseen or points is None or self._credit_is_open()
            else round(points - self.result.repair_deduction + self.result.extra_credit, 2)
        )

    @property
    def deduction(self) -> float:
        """Points that lateness takes off, at most what there is."""
        if self.late is None or self.adjusted is None:
            return 0.0
        return self.adjusted if self.late.refused else min(self.late.deduction, self.adjusted)

    @property
    def final(self) -> float | None:
        """The points that an export writes."""
        return None if self.adjusted is None else round(self.adjusted - self.deduction, 2)

    def adjustment(self, criterion: str) -> Adjustment | None:
        """The override of a criterion, a check, `TOTAL` or `BONUS`."""
        return next((each for each in self.adjustments if each.criterion == criterion and not each.alone), None)

    def points(self, criterion: CriterionResult) -> float | None:
        """Points of an override, or else the automatic ones; None where they are open."""
        given = {each.criterion: each.points for each in self.adjustments if not each.alone}
        if criterion.id in given:
            return given[criterion.id]
        return summed({check.id: given.get(check.id, check.points) for check in criterion.checks})

    def check_points(self, check: CheckResult) -> float | None:
        """Return a check's own points: those set by a person, else the automatic ones; None where they are open.

        An override of its whole criterion is not considered.
        """
        by_hand = self.adjustment(check.id)
        return check.points if by_hand is None else by_hand.points

    def outdated(self) -> list[Adjustment]:
        """Return the overrides whose automatic points, or what those are worth, have changed since: someone has to look again."""
        return [each for each in self.adjustments if not each.alone and self._is_outdated(each)]

    def _is_outdated(self, adjustment: Adjustment) -> bool:
        now = under(self.result, adjustment.criterion)
        if now is None or adjustment.beneath != now:
            return True
        return bool(adjustment.out_of) and adjustment.out_of != worths(self.result, now)

    def _credit_is_open(self) -> bool:
        rows = (check for extension in self.result.extensions for check in extension.checks)
        return self.result.extra_credit_cap is not None and any(check.points is None for check in rows)


def given_out(final_grades: Mapping[str, FinalGrade], reviewed: Collection[str] = ()) -> dict[str, FinalGrade]:
    """Return the standings as files have them: an empty or unreadable submission is blank until a person has looked.

    A person has looked where there is an override, or where the submission is among those that were marked as reviewed.
    """

    def nothing(final_grade: FinalGrade) -> bool:
        empty = final_grade.result.status in ("empty", "unreadable")
        return empty and final_grade.id not in reviewed and all(each.alone for each in final_grade.adjustments)

    return {id_: replace(final_grade, unseen=nothing(final_grade)) for id_, final_grade in final_grades.items()}


def beneath(criterion: CriterionResult) -> dict[str, float | None]:
    """The automatic points of each check of a criterion."""
    return {check.id: check.points for check in criterion.checks}


def under(result: Result, target: str) -> dict[str, float | None] | None:
    """The automatic points of each check that an override of `target` replaces; None if there is no such target."""
    if target == BONUS:
        return {}
    criteria = {criterion.id: beneath(criterion) for criterion in result.criteria}
    rows = {id_: points for checks in criteria.values() for id_, points in checks.items()}
    each = {id_: {id_: points} for id_, points in rows.items()}
    return {**each, **criteria, TOTAL: rows}.get(target)


def worths(result: Result, ids: Collection[str]) -> dict[str, float]:
    """Return what these checks are worth."""
    rows = (check for criterion in result.criteria for check in criterion.checks)
    return {check.id: check.max_points for check in rows if check.id in ids}


def summed(points: Mapping[str, float | None]) -> float | None:
    """Return the sum of the points; None while any of them is open."""
    return None if None in points.values() else round(sum(p for p in points.values() if p is not None), 2)


def worth(result: Result, target: str) -> float | None:
    """The most points that an override of `target` may give; None if there is no such target."""
    if target == BONUS:
        return result.max_score
    if target == TOTAL:
        return round(result.max_score + (result.extra_credit_cap or 0.0), 2)
    most = {check.id: check.max_points for criterion in result.criteria for check in criterion.checks}
    return (most | {criterion.id: criterion.max_points for criterion in result.criteria}).get(target)


def hand_in_to_dict(hand_in: HandIn) -> dict[str, Any]:
    return asdict(hand_in)


def hand_in_from_dict(record: Mapping[str, Any]) -> HandIn:
    """The inverse, for records read back from the store."""
    people = tuple(Person(**{**person, "ids": tuple(person.get("ids", ()))}) for person in record["people"])
    late = None if record["late"] is None else Lateness(**record["late"])
    return HandIn(**{**record, "people": people, "late": late})
