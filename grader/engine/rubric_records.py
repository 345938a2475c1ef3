"""Records of a rubric: criteria, checks with their points, extensions, limits, late policy and repair policy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from grader.engine.lab import Lab

OwnChecks = tuple[tuple[str, bytes], ...]
"""Names and contents of the files in the folder ``checks`` beside a rubric. They are read once and run from this copy."""


@dataclass(frozen=True)
class CheckWeight:
    """A check as a rubric lists it: `max_points` is its part of the criterion's points, in proportion to `weight`.

    `id` is the full id (``filtering.passes_constant``), `line` its line in the file.
    """

    id: str
    weight: float
    max_points: float
    line: int


@dataclass(frozen=True)
class Criterion:
    """A criterion as a rubric lists it: title, points and checks; `line` is its line in the file."""

    id: str
    title: str
    points: float
    checks: tuple[CheckWeight, ...]
    line: int


@dataclass(frozen=True)
class Extension(Criterion):
    """An optional task of the lab sheet, solved in a `file` of its own. With `points` 0 it is reported and earns nothing."""

    file: str


@dataclass(frozen=True)
class Limits:
    """CPU time in seconds for one call of a student's code, and for all calls of one submission."""

    call_cpu_s: float
    submission_cpu_s: float


@dataclass(frozen=True)
class LatePolicy:
    """Late policy: what a late submission loses. It changes the final grade, never the score.

    Attributes
    ----------
    due : the due date, in UTC
    grace_minutes : a submission up to this late counts as on time; a later one is late from `due` on
    per_day : points deducted for each day begun after `due`
    cut_off_days : a submission later than this many days is not accepted; None: each is accepted
    due_dates : other due dates for some submissions or people, by id, name or e-mail address
    tz : the time zone in which days are counted, for example "Europe/Berlin"; "" counts 24 hours as a day
    """

    due: datetime
    grace_minutes: float
    per_day: float
    cut_off_days: float | None
    due_dates: Mapping[str, datetime] = field(default_factory=dict)
    tz: str = ""


@dataclass(frozen=True)
class RepairPolicy:
    """Repair policy: what happens with files that do not run, if a small patch makes them run.

    Attributes
    ----------
    suggested : whether `grade` applies a suggested repair by itself; otherwise a person decides
    deduct : points deducted for a repair that `grade` applies; the review desk proposes the same number
    """

    suggested: bool = False
    deduct: float = 5.0


@dataclass(frozen=True)
class Rubric:
    """A valid rubric, read from a file: what a submission is graded by.

    Attributes
    ----------
    criteria, extensions : in the lab sheet's order, not the file's
    settings : values of the lab's own keys (`Lab.settings`)
    sha256 : digest of all that checks' points depend on; comments, order of criteria, late and repair policies do not change it
    asked_sha256 : digest of all that questions to student code depend on; results recorded under it get points without a new run
    source : name of the file in messages
    extra_credit_cap : the most that all extensions add: the file's cap, else the sum of their points; None if that sum is 0
    late : None without a late policy
    faults : points to deduct by id of the fault, in place of the share that a check loses
    own_checks : name and content of each ``.py`` file of checks that the instructor adds, from a folder beside the rubric
    text, folder : the whole file, and the folder that relative paths in it start from
    """

    lab: Lab
    criteria: tuple[Criterion, ...]
    extensions: tuple[Extension, ...]
    limits: Limits
    settings: Mapping[str, Any]
    sha256: str
    asked_sha256: str
    source: str
    extra_credit_cap: float | None
    late: LatePolicy | None
    faults: Mapping[str, float]
    own_checks: OwnChecks
    text: str = field(default="", repr=False)
    folder: Path | None = None
    repairs: RepairPolicy = RepairPolicy()

    @property
    def parts(self) -> tuple[Criterion, ...]:
        """The criteria, then the extensions."""
        return (*self.criteria, *self.extensions)

    @property
    def checks(self) -> tuple[CheckWeight, ...]:
        """The checks of the criteria, then those of the extensions."""
        return tuple(check for part in self.parts for check in part.checks)
