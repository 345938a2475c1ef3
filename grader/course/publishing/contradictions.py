"""Contradictions of a class: grades that cannot be right as they stand, shown to the instructor before an export."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from grader.base.text import printable, some
from grader.course.record.class_settings import ClassSettings
from grader.people.final_grade import Adjustment, FinalGrade, maximum_points, untimed
from grader.people.identity import Directory, PersonRow
from grader.report import words
from grader.report.adjusted import explained

_A_FEW = 20  # names

Kind = Literal["above maximum", "two grades", "not judged", "no row", "unknown lateness"]


@dataclass(frozen=True)
class Contradiction:
    """A grade that cannot be right, such as an override above its maximum; export and review desk show it to a person.

    Attributes
    ----------
    id
        The submission; "" for the whole class.
    text
        What is wrong, with the numbers, and the way out.
    stops_export
        Whether `export` writes nothing while it stands, unless a person allows it.
    """

    kind: Kind
    id: str
    text: str
    stops_export: bool = True


def contradictions(
    final_grades: Mapping[str, FinalGrade], settings: ClassSettings | None, without_row: Mapping[str, str] | None = None
) -> list[Contradiction]:
    """Return the contradictions of a class, such as an override above its maximum, so that a person solves them before an export.

    Parameters
    ----------
    final_grades
        Every submission in the class database, by id.
    settings
        The settings of the class; None if none are stored, and then there is no late policy.
    without_row
        A sentence for each graded submission (by id) whose people lack a row in the platform's file; None if no file is exported.
    """
    found = [each for final_grade in final_grades.values() for each in _of_submission(final_grade)]
    found += _two_grades(final_grades)
    found += [Contradiction("no row", id_, text) for id_, text in (without_row or {}).items()]
    return [*found, *_unknown_lateness(final_grades, settings)]


def _of_submission(final_grade: FinalGrade) -> Iterator[Contradiction]:
    name, id_ = words.distinct(final_grade), final_grade.id
    if final_grade.final is None and not final_grade.unseen:
        yield Contradiction("not judged", id_, f"{name}: not judged, because the grader failed; grade it again")
    above = final_grade.above_maximum()
    for each in above:
        yield Contradiction("above maximum", id_, f"{name}: {_above_its_maximum(final_grade, each)}")
    if not above and final_grade.final is not None and final_grade.final > final_grade.maximum:
        yield Contradiction("above maximum", id_, f"{name}: {explained(final_grade)}")


def _two_grades(final_grades: Mapping[str, FinalGrade]) -> Iterator[Contradiction]:
    """Yield a contradiction for each person who got points without a submission and whose submission came later."""
    given = [each for each in final_grades.values() if each.has_no_submission]
    if not given:
        return
    handed_in = Directory({id_: each.people for id_, each in final_grades.items() if not each.has_no_submission})
    for each in given:
        (person,) = each.people
        numbers = tuple(filter(None, (person.sid, *person.ids)))
        match = handed_in.find(PersonRow(person.platform, person.key, numbers, person.email, person.name))
        if match is not None:
            points, theirs = (_points(final_grades[id_]) for id_ in (each.id, match.id))
            two = (
                f"{points} without a submission ({printable(each.id, 80)}), and {theirs} for {printable(match.id, 80)}"
            )
            text = f"{words.person(each)} has two grades, {two}; withdraw the points of {printable(each.id, 80)}"
            yield Contradiction("two grades", each.id, text)


def _points(final_grade: FinalGrade) -> str:
    return "a blank" if final_grade.final is None else words.number(final_grade.final)


def _above_its_maximum(final_grade: FinalGrade, override: Adjustment) -> str:
    most = maximum_points(final_grade.result, override.criterion) or 0.0
    return (
        f"the override of {printable(override.criterion, 80)} with {words.number(override.points or 0.0)} is above its maximum, "
        f"which is now {words.number(most)}; override it again or withdraw it"
    )


def _unknown_lateness(
    final_grades: Mapping[str, FinalGrade], settings: ClassSettings | None
) -> Iterator[Contradiction]:
    ids = untimed(final_grades.values())
    if settings is None or not settings.has_late_policy or not ids:
        return
    marked = [id_ for id_ in ids if final_grades[id_].hand_in.marked_late]
    late = f"{some(marked, _A_FEW, '; ')}, which the platform marks as late" if marked else ""
    handed_in = sum(not each.has_no_submission for each in final_grades.values())
    what = f"{late or f'{len(ids)} of {handed_in} hand-ins'}: their time is unknown"
    text = f"the late policy deducts nothing from {what} (add a column `submitted` to the roster)"
    yield Contradiction("unknown lateness", "", text, stops_export=False)
