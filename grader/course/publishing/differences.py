"""Comparison of two gradings of a class for `imugrade diff`: changed scores, the checks behind them, changed settings."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Mapping

from grader.base.text import printable
from grader.engine.results import CheckResult, Result
from grader.people.final_grade import FinalGrade, grade_changes, graded
from grader.report import words

_CAUSES = {
    "submission_sha256": "the submission",
    "rubric_sha256": "the rubric",
    "traces_sha256": "the scenarios",
    "grader": "the version of imugrade",
    "mujoco": "the version of MuJoCo",
    "isolation": "the isolation",
}


def lines_of(old: Mapping[str, FinalGrade], new: Mapping[str, FinalGrade]) -> Iterator[str]:
    """Yield lines on how two gradings differ: causes common to all submissions, weights, each changed submission, mean grades."""
    both = [id_ for id_ in old if id_ in new]
    causes = {id_: _changed(old[id_], new[id_]) for id_ in both}
    common = [cause for cause in _CAUSES.values() if len(both) > 1 and all(cause in each for each in causes.values())]
    if common:
        yield f"changed for all: {', '.join(common)}"
    yield from _changed_weights(old, new, both)
    own = {id_: [cause for cause in causes[id_] if cause not in common] for id_ in both}
    blocks = {id_: _block(old[id_], new[id_], own[id_]) for id_ in both}
    moved = {each.final_grade.id for each in grade_changes(old, new)}
    for id_, lines in blocks.items():
        if id_ in moved:
            yield f"{printable(id_, words.NAME_LIMIT)}  {_final(old[id_])} → {_final(new[id_])}"
            yield from (f"  {line}" for line in lines)
    for id_ in old:
        if id_ not in new:
            yield f"{printable(id_, words.NAME_LIMIT)}  only in the first: {_final(old[id_])}"
    for id_ in new:
        if id_ not in old:
            yield f"{printable(id_, words.NAME_LIMIT)}  only in the second: {_final(new[id_])}"
    others = sum(bool(lines) and id_ not in moved for id_, lines in blocks.items())
    if others:
        yield f"{others} more differ in their checks and end with the same points"
    means = [_mean([side[id_] for id_ in both]) for side in (old, new)]
    yield f"{len(moved)} of {len(both)} moved; mean of graded {means[0]} → {means[1]}"


def _final(final_grade: FinalGrade) -> str:
    blank = "blank" if final_grade.unseen else "not judged"
    return blank if final_grade.final is None else words.number(final_grade.final)


def _mean(final_grades: list[FinalGrade]) -> str:
    finals = graded(final_grades)
    return f"{statistics.fmean(finals):.1f}" if finals else "–"


def _changed(old: FinalGrade, new: FinalGrade) -> list[str]:
    was, now = old.result.provenance, new.result.provenance
    return [cause for key, cause in _CAUSES.items() if was.get(key) != now.get(key)]


def _block(old: FinalGrade, new: FinalGrade, changed: list[str]) -> list[str]:
    """Return lines on what changed in one submission, with the causes that are not common to all; empty if nothing differs."""
    lines = [*_checks(old.result, new.result), *_other_changes(old, new)]
    return [*lines, f"changed: {', '.join(changed)}"] if lines and changed else lines


def _checks(old: Result, new: Result) -> Iterator[str]:
    was, now = _by_id(old), _by_id(new)
    for id_ in {**was, **now}:
        before, after = was.get(id_), now.get(id_)
        if _outcome_in_words(before) != _outcome_in_words(after) and not _is_same_share(before, after):
            yield f"{id_}  {_outcome_in_words(before)} → {_outcome_in_words(after)}"


def _changed_weights(old: Mapping[str, FinalGrade], new: Mapping[str, FinalGrade], both: list[str]) -> Iterator[str]:
    """Yield a line for each check whose maximum points differ between the gradings, once and not for every submission."""
    changed: dict[tuple[str, float, float], None] = {}
    for id_ in both:
        was, now = _by_id(old[id_].result), _by_id(new[id_].result)
        rows = ((check, was[check].max_points, now[check].max_points) for check in was if check in now)
        changed.update((row, None) for row in rows if row[1] != row[2])
    yield from (f"{check}  worth {words.number(was)} → {words.number(now)} points" for check, was, now in changed)


def _is_same_share(before: CheckResult | None, after: CheckResult | None) -> bool:
    """Return whether a check differs in its weight alone, so that it needs no line of its own; False if one grading lacks it."""
    if before is None or after is None or before.outcome != after.outcome or before.max_points == after.max_points:
        return False
    shares = [(check.points or 0.0) / check.max_points if check.max_points else 0.0 for check in (before, after)]
    return abs(shares[0] - shares[1]) * after.max_points < 0.02  # points are rounded to hundredths on both sides


def _by_id(result: Result) -> dict[str, CheckResult]:
    return {check.id: check for part in result.parts for check in part.checks}


def _outcome_in_words(check: CheckResult | None) -> str:
    return (
        "absent"
        if check is None
        else f"{check.outcome.replace('_', ' ')} {words.fraction(check.points, check.max_points)}"
    )


def _other_changes(old: FinalGrade, new: FinalGrade) -> Iterator[str]:
    """Yield a line for each repair, override and late deduction of a submission that differs between the two gradings."""
    repaired = [words.repairs(side.result) for side in (old, new)]
    yield from (f"no longer: {line}" for line in repaired[0] if line not in repaired[1])
    yield from (line for line in repaired[1] if line not in repaired[0])
    for criterion in dict.fromkeys(a.criterion for a in (*old.adjustments, *new.adjustments)):
        before, after = (_by_hand(side, criterion) for side in (old, new))
        if before != after:
            yield f"{criterion} override  {before} → {after}"
    if old.deduction != new.deduction:
        yield f"lateness  −{words.number(old.deduction)} → −{words.number(new.deduction)}"


def _by_hand(final_grade: FinalGrade, criterion: str) -> str:
    adjustment = final_grade.adjustment(criterion)
    return "none" if adjustment is None or adjustment.points is None else words.number(adjustment.points)
