"""Item analysis, by which an instructor finds doubtful checks: difficulty and discrimination of each check over a class.

References
----------
Ebel, R. L., Frisbie, D. A. (1991). Essentials of Educational Measurement, 5th ed., chapter 13: difficulty and discrimination.
Henrysson, S. (1963). Correction of item-total correlations in item analysis. Psychometrika 28, 211-218: the item is left out of
the total that it is correlated with.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from grader.engine.results import CheckResult, Result

FEWEST = 10
"""Fewest submissions for a discrimination: with 10 its standard error is 0.3."""
FEWEST_FAILED = 5
"""Fewest submissions that lost points on the check: fewer make the correlation a matter of one or two people."""
_QUANTILE = 1.96
"""Standard normal quantile of a two-sided 95 % confidence interval."""
_WEAK = 0.1
_ENOUGH = 30


@dataclass(frozen=True)
class ItemAnalysis:
    """How a class of students did on one check: how hard it is, and whether strong submissions pass it (item analysis).

    Attributes
    ----------
    judged
        Number of submissions for which the check was judged.
    losers
        Number of judged submissions that lost points on the check.
    difficulty
        Mean share of the check's points that the judged submissions got, 0 (hard) to 1 (easy).
    discrimination
        Correlation of a submission's share of the points with its score on all other checks, −1 to 1; None for too little data.
    """

    id: str
    title: str
    judged: int
    losers: int
    difficulty: float
    discrimination: float | None

    @property
    def bounds(self) -> tuple[float, float] | None:
        """Return the 95 % confidence interval of the discrimination (Fisher's z), to show how sure it is; None if not estimated."""
        if self.discrimination is None:
            return None
        z, half = math.atanh(max(-0.999, min(self.discrimination, 0.999))), _QUANTILE / math.sqrt(self.judged - 3)
        return math.tanh(z - half), math.tanh(z + half)

    @property
    def doubtful(self) -> bool:
        """Return whether strong submissions hardly do better than weak ones: discrimination < 0.1; False if None or < 30 judged."""
        return self.judged >= _ENOUGH and self.discrimination is not None and self.discrimination < _WEAK


def items(results: Iterable[Result]) -> list[ItemAnalysis]:
    """Return, for each check in the rubric's order, how a class of students did on it, to find checks that are hard or faulty.

    Submissions for which a check was not judged do not count for it; empty and unreadable ones count for none. Checks of extensions
    are left out.
    """
    rows: dict[str, list[tuple[CheckResult, float]]] = {}
    for result in results:
        if result.status in ("empty", "unreadable"):
            continue  # no check was run
        for criterion in result.criteria:
            for check in criterion.checks:
                if check.points is not None and check.max_points:
                    rows.setdefault(check.id, []).append((check, result.score - check.points))
    return [_item(row) for row in rows.values()]


def _item(row: list[tuple[CheckResult, float]]) -> ItemAnalysis:
    first = row[0][0]
    shares = np.array([(check.points or 0.0) / check.max_points for check, _ in row])
    rests = np.array([rest for _, rest in row])
    failed = int((shares < 1).sum())
    related = len(row) >= FEWEST and failed >= FEWEST_FAILED and np.ptp(shares) > 0 and np.ptp(rests) > 0
    return ItemAnalysis(
        id=first.id,
        title=first.title,
        judged=len(row),
        losers=failed,
        difficulty=float(shares.mean()),
        discrimination=float(np.corrcoef(shares, rests)[0, 1]) if related else None,
    )
