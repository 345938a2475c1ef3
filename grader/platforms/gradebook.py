"""`gradebook.csv`: one row per submission with id, name, criteria, total, status, and columns for overrides and lateness."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from grader.base import tables
from grader.base.text import printable
from grader.engine.results import CriterionResult
from grader.people.final_grade import FinalGrade, Person, untimed
from grader.platforms.platform import Help, Platform
from grader.report import words

Cell = Callable[[FinalGrade], str]


def gradebook(
    final_grades: Mapping[str, FinalGrade], absent: Sequence[Person] = (), *, has_late_policy: bool = False
) -> str:
    """Return a class's points as CSV: a row for each submission, in the order of `final_grades`, and each person in `absent`.

    A criterion that was not judged is blank, and so is the submission's total, because a failure of the grader is never a zero.
    Criteria and total are automatic points; if an instructor repaired a file, those of the repaired copy. Columns for extra credit,
    sections, repairs, adjustments and lateness appear only if the class has such data.

    Parameters
    ----------
    final_grades
        The final grade of each submission, by its id.
    absent
        The people of the roster who did not hand in.
    has_late_policy
        Whether the class has a late policy: columns of lateness then, even if nobody is late.
    """
    columns = _columns(list(final_grades.values()), absent, has_late_policy)
    handed_in = [{title: cell(final_grade) for title, cell in columns.items()} for final_grade in final_grades.values()]
    return _table([*handed_in, *_absentees(final_grades, absent, "")], list(columns))


def exported(final_grades: Mapping[str, FinalGrade], absent: Sequence[Person] = (), missing: str = "") -> str:
    """Return a class's grades as CSV for `imugrade export`: the columns of `gradebook` and the submission id, a row per person.

    Column `final` is always there: `FinalGrade.final`, after overrides and the deductions for repairs and lateness; blank if None.
    `final_grades` are by submission id. `missing` is the grade of the people in `absent`, who did not hand in; "" for a blank cell.
    """
    columns = _columns(list(final_grades.values()), absent)
    columns |= {"final": lambda s: _points(s.final), "status": columns.pop("status")}
    people = [
        _row_for(columns, final_grade, person) for final_grade in final_grades.values() for person in final_grade.people
    ]
    return _table(
        [*people, *_absentees(final_grades, absent, missing)], ["id", "name", "submission", *list(columns)[2:]]
    )


def _row_for(columns: Mapping[str, Cell], final_grade: FinalGrade, person: Person) -> dict[str, str]:
    """Return the row of one person of a submission for `exported`, as text by column title."""
    own = {"id": _text(person.number or final_grade.id), "name": _text(person.name), "section": _text(person.section)}
    shared = {title: cell(final_grade) for title, cell in columns.items()}
    return {**shared, **own, "submission": final_grade.id}


def _absentees(
    final_grades: Mapping[str, FinalGrade], absent: Sequence[Person], missing: str
) -> Iterator[dict[str, str]]:
    """Yield the rows of the people without a submission, as text by column title; their grade is `missing`."""
    names = words.absentees(absent, (each.hand_in for each in final_grades.values()))
    for person, name in zip(absent, names, strict=True):
        known = {"id": person.number, "name": name, "section": person.section, "final": missing}
        yield {**{title: _text(text) for title, text in known.items()}, "status": words.NO_SUBMISSION}


def _table(rows: Iterable[Mapping[str, str]], titles: Sequence[str]) -> str:
    return tables.written([titles, *([row.get(title, "") for title in titles] for row in rows)])


def _columns(
    final_grades: list[FinalGrade], absent: Sequence[Person], has_late_policy: bool = False
) -> dict[str, Cell]:
    """Return the title and the function of each column; criteria in the order in which they first occur.

    The columns of lateness are there if somebody is late, and in a class with a late policy even if no time is known.
    """
    columns: dict[str, Cell] = {"id": lambda s: s.id, "name": lambda s: _text(s.name)}
    if any(s.section for s in final_grades) or any(person.section for person in absent):
        columns["section"] = lambda s: _text(s.section)
    for criterion in dict.fromkeys(c.id for s in final_grades for c in s.result.criteria):
        columns[criterion] = lambda s, id_=criterion: "" if s.unseen or s.has_no_submission else _criterion(s, id_)  # type: ignore[misc] # a default binds the id
    if any(s.result.extra_credit_cap is not None for s in final_grades):
        columns["extra_credit"] = lambda s: words.number(s.result.extra_credit)
    if any(s.result.repairs for s in final_grades):
        columns["repair_deduction"] = lambda s: words.number(s.result.repair_deduction)
    columns["total"] = lambda s: "" if _has_no_total(s) else words.number(s.result.total)
    if any(s.adjustments for s in final_grades):
        columns["adjusted"] = lambda s: _points(s.adjusted)
    if any(s.hand_in.submitted for s in final_grades):
        columns["submitted"] = lambda s: _text(s.hand_in.submitted)
    if has_late_policy or any(s.late for s in final_grades):
        unknown = untimed(final_grades)
        columns["late"] = lambda s: "unknown" if s.id in unknown else _late_days(s)
        columns["late_deduction"] = lambda s: "" if s.final is None else words.number(s.deduction)
    if any(s.late and s.late.grace_days for s in final_grades):
        columns["grace_days_used"] = lambda s: str(s.late.grace_days if s.late else 0)
    if "adjusted" in columns or "late" in columns:
        columns["final"] = lambda s: _points(s.final)
    return columns | {"status": words.status}


def _has_no_total(final_grade: FinalGrade) -> bool:
    return final_grade.unseen or final_grade.has_no_submission or final_grade.result.status == "incomplete"


def _text(text: str) -> str:
    return printable(text, 500, newlines=True)


def _points(points: float | None) -> str:
    return "" if points is None else words.number(points)


def _late_days(final_grade: FinalGrade) -> str:
    """Return the late days that count; "refused" after the cut-off, "yes" if the number of days is unknown, "0" if in time."""
    late = final_grade.late
    if late is None:
        return "0"
    return "refused" if late.refused else "yes" if late.seconds is None else str(late.days)


def _criterion(final_grade: FinalGrade, id_: str) -> str:
    found: CriterionResult | None = next((c for c in final_grade.result.criteria if c.id == id_), None)
    return "" if found is None or words.unjudged(found) else words.number(found.points)


PLATFORM = Platform(
    name="csv",
    title="CSV",
    help=Help(grades="one row a person; the grade is in `final`, after overrides and lateness."),
    write=lambda final_grades, absent, missing: exported(final_grades, absent, missing).encode("utf-8", "replace"),
    gradebook="marks.csv",
)
