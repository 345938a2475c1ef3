"""Submissions of a class: find them, match them with the roster, and apply the late policy."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from grader.base.errors import RequestError
from grader.base.text import printable, some
from grader.course.record.database import FILE_NAME
from grader.course.record.store import Store
from grader.course.run.grade_request import GradeRequest
from grader.engine.rubric import Rubric
from grader.engine.rubric_nodes import guess_at
from grader.people import late_policy, roster
from grader.people.final_grade import HandIn, Person
from grader.people.identity import PersonLookup
from grader.platforms.classes import ClassEntry, read_class
from grader.report import words


@dataclass(frozen=True)
class Class:
    """The submissions of a class of students that a run found, and what an instructor should know of them.

    `entries` are the submissions, `leftovers` files that belong to none. `notices` are lines on what was read, `absent` people
    without a submission, `unknown` submissions that the roster lacks, `doubtful` lines on unclear matches and times. `others` are
    submissions stored earlier that are not in this download, with the people that the roster has for them.
    """

    entries: tuple[ClassEntry, ...]
    leftovers: tuple[str, ...]
    notices: tuple[str, ...]
    absent: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()
    doubtful: tuple[str, ...] = ()
    others: Mapping[str, HandIn] = field(default_factory=dict)


def find(request: GradeRequest) -> Class:
    """Find the submissions of a class, match them with the roster, and apply the late policy, before any is graded.

    Raises
    ------
    RequestError
        If there is nothing to grade, a name in `request.only` fits no submission, or the roster cannot be read.
    """
    listed = request.roster.people
    known = {each.who.key: each.who.name for each in listed if each.who.key}
    found = read_class(request.paths, request.rubric.lab.files, request.shape, request.attempts, known)
    submissions = _without_output_folder(found.entries, request)
    if not submissions:
        raise RequestError(
            f"{some([*map(str, request.paths)], 3)}: no submission found there; give a folder of submissions or an archive"
        )
    placed = roster.place(listed, {entry.id: _with_people(entry) for entry in submissions})
    entries = _select(
        submissions, request.only, PersonLookup({id_: each.people for id_, each in placed.hand_ins.items()})
    )
    dated = tuple(replace(entry, hand_in=_apply_late_policy(entry, placed, request.rubric)) for entry in entries)
    unknown = placed.unknown if listed else ()
    others = {
        id_: each for id_, each in _recorded(request.out).items() if id_ not in {entry.id for entry in submissions}
    }
    rest = roster.place(placed.absent, others)
    absent = tuple(
        words.absentees([each.person for each in rest.absent], (*placed.hand_ins.values(), *rest.hand_ins.values()))
    )
    doubtful = (*placed.doubtful, *_contradicting_times(entries, placed), *_unread_times(request))
    named = {id_: each for id_, each in rest.hand_ins.items() if each != others[id_]}
    return Class(dated, found.leftovers, found.notices, absent, unknown, doubtful, named)


def _recorded(out: Path) -> dict[str, HandIn]:
    """Return who handed in which stored submission or has points without one, so that a student graded earlier is not absent."""
    if not (out / FILE_NAME).is_file():
        return {}
    with Store.existing(out) as store:
        return {id_: each.hand_in for id_, each in store.final_grades().items()}


def _with_people(entry: ClassEntry) -> HandIn:
    """Return who handed in a submission and when; if no platform names people, the submission's name stands for them."""
    return replace(entry.hand_in, people=entry.hand_in.people or (Person(entry.name, entry.id),))


def _apply_late_policy(entry: ClassEntry, placed: roster.RosterMatch, rubric: Rubric) -> HandIn:
    """Add the roster's times and grace days to who handed in, and apply the late policy. The platform's time beats the roster's."""
    row = placed.rows.get(entry.id, roster.NO_FACTS)
    hand_in = replace(
        entry.hand_in,
        people=placed.hand_ins[entry.id].people,
        submitted=entry.hand_in.submitted or row.submitted,
        due=row.due.isoformat() if row.due else "",
        grace_days=row.grace_days,
        marked_late=entry.hand_in.marked_late or row.marked_late,
    )
    return late_policy.judged(hand_in, rubric.late, (entry.id, entry.name))


def _contradicting_times(entries: Sequence[ClassEntry], placed: roster.RosterMatch) -> Iterator[str]:
    """Yield a warning for each submission whose times in the roster and on the platform differ; the platform's counts."""
    for entry in entries:
        by_roster, known = placed.rows.get(entry.id, roster.NO_FACTS).submitted, entry.hand_in.submitted
        if by_roster and known and by_roster != known:
            yield f"{entry.id}: submitted {known} by the platform, which counts, and {by_roster} by the roster"


def _unread_times(request: GradeRequest) -> Iterator[str]:
    """Yield a warning if roster times cannot be used for lateness: they have no UTC offset, and the policy names no time zone."""
    if request.roster.has_local_times and request.rubric.late is not None:
        yield f"{request.roster.source}: its times are not read, as they have no offset from UTC; add `tz` to the late policy"


def listing(found: Class) -> Iterator[str]:
    """Yield a line for each submission found, as `grade --list` prints it: id, and, as far as known, people, time and lateness."""
    for entry in found.entries:
        hand_in = entry.hand_in
        people = "; ".join(" ".join(filter(None, (p.name, p.sid or p.key, p.email))) for p in hand_in.people)
        late = "late" if hand_in.late else ""
        yield "  ".join(printable(text, 200) for text in (entry.id, people, hand_in.submitted, late) if text)


def _without_output_folder(entries: tuple[ClassEntry, ...], request: GradeRequest) -> tuple[ClassEntry, ...]:
    """Drop an empty output folder from the submissions; RequestError if it is a submission or the class folder itself."""
    out = os.path.realpath(request.out)
    within = [entry for entry in entries if os.path.realpath(entry.path) == out]
    if out in map(os.path.realpath, request.paths) or any(entry.read().status != "empty" for entry in within):
        raise RequestError(
            f"-o {printable(str(request.out), 500)}: is one of the submissions; choose another folder for the results"
        )
    return tuple(entry for entry in entries if entry not in within)


def _select(entries: tuple[ClassEntry, ...], only: tuple[str, ...], who: PersonLookup) -> list[ClassEntry]:
    """Return the submissions that `--only` names, or all without it; RequestError for a word that matches none."""
    ids = [entry.id for entry in entries]
    wanted = {who.by(word): word for word in only}
    for id_, word in wanted.items():
        if id_ not in ids:
            raise RequestError(
                f"--only {printable(word)}: no submission has this id, name, number or address"
                f"{guess_at(word, [*ids, *(entry.name for entry in entries)])}; --list shows all"
            )
    return [entry for entry in entries if not only or entry.id in wanted]
