"""The late policy applied to one hand-in: how late it is, and what that takes off. The marks themselves are left alone."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import datetime

from grader.engine.rubric import LatePolicy
from grader.ground.stamps import read_stamp
from grader.people.standing import HandIn, Lateness, Person

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
    return _lateness(policy, until, math.ceil((came - until).total_seconds()))


def _lateness(policy: LatePolicy, due: datetime, seconds: int) -> Lateness | None:
    """A day that has begun counts whole; None up to the end of the grace period."""
    if seconds <= 60 * policy.grace_minutes:
        return None
    days = math.ceil(seconds / DAY)
    refused = policy.cut_off_days is not None and seconds > policy.cut_off_days * DAY
    return Lateness(_text(due), seconds, days, round(days * policy.per_day, 2), refused)


def _extension(policy: LatePolicy, people: tuple[Person, ...], names: tuple[str, ...]) -> datetime | None:
    """The latest date that anyone of a group has."""
    called = {
        text.casefold() for person in people for text in (person.name, person.key, person.sid, person.email) if text
    }
    called |= {name.casefold() for name in names}
    return max((until for who, until in policy.extensions.items() if who.casefold() in called), default=None)


def _text(when: datetime) -> str:
    return when.isoformat(timespec="minutes")
