"""Recordings: what the sandbox answered about a submission, kept so that tests can judge the submission without running it.

Recordings are a cache in a folder outside the repository (`store.FOLDER`). What is missing is recorded while the tests run.
"""

from __future__ import annotations

from typing import Protocol

from grader.engine.results import Result
from grader.intake import Submission


class Marking(Protocol):
    """What most tests need of a marker."""

    def mark(self, submission: Submission, only: str | None = None) -> Result: ...
