"""Background grading of edited copies for the desk, one at a time in a process of its own, so that pages go on answering.

Student code runs in the sandbox that the marker opens, as in `imugrade grade`. The desk's own process never runs it.
"""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import partial
from typing import ClassVar

from grader.base.errors import GraderError, RequestError
from grader.course.markers.pool import Bounds, Ended, Pool, Unmarked
from grader.course.record.repair_log import sha256_of
from grader.course.repairs.making import Grading, GradingSettings, RepairPreview
from grader.engine.results import Result
from grader.intake import Submission

_KEPT_JOBS = 50
_KEPT_RESULTS = 12  # a result with its charts is about a megabyte
_BOUNDS = Bounds(wall_s=300.0)


@dataclass(frozen=True)
class RepairForm:
    """The repair editor's form as a person filled it in; `also` holds the ids of other submissions to repair in the same way."""

    text: str = ""
    deduct: str = ""
    comment: str = ""
    also: tuple[str, ...] = ()


@dataclass(kw_only=True)
class Job(ABC):
    """One piece of work for the repair editor that grades in the background, and its outcome. Each kind is a subclass.

    Attributes
    ----------
    records
        Whether the job changes the class database, so that the editor is closed after it.
    id, file
        The submission and the file.
    form
        The form as it was sent; a suggestion replaces the text.
    step
        What is being done at present, in words.
    grades
        The grades now and with the edit; None while they are unknown.
    lines
        What was done, a line each.
    problem
        Why the job failed; "" if it did not.
    """

    records: ClassVar[bool] = False
    id: str
    file: str
    form: RepairForm = RepairForm()
    number: int = 0
    step: str = ""
    grades: RepairPreview | None = None
    lines: list[str] = field(default_factory=list)
    problem: str = ""
    began: float = field(default_factory=time.monotonic)
    ended: threading.Event = field(default_factory=threading.Event)

    @abstractmethod
    def run(self, grading: Grading) -> None:
        """Do the job by the rubric and recordings in `grading`: set `grades` or `lines`; an error raised here becomes `problem`."""

    def grading_step(self) -> str:
        """Return the `step` to show while an edited copy is graded; in a search for a repair, each call counts one more copy."""
        return "Grading the edited copy in the sandbox"

    @property
    def done(self) -> bool:
        return self.ended.is_set()

    @property
    def seconds(self) -> int:
        return round(time.monotonic() - self.began)


class RepairJobs:
    """Queue of the review desk's grading jobs, done one at a time on a thread, and the process that grades for them.

    `settings_on_record` returns the class's settings. It is called before each job, as another process may have changed them.
    """

    def __init__(self, settings_on_record: Callable[[], GradingSettings]) -> None:
        self._settings_on_record = settings_on_record
        self._jobs: OrderedDict[int, Job] = OrderedDict()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="repairs")
        self._stack = ExitStack()
        self._open: GradingSettings | None = None
        self._pool: Pool | None = None
        self._results: OrderedDict[str, Result] = OrderedDict()

    def start(self, job: Job) -> Job:
        """Queue a job for the thread that grades, and return it with its number; `get` finds only the last `_KEPT_JOBS`."""
        job.number = max(self._jobs, default=0) + 1
        self._jobs[job.number] = job
        while len(self._jobs) > _KEPT_JOBS:
            self._jobs.popitem(last=False)
        job.step = "Waiting for another preview" if any(not each.done for each in [*self._jobs.values()][:-1]) else ""
        self._thread.submit(self._run, job)
        return job

    def get(self, number: int | None) -> Job | None:
        return self._jobs.get(number or 0)

    def close(self) -> None:
        """Wait for the running job, drop those that wait for it, and end the process that grades, as the desk ends."""
        self._thread.shutdown(wait=True, cancel_futures=True)
        self._stack.close()

    def _run(self, job: Job) -> None:
        """Do a job on the thread that grades, and keep its problem if it fails, so that the desk goes on."""
        try:
            settings = self._current_settings()
            job.run(settings.by(partial(self._mark, settings, job)))
        except (RequestError, GraderError) as problem:
            job.problem = str(problem).removeprefix("repair: ")
        except Exception as problem:  # one failed job must not stop the desk
            job.problem = f"The grader failed: {type(problem).__name__}: {problem}"
        finally:
            job.ended.set()

    def _current_settings(self) -> GradingSettings:
        """Return how edited copies are graded; if that has changed in the class, close the process that grades by the old way."""
        now = self._settings_on_record()
        if self._open is None or _digests(now) != _digests(self._open):
            self._stack.close()
            self._results.clear()
            self._open, self._pool = now, None
        return self._open

    def _mark(self, settings: GradingSettings, job: Job, submission: Submission, cpu_s: float | None = None) -> Result:
        """Grade an edited copy for a job; a copy just graded within the same CPU seconds is not graded again."""
        job.step = job.grading_step()
        key = _key(submission, cpu_s)
        if key not in self._results:
            self._results[key] = self._graded(submission, settings, cpu_s)
            while len(self._results) > _KEPT_RESULTS:
                self._results.popitem(last=False)
        return replace(self._results[key], submission=submission.name)

    def _graded(self, submission: Submission, settings: GradingSettings, cpu_s: float | None) -> Result:
        """Grade an edited copy in the process for that; RequestError if the grader fails on it or exceeds a limit."""
        if self._pool is None:
            self._pool = self._stack.enter_context(Pool(settings.open_marker, 1, _BOUNDS))
        for _, outcome in list(self._pool.run(iter([submission]), cpu_s)):
            if isinstance(outcome, Unmarked | Ended):
                raise RequestError(f"the edited copy could not be graded: {outcome.reason}")
            return outcome
        raise RequestError("the edited copy could not be graded")


def _digests(settings: GradingSettings) -> tuple[str, str]:
    return settings.rubric.sha256, settings.traces.sha256


def _key(submission: Submission, cpu_s: float | None) -> str:
    files = sorted((path, sha256_of(content)) for path, content in submission.files.items())
    return sha256_of(repr((files, cpu_s)).encode())
