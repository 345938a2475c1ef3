"""Background grading for the desk: one edited copy after another, in a marker process of its own, so that pages go on answering.

Student code runs in the sandbox that the marker opens, as in `imugrade grade`. The desk's own process never runs it.
"""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from typing import Literal

from grader.base.errors import GraderError, RequestError
from grader.course.class_grading import GradingSettings
from grader.course.pool import Bounds, Pool, Stopped, Unmarked
from grader.course.repair_log import sha256_of
from grader.course.repair_suggestions import MOST
from grader.course.repairs import Grading, Preview
from grader.engine.results import Result
from grader.intake import Submission

Kind = Literal["preview", "suggest", "save", "undo"]
_KEPT_JOBS = 50
_KEPT_RESULTS = 12  # a result with its charts is about a megabyte
_BOUNDS = Bounds(wall_s=300.0)


@dataclass
class Job:
    """One request to grade, and what came of it.

    Attributes
    ----------
    kind, id, file
        What is done, to which submission and file.
    text
        The edited file as the form has it; a suggestion replaces it.
    step, tried
        What is being done at present, in words, and how many candidates for a repair were graded.
    lines
        What was done, a line each.
    problem
        Why it failed; "" if it did not.
    """

    kind: Kind
    id: str
    file: str
    text: str = ""
    deduct: str = ""
    comment: str = ""
    also: tuple[str, ...] = ()
    number: int = 0
    step: str = ""
    tried: int = 0
    grades: Preview | None = None
    lines: list[str] = field(default_factory=list)
    problem: str = ""
    began: float = field(default_factory=time.monotonic)
    ended: threading.Event = field(default_factory=threading.Event)

    @property
    def done(self) -> bool:
        return self.ended.is_set()

    @property
    def seconds(self) -> int:
        return round(time.monotonic() - self.began)


class RepairJobs:
    """Grades one job after another. The marker is opened with the first one, and again when the class has other settings.

    Parameters
    ----------
    settings_on_record
        Returns how the class is graded now.
    """

    def __init__(self, settings_on_record: Callable[[], GradingSettings]) -> None:
        self._settings_on_record = settings_on_record
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="repairs")
        self._jobs: OrderedDict[int, Job] = OrderedDict()
        self._results: OrderedDict[str, Result] = OrderedDict()
        self._open: GradingSettings | None = None
        self._pool: Pool | None = None
        self._stack = ExitStack()

    def start(self, job: Job, do: Callable[[Grading], None]) -> Job:
        """Queue a job. `do` is called on the jobs' thread with the `Grading` of the class."""
        job.number = max(self._jobs, default=0) + 1
        self._jobs[job.number] = job
        while len(self._jobs) > _KEPT_JOBS:
            self._jobs.popitem(last=False)
        job.step = "Waiting for another preview" if any(not each.done for each in [*self._jobs.values()][:-1]) else ""
        self._thread.submit(self._run, job, do)
        return job

    def get(self, number: int | None) -> Job | None:
        return self._jobs.get(number or 0)

    def close(self) -> None:
        """Wait for the running job, drop those that wait for it, and close the marker."""
        self._thread.shutdown(wait=True, cancel_futures=True)
        self._stack.close()

    def _run(self, job: Job, do: Callable[[Grading], None]) -> None:
        """Do a job, and keep its problem if it fails."""
        try:
            do(self._grading(job))
        except (RequestError, GraderError) as problem:
            job.problem = str(problem).removeprefix("repair: ")
        except Exception as problem:  # one failed job must not stop the desk
            job.problem = f"The grader failed: {type(problem).__name__}: {problem}"
        finally:
            job.ended.set()

    def _grading(self, job: Job) -> Grading:
        """Return how edited copies are graded; the marker is opened again if the settings of the class have changed."""
        now = self._settings_on_record()
        if self._open is None or _digests(now) != _digests(self._open):
            self._stack.close()
            self._results.clear()
            self._open, self._pool = now, None
        opened = self._open

        def mark(submission: Submission, cpu_s: float | None = None) -> Result:
            return self._mark(submission, opened, job, cpu_s)

        return Grading(opened.rubric, opened.traces, mark)

    def _mark(self, submission: Submission, opened: GradingSettings, job: Job, cpu_s: float | None) -> Result:
        """Grade in the marker process; a copy that was graded just before is not graded again."""
        if cpu_s is not None:
            job.tried += 1
            job.step = f"Grading edit {job.tried} of at most {MOST} in the sandbox"
            return self._graded(submission, opened, cpu_s)
        key = _key(submission)
        if key not in self._results:
            job.step = "Grading the edited copy in the sandbox"
            self._results[key] = self._graded(submission, opened)
            while len(self._results) > _KEPT_RESULTS:
                self._results.popitem(last=False)
        return replace(self._results[key], submission=submission.name)

    def _graded(self, submission: Submission, opened: GradingSettings, cpu_s: float | None = None) -> Result:
        """Grade an edited copy in the marker process."""
        if self._pool is None:
            self._pool = self._stack.enter_context(Pool(opened.open_marker, 1, _BOUNDS))
        for _, outcome in list(self._pool.run(iter([submission]), cpu_s)):
            if isinstance(outcome, Unmarked | Stopped):
                raise RequestError(f"the edited copy could not be graded: {outcome.reason}")
            return outcome
        raise RequestError("the edited copy could not be graded")


def _digests(settings: GradingSettings) -> tuple[str, str]:
    return settings.rubric.sha256, settings.traces.sha256


def _key(submission: Submission) -> str:
    return sha256_of(repr(sorted((path, sha256_of(content)) for path, content in submission.files.items())).encode())
