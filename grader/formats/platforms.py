"""The platforms that take a result: how each is recognised, where it hands in and where it looks for the answer."""

from __future__ import annotations

import difflib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from grader.errors import RequestError
from grader.text import printable


@dataclass(frozen=True)
class Platform:
    """One value of `--format`.

    Attributes
    ----------
    name, title
        The value, and what it is called.
    submission
        Where the platform puts what was handed in, without the leading slash; "" is the working folder.
    answer
        Where it looks for the answer, without the leading slash for an absolute place; "" is standard output.
    keeps_secrets
        Whether students see only what the answer holds. Where a job runs in their own repository it is False, and hidden
        scenarios are refused.
    """

    name: str
    title: str
    submission: str
    answer: str
    keeps_secrets: bool


PLATFORMS: Mapping[str, Platform] = {
    platform.name: platform
    for platform in (
        Platform("github", "GitHub Actions", "", "", keeps_secrets=False),
        Platform("gradescope", "Gradescope", "autograder/submission", "autograder/results/results.json", True),
        Platform("classroom50", "Classroom 50", "", "result.json", keeps_secrets=False),
        Platform("junit", "JUnit XML (GitLab, Jenkins)", "", "", keeps_secrets=False),
        Platform("prairielearn", "PrairieLearn", "grade/student", "grade/results/results.json", True),
        Platform("json", "result.json", "", "", keeps_secrets=True),
    )
}
NAMES = ("auto", *PLATFORMS)


def named(name: str) -> Platform:
    """The platform of a `--format`; "auto" recognises it.

    Raises
    ------
    RequestError
        If there is no such format.
    """
    if name == "auto":
        return recognise(os.environ)
    if name not in PLATFORMS:
        near = difflib.get_close_matches(name, NAMES, 1)
        guess = f"did you mean {near[0]}?" if near else f"there are {', '.join(NAMES)}"
        raise RequestError(f"--format {printable(name)}: there is no such format; {guess}")
    return PLATFORMS[name]


def recognise(environ: Mapping[str, str], root: Path = Path("/")) -> Platform:
    """The platform that this process runs on; plain JSON where none is recognised.

    Parameters
    ----------
    environ
        The environment's variables.
    root
        Where absolute places start; for tests.
    """
    if environ.get("CLASSROOM") and environ.get("ASSIGNMENT") and environ.get("SUBMISSION_TAG"):
        return PLATFORMS["classroom50"]  # runs inside GitHub Actions, so it is asked first
    if environ.get("GITHUB_ACTIONS") == "true":
        return PLATFORMS["github"]
    if environ.get("GITLAB_CI") == "true":
        return PLATFORMS["junit"]
    for name in ("gradescope", "prairielearn"):
        if (root / PLATFORMS[name].submission).is_dir():
            return PLATFORMS[name]
    return PLATFORMS["json"]


def submission_of(platform: Platform, root: Path = Path("/")) -> Path:
    """The submission where no path is given: the platform's place if it is there, else the working folder."""
    place = root / platform.submission
    return place if platform.submission and place.is_dir() else Path()


def answer_of(platform: Platform, root: Path = Path("/")) -> Path | None:
    """Where the answer goes if nothing is said: None is standard output."""
    if "/" not in platform.answer:
        return Path(platform.answer) if platform.answer else None
    place = root / platform.answer
    return place if place.parent.is_dir() else None
