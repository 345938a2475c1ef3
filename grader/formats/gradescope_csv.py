"""Gradescope-style CSV: the columns in which Gradescope itself exports the grades of an assignment, a row a person."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping

from grader import words
from grader.people.standing import Person, Standing
from grader.text import csv_cell, printable

COLUMNS = (
    "First Name", "Last Name", "SID", "Email", "Sections", "Total Score", "Max Points", "Status", "Submission ID",
    "Submission Time", "Lateness (H:M:S)", "View Count", "Submission Count",
)  # fmt: skip
_SUFFIXES = ("jr", "jr.", "sr", "sr.", "ii", "iii", "iv")


def gradescope_csv(standings: Mapping[str, Standing]) -> str:
    """Final points of each person; all members of a group have the group's. What nobody counted here is blank."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    for standing in standings.values():
        table.writerows(_row(standing, person) for person in standing.people)
    return text.getvalue()


def _row(standing: Standing, person: Person) -> list[str]:
    first, last = _names(person.name)
    final = standing.final
    who = (first, last, person.sid or person.key, person.email, person.section)
    return [
        *(csv_cell(printable(text, 500)) for text in who),
        "" if final is None else words.number(final),
        words.number(standing.result.max_score),
        "Ungraded" if final is None else "Graded",
        *(csv_cell(printable(text, 80)) for text in (standing.hand_in.number, standing.hand_in.submitted)),
        _lateness(standing),
        "",
        "",
    ]


def _names(name: str) -> tuple[str, str]:
    """First and last; ``Doe, Jane`` says which is which, otherwise the last word is the last name, with its suffix."""
    last, comma, first = (part.strip() for part in name.partition(","))
    if comma and first.casefold() not in _SUFFIXES:
        return first, last
    given, _, family = last.rpartition(" ")
    return given.strip(), f"{family}, {first}" if comma else family


def _lateness(standing: Standing) -> str:
    seconds = standing.late.seconds if standing.late else 0
    if seconds is None:
        return ""
    return f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}"
