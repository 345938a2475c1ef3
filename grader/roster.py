"""The roster: a CSV that gives names, sections, dates of their own and times of handing in to those who are in the class."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

from grader.errors import RequestError
from grader.identity import Directory, participant
from grader.stamps import read_stamp, stamp
from grader.standing import HandIn, Person
from grader.text import printable

MAX_BYTES = 16_000_000
COLUMNS: Mapping[str, tuple[str, ...]] = {
    "id": ("id", "student id", "sid", "username", "login", "identifier", "sis user id", "sis login id"),
    "name": ("name", "student", "full name"),
    "first": ("first name", "first_name", "firstname"),
    "last": ("last name", "last_name", "lastname"),
    "email": ("email", "email address", "e-mail"),
    "section": ("section", "sections", "group"),
    "due": ("due", "due date", "extension"),
    "submitted": ("submitted",),
}
"""What each column may be called: an export of Canvas, Moodle, Gradescope or Classroom 50 is a roster as it stands."""


@dataclass(frozen=True)
class Row:
    """One person of the roster. `due` and `submitted` are None and "" where the roster leaves them open."""

    numbers: tuple[str, ...]
    name: str
    email: str
    section: str
    due: datetime | None
    submitted: str

    def told(self) -> str:
        return self.name or self.email or next(iter(self.numbers), "")


def load(path: Path) -> list[Row]:
    """Read a roster.

    Raises
    ------
    RequestError
        If it cannot be read, has no column that tells people apart, or a date that is none: one line with its number.
    """
    source = printable(str(path), 500)
    try:
        with open(path, "rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise RequestError(f"{source}: cannot be read ({error.strerror}); give the path of a CSV file") from error
    if len(data) > MAX_BYTES:
        raise RequestError(f"{source}: is larger than {MAX_BYTES // 1_000_000} MB; give a roster")
    try:
        text = data.decode("utf-8-sig")
        return list(_rows(text, source))
    except (UnicodeDecodeError, csv.Error) as error:
        raise RequestError(f"{source}: is not a CSV file in UTF-8; save it as one") from error


def _rows(text: str, source: str) -> Iterator[Row]:
    head = text.partition("\n")[0]
    table = csv.reader(io.StringIO(text, newline=""), delimiter=max(",;\t", key=head.count))
    titles = [title.strip().casefold() for title in next(table, [])]
    places = {kind: [i for i, title in enumerate(titles) if title in known] for kind, known in COLUMNS.items()}
    if not any(places[kind] for kind in ("id", "name", "first", "email")):
        raise RequestError(f"{source}:1: no column id, name or email; the first line has to name the columns")
    for cells in table:
        values = {kind: [cells[i].strip() for i in where if i < len(cells)] for kind, where in places.items()}
        if any(cells) and not (cells[0].strip().startswith("Points Possible")):  # Canvas's second line is no person
            yield _row(values, f"{source}:{table.line_num}")


def _row(values: Mapping[str, Sequence[str]], place: str) -> Row:
    def first(kind: str) -> str:
        return next(filter(None, values[kind]), "")

    due, submitted = first("due"), first("submitted")
    for what, text in (("due", due), ("submitted", submitted)):
        if text and read_stamp(text) is None:
            example = "2026-11-20T23:59+01:00"
            raise RequestError(f"{place}: {what} must be a date and time with its offset, like {example}")
    name = first("name") or " ".join(filter(None, (first("first"), first("last"))))
    numbers = tuple(dict.fromkeys(filter(None, (participant(v) if " " in v else v for v in values["id"]))))
    return Row(numbers, name, first("email"), first("section"), read_stamp(due) if due else None, stamp(submitted))


@dataclass(frozen=True)
class Placed:
    """The roster laid over a class: hand-ins with what it knows, dates of their own, and rows and hand-ins without a partner."""

    hand_ins: Mapping[str, HandIn]
    due: Mapping[str, datetime]
    absent: tuple[str, ...]
    unknown: tuple[str, ...]


def place(rows: Sequence[Row], hand_ins: Mapping[str, HandIn]) -> Placed:
    """Give every hand-in what the roster knows of its people.

    Parameters
    ----------
    rows
        The roster.
    hand_ins
        By id of the submission, as the platform tells them.
    """
    directory = Directory({id_: hand_in.people for id_, hand_in in hand_ins.items()})
    placed = dict(hand_ins)
    due: dict[str, datetime] = {}
    absent: list[str] = []
    known: set[str] = set()
    for row in rows:
        id_ = directory.find(row.numbers, row.email, row.name)
        if id_ is None:
            absent.append(row.told())
            continue
        known.add(id_)
        placed[id_] = _enriched(id_, placed[id_], row)
        if row.due is not None:
            due[id_] = max(due.get(id_, row.due), row.due)  # a group has the latest date that one of it has
    unknown = tuple(id_ for id_ in hand_ins if id_ not in known)
    return Placed(placed, due, tuple(absent), unknown)


def _enriched(id_: str, hand_in: HandIn, row: Row) -> HandIn:
    """The row's words for the person that it means; the platform's own number stays, as its files are called by it."""
    people = hand_in.people or (Person(id_, id_),)
    meant = [i for i, p in enumerate(people) if Directory({id_: (p,)}).find(row.numbers, row.email, row.name)]
    if len(people) > 1 and len(meant) > 1:  # the id means all of a group
        return replace(hand_in, submitted=row.submitted or hand_in.submitted)
    mended = [_mended(p, row) if i in meant else p for i, p in enumerate(people)]
    return replace(hand_in, people=tuple(mended), submitted=row.submitted or hand_in.submitted)


def _mended(person: Person, row: Row) -> Person:
    sid = person.sid or next((number for number in row.numbers if number != person.key), "")
    return Person(row.name or person.name, person.key, sid, row.email or person.email, row.section or person.section)
