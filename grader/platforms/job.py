"""Run a CI job on one submission: grade it, write the output that the platform expects, and return the result."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from grader.base.errors import RequestError
from grader.base.files import write_whole
from grader.base.text import printable
from grader.engine.grader import Marker
from grader.engine.lab_sandbox import open_sandbox_for
from grader.engine.reading import read_apart
from grader.engine.results import Result
from grader.engine.rubric import Rubric
from grader.engine.rubric_nodes import did_you_mean
from grader.engine.traces import Traces
from grader.platforms import registry
from grader.platforms.platform import Platform, ResultContext


@dataclass(frozen=True)
class CiJob:
    """Request of `imugrade ci`: which submission to grade, by which rubric and scenarios (`traces`), and where the output goes.

    `path` or `out` None is the platform's default; `out` "-" is stdout. `trusted` allows hidden scenarios without isolation.
    `min_score` is the score below which `imugrade ci` fails; some platforms refuse it. `isolation_level` None is the best that
    works. `private` says that students can read neither the files nor the output of the job.
    """

    platform: Platform
    rubric: Rubric
    traces: Traces
    path: Path | None = None
    out: Path | None = None
    trusted: bool = False
    min_score: float | None = None
    isolation_level: str | None = None
    private: bool = False
    environ: Mapping[str, str] = field(default_factory=lambda: dict(os.environ))

    @property
    def hidden(self) -> bool:
        """Return whether the job grades on hidden scenarios, whose data students must not see."""
        return self.traces.name != "public"


def named(name: str) -> Platform:
    """Return the platform that `--format` names; "auto" recognises the platform from the environment.

    Raise RequestError if there is no such format.
    """
    if name == registry.AUTO:
        return recognise(os.environ)
    known = (registry.AUTO, *registry.names("respond"))
    if name not in known:
        guess = did_you_mean(name, known, f"there are {', '.join(known)}")
        raise RequestError(f"--format {printable(name)}: there is no such format; {guess}")
    return registry.platform(name)


def recognise(environ: Mapping[str, str], root: Path = Path("/")) -> Platform:
    """Return the platform that this process runs on, by its environment variables and files below `root`; JUnit if unknown."""
    known = registry.platforms("respond")
    return next(each for each in known if each.recognise is not None and each.recognise(environ, root))


def submission_of(platform: Platform, root: Path = Path("/")) -> Path:
    """Return the default path of the submission: the platform's folder below `root` if it exists, else the working folder."""
    place = root / platform.submission
    return place if platform.submission and place.is_dir() else Path()


def answer_of(platform: Platform, root: Path = Path("/")) -> Path | None:
    """Return the default path of a job's output; None (standard output) if the platform names no file, or its folder is missing."""
    if "/" not in platform.answer:
        return Path(platform.answer) if platform.answer else None
    place = root / platform.answer
    return place if place.parent.is_dir() else None


def run(job: CiJob) -> Result:
    """Grade a CI job's submission, write the output that the platform expects, and return the result.

    Raises
    ------
    RequestError
        If hidden scenarios are requested where students can read the job's files (unless `private`), or where nothing isolates
        their code (unless `trusted`); if there is nothing at the path; if the output cannot be written; if the platform refuses
        the job or has no CI output.
    GraderError
        If a part was not judged and the platform's format cannot express that.
    """
    respond = job.platform.respond
    if respond is None:
        raise RequestError(f"--format {job.platform.name}: {job.platform.title} has no CI output")
    _keep_secret(job)
    if job.platform.refuse is not None:
        job.platform.refuse(job.environ, job.min_score)
    path = job.path or submission_of(job.platform)
    submission = read_apart(path, job.rubric.lab.files)
    with Marker(
        job.rubric, job.traces, sandbox=open_sandbox_for(job.rubric.lab, submission.files, job.isolation_level)
    ) as marker:
        if job.hidden and not marker.isolation.isolates and not job.trusted:
            raise RequestError(
                "hidden scenarios, but this machine cannot keep students' code from reading them (`imugrade doctor` says why); "
                "leave --traces out, or add --trust-submissions"
            )
        result = marker.mark(submission)
    handed = ResultContext(job.rubric.lab, submission, path, job.environ, job.hidden)
    _write(job, respond(result, handed), result)
    if job.platform.aside is not None:
        _append(job.environ, job.platform.aside.variable, job.platform.aside.text(result, handed))
    return result


def _keep_secret(job: CiJob) -> None:
    if job.hidden and not (job.platform.keeps_secrets or job.private):
        raise RequestError(
            f"--traces: hidden scenarios stay out of {job.platform.title}, where students can read them; "
            "grade with them in a class run (imugrade grade), or in a job of your own private repository, with --private"
        )


def _write(job: CiJob, text: str, result: Result) -> None:
    out = job.out or answer_of(job.platform)
    if out is None or str(out) == "-":
        sys.stdout.write(text)
        sys.stdout.flush()
    else:
        write_whole(out, text)
        print(f"{out} written: {result.score:g} of {result.max_score:g} points", flush=True)


def _append(environ: Mapping[str, str], variable: str, text: str) -> None:
    """Append text to the file that an environment variable names, which the platform made for this job; without one do nothing."""
    file = environ.get(variable)
    if not file:
        return
    try:
        with open(file, "a", encoding="utf-8", errors="replace") as stream:
            stream.write(text)
    except OSError as problem:
        raise RequestError(f"{variable}: cannot write it ({problem.strerror}); unset it") from problem
