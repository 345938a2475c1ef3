"""Apply the late policy of a class to a hand-in: how late it is, and what that deducts. Scores themselves stay unchanged."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import datetime, timezone, tzinfo
from zoneinfo import ZoneInfo

from grader.base.stamps import read_stamp
from grader.engine.rubric import LatePolicy
from grader.people.final_grade import FinalGrade, HandIn, Lateness, Person

DAY = 86_400


def judged(hand_in: HandIn, policy: LatePolicy | None, names: tuple[str, ...]) -> HandIn:
    """Return the hand-in with its lateness by this policy, in place of an earlier lateness, and its time in the class's time zone.

    Parameters
    ----------
    hand_in : people, time, and a due date of their own, which takes precedence over the policy's dates
    policy : None keeps the platform's "late" and deducts nothing
    names : further names under which the policy may list a due date, such as the id of the submission
    """
    return replace(hand_in, submitted=in_zone(hand_in.submitted, policy), late=_late(hand_in, policy, names))


def zone_of(policy: LatePolicy | None) -> tzinfo | None:
    """Return the time zone in which a class reads dates; None without a late policy, or if it names none."""
    return ZoneInfo(policy.tz) if policy is not None and policy.tz else None


def in_zone(stamp: str, policy: LatePolicy | None) -> str:
    """Return an ISO 8601 time in the class's time zone; unchanged if it is no time with offset, or the class has no time zone."""
    when, zone = read_stamp(stamp), zone_of(policy)
    return stamp if when is None or zone is None else when.astimezone(zone).isoformat(timespec="seconds")


def judged_again(final_grade: FinalGrade, policy: LatePolicy | None) -> FinalGrade:
    """Return the final grade with its lateness computed again by a policy that changed; `policy` None deducts nothing."""
    names = (final_grade.id, final_grade.result.submission)
    return replace(final_grade, hand_in=judged(final_grade.hand_in, policy, names))


def _late(hand_in: HandIn, policy: LatePolicy | None, names: tuple[str, ...]) -> Lateness | None:
    if policy is None:
        return Lateness("", None) if hand_in.marked_late else None
    until = read_stamp(hand_in.due) or _own_due_date(policy, hand_in.people, names) or policy.due
    came = read_stamp(hand_in.submitted)
    if came is None:
        return Lateness(in_zone(_text(until), policy), None) if hand_in.marked_late else None
    return _lateness(policy, until, came, hand_in.grace_days)


def _lateness(policy: LatePolicy, due: datetime, came: datetime, grace_days: int) -> Lateness | None:
    """Return the lateness of a hand-in; None up to the end of the grace period.

    A day that has begun counts whole. If the policy names a time zone, days are counted on its clock, so a change to or from summer
    time adds no day. Grace days of the student are subtracted from the days.
    """
    seconds = math.ceil((came - due).total_seconds())
    if seconds <= 60 * policy.grace_minutes:
        return None
    by_clock = _by_clock(came, policy.tz) - _by_clock(due, policy.tz)
    days = max(1, math.ceil(by_clock.total_seconds() / DAY))
    refused = policy.cut_off_days is not None and by_clock.total_seconds() > policy.cut_off_days * DAY
    used = 0 if refused else min(days, grace_days)
    return Lateness(
        in_zone(_text(due), policy), seconds, days - used, round((days - used) * policy.per_day, 2), refused, used
    )


def _by_clock(when: datetime, zone: str) -> datetime:
    """Return the local time in a time zone, by which days are counted, or in UTC if `zone` is ""."""
    return when.astimezone(ZoneInfo(zone) if zone else timezone.utc).replace(tzinfo=None)


def _own_due_date(policy: LatePolicy, people: tuple[Person, ...], names: tuple[str, ...]) -> datetime | None:
    """Return the latest due date that the policy gives to one of these people or names; None if it gives none."""
    called = {text.casefold() for person in people for text in person.called}
    called |= {name.casefold() for name in names}
    return max((until for who, until in policy.due_dates.items() if who.casefold() in called), default=None)


def _text(when: datetime) -> str:
    return when.isoformat(timespec="minutes")
