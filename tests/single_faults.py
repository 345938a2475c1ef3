"""Submissions that are a base with some text replaced, and what they lose."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from grader.engine.results import Result
from grader.intake import Submission
from tests.corpus.cases import Case
from tests.corpus.writing import Files, as_bytes
from tests.recordings import Marking


def submission_of(files: Files) -> Submission:
    """A submission that is not written to disk and read again."""
    return Submission("s", "s", {name: as_bytes(content) for name, content in files.items()}, (), "ready", "")


def marked(marker: Marking, files: Files, only: str | None = None) -> Result:
    return marker.mark(submission_of(files), only=only)


def lost_by(result: Result) -> dict[str, float]:
    checks = [check for part in result.criteria for check in part.checks]
    return {check.id: check.max_points - (check.points or 0.0) for check in checks if check.points != check.max_points}


def thinned(cases: Sequence[Case], every: int) -> list[object]:
    """Return the parameters of a table of submissions; all but one of so many run each week alone."""
    return [
        pytest.param(case, marks=[pytest.mark.weekly] if n % every else [], id=case.name)
        for n, case in enumerate(cases)
    ]
