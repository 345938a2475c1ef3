"""The first lines of a check, told before anything is run: what was found, and what waits besides the public checks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from grader.text import printable

if TYPE_CHECKING:  # these lines come before anything slow is imported
    from grader.intake import Submission
    from grader.rubric import Rubric
    from grader.traces import Traces

ASKED_FOR = ("imu_reader.py", "noisy_imu.py", "filters.py", "imu_data.png", "filtered_imu.png")
SAME_FOR_ALL = frozenset({"standing", "free_fall", "watched"})
"""Scenarios in which no seed changes a number: at rest, falling, and the one that is watched live."""


def found(submission: Submission) -> str:
    """Which of the sheet's files are there, and which are not."""
    there = [name for name in ASKED_FOR if name in submission.files]
    absent = [name for name in ASKED_FOR if name not in submission.files]
    said = [f"{', '.join(there)} found"] if there else []
    said += [f"no {', no '.join(absent)}"] if absent else []
    return f"{printable(submission.name, 120)}: {'; '.join(said)}"


def waiting(submission: Submission, rubric: Rubric, traces: Traces, only: str | None) -> str:
    """How many public checks are run now, and how many hidden scenarios the instructor has."""
    count = sum(len(part.checks) for part in rubric.criteria if only in (None, part.id))
    count += sum(len(part.checks) for part in rubric.extensions if part.file in submission.files or only == part.id)
    hidden = len(traces.scenarios.keys() - SAME_FOR_ALL)
    return (
        f"{count} public check{'s' * (count != 1)}. {hidden} hidden scenarios wait: "
        "the same kinds, other numbers; your instructor grades with them."
    )
