"""What was handed in: folders, archives and classes of them, read into memory as bytes and never trusted.

`read_class` finds the submissions without reading them; an `Entry` is small and is read where it is graded.
"""

from __future__ import annotations

from grader.intake.classes import ATTEMPTS, SHAPES, Entry, Intake, read_class
from grader.intake.submission import Submission, read_submission

__all__ = ["ATTEMPTS", "SHAPES", "Entry", "Intake", "Submission", "read_class", "read_submission"]
