"""Compute points from the outcomes of the checks. No code is run, so a class can be marked again by another rubric at once."""

from __future__ import annotations

from dataclasses import replace

from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, Result, Unrepaired
from grader.engine.rubric import CheckWeight, Rubric


def marked(found: Result, rubric: Rubric) -> Result:
    """Return a recorded result with the points that a rubric gives for how each check ended, so that no code has to run again.

    The rubric must fit the result (see `fits`) and sets the order of the criteria. Criteria that the result lacks are left out, as
    a run may examine one alone. Points that the result already has are ignored.
    """
    rows = {check.id: check for part in found.parts for check in part.checks}
    before = _score_before(found, rubric) if found.repairs else 0.0
    criteria = {criterion.id for criterion in found.criteria}
    attempted = {extension.id: extension.attempted for extension in found.extensions}

    def checks(weights: tuple[CheckWeight, ...]) -> tuple[CheckResult, ...]:
        open_ = dict(rubric.faults)
        return tuple(_row(rows[weight.id], weight, open_) for weight in weights)

    return replace(
        found,
        criteria=tuple(
            CriterionResult(c.id, c.title, c.points, checks(c.checks)) for c in rubric.criteria if c.id in criteria
        ),
        extensions=tuple(
            ExtensionResult(e.id, attempted[e.id], e.points, checks(e.checks) if attempted[e.id] else ())
            for e in rubric.extensions
            if e.id in attempted
        ),
        extra_credit_cap=rubric.extra_credit_cap,
        provenance={**found.provenance, "rubric_sha256": rubric.sha256},
        asked_sha256=rubric.asked_sha256,
        repairs=tuple(replace(repair, score_before=before) for repair in found.repairs),
    )


def fits(found: Result, rubric: Rubric) -> bool:
    """Return whether a rubric can mark a result without a new run: its criteria were run, with its checks, CPU limits, settings."""
    if found.asked_sha256 != rubric.asked_sha256:
        return False
    asked = {part.id: {check.id for check in part.checks} for part in found.parts if part.checks}
    listed = {part.id: {check.id for check in part.checks} for part in rubric.parts}
    whole = asked.keys() >= {criterion.id for criterion in rubric.criteria}
    return whole and all(listed.get(id_) == checks for id_, checks in asked.items())


def _row(found: CheckResult, weight: CheckWeight, deductions: dict[str, float]) -> CheckResult:
    worth = {"points": earned(found, weight.max_points, deductions), "max_points": weight.max_points}
    return CheckResult(**{**vars(found), **worth})  # half the time of `replace`; matters for thousands of submissions


def _score_before(found: Result, rubric: Rubric) -> float:
    """Return the score before the repairs, the least that a repaired submission gets; a check that was not judged counts as 0."""
    score = 0.0
    for criterion in rubric.criteria:
        open_ = dict(rubric.faults)
        known = [(found.unrepaired[c.id], c.max_points) for c in criterion.checks if c.id in found.unrepaired]
        score += sum(earned(each, most, open_) or 0.0 for each, most in known)
    return round(score, 2)


def earned(found: CheckResult | Unrepaired, most: float, deductions: dict[str, float]) -> float | None:
    """Return the points of a check, or of its outcome before repairs (`Unrepaired`): its share of `most`; None if not judged.

    If it has faults and `deductions` (the rubric's fixed points by fault) has them all, these points are subtracted from `most`
    instead, down to 0. What was subtracted is also removed from `deductions`, so that later checks of the criterion do not lose
    it again.
    """
    if found.keeps is None:
        return None
    named = found.misconceptions
    if not named or any(fault not in deductions for fault in named):
        return round(most * found.keeps, 2)
    points = most
    for fault in named:
        taken = min(points, deductions[fault])
        points -= taken
        deductions[fault] -= taken
    return round(points, 2)
