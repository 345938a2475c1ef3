"""Show which points were gained and lost since the last `imugrade check`, while a student works with `--watch`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from grader.engine.results import CheckResult, CriterionResult
from grader.report.words import number


@dataclass(frozen=True)
class EarlierPoints:
    """Points of one submission in its previous run, by the check's id, to show what changed since; empty in the first run."""

    before: Mapping[str, float]

    def total_change(self, criteria: Iterable[CriterionResult]) -> str:
        """Return how the score changed: ``+9.5 since the last check``, ``no change …``; "" unless both runs judged every check."""
        points = _gained(self.before, [check for criterion in criteria for check in criterion.checks])
        if points is None:
            return ""
        return f"{_signed(points) if points else 'no change'} since the last check"

    def change_of(self, checks: Iterable[CheckResult]) -> str:
        """Return how a criterion's points changed, as ``+6``; "" if not at all, or if not both runs judged every check."""
        points = _gained(self.before, checks)
        return _signed(points) if points else ""

    def points_before(self, check: CheckResult) -> str:
        """Return what to add to a check's points: those of the previous run as ``, was 6``; "" if they are equal or unknown."""
        points = self.before.get(check.id)
        return f", was {number(points)}" if points is not None and points != check.points else ""


def _gained(before: Mapping[str, float], checks: Iterable[CheckResult]) -> float | None:
    """Return by how much the checks' points changed since the previous run; None if one was not judged then or is not now."""
    points = 0.0
    for check in checks:
        if check.points is None or check.id not in before:
            return None
        points += check.points - before[check.id]
    return round(points, 2)


def _signed(points: float) -> str:
    return f"{'+' if points >= 0 else '−'}{number(abs(points))}"
