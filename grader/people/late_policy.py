"""Late policy of a class, applied to one hand-in: how late it is, and the deduction. Scores themselves are left alone."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import datetime, timezone
from zoneinfo import ZoneInfo

from grader.base.stamps import read_stamp
from grader.engine.rubric import LatePolicy
from grader.people.final_grade import HandIn, Lateness, Person

DAY = 86_400


def judged(hand_in: HandIn, policy: LatePolicy | None, names: tuple[str, ...]) -> HandIn:
    """The hand-in with what the policy says of it, whatever another one said before.

    Parameters
    ----------
    hand_in
        Who, when, and a date of their own, before which no other counts.
    policy
        None: the platform's own word on lateness stands, and nothing is taken off.
    names
        What else the policy may call them: the id of the submission.
    """
    return replace(hand_in, late=_late(hand_in, policy, names))


def _late(hand_in: HandIn, policy: LatePolicy | None, names: tuple[str, ...]) -> Lateness | None:
    if policy is None:
        return Lateness("", None) if hand_in.marked_late else None
    until = read_stamp(hand_in.due) or _extension(policy, hand_in.people, names) or policy.due
    came = read_stamp(hand_in.submitted)
    if came is None:
        return Lateness(_text(until), None) if hand_in.marked_late else None
    return _lateness(policy, until, came, hand_in.grace_days)


def _lateness(policy: LatePolicy, due: datetime, came: datetime, grace_days: int) -> Lateness | None:
    """Return the lateness of a hand-in; None up to the end of the grace period.

    A day that has begun counts whole. Where the policy names a time zone, a day ends when its clock shows the time of `due` again:
    a night in which the clock is changed makes it no longer. Grace days of the student are taken off the days that count.
    """
    seconds = math.ceil((came - due).total_seconds())
    if seconds <= 60 * policy.grace_minutes:
        return None
    by_clock = _by_clock(came, policy.tz) - _by_clock(due, policy.tz)
    days = max(1, math.ceil(by_clock.total_seconds() / DAY))
    refused = policy.cut_off_days is not None and by_clock.total_seconds() > policy.cut_off_days * DAY
    used = 0 if refused else min(days, grace_days)
    return Lateness(_text(due), seconds, days - used, round((days - used) * policy.per_day, 2), refused, used)


def _by_clock(when: datetime, zone: str) -> datetime:
    """Return what the clock of a time zone shows, UTC where none is named."""
    return when.astimezone(ZoneInfo(zone) if zone else timezone.utc).replace(tzinfo=None)


def _extension(policy: LatePolicy, people: tuple[Person, ...], names: tuple[str, ...]) -> datetime | None:
    """The latest date that anyone of a group has."""
    called = {text.casefold() for person in people for text in person.called}
    called |= {name.casefold() for name in names}
    return max((until for who, until in policy.extensions.items() if who.casefold() in called), default=None)


def _text(when: datetime) -> str:
    return when.isoformat(timespec="minutes")
