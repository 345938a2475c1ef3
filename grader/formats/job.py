"""One submission on a CI platform: mark it, write what the platform reads, answer with the result."""

from __future__ import annotations

import datetime
import os
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import cast, get_args

from grader.errors import RequestError
from grader.files import write_whole
from grader.formats import github
from grader.formats.classroom50 import Identity, classroom50
from grader.formats.gradescope import Visibility, gradescope
from grader.formats.junit import junit
from grader.formats.places import Places, find_places
from grader.formats.platforms import Platform, answer_of, submission_of
from grader.formats.prairielearn import prairielearn
from grader.intake import Submission, read_submission
from grader.lab_box import open_box_for
from grader.marking import Marker
from grader.results import Result, to_json
from grader.rubric import Rubric
from grader.text import printable
from grader.traces import Traces


@dataclass(frozen=True)
class Job:
    """What a CI job asks for. `path` and `out` None: where the platform has them; `out` "-" is standard output."""

    platform: Platform
    rubric: Rubric
    traces: Traces
    path: Path | None = None
    out: Path | None = None
    visibility: Visibility = "visible"
    trusted: bool = False
    rung: str | None = None
    environ: Mapping[str, str] = field(default_factory=lambda: dict(os.environ))

    @property
    def hidden(self) -> bool:
        """Whether the traces are an instructor's secret."""
        return self.traces.name != "public"


def visible(when: str) -> Visibility:
    """`--visibility`, refused where Gradescope has no such word."""
    if when not in get_args(Visibility):
        raise RequestError(f"--visibility {printable(when)}: there are {', '.join(get_args(Visibility))}")
    return cast(Visibility, when)


def refuse_limit(job: Job, min_score: float | None) -> None:
    """Classroom 50 takes every exit code but 0 for a broken autograder."""
    if min_score is not None and job.platform.name == "classroom50":
        raise RequestError("--min-score: Classroom 50 reads the points from result.json; leave it out there")


def run(job: Job) -> Result:
    """Mark the submission and write the answer.

    Raises
    ------
    RequestError
        If hidden scenarios are wanted where students can read what the job reads, or where nothing isolates their code;
        if there is nothing at the path; if the answer cannot be written.
    GraderError
        If the platform has no way to say that a part could not be judged.
    """
    _keep_secret(job)
    identity = Identity.of(job.environ) if job.platform.name == "classroom50" else None
    path = job.path or submission_of(job.platform)
    submission = read_submission(path)
    with Marker(job.rubric, job.traces, box=open_box_for(submission.files, job.rung)) as marker:
        if job.hidden and marker.isolation == "none" and not job.trusted:
            raise RequestError(
                "hidden scenarios, but nothing here keeps students' code from reading them (`imugrade doctor` tells why); "
                "leave --traces out, or add --trust-submissions"
            )
        result = marker.mark(submission)
    _write(job, _text(job, result, submission, path, identity), result)
    return result


def _keep_secret(job: Job) -> None:
    if job.hidden and not job.platform.keeps_secrets:
        raise RequestError(
            f"--traces: hidden scenarios stay out of {job.platform.title}, where students can read them; "
            "grade with them in a class run (imugrade grade)"
        )


def _text(job: Job, result: Result, submission: Submission, path: Path, identity: Identity | None) -> str:
    name = job.platform.name
    if name == "github":
        return github.commands(result, _places(job, submission, path))
    if name == "gradescope":
        return gradescope(result, hidden=job.hidden, visibility=job.visibility)
    if identity is not None:
        return classroom50(result, identity, committed(path))
    if name == "prairielearn":
        return prairielearn(result, hidden=job.hidden)
    return junit(result) if name == "junit" else to_json(result)


def _places(job: Job, submission: Submission, path: Path) -> Places:
    root = Path(job.environ.get("GITHUB_WORKSPACE") or ".").resolve()
    return find_places(submission, path.resolve(), root)


def _write(job: Job, text: str, result: Result) -> None:
    out = job.out or answer_of(job.platform)
    if out is None or str(out) == "-":
        sys.stdout.write(text)
        sys.stdout.flush()
    else:
        write_whole(out, text)
        print(f"{out} written: {result.score:g} of {result.max_score:g} points", flush=True)
    if job.platform.name == "github":
        _append_summary(job.environ.get("GITHUB_STEP_SUMMARY"), github.summary(result))


def _append_summary(file: str | None, text: str) -> None:
    """The runner makes the file for each step and reads what stands in it."""
    if not file:
        return
    try:
        with open(file, "a", encoding="utf-8", errors="replace") as stream:
            stream.write(text)
    except OSError as problem:
        raise RequestError(f"GITHUB_STEP_SUMMARY: cannot write it ({problem.strerror}); unset it") from problem


def committed(path: Path) -> str:
    """The instant of the commit that is graded, in UTC; now, where git does not know one."""
    folder = path if path.is_dir() else path.parent
    command = ["git", "-C", str(folder), "show", "--no-patch", "--format=%ct", "HEAD"]
    try:
        said = subprocess.run(command, capture_output=True, text=True, timeout=20, check=True).stdout
        instant = datetime.datetime.fromtimestamp(int(said), datetime.timezone.utc)
    except (OSError, ValueError, subprocess.SubprocessError):
        instant = datetime.datetime.now(datetime.timezone.utc)
    return instant.strftime("%Y-%m-%dT%H:%M:%SZ")
