"""Fill grades into a file that a platform exported: they go into one column, and all other bytes are kept."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from grader.base.errors import RequestError
from grader.base.text import decimal
from grader.intake.names import encodable
from grader.people.final_grade import FinalGrade, Person
from grader.people.identity import Directory, Match, PersonRow
from grader.platforms.platform import Template
from grader.platforms.sheet import CsvSheet, SheetRow
from grader.report import words

_COMMA = re.compile(r"-?\d+,\d+")


@dataclass
class Filled:
    """A platform's file with grades filled in, and what happened to each row, which `imugrade export` tells the instructor.

    Attributes
    ----------
    data, grades
        The file's bytes, and the number of grades filled in.
    placed
        Whom the rows belong to: a person and the submission, or, if `person` is None, all people of a submission.
    unmatched
        Rows that match nobody who handed in, or several, with the name in the file. They are left unchanged.
    missing
        Names in rows of people without a submission that were given the grade `Template.missing`.
    kept
        Names in rows whose grade the platform has locked.
    replaced
        Names in rows that had another grade, with both grades.
    """

    data: bytes = b""
    grades: int = 0
    placed: set[Match] = field(default_factory=set)
    unmatched: list[tuple[PersonRow, str]] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    kept: list[str] = field(default_factory=list)
    replaced: list[str] = field(default_factory=list)

    def without_row(self, final_grade: FinalGrade) -> list[Person]:
        """Return the people of a submission who have no row in the file, to warn about them; [] if one row stands for the group."""
        if Match(final_grade.id, None) in self.placed:
            return []
        return [person for person in final_grade.people if Match(final_grade.id, person) not in self.placed]


@dataclass(frozen=True)
class TemplateLayout:
    """How to read and fill in a platform's file: where the grades go, and whom a row means; a platform's module makes it.

    Attributes
    ----------
    sheet, grade
        The file, and the index of its column of grades.
    rows
        Rows of people (`SheetRow`), by row number; each function below takes such a row.
    who, name
        Functions that return a row's person for matching, and the person's name for messages.
    out_of
        Function that returns the maximum of a row's grade as text; "" if the file has none.
    locked
        Function that returns whether the platform has locked a row's grade, which is then kept.
    is_student
        Function that returns whether a row belongs to a student, and not to a test account of the platform.
    """

    sheet: CsvSheet
    grade: int
    rows: Mapping[int, SheetRow]
    who: Callable[[SheetRow], PersonRow]
    name: Callable[[SheetRow], str]
    out_of: Callable[[SheetRow], str]
    locked: Callable[[SheetRow], bool]
    is_student: Callable[[SheetRow], bool] = lambda _: True

    def matches(self, final_grades: Mapping[str, FinalGrade]) -> dict[int, Match | None]:
        """Return the submission or person that each row belongs to, by row number; None without an unambiguous match."""
        return match_rows(((number, self.who(row)) for number, row in self.rows.items()), directory(final_grades))


def fill_in(
    layout: TemplateLayout,
    template: Template,
    matches: Mapping[int, Match | None],
    final_grades: Mapping[str, FinalGrade],
) -> Filled:
    """Write final grades into `layout.sheet`, and return what happened to each row; the caller sets `Filled.data` from the sheet.

    `matches` says by row number which submission a row belongs to; `final_grades` are by submission id. A row whose match is None
    gets `template.missing` if its grade is blank, it is a student's, and nobody who handed in resembles that student. Locked
    grades, and rows of a submission without a final grade, stay as they are. Raise RequestError if the maximum of a row to be
    graded differs from the rubric's and `template.scaled` is False.
    """
    filled, known = Filled(), directory(final_grades)
    comma = any(
        _COMMA.fullmatch(text.strip())
        for row in layout.rows.values()
        for text in (row.value(layout.grade), layout.out_of(row))
    )
    for number, row in layout.rows.items():
        match = matches[number]
        if match is None:
            if template.missing and _is_missing(layout, row, known):
                layout.sheet.set(row, layout.grade, template.missing)
                filled.missing.append(layout.name(row))
            elif layout.is_student(row):
                filled.unmatched.append((layout.who(row), layout.name(row)))
            continue
        final_grade = final_grades[match.id]
        filled.placed.add(match)
        if layout.locked(row):
            filled.kept.append(layout.name(row))
        elif final_grade.final is not None:
            points = words.number(final_grade.final * _scale_factor(layout, template, row, final_grade))
            _write_grade(layout, row, points.replace(".", ",") if comma else points, filled)
    return filled


def _is_missing(layout: TemplateLayout, row: SheetRow, known: Directory) -> bool:
    """Return whether a row without a match belongs to a student who handed in nothing and has no grade yet."""
    blank = row.value(layout.grade).strip() in ("", "-") and not layout.locked(row)
    return blank and layout.is_student(row) and not known.why_not(layout.who(row))


def _write_grade(layout: TemplateLayout, row: SheetRow, points: str, filled: Filled) -> None:
    """Write points into a row; if the row held another grade, list it in `filled.replaced`."""
    before = row.value(layout.grade).strip()
    known = decimal(before)
    if before not in ("", "-") and (known is None or words.number(known) != points.replace(",", ".")):
        filled.replaced.append(f"{layout.name(row)} ({before} → {points})")
    layout.sheet.set(row, layout.grade, points)
    filled.grades += 1


def _scale_factor(layout: TemplateLayout, template: Template, row: SheetRow, final_grade: FinalGrade) -> float:
    """Return the factor from the rubric's points to the file's; RequestError if the maxima differ and points are not scaled."""
    most, ours = decimal(layout.out_of(row)), final_grade.result.max_score
    if most is None or most == ours:
        return 1.0  # the file names no other maximum
    if not template.scaled:
        differ = f"the assignment is out of {words.number(most)}, and the rubric out of {words.number(ours)}"
        rest = "have the points scaled, or make them equal on the platform or in rubric.yaml"
        raise RequestError(
            f"{template.source}: {differ}; add --scale to {rest}", option="scale", why=f"{differ}; {rest}"
        )
    return most / ours


def reply_to(final_grade: FinalGrade, person: Person) -> str:
    """Return how a report's file name must begin so that the platform returns the report to this person; "" if it cannot.

    That is `HandIn.reply` of the person who handed in. For a partner, name and number in it are replaced by the partner's, which
    the download or the roster tells. Canvas returns the file only if it lists the attachment for the partner, too.
    """
    reply, first = final_grade.hand_in.reply, final_grade.people[0]
    if person == first or not reply:
        return reply
    key = person.key if person.platform == first.platform else ""
    key = key or (person.listed if first.key and first.listed == first.key else "")
    _, number, rest = reply.rpartition(f"_{first.key}_")
    if not key or not number:
        return ""
    name = (
        encodable(person.name).replace("_", " ")
        if first.platform == "moodle"
        else "".join(filter(str.isalpha, person.name))
    )
    return f"{name or 'partner'}_{key}_{rest}"


def directory(final_grades: Mapping[str, FinalGrade]) -> Directory:
    """Return an index of all people with a submission, to find whom a row of a platform's file means."""
    return Directory({id_: final_grade.people for id_, final_grade in final_grades.items()})


def match_rows(rows: Iterable[tuple[int, PersonRow]], known: Directory) -> dict[int, Match | None]:
    """Return whom of `known` each row of a platform's file means, by row number; None if unclear, or if several rows mean one."""
    found = {number: known.find(who) for number, who in rows}
    owners: dict[Match, list[int]] = {}
    for number, match in found.items():
        if match is not None and match.person is not None:
            owners.setdefault(match, []).append(number)
    twice = {number for numbers in owners.values() if len(numbers) > 1 for number in numbers}
    return {number: None if number in twice else match for number, match in found.items()}
