"""Regrading of stored results by another rubric: other weights, caps, dates or deductions run no code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from grader.base.errors import RequestError
from grader.base.text import some
from grader.course.publishing.out_files import write_class
from grader.course.record.store import Store
from grader.engine.marks import fits, marked
from grader.engine.rubric import Rubric
from grader.people import late_policy
from grader.people.final_grade import FinalGrade

_A_LINE = 10  # names


def regraded(final_grades: Mapping[str, FinalGrade], rubric: Rubric) -> dict[str, FinalGrade]:
    """Return the final grades, by id, that submissions would have by another rubric. Nothing is written, and overrides are kept.

    Raises
    ------
    RequestError
        If submissions have to run again: the rubric has other limits, another model or other checks than at their grading, or an
        older version graded them.
    """
    others = [id_ for id_, final_grade in final_grades.items() if not fits(final_grade.result, rubric)]
    if others:
        raise RequestError(
            f"{rubric.source}: needs other measurements than those of {some(others, _A_LINE)} (limits, model or checks differ, or "
            "the record is older); grade the class again"
        )
    return {
        id_: late_policy.judged_again(replace(final_grade, result=marked(final_grade.result, rubric)), rubric.late)
        for id_, final_grade in final_grades.items()
    }


def remark(out: Path, store: Store, rubric: Rubric) -> dict[str, FinalGrade]:
    """Regrade a class by another rubric: store and return the final grades, write gradebook and index; the caller writes reports.

    RequestError, with the class database unchanged, if submissions have to run again, such as for other checks or limits.
    """
    after = store.remark_class(lambda before: regraded(before, rubric), rubric)
    write_class(out, after, store, rubric.lab)
    return after
