"""Groups of submissions with the same fault, failed check or similar code, so that a person decides on all at once."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from grader.base.errors import RequestError
from grader.base.text import printable
from grader.course.record.store import Store
from grader.course.regrading.adjusting import said
from grader.engine.results import CheckResult, Result
from grader.engine.rubric_nodes import guess_at
from grader.people.final_grade import Adjustment, FinalGrade
from grader.report import words

FAULT, CHECK, ALIKE = "fault", "check", "alike"


@dataclass(frozen=True)
class Group:
    """Submissions (`ids`) with the same fault (diagnosed mistake), failed check or code.

    `kind` says which, `key` is the id of the fault or check, or a digest of the ids, `checks` the titles of failed checks by id.
    """

    kind: str
    key: str
    title: str
    ids: tuple[str, ...]
    checks: Mapping[str, str]

    @property
    def what(self) -> str:
        """Return the subject of a decision on this group, as stored: ``fault: <title>``, ``lost: <check>`` or ``alike: <ids>``."""
        kind = {FAULT: "fault", CHECK: "lost", ALIKE: "alike"}[self.kind]
        return printable(f"{kind}: {self.title}", 200)


@dataclass(frozen=True)
class Decision:
    """One decision of a person on several submissions; `made` is their number, `in_force` that of those without a later override.

    `what` is what the submissions have in common, `said` the criterion with its new points, or that it is a comment.
    """

    number: int
    what: str
    said: str
    author: str
    at: str
    comment: str
    made: int
    in_force: int


def groups(final_grades: Mapping[str, FinalGrade]) -> list[Group]:
    """Return groups of two or more submissions with the same fault, then those with the same failed check, both largest first."""
    faults: dict[str, dict[str, list[CheckResult]]] = {}
    checks: dict[str, dict[str, list[CheckResult]]] = {}
    for id_, final_grade in final_grades.items():
        for check in _lost(final_grade.result):
            checks.setdefault(check.id, {})[id_] = [check]
            for fault in check.misconceptions:
                faults.setdefault(fault, {}).setdefault(id_, []).append(check)
    found = [
        *(_group(FAULT, id_, words.fault_in_words(id_), members) for id_, members in faults.items()),
        *(_group(CHECK, id_, _titles(members), members) for id_, members in checks.items()),
    ]
    order = (FAULT, CHECK)
    several = [group for group in found if len(group.ids) > 1]
    return sorted(several, key=lambda group: (order.index(group.kind), -len(group.ids), group.title))


def similar_group(ids: Sequence[str]) -> Group:
    """Return the group of the submissions `ids`, found to have the same files or similar code, to decide on together."""
    digest = hashlib.sha256(" ".join(ids).encode()).hexdigest()[:16]
    return Group(ALIKE, digest, f"{ids[0]} and {len(ids) - 1} more", tuple(ids), {})


def members_of(store: Store, name: str) -> tuple[str, tuple[str, ...]]:
    """Return (text that names the group, ids) of all submissions with the fault or failed check whose id is `name`.

    RequestError if fewer than two submissions have it.
    """
    named = {group.key: group for group in groups(store.final_grades())}
    if name not in named:
        raise RequestError(f"--having {printable(name)}: no two submissions have this in common{guess_at(name, named)}")
    return named[name].what, named[name].ids


def decisions(store: Store, final_grades: Mapping[str, FinalGrade]) -> list[Decision]:
    """Return all overrides and comments that a person gave a whole group at once, latest first, with how many still count."""
    made: dict[int, list[Adjustment]] = {}
    for _, each in store.history():
        if each.decision:
            made.setdefault(each.decision, []).append(each)
    in_force = [each.decision for final_grade in final_grades.values() for each in final_grade.adjustments]
    what = store.decisions()
    found = [
        Decision(
            number,
            what.get(number, ""),
            f"{rows[0].criterion} {said(rows[0])}",
            rows[0].author,
            rows[0].at,
            rows[0].comment,
            len(rows),
            in_force.count(number),
        )
        for number, rows in made.items()
    ]
    return found[::-1]


def _lost(result: Result) -> list[CheckResult]:
    if result.status in ("empty", "unreadable"):
        return []  # no check was run
    rows = (check for criterion in result.criteria for check in criterion.checks)
    return [check for check in rows if check.points is not None and check.points < check.max_points]


def _group(kind: str, key: str, title: str, members: Mapping[str, Sequence[CheckResult]]) -> Group:
    checks = {check.id: printable(check.title, 300) for lost in members.values() for check in lost}
    return Group(kind, key, title, tuple(members), checks)


def _titles(members: Mapping[str, Sequence[CheckResult]]) -> str:
    return next(printable(lost[0].title, 300) for lost in members.values())
