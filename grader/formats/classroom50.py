"""Classroom 50: `result.json` in the student's checkout. Its scores are integers; the exact ones go beside them.

The total is rounded once, half upwards, and shared among the tests by largest remainder, so that the parts always sum to it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from grader.errors import GraderError, RequestError
from grader.formats import rows
from grader.results import Result

SCHEMA = "classroom50/result/v1"
_REQUIRED = ("CLASSROOM", "ASSIGNMENT", "SUBMISSION_TAG", "COMMIT_URL", "RELEASE_URL")


@dataclass(frozen=True)
class Identity:
    """Whose submission it is, as the runner says in the environment; collection refuses one that does not match."""

    classroom: str
    assignment: str
    assignment_type: str
    owner: str
    submission: str
    commit: str
    release: str
    review: str

    @classmethod
    def of(cls, environ: Mapping[str, str]) -> Identity:
        """Read it.

        Raises
        ------
        RequestError
            If a variable is missing; names it.
        """
        owner = environ.get("OWNER") or environ.get("USERNAME") or ""
        missing = [name for name in _REQUIRED if not environ.get(name)] + ([] if owner else ["OWNER"])
        if missing:
            told = ", ".join(missing)
            raise RequestError(f"--format classroom50: {told} not set; run it from a Classroom 50 autograder")
        classroom, assignment, tag, commit, release = (environ[name] for name in _REQUIRED)
        kind, review = environ.get("ASSIGNMENT_TYPE") or "individual", environ.get("REVIEW_URL") or commit
        return cls(classroom, assignment, kind, owner, tag, commit, release, review)


def classroom50(result: Result, identity: Identity, committed: str) -> str:
    """The text of `result.json`.

    Parameters
    ----------
    result
        A complete one: scores are integers, and an open one has none.
    identity
        Whose it is.
    committed
        The commit's instant, ISO 8601 in UTC: late marks follow from it, so a regrade must not move it.

    Raises
    ------
    GraderError
        If a part of the submission could not be judged.
    """
    if result.status == "incomplete":
        raise GraderError("a part of the submission could not be judged, so there is no score to report; run it again")
    checks = [(part, check) for part in result.criteria for check in part.checks]
    most = shares([check.max_points for _, check in checks], [math.inf] * len(checks))
    scores = shares([check.points or 0.0 for _, check in checks], most)
    tests: list[dict[str, Any]] = [
        {
            "test-name": check.id,
            "passed": check.outcome == "passed",
            "score": score,
            "max-score": full,
            "exact-score": check.points,
            "exact-max-score": check.max_points,
            "title": check.title,
            "output": rows.plain(check, part),
        }
        for (part, check), score, full in zip(checks, scores, most, strict=True)
    ]
    tests += _extra_credit(result)
    record = {
        "schema": SCHEMA,
        **identity.__dict__,
        "datetime": committed,
        "score": sum(test["score"] for test in tests),
        "max-score": sum(most),
        "tests": tests,
    }
    return json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _extra_credit(result: Result) -> list[dict[str, Any]]:
    """One more test, out of nothing, where the rubric gives extra credit."""
    if result.extra_credit_cap is None:
        return []
    exact, score = result.extra_credit, math.floor(result.extra_credit + 0.5)
    return [{"test-name": "extra_credit", "passed": exact > 0, "score": score, "max-score": 0, "exact-score": exact}]


def shares(points: Sequence[float], most: Sequence[float]) -> list[int]:
    """Whole numbers that sum to the rounded sum of `points`, each next to its own and none above its `most`."""
    whole = [math.floor(each + 1e-9) for each in points]
    open_ = math.floor(round(sum(points), 2) + 0.5) - sum(whole)
    by_remainder = sorted(range(len(points)), key=lambda i: (whole[i] - points[i], i))
    for i in [i for i in by_remainder if whole[i] < most[i]][: max(open_, 0)]:
        whole[i] += 1
    return whole
