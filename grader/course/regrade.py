"""A class under another rubric, from what is on record: other weights, caps, dates or prices of mistakes need no sandbox."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from grader.base.errors import RequestError
from grader.base.text import printable
from grader.course.publishing import write_class
from grader.course.record import Store
from grader.engine.marks import fits, marked
from grader.engine.rubric import Rubric
from grader.people import late_policy
from grader.people.final_grade import FinalGrade, HandIn

_A_LINE = 10  # names


def under(final_grades: Mapping[str, FinalGrade], rubric: Rubric) -> dict[str, FinalGrade]:
    """The class as it would stand by this rubric. Nothing is written; adjustments stand as they are.

    Raises
    ------
    RequestError
        If it takes a sandbox: the rubric has other limits, another model or other checks, or the record is of an older
        version.
    """
    others = [id_ for id_, final_grade in final_grades.items() if not fits(final_grade.result, rubric)]
    if others:
        raise RequestError(
            f"{rubric.source}: needs other measurements than those of {_told(others)} (limits, model or checks differ, or "
            "the record is older); grade the class again"
        )
    return {id_: _under(final_grade, rubric) for id_, final_grade in final_grades.items()}


def remark(out: Path, store: Store, rubric: Rubric) -> dict[str, FinalGrade]:
    """Mark the class of a record by this rubric, keep that, and write what there is of the class; `publish` writes the rest.

    Raises
    ------
    RequestError
        As `under` does; nothing has been changed then.
    """
    after = store.remark_class(lambda before: under(before, rubric), rubric)
    write_class(out, after, store, rubric.lab)
    return after


def _under(final_grade: FinalGrade, rubric: Rubric) -> FinalGrade:
    return replace(final_grade, result=marked(final_grade.result, rubric), hand_in=_judged(final_grade, rubric))


def _judged(final_grade: FinalGrade, rubric: Rubric) -> HandIn:
    return late_policy.judged(final_grade.hand_in, rubric.late, (final_grade.id, final_grade.result.submission))


def _told(ids: list[str]) -> str:
    more = f" and {len(ids) - _A_LINE} more" if len(ids) > _A_LINE else ""
    return ", ".join(printable(id_, 80) for id_ in ids[:_A_LINE]) + more
