"""Request of a run over a class, which `imugrade grade` makes from its options."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from grader.course.record.class_settings import ClassSettings
from grader.engine.rubric import Rubric
from grader.engine.traces import Traces
from grader.people.roster import NO_ROSTER, Roster


@dataclass(frozen=True)
class GradeRequest:
    """Request of a user to `imugrade grade`: submissions, output folder, rubric, traces (reference recordings) and options.

    An empty `only` grades all; `jobs` None starts one process per core; `force` grades again what has a stored result; `trusted`
    allows code to run without isolation; `cluster` None grades on this machine. `shape` is the platform whose download each path
    is, or "folders", None to recognise it. `attempts`, "latest" or "best", chooses the attempt that counts. `change` allows stored
    scores to change. `at_least` is the weakest isolation level allowed, "" any.
    """

    paths: tuple[Path, ...]
    out: Path
    rubric: Rubric
    traces: Traces
    jobs: int | None = None
    only: tuple[str, ...] = ()
    force: bool = False
    trusted: bool = False
    isolation_level: str | None = None
    cluster: str | None = None
    shape: str | None = None
    roster: Roster = NO_ROSTER
    attempts: str = "latest"
    change: bool = False
    at_least: str = ""

    @property
    def settings(self) -> ClassSettings:
        return ClassSettings.of(self.rubric, self.roster, self.attempts, self.traces)
