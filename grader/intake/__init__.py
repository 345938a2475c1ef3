"""Read submissions (folders and archives) into memory as bytes that are never trusted.

One submission is here at once; `classes.read_class` finds those of a class without reading them.
"""

from __future__ import annotations

from grader.intake.submission import Submission, read_submission

__all__ = ["Submission", "read_submission"]
