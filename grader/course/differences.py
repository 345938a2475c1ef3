"""Two gradings of a class: whose marks moved, by which checks, and what had changed."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Mapping

from grader.engine.results import CheckResult, Result
from grader.ground.text import printable
from grader.people.standing import Standing
from grader.report import words

_CAUSES = {
    "submission_sha256": "the submission",
    "rubric_sha256": "the rubric",
    "traces_sha256": "the scenarios",
    "grader": "the version of imugrade",
    "mujoco": "the version of MuJoCo",
    "isolation": "the isolation",
}


def told(old: Mapping[str, Standing], new: Mapping[str, Standing]) -> Iterator[str]:
    """Lines for a terminal: a block for each submission whose points moved, how many others differ, how many moved, the means."""
    both = [id_ for id_ in old if id_ in new]
    blocks = {id_: _block(old[id_], new[id_]) for id_ in both}
    moved = [id_ for id_ in both if old[id_].final != new[id_].final]
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
    yield f"{len(moved)} of {len(both)} moved; mean {means[0]} → {means[1]}"


def _final(standing: Standing) -> str:
    return "not judged" if standing.final is None else words.number(standing.final)


def _mean(standings: list[Standing]) -> str:
    finals = [standing.final for standing in standings if standing.final is not None]
    return f"{statistics.fmean(finals):.1f}" if finals else "–"


def _block(old: Standing, new: Standing) -> list[str]:
    """What differs; nothing where neither points, checks nor what stands beside them do."""
    lines = [*_checks(old.result, new.result), *_beside(old, new)]
    if not lines:
        return []
    was, now = old.result.provenance, new.result.provenance
    changed = [cause for key, cause in _CAUSES.items() if was.get(key) != now.get(key)]
    return [*lines, f"changed: {', '.join(changed)}"] if changed else lines


def _checks(old: Result, new: Result) -> Iterator[str]:
    was, now = _by_id(old), _by_id(new)
    for id_ in {**was, **now}:
        before, after = was.get(id_), now.get(id_)
        if _told(before) != _told(after):
            yield f"{id_}  {_told(before)} → {_told(after)}"


def _by_id(result: Result) -> dict[str, CheckResult]:
    rows = [check for criterion in result.criteria for check in criterion.checks]
    rows += [check for extension in result.extensions for check in extension.checks]
    return {check.id: check for check in rows}


def _told(check: CheckResult | None) -> str:
    return (
        "absent"
        if check is None
        else f"{check.outcome.replace('_', ' ')} {words.fraction(check.points, check.max_points)}"
    )


def _beside(old: Standing, new: Standing) -> Iterator[str]:
    """Adjustments and lateness."""
    for criterion in dict.fromkeys(a.criterion for a in (*old.adjustments, *new.adjustments)):
        before, after = (_by_hand(side, criterion) for side in (old, new))
        if before != after:
            yield f"{criterion} by hand  {before} → {after}"
    if old.deduction != new.deduction:
        yield f"lateness  −{words.number(old.deduction)} → −{words.number(new.deduction)}"


def _by_hand(standing: Standing, criterion: str) -> str:
    adjustment = standing.adjustment(criterion)
    return "none" if adjustment is None or adjustment.points is None else words.number(adjustment.points)
