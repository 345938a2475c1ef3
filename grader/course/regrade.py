"""A class under another rubric, from what is on record: other weights, caps, dates or prices of mistakes need no box."""

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
from grader.people.final_grade import HandIn, Standing

_A_LINE = 10  # names


def under(standings: Mapping[str, Standing], rubric: Rubric) -> dict[str, Standing]:
    """The class as it would stand by this rubric. Nothing is written; adjustments stand as they are.

    Raises
    ------
    RequestError
        If it takes a box: the rubric asks something else (its limits, its model, its checks), or the record is of an older version.
    """
    others = [id_ for id_, standing in standings.items() if not fits(standing.result, rubric)]
    if others:
        raise RequestError(
            f"{rubric.source}: asks other things than were asked of {_told(others)} (limits, model or checks differ, or "
            "the record is older); grade the class again"
        )
    return {id_: _under(standing, rubric) for id_, standing in standings.items()}


def remark(out: Path, store: Store, rubric: Rubric) -> dict[str, Standing]:
    """Mark the class of a record by this rubric, keep that, and write what there is of the class; `publish` writes the rest.

    Raises
    ------
    RequestError
        As `under` does; nothing has been changed then.
    """
    after = store.remark_class(lambda before: under(before, rubric), rubric)
    write_class(out, after, store, rubric.lab)
    return after


def _under(standing: Standing, rubric: Rubric) -> Standing:
    return replace(standing, result=marked(standing.result, rubric), hand_in=_judged(standing, rubric))


def _judged(standing: Standing, rubric: Rubric) -> HandIn:
    return late_policy.judged(standing.hand_in, rubric.late, (standing.id, standing.result.submission))


def _told(ids: list[str]) -> str:
    more = f" and {len(ids) - _A_LINE} more" if len(ids) > _A_LINE else ""
    return ", ".join(printable(id_, 80) for id_ in ids[:_A_LINE]) + more
