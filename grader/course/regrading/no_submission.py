"""People of the roster without a submission, who can get points for something else, such as an oral exam."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import replace

from grader import __version__
from grader.course.record import class_settings
from grader.course.record.class_settings import ClassSettings
from grader.course.record.store import Key, Store
from grader.engine.results import CheckResult, ExtensionResult, Result
from grader.intake.names import distinct_ids
from grader.people.final_grade import FinalGrade, HandIn, Person

_NOTE = "There is no submission. A person gave the points."


def absent_by_id(store: Store) -> dict[str, Person]:
    """Return the people of the roster without a submission, by ids made from number or name, under which they can get points."""
    return _by_id(store.settings(), store.final_grades())


def _by_id(settings: ClassSettings | None, final_grades: Mapping[str, FinalGrade]) -> dict[str, Person]:
    people = class_settings.absent(settings, {id_: each.hand_in for id_, each in final_grades.items()})
    ids = distinct_ids([*final_grades, *(person.number or person.name for person in people)])
    return dict(zip(ids[len(final_grades) :], people, strict=True))


def blank_grades(settings: ClassSettings | None, final_grades: Mapping[str, FinalGrade]) -> dict[str, FinalGrade]:
    """Return a blank final grade by id for each person of the roster without a submission, so that pages can show them.

    Nothing is stored. `final_grades` holds every submission in the class database; a blank grade copies criteria from one of them.
    Empty without submissions, or if `settings`, which hold the roster, are None or name no roster.
    """
    if not final_grades:
        return {}
    like = next(iter(final_grades.values())).result
    absent = _by_id(settings, final_grades)
    names = Counter(
        name.casefold() for name in (*(e.name for e in final_grades.values()), *(p.name for p in absent.values()))
    )
    return {
        id_: FinalGrade(
            id_, _blank_result(id_, person, like), HandIn((person,)), namesake=names[person.name.casefold()] > 1
        )
        for id_, person in absent.items()
    }


def admit(store: Store, ids: Collection[str]) -> dict[str, FinalGrade]:
    """Store a blank result for people of the roster without a submission, so that they can get points; return their final grades.

    `ids` are keys of `absent_by_id`, made from number or name; other ids are ignored. Until there is an override, the grade stays
    blank and the pages list the person as without a submission.
    """
    settings = store.settings()
    if settings is None:
        return {}
    blank = blank_grades(settings, store.final_grades())
    admitted = {id_: blank[id_] for id_ in ids if id_ in blank}
    for id_, each in admitted.items():
        sha256 = str(each.result.provenance["submission_sha256"])
        store.keep(Key(id_, sha256, settings.rubric_sha256, settings.traces_sha256, __version__), each.result)
        store.keep_hand_in(id_, each.hand_in)
    return admitted


def _skipped_check(check: CheckResult) -> CheckResult:
    """Return the result of a check that had no submission to look at: skipped, and without points."""
    return CheckResult(
        check.id, check.title, "skipped", 0.0, check.max_points, said=_NOTE, lab_step=check.lab_step, keeps=0.0
    )


def _blank_result(id_: str, person: Person, like: Result) -> Result:
    """Return a result without points for a person without a submission, with the criteria of `like`, a result of the class."""
    criteria = tuple(replace(part, checks=tuple(map(_skipped_check, part.checks))) for part in like.criteria)
    return Result(
        person.name or id_,
        "empty",
        criteria,
        extensions=tuple(ExtensionResult(each.id, False, each.max_points) for each in like.extensions),
        notes=(_NOTE,),
        provenance={
            "submission_sha256": hashlib.sha256(f"no submission of {id_}".encode()).hexdigest(),
            "no_submission": True,
        },
        extra_credit_cap=like.extra_credit_cap,
        lab=like.lab,
        asked_sha256=like.asked_sha256,
    )
