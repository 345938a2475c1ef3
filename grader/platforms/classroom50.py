"""Classroom 50: `result.json` in the student's checkout, and `scores.csv` beside the clones (`gh teacher download`).

In `result.json` scores are integers; each test has its exact score, too, as `exact-score`. The sum of the checks is rounded once,
half upwards, and shared among their tests by largest remainder, so that the parts always sum to it. Extra credit is one more test.
"""

from __future__ import annotations

import datetime
import math
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from grader.base import tables
from grader.base.errors import RequestError
from grader.engine.results import Result
from grader.intake.downloads import Download
from grader.platforms import rows
from grader.platforms.found import Shape
from grader.platforms.git import clone, unassigned
from grader.platforms.platform import Help, Platform, ResultContext

# --- result.json ------------------------------------------------------------------------------------------------------

SCHEMA = "classroom50/result/v1"
_REQUIRED = ("CLASSROOM", "ASSIGNMENT", "SUBMISSION_TAG", "COMMIT_URL", "RELEASE_URL")


def identity_of(environ: Mapping[str, str]) -> dict[str, str]:
    """Return the fields of `result.json` that identify a submission, with the values that Classroom 50 set in the environment.

    Raise RequestError if a variable is missing; the message names it.
    """
    owner = environ.get("OWNER") or environ.get("USERNAME") or ""
    missing = [name for name in _REQUIRED if not environ.get(name)] + ([] if owner else ["OWNER"])
    if missing:
        raise RequestError(f"--format classroom50: {', '.join(missing)} not set; run it from a Classroom 50 autograder")
    classroom, assignment, tag, commit, release = (environ[name] for name in _REQUIRED)
    return {
        "classroom": classroom,
        "assignment": assignment,
        "assignment_type": environ.get("ASSIGNMENT_TYPE") or "individual",
        "owner": owner,
        "submission": tag,
        "commit": commit,
        "release": release,
        "review": environ.get("REVIEW_URL") or commit,
    }


def classroom50(result: Result, identity: Mapping[str, str], committed: str) -> str:
    """Return the text of Classroom 50's `result.json`, which has whole points.

    Parameters
    ----------
    result
        A complete result, because a check that was not judged has no integer score.
    identity
        The fields that identify the submission, as `identity_of` returns them.
    committed
        Time of the commit, ISO 8601 in UTC. Lateness follows from it, so a regrade must not change it.

    Raises
    ------
    GraderError
        If a part of the submission could not be judged.
    """
    rows.require_complete(result)
    checks = [(part, check) for part in result.criteria for check in part.checks]
    most = shares([check.max_points for _, check in checks], [math.inf] * len(checks))
    scores = shares([check.points or 0.0 for _, check in checks], most)
    tests: list[dict[str, Any]] = [
        {
            "test-name": check.id,
            "passed": check.outcome == "passed",
            "score": score,
            "max-score": full,
            "exact-score": check.points,
            "exact-max-score": check.max_points,
            "title": check.title,
            "output": rows.plain_text(check, part, result.lab),
        }
        for (part, check), score, full in zip(checks, scores, most, strict=True)
    ]
    for test in [test for test in tests if not test["passed"]][:1]:  # the file has no text on the whole result
        test["output"] = rows.with_help(test["output"], result)
    tests += _extra_credit(result)
    record = {
        "schema": SCHEMA,
        **identity,
        "datetime": committed,
        "score": sum(test["score"] for test in tests),
        "max-score": sum(most),
        "tests": tests,
    }
    return rows.as_json(record)


def _extra_credit(result: Result) -> list[dict[str, Any]]:
    """Return extra credit as one more test with a maximum of 0; no test if the rubric gives none."""
    if result.extra_credit_cap is None:
        return []
    exact, score = result.extra_credit, math.floor(result.extra_credit + 0.5)
    return [{"test-name": "extra_credit", "passed": exact > 0, "score": score, "max-score": 0, "exact-score": exact}]


def shares(points: Sequence[float], most: Sequence[float]) -> list[int]:
    """Round points of checks to integers, as Classroom 50 requires, that add up to the rounded total; none exceeds its `most`."""
    whole = [math.floor(each + 1e-9) for each in points]
    open_ = math.floor(round(sum(points), 2) + 0.5) - sum(whole)
    by_remainder = sorted(range(len(points)), key=lambda i: (whole[i] - points[i], i))
    while open_ > 0 and (room := [i for i in by_remainder if whole[i] < most[i]][:open_]):
        for i in room:
            whole[i] += 1
        open_ -= len(room)
    return whole


def committed(path: Path) -> str:
    """Return the time of the commit checked out at `path`, ISO 8601 in UTC; the present time if git knows no commit there."""
    folder = path if path.is_dir() else path.parent
    command = ["git", "-C", str(folder), "show", "--no-patch", "--format=%ct", "HEAD"]
    try:
        said = subprocess.run(command, capture_output=True, text=True, timeout=20, check=True).stdout
        instant = datetime.datetime.fromtimestamp(int(said), datetime.timezone.utc)
    except (OSError, ValueError, subprocess.SubprocessError):
        instant = datetime.datetime.now(datetime.timezone.utc)
    return instant.strftime("%Y-%m-%dT%H:%M:%SZ")


def _respond(result: Result, handed: ResultContext) -> str:
    return classroom50(result, identity_of(handed.environ), committed(handed.path))


def _refuse(environ: Mapping[str, str], min_score: float | None) -> None:
    """Raise RequestError for `--min-score`, as Classroom 50 takes any exit code but 0 for a fault, or for missing variables."""
    if min_score is not None:
        raise RequestError("--min-score: leave it out; Classroom 50 reads the points from result.json")
    identity_of(environ)


# --- clones -----------------------------------------------------------------------------------------------------------

TITLE = "Classroom 50 clones"
SCORES = "scores.csv"
MAX_SCORES = 16_000_000
_COLUMNS = {"username", "first_name", "last_name", "submission_tag"}


def read(download: Download) -> Shape | None:
    """Return the submissions (git clones) beside Classroom 50's `scores.csv`; None without such a file, or without its columns."""
    data = download.read(SCORES, MAX_SCORES) if SCORES in download.top else None
    try:
        table = tables.titled(data or b"", SCORES, _COLUMNS, _COLUMNS)
        rows = {row["username"].casefold(): row for _, row in table if row.get("username")}
    except RequestError:
        return None
    folders = [name for name, is_folder in download.top.items() if is_folder]
    found = (clone(download, name, _row_of_clone(name, rows)) for name in folders)
    return Shape(TITLE, tuple(found), unassigned(download, SCORES))


def _row_of_clone(folder: str, rows: Mapping[str, dict[str, str]]) -> dict[str, str]:
    """Return the row of a clone `<classroom>-<assignment>-<username>`: that of the longest user name that fits; {} if none does."""
    fits = [user for user in rows if folder.casefold() == user or folder.casefold().endswith(f"-{user}")]
    return rows[max(fits, key=len)] if fits else {}


PLATFORM = Platform(
    name="classroom50",
    title="Classroom 50",
    help=Help(
        respond="""\
    imugrade kit --classroom50 autograder

writes `autograder.py` and the wheel; put both into `CLASSROOM/autograders/ASSIGNMENT/`. Classroom 50 takes whole points: the
total is rounded once, its parts sum to it, and each test carries its `exact-score`. `datetime` is the commit's instant, so a
regrade moves no late mark. The job exits with 0 when it ran. It runs in the student's repository, so it grades on the public
scenarios; grade with hidden ones on your own machine, over the clones.""",
        read=("`gh teacher download`", "`scores.csv` with its columns", "the clone; names and times from `scores.csv`"),
    ),
    respond=_respond,
    recognise=lambda environ, _: all(environ.get(name) for name in ("CLASSROOM", "ASSIGNMENT", "SUBMISSION_TAG")),
    refuse=_refuse,
    answer="result.json",
    read=read,
)
