"""Read the roster of a class, a CSV with names, sections, own due dates and hand-in times, and match it with the hand-ins."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, tzinfo
from pathlib import Path
from typing import Any

from grader.base import tables
from grader.base.errors import RequestError
from grader.base.files import read_file
from grader.base.stamps import read_stamp, stamp
from grader.base.text import printable
from grader.people.final_grade import HandIn, Person
from grader.people.identity import Directory, Match, PersonRow, participant
from grader.people.worksheet_times import LATE, local_time

MAX_BYTES = 16_000_000
_DAYS = re.compile(r"[0-9]{1,3}")
COLUMNS: Mapping[str, tuple[str, ...]] = {
    "canvas": ("canvas_user_id",),
    "moodle": ("identifier",),
    "sid": ("sid", "student id", "student number", "sis user id", "id"),
    "id": (
        "username",
        "login",
        "sis login id",
        "user_id",
        "login_id",
        "integration id",
        "github_username",
        "github_id",
    ),
    "name": ("name", "student", "full name"),
    "first": ("first name", "first_name", "firstname"),
    "last": ("last name", "last_name", "lastname"),
    "email": ("email", "email address", "e-mail"),
    "section": ("section", "sections"),
    "group": ("group", "group name", "group_name", "team"),
    "due": ("due", "due date", "extension"),
    "submitted": ("submitted", "last modified (submission)"),
    "status": ("status",),
    "grace": ("grace_days", "grace days", "late_days", "late days", "slip days"),
}
"""Accepted titles of each column. They cover the exports of Canvas (also of its groups), Moodle, Gradescope, GitHub Classroom and
Classroom 50. Student numbers come before other identifiers, in this order."""


_NOBODY = ("Points Possible", "Student, Test")
"""First cells of Canvas gradebook rows that are no person: the row of maximum points, and the test student."""


@dataclass(frozen=True)
class RosterRow:
    """A person's row of a roster file, with an own `due` date or None; `submitted` is the hand-in time, ISO 8601, "" if unknown.

    `place` is file and line. `marked_late` says that Moodle's worksheet calls the submission late.
    """

    who: PersonRow
    section: str = ""
    due: datetime | None = None
    submitted: str = ""
    group: str = ""
    grace_days: int = 0
    marked_late: bool = False
    place: str = field(default="", compare=False)

    @property
    def person(self) -> Person:
        """Return this row as a `Person`, for a student whom no hand-in names: one without a submission, or a group partner."""
        return self.completed(
            Person(self.who.email or next(iter(self.who.numbers), ""), self.who.key, self.who.platform)
        )

    def completed(self, person: Person) -> Person:
        """Return a person with the name, numbers and section of this row. The platform's number stays: file names contain it."""
        numbers = self.who.numbers
        sid = person.sid or next((number for number in numbers if number != person.key), "")
        return replace(
            person,
            name=self.who.name or person.name,
            sid=sid,
            email=self.who.email or person.email,
            section=self.section or person.section,
            listed=next(iter(numbers), ""),
            ids=tuple(number for number in numbers if number not in (sid, person.key)),
        )

    def merged(self, other: RosterRow) -> RosterRow:
        """Return this row joined with another row of the same person or group.

        The later dates, most grace days and first section and group count; the joined row is marked late if either row is.
        """
        return replace(
            self, **{fact: of_two(getattr(self, fact), getattr(other, fact)) for fact, of_two in _FACTS.items()}
        )


NO_FACTS = RosterRow(PersonRow())


_FACTS: Mapping[str, Callable[[Any, Any], Any]] = {
    "due": lambda *dates: max(filter(None, dates), default=None),
    "submitted": max,
    "section": lambda first, second: first or second,
    "group": lambda first, second: first or second,
    "grace_days": max,
    "marked_late": max,
}
"""Which value of a fact counts where two rows have one."""
_COUNTS = "the later date, the most grace days and the first section and group count"


@dataclass(frozen=True)
class Roster:
    """The people of a class; `text` is the whole file and `source` its name.

    `has_local_times` says that it has times without an offset, and no zone was given by which to read them.
    """

    people: tuple[RosterRow, ...] = ()
    text: str = ""
    source: str = ""
    has_local_times: bool = False


NO_ROSTER = Roster()


def load(path: Path, zone: tzinfo | None = None) -> Roster:
    """Read and return a class's roster (CSV). `zone` is the time zone of a Moodle worksheet's times; None ignores the times.

    Raises
    ------
    RequestError
        If it cannot be read, has no column that identifies people, or an invalid date or grace days; the message names the line.
    """
    return parse(read_file(path, MAX_BYTES, "give the path of a CSV file"), printable(str(path), 500), zone)


def parse(data: bytes, source: str, zone: tzinfo | None = None) -> Roster:
    """Return the roster in the bytes of a CSV file, which messages call `source`; raise RequestError if it is no valid roster.

    `zone` is the time zone of a Moodle worksheet's times; None ignores the times.
    """
    table = tables.read(data, source).rows
    people = tuple(_rows(table, source, zone))
    local = zone is None and any(local_time(cell) for _, cells in table for cell in cells)
    return Roster(people, data.decode("utf-8", "surrogateescape"), source, local)


def _rows(table: Sequence[tuple[int, Sequence[str]]], source: str, zone: tzinfo | None) -> Iterator[RosterRow]:
    (_, first), *others = table or [(1, [])]
    titles = [title.strip().casefold() for title in first]
    known = {**COLUMNS, **_titled(titles)}
    places = {kind: [titles.index(name) for name in names if name in titles] for kind, names in known.items()}
    if not any(places[kind] for kind in ("canvas", "moodle", "sid", "id", "name", "first", "email")):
        raise RequestError(f"{source}:1: no column id, name or email; the first line has to name the columns")
    for line, cells in others:
        values = {kind: [cells[i].strip() for i in where if i < len(cells)] for kind, where in places.items()}
        if any(cells) and not cells[0].strip().startswith(_NOBODY):
            yield _listed(values, f"{source}:{line}", zone)


def _titled(titles: Sequence[str]) -> Mapping[str, tuple[str, ...]]:
    """Return other titles for columns in exports where a platform uses a common title in a special sense; {} for all others."""
    if titles[:2] == ["student", "id"]:  # Canvas: its own number
        return {"canvas": ("id",), "sid": tuple(name for name in COLUMNS["sid"] if name != "id")}
    if "github_username" in titles:  # GitHub Classroom: the number that the instructor entered
        return {"moodle": (), "sid": ("identifier", *COLUMNS["sid"])}
    return {}


def _listed(values: Mapping[str, Sequence[str]], place: str, zone: tzinfo | None) -> RosterRow:
    def first(kind: str) -> str:
        return next(filter(None, values[kind]), "")

    due, submitted = (_with_offset(first(kind), zone) for kind in ("due", "submitted"))
    for what, text in (("due", due), ("submitted", submitted)):
        if text and read_stamp(text) is None:
            example = "2026-11-20T23:59+01:00"
            raise RequestError(f"{place}: {what} must be a date and time with its offset from UTC, like {example}")
    name = first("name") or " ".join(filter(None, (first("first"), first("last"))))
    platform = next((each for each in ("canvas", "moodle") if first(each)), "")
    key = participant(first(platform)) if platform else ""
    if not _DAYS.fullmatch(first("grace") or "0"):
        raise RequestError(f"{place}: grace days must be a whole number, not {printable(first('grace'), 60)}")
    numbers = tuple(dict.fromkeys(filter(None, (*values["sid"], *values["id"]))))
    who = PersonRow(platform, key, numbers, first("email"), name)
    until, days = read_stamp(due) if due else None, int(first("grace") or 0)
    marked_late = bool(LATE.search(first("status")))
    return RosterRow(who, first("section"), until, stamp(submitted), first("group"), days, marked_late, place)


def _with_offset(text: str, zone: tzinfo | None) -> str:
    """Return a time of a Moodle worksheet with its offset, "" without a known zone; "" for "-" and any other text as it is."""
    if local := local_time(text):
        when = read_stamp(local, zone)
        return when.isoformat() if when else ""
    return "" if text == "-" else text


@dataclass(frozen=True)
class RosterMatch:
    """The hand-ins of a class by submission id, with people as the roster has them, and the rows of the roster that match none.

    `rows` has the rows of each hand-in's people, merged into one, by submission id. `absent` has the rows without a hand-in.
    `doubtful` are warnings: for each row that contradicts another of the same person, and each in `absent` that resembles somebody.
    """

    hand_ins: Mapping[str, HandIn]
    rows: Mapping[str, RosterRow]
    absent: tuple[RosterRow, ...]
    doubtful: tuple[str, ...] = ()

    @property
    def unknown(self) -> tuple[str, ...]:
        """Return the ids of the hand-ins that no row matches, for a warning."""
        return tuple(id_ for id_ in self.hand_ins if id_ not in self.rows)


def place(roster: Sequence[RosterRow], hand_ins: Mapping[str, HandIn]) -> RosterMatch:
    """Match the rows of a roster with a class's hand-ins, and complete the people of the hand-ins: names, numbers and sections.

    `hand_ins` are those that the platform lists, by id of the submission.
    """
    placed = {id_: _with_login(hand_in, roster) for id_, hand_in in hand_ins.items()}
    directory = Directory({id_: hand_in.people for id_, hand_in in placed.items()})
    rows: dict[str, RosterRow] = {}
    absent: list[RosterRow] = []
    roster, doubtful = _merged_rows(roster)
    matches = directory.find_each([listed.who for listed in roster])
    shared = _shared(roster, matches, directory)
    for listed, match in zip(roster, matches, strict=True):
        theirs = match or shared.get(listed.group.casefold())
        if theirs is None:
            absent.append(listed)
            why = directory.why_not(listed.who) or _lost_zeros(listed.who, placed)
            doubtful += [f"{listed.place}: {listed.who.in_words()} {why}"] if why else []
            continue
        with_row = _with_roster_facts if match else _with_member
        placed[theirs.id] = with_row(placed[theirs.id], theirs.person, listed)
        rows[theirs.id] = rows[theirs.id].merged(listed) if theirs.id in rows else listed
    return RosterMatch(placed, rows, tuple(absent), tuple(doubtful))


def _lost_zeros(who: PersonRow, hand_ins: Mapping[str, HandIn]) -> str:
    """Say that a number of a row equals that of a submission but for zeros at its start; "" if none does."""
    numbers = {number.lstrip("0"): number for number in who.numbers if number.isdecimal()}
    for id_, hand_in in hand_ins.items():
        for theirs in (id_, *(word for person in hand_in.people for word in person.called)):
            ours = numbers.get(theirs.lstrip("0")) if theirs.isdecimal() else None
            if ours is not None and ours != theirs:
                return f"has {ours}, and a submission {theirs}: a spreadsheet drops zeros at the start; format the column as text"
    return ""


def _merged_rows(roster: Sequence[RosterRow]) -> tuple[list[RosterRow], list[str]]:
    """Return one row for each person, and a line on each person whose rows contradict each other.

    Of several rows of a person the later dates, the most grace days and the first section and group count.
    """
    rows: dict[PersonRow, RosterRow] = {}
    told = []
    for listed in roster:
        known = rows.setdefault(listed.who, listed)
        if known is listed:
            continue
        if what := ", ".join(name for name in _FACTS if getattr(known, name) != getattr(listed, name)):
            told.append(
                f"{known.place} and {listed.place}: {listed.who.in_words()} stands twice, with another {what}; {_COUNTS}"
            )
        rows[listed.who] = known.merged(listed)
    return list(rows.values()), told


def _shared(roster: Sequence[RosterRow], matches: Sequence[Match | None], directory: Directory) -> dict[str, Match]:
    """Return the hand-in of each group, by its name: the only one of its members, or else one with the name of the group.

    A group without a hand-in, or whose members have several, is left out.
    """
    members: dict[str, set[str]] = {}
    for listed, match in zip(roster, matches, strict=True):
        members.setdefault(listed.group.casefold(), set()).update({match.id} if match else ())
    members.pop("", None)
    called = {
        group: directory.find(PersonRow(numbers=(group,), name=group)) for group, ids in members.items() if not ids
    }
    own = {group: Match(next(iter(ids)), None) for group, ids in members.items() if len(ids) == 1}
    return own | {group: match for group, match in called.items() if match}


def _with_member(hand_in: HandIn, stand_in: Person | None, listed: RosterRow) -> HandIn:
    """Return a group's hand-in with one more member; the first replaces `stand_in`, a person with the group's name."""
    return replace(hand_in, people=(*(person for person in hand_in.people if person != stand_in), listed.person))


def _with_login(hand_in: HandIn, roster: Sequence[RosterRow]) -> HandIn:
    """Return the hand-in of a clone `<assignment>-<user>` with its user name: the roster's longest that ends the folder's name.

    Other hand-ins are unchanged.
    """
    if [person.platform for person in hand_in.people] != ["git"]:
        return hand_in
    (person,) = hand_in.people
    folder = person.key.casefold()
    fits = [number for listed in roster for number in listed.who.numbers if folder.endswith(f"-{number.casefold()}")]
    return replace(hand_in, people=(replace(person, key=max(fits, key=len, default=person.key)),))


def _with_roster_facts(hand_in: HandIn, meant: Person | None, listed: RosterRow) -> HandIn:
    """Return the hand-in with names, numbers and section of the person `meant` completed from the roster."""
    return replace(hand_in, people=tuple(listed.completed(p) if p == meant else p for p in hand_in.people))
