"""Final grades: a submission's automatic result together with a person's overrides and the late deduction."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from grader.engine.results import CheckResult, CriterionResult, Result


@dataclass(frozen=True)
class Person:
    """A student of the class, as platform and roster know them. `key` is the platform's identifier, such as a Canvas user id.

    `platform` is the platform of that key; "" if none gave it. `sid` is the student number, else another identifier in the person's
    row of the roster. `ids` are the rest of that row: logins, user names, GitHub names. `listed` is the row's student number, else
    its first other identifier, so that exports name people as the roster does; "" without either.
    """

    name: str
    key: str = ""
    platform: str = ""
    sid: str = ""
    email: str = ""
    section: str = ""
    ids: tuple[str, ...] = ()
    listed: str = field(default="", compare=False)

    @property
    def number(self) -> str:
        """The identifier in exported files: `listed`, else the student number, the platform's key or the e-mail; "" without any."""
        return self.listed or self.sid or self.key or self.email

    @property
    def called(self) -> tuple[str, ...]:
        """All known names and identifiers of the person, under which a late policy or a roster may list them."""
        return tuple(filter(None, (self.name, self.key, self.sid, self.email, *self.ids)))


@dataclass(frozen=True)
class Lateness:
    """Lateness of a submission that is not in time, and what the late policy deducts for it.

    Attributes
    ----------
    due : due date of the people who handed in, ISO 8601 with offset; "" without a policy
    seconds : seconds from `due` to the hand-in, more than 0; None if the platform only says "late"
    days : days begun after `due` for which points are deducted; 0 if grace days cover them all
    deduction : points that the policy deducts, not yet limited to the points earned
    refused : whether the hand-in came after the cut-off, so that it earns nothing
    grace_days : grace days of the student that were used, not counted in `days`
    """

    due: str
    seconds: int | None
    days: int = 0
    deduction: float = 0.0
    refused: bool = False
    grace_days: int = 0


@dataclass(frozen=True)
class HandIn:
    """Who handed in a submission, when and on which platform: all that is known of it beside its files.

    Attributes
    ----------
    people : one person, or all members of a group; empty if no platform names them
    submitted : time of the hand-in, ISO 8601 with offset; "" if it is unknown
    due : due date that the roster gives the people, ISO 8601 with offset; "" if they have none
    grace_days : late days without a deduction that the roster gives the people
    marked_late : whether the platform says that the hand-in is late
    late : `Lateness`: how late the hand-in is, and the deduction; None if it is not late, or nobody knows
    reply : prefix of a file name in the platform's upload that returns the file to the people; "" if the platform has none
    number : the platform's number of the submission; "" if it has none
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
    """Change that an instructor made to a submission's grade: an override of points, additional points, or only a comment.

    Attributes
    ----------
    criterion : what is changed: a criterion, a check, `TOTAL`, which replaces the sum, or `BONUS`, which is added to the sum
    points : the new points, None for a comment; an override with None withdraws the previous one
    automatic, out_of : automatic points and maximum of each replaced check, by its id, when the override was made
    alone : whether it is a comment without points; an empty comment withdraws the previous one
    decision : the number that all adjustments share that were made at once for several submissions; 0 for a single one
    number : the adjustment's row number in the class's database
    """

    criterion: str
    points: float | None
    comment: str
    author: str
    at: str
    automatic: Mapping[str, float | None] = field(default_factory=dict)
    out_of: Mapping[str, float] = field(default_factory=dict)
    alone: bool = False
    decision: int = 0
    number: int = field(default=0, compare=False, repr=False)

    @property
    def withdraws(self) -> bool:
        return not self.comment if self.alone else self.points is None


@dataclass(frozen=True)
class Term:
    """Summand of a final grade, such as the score, or a deduction with negative points.

    `name` is "score", or "total" if an instructor set the total; "bonus" for points that an instructor added; "extra credit" for
    points earned by the lab's optional extensions; "repair" or "late" for deductions.
    """

    name: str
    points: float


@dataclass(frozen=True)
class FinalGrade:
    """The final grade of one submission, from the automatic `result`, the hand-in and the adjustments of instructors.

    `final` is the score, with overrides, plus bonus and extra credit, minus the deductions for repairs and lateness; `terms` holds
    these numbers. An override of the total replaces this sum: only a bonus is added to it. `final` is None while a check is not
    judged because the grader failed, and while an empty or unreadable submission is `unseen`: no instructor has overridden its
    points or marked it as `reviewed`. `namesake` says that another student of the class has the same name.
    """

    id: str
    result: Result
    hand_in: HandIn = NOTHING_KNOWN
    adjustments: tuple[Adjustment, ...] = ()
    reviewed: bool = False
    namesake: bool = field(default=False, compare=False)

    @property
    def people(self) -> tuple[Person, ...]:
        """Return the people who handed in; if no platform names them, a person named as the submission. Names are untrusted."""
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
    def has_no_submission(self) -> bool:
        """Return whether the person handed in nothing, so that all points come from overrides."""
        return bool(self.result.provenance.get("no_submission"))

    @property
    def unseen(self) -> bool:
        """Return whether the submission is empty or unreadable, and no instructor reviewed or overrode it: a blank grade."""
        empty = self.result.status in ("empty", "unreadable")
        return empty and not self.reviewed and all(each.alone for each in self.adjustments)

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """Return the summands of the final grade but for zeros, the score or total first; () while `final` is None."""
        first = self._first_terms()
        if not first:
            return ()
        bonus = self.adjustment(BONUS)
        terms = [first[0], Term(BONUS, 0.0 if bonus is None else bonus.points or 0.0), *first[1:]]
        terms.append(Term("late", -self._late_deduction(_sum_of(terms))))
        return (terms[0], *(each for each in terms[1:] if each.points))

    def _first_terms(self) -> list[Term]:
        """Return the override of the total, or else score, extra credit and repair deduction; [] while a check is not judged."""
        total = self.adjustment(TOTAL)
        if total is not None:
            return [Term(TOTAL, total.points or 0.0)]
        points = summed({criterion.id: self._counted(criterion) for criterion in self.result.criteria})
        if points is None or self._credit_is_open():
            return []
        repair = min(self.result.repair_deduction, points)
        return [Term("score", points), Term("extra credit", self.result.extra_credit), Term("repair", -repair)]

    def _late_deduction(self, points: float) -> float:
        if self.late is None or self.total_is_set:
            return 0.0
        return points if self.late.refused else min(self.late.deduction, points)

    @property
    def adjusted(self) -> float | None:
        """Return the final grade before the late deduction; None as long as there is no final grade."""
        return _sum_of(each for each in self.terms if each.name != "late") if self.terms else None

    @property
    def deduction(self) -> float:
        """Return the late deduction, at most the grade without it; 0 if not late, or if an instructor set the total."""
        return next((-each.points for each in self.terms if each.name == "late"), 0.0)

    @property
    def final(self) -> float | None:
        """Return the final grade, the sum of its terms; None while a check is not judged or a review is due (see `unseen`)."""
        return _sum_of(self.terms) if self.terms else None

    @property
    def total_is_set(self) -> bool:
        """Return whether an instructor set the total: nothing automatic is then added to it or deducted from it."""
        return self.adjustment(TOTAL) is not None

    @property
    def maximum(self) -> float:
        """Return what a final grade should not exceed: all criteria's points plus the cap on extra credit. More stops an export."""
        return round(self.result.max_score + (self.result.extra_credit_cap or 0.0), 2)

    def above_maximum(self) -> list[Adjustment]:
        """Return the overrides with more points than their target has, as after a change of the rubric; they stop an export."""
        known = ((each, maximum_points(self.result, each.criterion)) for each in self.adjustments)
        return [each for each, most in known if each.points is not None and most is not None and each.points > most]

    def adjustment(self, criterion: str) -> Adjustment | None:
        """Return the override of a criterion, a check, `TOTAL` or `BONUS`; None if there is none."""
        return next((each for each in self.adjustments if each.criterion == criterion and not each.alone), None)

    def points(self, criterion: CriterionResult) -> float | None:
        """Return a criterion's points, overrides before automatic ones; None while a check is not judged.

        They are also None for a submission that is `unseen` (empty or unreadable, not reviewed) or missing, without an override.
        """
        targets = {criterion.id, *(check.id for check in criterion.checks)}
        by_hand = any(each.criterion in targets and not each.alone for each in self.adjustments)
        return None if self.has_no_submission and not by_hand else self._counted(criterion)

    def _counted(self, criterion: CriterionResult) -> float | None:
        """Return a criterion's points for the score: without a submission, 0 for a check that no override gives points.

        They are None while a check is not judged or the submission is `unseen`.
        """
        if self.unseen:
            return None
        given = {each.criterion: each.points for each in self.adjustments if not each.alone}
        if criterion.id in given:
            return given[criterion.id]
        return summed({check.id: given.get(check.id, check.points) for check in criterion.checks})

    def check_points(self, check: CheckResult) -> float | None:
        """Return a check's own points: those set by a person, else the automatic ones; None if it was not judged.

        An override of its whole criterion is not considered.
        """
        by_hand = self.adjustment(check.id)
        return check.points if by_hand is None else by_hand.points

    def outdated(self) -> list[Adjustment]:
        """Return the overrides whose automatic points or maximum changed after they were made; a person should review them."""
        return [each for each in self.adjustments if not each.alone and self._is_outdated(each)]

    def _is_outdated(self, adjustment: Adjustment) -> bool:
        now = automatic_points(self.result, adjustment.criterion)
        if now is None or adjustment.automatic != now:
            return True
        return bool(adjustment.out_of) and adjustment.out_of != maximum_by_check(self.result, now)

    def _credit_is_open(self) -> bool:
        rows = (check for extension in self.result.extensions for check in extension.checks)
        return self.result.extra_credit_cap is not None and any(check.points is None for check in rows)


def _sum_of(terms: Iterable[Term]) -> float:
    return round(sum(each.points for each in terms), 2)


def untimed(final_grades: Iterable[FinalGrade]) -> list[str]:
    """Return the ids of submissions of unknown time, from which a late policy can deduct nothing.

    Submissions whose total an instructor set are left out, as nothing is deducted from such a total. If the platform marks late
    submissions, unmarked ones are in time, so only marked ones are returned.
    """
    handed_in = [each for each in final_grades if not each.has_no_submission]
    open_ = [each for each in handed_in if not each.hand_in.submitted and not each.total_is_set]
    only_marked = any(each.hand_in.marked_late for each in handed_in)
    return [each.id for each in open_ if each.hand_in.marked_late or not only_marked]


def graded(final_grades: Iterable[FinalGrade]) -> list[float]:
    """Return final grades for class means and charts, without empty, unreadable or partly judged submissions, even overridden."""
    return [each.final for each in final_grades if each.result.status == "graded" and each.final is not None]


@dataclass(frozen=True)
class GradeChange:
    """A submission whose final grade a regrade or another run changed, from `before` to `after`; None where a grade was blank."""

    final_grade: FinalGrade
    before: float | None
    after: float | None

    @property
    def by(self) -> float:
        return round((self.after or 0.0) - (self.before or 0.0), 2)


def grade_changes(before: Mapping[str, FinalGrade], after: Mapping[str, FinalGrade]) -> list[GradeChange]:
    """Return the submissions in both gradings whose final grade differs, the largest change first."""
    both = ((before[id_].final, each) for id_, each in after.items() if id_ in before)
    changes = [GradeChange(each, was, each.final) for was, each in both if was != each.final]
    return sorted(changes, key=lambda change: (-abs(change.by), change.final_grade.id))


def points_by_check(criterion: CriterionResult) -> dict[str, float | None]:
    """Return the automatic points of each check of a criterion; None for a check that was not judged."""
    return {check.id: check.points for check in criterion.checks}


def automatic_points(result: Result, target: str) -> dict[str, float | None] | None:
    """Return the automatic points of each check that an override of `target` replaces; {} for `BONUS`, None for an unknown id."""
    if target == BONUS:
        return {}
    criteria = {criterion.id: points_by_check(criterion) for criterion in result.criteria}
    rows = {id_: points for checks in criteria.values() for id_, points in checks.items()}
    each = {id_: {id_: points} for id_, points in rows.items()}
    return {**each, **criteria, TOTAL: rows}.get(target)


def maximum_by_check(result: Result, ids: Collection[str]) -> dict[str, float]:
    """Return the maximum points of the checks in `ids`, by check id, to see later whether an override is outdated."""
    rows = (check for criterion in result.criteria for check in criterion.checks)
    return {check.id: check.max_points for check in rows if check.id in ids}


def summed(points: Mapping[str, float | None]) -> float | None:
    """Return the sum of the points of several checks; None if any of them is None, because a check was not judged."""
    return None if None in points.values() else round(sum(p for p in points.values() if p is not None), 2)


def maximum_points(result: Result, target: str) -> float | None:
    """Return an override's most points: for `BONUS` the maximum score, for `TOTAL` with extra credit; None for an unknown id."""
    if target == BONUS:
        return result.max_score
    if target == TOTAL:
        return round(result.max_score + (result.extra_credit_cap or 0.0), 2)
    most = {check.id: check.max_points for criterion in result.criteria for check in criterion.checks}
    return (most | {criterion.id: criterion.max_points for criterion in result.criteria}).get(target)
