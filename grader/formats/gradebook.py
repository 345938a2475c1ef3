"""`gradebook.csv`: one row a submission; id, name, each criterion, total, status."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping

from grader.results import CriterionResult, Result
from grader.text import csv_cell, printable


def gradebook(results: Mapping[str, Result]) -> str:
    """The class as CSV, in the order of `results`.

    What could not be judged is a blank cell, and so is the total above it: a fault of the grader is never a zero.

    Parameters
    ----------
    results
        The present result of each submission, by its id.
    """
    columns, extra = _criteria(results), any(result.extra_credit_cap is not None for result in results.values())
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["id", "name", *columns, *(["extra_credit"] if extra else []), "total", "status"])
    for id_, result in results.items():
        table.writerow(
            [
                csv_cell(id_),
                csv_cell(printable(result.submission, 500, newlines=True)),
                *_points(result, columns, extra=extra),
                result.status,
            ]
        )
    return text.getvalue()


def _criteria(results: Mapping[str, Result]) -> list[str]:
    """Ids of all criteria in the order in which they are first met (an older row may have had another rubric)."""
    return list(dict.fromkeys(criterion.id for result in results.values() for criterion in result.criteria))


def _points(result: Result, columns: list[str], *, extra: bool) -> list[str]:
    """One cell a criterion, one for extra credit where there is such a thing, and the total."""
    judged = {criterion.id: _cell(criterion) for criterion in result.criteria}
    total = "" if result.status == "incomplete" else _number(result.total)
    credit = [_number(result.extra_credit)] if extra else []
    return [*(judged.get(column, "") for column in columns), *credit, total]


def _cell(criterion: CriterionResult) -> str:
    unjudged = any(check.points is None for check in criterion.checks)
    return "" if unjudged else _number(criterion.points)


def _number(points: float) -> str:
    """Two decimals at most, without a trailing zero: 20, 87.5, 13.33."""
    return f"{points:.2f}".rstrip("0").rstrip(".")
