"""Overrides and comments by people: validated, stored apart from the automatic points, and published at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from pathlib import Path

from grader.base import stamps, tables
from grader.base.errors import RequestError
from grader.base.files import read_file
from grader.base.text import decimal, printable
from grader.course.publishing.out_files import publish_all, write_class
from grader.course.record.store import Store
from grader.course.regrading.no_submission import absent_by_id, admit
from grader.engine.lab import Lab
from grader.engine.rubric_nodes import guess_at
from grader.people.final_grade import (
    BONUS,
    TOTAL,
    Adjustment,
    FinalGrade,
    automatic_points,
    maximum_by_check,
    maximum_points,
)
from grader.people.identity import PersonLookup
from grader.report import words

COLUMNS = ("id", "criterion", "points", "comment")
MAX_COMMENT = 2000
MAX_TABLE = 16_000_000
ALONE = "comment"
"""Value of the points column that makes a row a comment without points."""


@dataclass(frozen=True)
class OverrideRequest:
    """An override, a comment or a withdrawal as a person typed it at the desk, in a command or in a table; not validated yet.

    Attributes
    ----------
    id
        The submission's id; from `read_overrides`, the name, address or number in the table, which the caller looks up.
    criterion
        What the points or the comment are for: a criterion, a check, `total` or `bonus`.
    points
        The points as typed; "" withdraws the override.
    place
        Prefix of error messages: the command, or file and line of a table.
    alone
        True for a comment without points; an empty comment then withdraws the last one.
    """

    id: str
    criterion: str
    points: str
    comment: str
    place: str = "adjust"
    alone: bool = False


def read_overrides(path: Path) -> list[OverrideRequest]:
    """Read overrides from a CSV with the columns id, criterion, points and comment; RequestError if columns are missing.

    Blank points withdraw an override. The word `comment` in place of points adds a comment only.
    """
    source = printable(str(path), 500)
    rows = tables.titled(read_file(path, MAX_TABLE, "give the path of a CSV file"), source, COLUMNS, COLUMNS)
    return [_request(row, f"{source}:{line}") for line, row in rows]


def _request(row: Mapping[str, str], place: str) -> OverrideRequest:
    id_, criterion, points, comment = (row.get(column, "").strip() for column in COLUMNS)
    return OverrideRequest(id_, criterion, points, comment, place, alone=points == ALONE)


def adjust(lab: Lab, out: Path, store: Store, requests: Sequence[OverrideRequest], author: str, what: str) -> list[str]:
    """Validate and store override requests, all or none, rewrite the pages, and return a line for the terminal on each.

    A request that is already in force changes nothing, so a table can be given twice. If the automatic points beneath an override
    have changed, the same request confirms the override. `what` is the subject of one decision on several submissions, else "".

    Raises
    ------
    RequestError
        With a line for each request that cannot be met.
    """
    before = {**store.final_grades(), **admit(store, {request.id for request in requests})}
    made = decide(store, before, requests, author, what=what)
    said = store.adjustments()
    after = {id_: replace(each, adjustments=said.get(id_, ())) for id_, each in before.items()}
    write_class(out, store.final_grades(), store, lab)
    fresh = dict.fromkeys(each.id for each in made if each.fresh)
    publish_all(out, (after[id_] for id_ in fresh), store, lab)
    return [_line_on(each, after[each.id]) for each in made]


@dataclass(frozen=True)
class RecordedOverride:
    """An override, comment or withdrawal as stored; `fresh` is False if it was in force before, so that no page changes."""

    id: str
    adjustment: Adjustment
    fresh: bool


def decide(
    store: Store,
    final_grades: Mapping[str, FinalGrade],
    requests: Sequence[OverrideRequest],
    author: str,
    *,
    seen: int | None = None,
    what: str = "",
) -> list[RecordedOverride]:
    """Validate and store override requests, all or none, and return them as recorded. No page is written.

    `final_grades` are those of the class by id. `seen` is the number of the last adjustment that the author has seen; None skips
    the comparison. `what` says, for the history, what the submissions of one decision have in common; "" for single overrides.

    Raises
    ------
    RequestError
        With a line for each request that cannot be met; `OvertakenError` if a submission has an adjustment later than `seen`.
    """
    said = {(id_, each.criterion, each.alone) for id_, each in store.history()}
    problems = [problem for request in requests if (problem := _problem(request, final_grades, said))]
    if problems:
        raise RequestError("\n".join(problems))
    made = [(request.id, _adjustment(request, final_grades[request.id], author, stamps.now())) for request in requests]
    recorded = [RecordedOverride(id_, each, not _changes_nothing(each, final_grades[id_])) for id_, each in made]
    store.adjust([(each.id, each.adjustment) for each in recorded if each.fresh], seen, what)
    return recorded


def undone(store: Store, id_: str, criterion: str, *, alone: bool | None = None) -> OverrideRequest:
    """Return the request that undoes the last override or comment on a target and restores the one before it.

    A target is a criterion, a check, `total` or `bonus`. `alone` True undoes a comment, False an override, None the later of the
    two.

    Raises
    ------
    RequestError
        If there is nothing to undo.
    """
    rows = [each for who, each in store.history() if (who, each.criterion) == (id_, criterion)]
    kind = alone if alone is not None else bool(rows and rows[-1].alone)
    rows = [each for each in rows if each.alone == kind]
    if not rows or rows[-1].withdraws:
        raise RequestError(f"adjust: {printable(id_)} has no adjustment of {printable(criterion)} to undo")
    return _restoring_request(id_, rows)


def undoing_requests(store: Store, number: int) -> list[OverrideRequest]:
    """Return the requests that undo decision `number` on several submissions, except where a later override has replaced it.

    RequestError if no part of the decision is in force.
    """
    rows: dict[tuple[str, str, bool], list[Adjustment]] = {}
    for id_, each in store.history():
        rows.setdefault((id_, each.criterion, each.alone), []).append(each)
    last = {key: each for key, each in rows.items() if each[-1].decision == number and not each[-1].withdraws}
    if not last:
        raise RequestError(f"adjust: decision {number} has nothing left to undo")
    return [_restoring_request(id_, each) for (id_, _, _), each in last.items()]


def _restoring_request(id_: str, rows: Sequence[Adjustment]) -> OverrideRequest:
    """Return the request that restores what was in force before the last of `rows`, all adjustments of one target."""
    last, before = rows[-1], rows[-2] if len(rows) > 1 else None
    if before is None or before.withdraws:
        return OverrideRequest(id_, last.criterion, "", "" if last.alone else "undone", alone=last.alone)
    points = "" if before.points is None else repr(before.points)
    return OverrideRequest(id_, last.criterion, points, before.comment, alone=last.alone)


def person_lookup(store: Store) -> PersonLookup:
    """Return a lookup whose method `by` finds ids by name, e-mail address or number, also those of people without a submission."""
    handed_in = {id_: hand_in.people for id_, hand_in in store.hand_ins().items() if hand_in.people}
    return PersonLookup({**{id_: (person,) for id_, person in absent_by_id(store).items()}, **handed_in})


def listing(store: Store) -> Iterator[str]:
    """Yield a line on every override, bonus and comment ever made, oldest first, with author and time; or that there is none."""
    decisions, history = store.decisions(), store.history()
    if not history:
        yield "no overrides on record"
    for id_, each in history:
        who = f"{each.at} by {printable(each.author, 80)}: {printable(each.comment, MAX_COMMENT)}"
        decision = decisions.get(each.decision)
        several = f"  (decision {each.decision}: {printable(decision)})" if decision is not None else ""
        yield f"{printable(id_, 80)} {each.criterion} {said(each)}  {who}{several}"


def said(adjustment: Adjustment) -> str:
    """Return the points of an override or bonus as text; `comment` for a comment alone, `withdrawn` for a withdrawal."""
    if adjustment.withdraws:
        return "withdrawn"
    return ALONE if adjustment.points is None else words.number(adjustment.points)


def _problem(
    override: OverrideRequest, final_grades: Mapping[str, FinalGrade], said: Set[tuple[str, str, bool]]
) -> str:
    """Return why a request cannot be met, or "". `said` holds all targets ever adjusted, without which nothing is withdrawn."""
    if override.id not in final_grades:
        return f"{override.place}: there is no submission {printable(override.id)}{guess_at(override.id, final_grades)}"
    final_grade = final_grades[override.id]
    most = maximum_points(final_grade.result, override.criterion)
    if not override.criterion:
        criteria = ", ".join(each.id for each in final_grade.result.criteria)
        return f"{override.place}: say for what with --criterion: {criteria}, one of their checks, total or bonus"
    if most is None:
        near = guess_at(override.criterion, targets(final_grade))
        return f"{override.place}: there is no criterion {printable(override.criterion)}{near}"
    withdraws = not (override.comment.strip() if override.alone else override.points)
    if withdraws and (override.id, override.criterion, override.alone) not in said:
        return f"{override.place}: {printable(override.id)} has no adjustment of {override.criterion} to withdraw"
    return next((f"{override.place}: {why}" for why in objections(override, final_grade).values()), "")


def objections(override: OverrideRequest, final_grade: FinalGrade) -> dict[str, str]:
    """Return the problems of a request's points and comment, by field of the form where the desk shows them; empty if none."""
    found = {}
    most = maximum_points(final_grade.result, override.criterion)
    if override.points and not override.alone and most is not None:
        points = decimal(override.points)
        if points is None or not 0 <= points <= most or round(points, 2) != points:
            form = f"a number from 0 to {words.number(most)} with at most two decimals"
            found["points"] = f"points must be {form}, not {printable(override.points, 60)}"
        elif over := covering(final_grade, override.criterion):
            replaced = f"the override of {over} of {words.distinct(final_grade)} replaces {override.criterion}"
            found["points"] = f"{replaced}; withdraw that first"
    if not (override.comment.strip() or override.alone) or len(override.comment) > MAX_COMMENT:
        found["comment"] = f"say why in a comment of at most {MAX_COMMENT} characters"
    return found


def targets(final_grade: FinalGrade) -> list[str]:
    """Return the ids of all that a person may override in a submission: criteria, their checks, the total and the bonus."""
    criteria = final_grade.result.criteria
    return [*(c.id for c in criteria), *(check.id for c in criteria for check in c.checks), TOTAL, BONUS]


def covering(final_grade: FinalGrade, target: str) -> str:
    """Return the id whose override replaces the points of `target`: a check's criterion, else `total`; "" if there is none."""
    holders = [c.id for c in final_grade.result.criteria if any(check.id == target for check in c.checks)]
    above = [*holders, TOTAL] if target not in (TOTAL, BONUS) else []
    return next((each for each in above if final_grade.adjustment(each)), "")


def _adjustment(override: OverrideRequest, final_grade: FinalGrade, author: str, now: str) -> Adjustment:
    comment = override.comment.strip().encode("utf-8", "replace").decode()
    if override.alone:
        return Adjustment(override.criterion, None, comment, author, now, alone=True)
    stands_for = automatic_points(final_grade.result, override.criterion) or {}
    out_of = maximum_by_check(final_grade.result, stands_for)
    return Adjustment(override.criterion, decimal(override.points), comment, author, now, stands_for, out_of)


def _changes_nothing(override: Adjustment, final_grade: FinalGrade) -> bool:
    """Return whether an override need not be stored: an equal one is in force for the same points, or none is to withdraw."""
    same = (
        each for each in final_grade.adjustments if (each.criterion, each.alone) == (override.criterion, override.alone)
    )
    now = next(same, None)
    if now is None:
        return override.withdraws
    same_points = (now.points, now.comment, now.automatic) == (override.points, override.comment, override.automatic)
    return same_points and now.out_of == override.out_of


def _line_on(made: RecordedOverride, final_grade: FinalGrade) -> str:
    final = "open" if final_grade.final is None else words.number(final_grade.final)
    before = "" if made.fresh else " (as before)"
    return f"{printable(made.id, 80)} {made.adjustment.criterion} {said(made.adjustment)}{before}, final {final}"
