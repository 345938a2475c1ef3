"""What a check shows that the one before it did not: points gained and lost."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from grader.engine.results import CheckResult, CriterionResult
from grader.report.words import number


@dataclass(frozen=True)
class Change:
    """The points of each check at the last check, by its id, beside those of now."""

    before: Mapping[str, float]

    def since(self, criteria: Iterable[CriterionResult]) -> str:
        """``+9.5 since the last check``; empty where it is not known what all of it was worth then."""
        points = _gained(self.before, [check for criterion in criteria for check in criterion.checks])
        if points is None:
            return ""
        return f"{_signed(points) if points else 'no change'} since the last check"

    def of(self, checks: Iterable[CheckResult]) -> str:
        """``+6``; empty where nothing has changed."""
        points = _gained(self.before, checks)
        return _signed(points) if points else ""

    def was(self, check: CheckResult) -> str:
        """``, was 6``; empty where it is as it was."""
        points = self.before.get(check.id)
        return f", was {number(points)}" if points is not None and points != check.points else ""


def _gained(before: Mapping[str, float], checks: Iterable[CheckResult]) -> float | None:
    """None where a check had not been judged then, or is not now."""
    points = 0.0
    for check in checks:
        if check.points is None or check.id not in before:
            return None
        points += check.points - before[check.id]
    return round(points, 2)


def _signed(points: float) -> str:
    return f"{'+' if points >= 0 else '−'}{number(abs(points))}"
