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

    `only` are ids, names or e-mails of students to grade, () all; `cluster` is the address of a Dask cluster, None this machine;
    `jobs` None starts one process per core; `force` grades stored results again; `trusted` allows code to run without isolation.
    `shape` is the platform that the paths were downloaded from, or "folders", None to recognise it. `attempts`, "latest" or "best",
    is the attempt that counts. `change` allows stored scores to change. `isolation_level` names the sandbox's level, None the best
    here; `at_least` is the weakest level allowed, "" any.
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
