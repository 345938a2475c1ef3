"""People of the roster without a submission, who get points for something else, such as an oral exam."""

from __future__ import annotations

import hashlib
from collections.abc import Collection
from dataclasses import replace

from grader import __version__
from grader.course import class_settings
from grader.course.record import Key, Store
from grader.engine.results import CheckResult, ExtensionResult, Result
from grader.intake.names import safe_id
from grader.people.final_grade import FinalGrade, HandIn, Person

_NOTE = "There is no submission. A person gave the points."


def absent_by_id(store: Store) -> dict[str, Person]:
    """Return the people of the roster without a submission, by the id that their points are recorded under."""
    final_grades = store.final_grades()
    people = class_settings.absent(store.settings(), {id_: each.hand_in for id_, each in final_grades.items()})
    named = {safe_id(person.number or person.name): person for person in people}
    return {id_: person for id_, person in named.items() if id_ not in final_grades}


def admit(store: Store, ids: Collection[str]) -> dict[str, FinalGrade]:
    """Record a result without a submission for those of these ids that have none, and return their final grades.

    The grade is blank, and the class shows the person as without a submission, until there is an override.
    """
    absent, settings, known = absent_by_id(store), store.settings(), store.present()
    wanted = [id_ for id_ in ids if id_ in absent]
    if settings is None or not known or not wanted:
        return {}
    like = next(iter(known.values()))
    admitted = {}
    for id_ in wanted:
        person = absent[id_]
        sha256 = hashlib.sha256(f"no submission of {id_}".encode()).hexdigest()
        result = _result(person.name or id_, sha256, like)
        store.keep(Key(id_, sha256, settings.rubric_sha256, settings.traces_sha256, __version__), result)
        store.keep_hand_in(id_, HandIn((person,)))
        admitted[id_] = FinalGrade(id_, result, HandIn((person,)), store.adjustments().get(id_, ()))
    return admitted


def _row(check: CheckResult) -> CheckResult:
    """Return the row of a check that had nothing to look at."""
    return CheckResult(
        check.id, check.title, "skipped", 0.0, check.max_points, said=_NOTE, lab_step=check.lab_step, keeps=0.0
    )


def _result(name: str, sha256: str, like: Result) -> Result:
    """Return a result without points, with the criteria of another result of the class."""
    criteria = tuple(replace(part, checks=tuple(map(_row, part.checks))) for part in like.criteria)
    return replace(
        like,
        submission=name,
        status="empty",
        criteria=criteria,
        extensions=tuple(ExtensionResult(each.id, False, each.max_points) for each in like.extensions),
        notes=(_NOTE,),
        provenance={"submission_sha256": sha256, "no_submission": True},
        repairs=(),
        unrepaired={},
    )
