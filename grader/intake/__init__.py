"""Read one submission (a folder, an archive or a single file) into memory, as bytes that are never trusted.

`read_class` finds the submissions of a whole class without reading them.
"""

from __future__ import annotations

from grader.intake.submission import Submission, read_submission

__all__ = ["Submission", "read_submission"]
