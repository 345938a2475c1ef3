"""`imugrade ci` from the words to the exit code, with a marker that is made up."""

from __future__ import annotations

import json
import subprocess
from dataclasses import replace
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from grader import cli
from grader.engine import traces
from grader.engine.results import Result
from grader.engine.rubric import Rubric
from grader.engine.traces import Traces
from grader.labs.imu import bundles
from grader.platforms import job
from grader.sandbox.isolation_levels import LEVELS, NO_ISOLATION
from tests.fake_results import check, lost, result
from tests.test_ci_formats import ID


class Given:
    """Stands in for the marker: gives the result that the test wants, and the isolation level that it says."""

    answer: Result
    isolation = LEVELS[0]

    def __init__(self, rubric: Rubric, bundle: Traces, *, sandbox: object) -> None:
        pass

    def __enter__(self) -> Given:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def mark(self, submission: object) -> Result:
        return type(self).answer


@pytest.fixture(autouse=True)
def alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No platform's variables, a submission in the working folder, 14 of 20 points."""
    others = (
        "GITHUB_ACTIONS",
        "GITLAB_CI",
        "GITHUB_STEP_SUMMARY",
        "GITHUB_WORKSPACE",
        "IMUGRADE_SEED",
        "IMUGRADE_DEBUG",
    )
    for name in (*ID, *others):
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "imu_reader.py").write_text("\ndef get_imu_readings():\n    pass\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(job, "Marker", Given)
    monkeypatch.setattr(job, "open_sandbox_for", lambda lab, files, isolation_level: None)
    monkeypatch.setattr(Given, "isolation", LEVELS[0])
    answer = result(check(points=14.0, max_points=14.0, id="sensor_access.a"), lost())
    monkeypatch.setattr(Given, "answer", answer, raising=False)


@pytest.fixture
def secret(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The path of a bundle that is not the public one."""
    public = bundles.shipped()
    monkeypatch.setattr(traces, "load", lambda path: replace(public, name="hidden"))
    return str(tmp_path / "hidden.npz")


def test_github_annotates_the_definition_and_adds_to_the_summary(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    monkeypatch.setenv("GITHUB_WORKSPACE", str(tmp_path.parent))
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path / "summary.md"))
    (tmp_path / "summary.md").write_text("before\n")
    assert cli.main(["ci"]) == 0
    assert capsys.readouterr().out.startswith(f"::error file={tmp_path.name}/imu_reader.py,line=2,title=")
    assert (tmp_path / "summary.md").read_text().startswith("before\n## Lab 04-01: 14 &#47; 20\n")


@pytest.mark.parametrize(("limit", "code"), [("14", 0), ("14.01", 1), ("0", 0)])
def test_the_exit_code_says_whether_the_points_suffice(limit: str, code: int) -> None:
    assert cli.main(["ci", "--format", "json", "--min-score", limit]) == code


def test_gradescope_gets_no_file_for_what_was_not_judged(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(Given, "answer", result(check("not_judged", None), status="incomplete"))
    assert cli.main(["ci", "--format", "gradescope", "-o", str(tmp_path / "results.json")]) == 3
    assert not (tmp_path / "results.json").exists()
    assert "failed on a part of the submission, so there is no score to report" in capsys.readouterr().err


def test_junit_goes_to_the_file_that_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["ci", "-f", "junit", "-o", "reports/junit.xml"]) == 0
    assert (tmp_path / "reports/junit.xml").read_text().startswith("<?xml")
    assert capsys.readouterr().out == "reports/junit.xml written: 14 of 20 points\n"


def test_where_no_platform_is_recognised_the_answer_is_junit_with_the_instant_of_marking(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cli.main(["ci"]) == 0
    (suite, _) = ElementTree.fromstring(capsys.readouterr().out)
    at = datetime.fromisoformat(suite.get("timestamp", ""))
    assert abs(datetime.now(timezone.utc) - at) < timedelta(minutes=5)


def test_classroom50_writes_result_json_with_the_instant_of_the_commit(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name, value in ID.items():
        monkeypatch.setenv(name, value)
    for key in ("AUTHOR", "COMMITTER"):
        monkeypatch.setenv(f"GIT_{key}_NAME", "a")
        monkeypatch.setenv(f"GIT_{key}_EMAIL", "a@example.org")
        monkeypatch.setenv(f"GIT_{key}_DATE", "2026-11-01T12:00:00+0200")
    subprocess.run(["git", "init", "-q", "."], check=True)
    subprocess.run(["git", "commit", "-q", "--allow-empty", "-m", "x"], check=True)
    assert cli.main(["ci"]) == 0
    record = json.loads((tmp_path / "result.json").read_text())
    assert (record["owner"], record["score"], record["datetime"]) == ("alice", 14, "2026-11-01T10:00:00Z")


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["nowhere", "--format", "json"], "imugrade: nowhere: there is no such file or folder; check the path\n"),
        (["--format", "jnit"], "imugrade: --format jnit: there is no such format; did you mean junit?\n"),
        (["--format", "classroom50"], "imugrade: --format classroom50: CLASSROOM, ASSIGNMENT, SUBMISSION_TAG, COMMIT_URL, "
                                      "RELEASE_URL, OWNER not set; run it from a Classroom 50 autograder\n"),
        (["--format", "classroom50", "--min-score", "5"], "imugrade: --min-score: leave it out; Classroom 50 reads the points from "
                                                          "result.json\n"),
        (["--visibility", "never"], "imugrade: --visibility never: there are visible, after_due_date, after_published, hidden\n"),
        (["--traces", "no.npz"], "imugrade: no.json: cannot read the manifest of the traces (No such file or directory)\n"),
    ],
)  # fmt: skip
def test_a_wrong_request_is_one_line_and_exit_code_2(
    arguments: list[str], line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["ci", *arguments]) == 2
    assert capsys.readouterr().err == line


@pytest.mark.parametrize("name", ["github", "classroom50", "junit"])
def test_hidden_scenarios_are_refused_where_students_can_read_them(
    name: str, secret: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["ci", "--format", name, "--traces", secret]) == 2
    assert "hidden scenarios stay out of" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["github", "junit"])
def test_hidden_scenarios_are_graded_with_in_a_private_job_of_the_instructors(name: str, secret: str) -> None:
    assert cli.main(["ci", "--format", name, "--traces", secret, "--private"]) == 0


@pytest.mark.parametrize("more", [("--format", "gradescope"), ("--format", "junit", "--private")])
def test_hidden_scenarios_are_refused_where_nothing_isolates_the_code(
    more: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, secret: str, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(Given, "isolation", NO_ISOLATION)
    assert cli.main(["ci", *more, "--traces", secret]) == 2
    assert "this machine cannot keep students' code from reading them" in capsys.readouterr().err
    assert cli.main(["ci", *more, "--traces", secret, "--trust-submissions"]) == 0


def test_a_seed_in_the_environment_does_not_bring_hidden_scenarios_into_ci(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    seen: list[Any] = []
    monkeypatch.setenv("IMUGRADE_SEED", "secret")
    monkeypatch.setattr(bundles, "obtain", lambda lab, seed, model: seen.append(seed) or bundles.shipped())
    assert cli.main(["ci"]) == 0
    assert seen == [None]
