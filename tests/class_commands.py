"""The commands of a class in this process, with a made-up marker: what it finds stands in the submission."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from grader import __version__, cli
from grader.course.markers.pool import Bounds
from grader.course.run import classroom
from grader.engine.findings import Where
from grader.engine.marks import marked
from grader.engine.results import Result
from grader.engine.rubric import Rubric
from grader.engine.traces import Traces
from grader.intake import Submission
from tests.desk import Student, result_of
from tests.rubrics import SHIPPED, edited

Run = Callable[..., tuple[int, str, str]]
Mark = Callable[[Submission, Rubric, Traces], Result]
CHECK = "filtering.follows_recursion"
STOPS = {
    "outcome": "error",
    "expected": "no exception",
    "got": "NameError: name 'x' is not defined at filters.py, line 1",
    "where": Where("filters.py", 1),
}
NO_SEED = "imugrade: no seed: graded on the public scenarios only, which students have too (set IMUGRADE_SEED)\n"


def in_process(capsys: pytest.CaptureFixture[str]) -> Run:
    """Run `imugrade` in this process; its exit code, stdout and stderr."""

    def command(*arguments: object) -> tuple[int, str, str]:
        code = cli.main([str(argument) for argument in arguments])
        return code, *capsys.readouterr()

    return command


def result_by_comment(submission: Submission, rubric: Rubric, traces: Traces) -> Result:
    """A result that keeps of `CHECK` what the comment in filters.py says."""
    said = submission.files.get("filters.py", b"# 1").decode().strip("# \r\n")
    if submission.status != "ready" or said == "nothing":
        made = result_of(Student(submission.id, dict.fromkeys((c.id for c in rubric.checks), 0.0), status="empty"))
    else:
        says = {CHECK: STOPS} if said == "stops" else {}
        made = result_of(Student(submission.id, {CHECK: 0.0 if says else float(said)}, says))
    provenance = {
        "grader": __version__,
        "rubric_sha256": rubric.sha256,
        "traces_sha256": traces.sha256,
        "submission_sha256": submission.sha256,
        "isolation": "full",
        **({"hidden": True} if traces.name != "public" else {}),
    }
    return marked(replace(made, submission=submission.name, provenance=provenance), rubric)


def commands(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    ran: list[str] | None = None,
    mark: Mark = result_by_comment,
) -> Run:
    """Run `imugrade` in this process with a made-up marker, which puts the ids into `ran`; nothing is said of a missing seed."""

    def mark_all(submissions, opener, jobs: int, bounds: Bounds):  # type: ignore[no-untyped-def] # as the pool has it
        rubric, traces = opener.args[:2]
        for each in submissions:
            (ran if ran is not None else []).append(each.id)
            yield each, mark(each, rubric, traces)

    def command(*arguments: object) -> tuple[int, str, str]:
        code, out, err = run(*arguments)
        return code, out, err.replace(NO_SEED, "")

    run = in_process(capsys)
    monkeypatch.delenv("IMUGRADE_SEED", raising=False)
    monkeypatch.setattr(classroom, "mark_all", mark_all)
    return command


def hand_in(root: Path, **kept: object) -> Path:
    """A folder for each, with the share of `CHECK` that it keeps; None is an empty folder."""
    for name, each in kept.items():
        (root / name).mkdir(parents=True, exist_ok=True)
        if each is not None:
            (root / name / "filters.py").write_text(f"# {each}\n")
    return root


def rubric_with(path: Path, *edits: tuple[str, str]) -> Path:
    """The shipped rubric with these edits."""
    text = SHIPPED
    for old, new in edits:
        text = edited(old, new, text)
    path.write_text(text, encoding="utf-8")
    return path


def late_policy(due: str, per_day: str = "10%") -> tuple[str, str]:
    """The edit of the shipped rubric that gives it a late policy."""
    return "# late:\n", f"late: {{{due}, per_day: {per_day}}}\n# late:\n"


def graded(run: Run, *more: object, folder: object = "class", roster: str = "") -> str:
    """Grade the folder into out, by a roster of this text if there is one; what is said on stderr."""
    if roster:
        Path("roster.csv").write_text(roster, encoding="utf-8")
        more = ("--roster", "roster.csv", *more)
    code, _, err = run("grade", folder, "-o", "out", *more)
    assert code == 0, err
    return err


def cells(table: Path | str, *titles: str) -> list[tuple[str, ...]]:
    """What stands in the columns of these titles, a line each."""
    with open(table, encoding="utf-8-sig", newline="") as stream:
        return [tuple(row[title] for title in titles) for row in csv.DictReader(stream)]


def column(table: Path, title: str, key: str = "id") -> dict[str, str]:
    return dict(cells(table, key, title))  # type: ignore[arg-type] # pairs
