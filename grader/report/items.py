"""Item analysis: how hard each check was for a class, and whether who earns it does well elsewhere.

References
----------
Ebel, R. L., Frisbie, D. A. (1991). Essentials of Educational Measurement, 5th ed., chapter 13: difficulty and discrimination.
Henrysson, S. (1963). Correction of item-total correlations in item analysis. Psychometrika 28, 211-218: the item is left out of
the total that it is correlated with.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from grader.engine.results import CheckResult, Result

FEWEST = 10
"""Below this a correlation says nothing: with 10 submissions its standard error is 0.3."""
_WEAK = 0.1
_ENOUGH = 30


@dataclass(frozen=True)
class Item:
    """One check over a class.

    Attributes
    ----------
    judged
        Submissions for which it was judged.
    losers
        How many of them lost something on it.
    difficulty
        Mean share of its points that was earned, 0 (hard) to 1 (easy).
    discrimination
        Correlation of that share with the score on all other checks, −1 to 1; None where there is nothing to correlate.
    """

    id: str
    title: str
    judged: int
    losers: int
    difficulty: float
    discrimination: float | None

    @property
    def doubtful(self) -> bool:
        """Whether good submissions lose it as often as weak ones: the check, or what was taught, is worth a look."""
        return self.judged >= _ENOUGH and self.discrimination is not None and self.discrimination < _WEAK


def items(results: Iterable[Result]) -> list[Item]:
    """Every check of the criteria, in the order of the rubric; results with open points count where they were judged."""
    rows: dict[str, list[tuple[CheckResult, float]]] = {}
    for result in results:
        if result.status in ("empty", "unreadable"):
            continue  # nothing was asked of them
        for criterion in result.criteria:
            for check in criterion.checks:
                if check.points is not None and check.max_points:
                    rows.setdefault(check.id, []).append((check, result.score - check.points))
    return [_item(row) for row in rows.values()]


def _item(row: list[tuple[CheckResult, float]]) -> Item:
    first = row[0][0]
    shares = np.array([(check.points or 0.0) / check.max_points for check, _ in row])
    rests = np.array([rest for _, rest in row])
    related = len(row) >= FEWEST and np.ptp(shares) > 0 and np.ptp(rests) > 0
    return Item(
        id=first.id,
        title=first.title,
        judged=len(row),
        losers=int((shares < 1).sum()),
        difficulty=float(shares.mean()),
        discrimination=float(np.corrcoef(shares, rests)[0, 1]) if related else None,
    )
