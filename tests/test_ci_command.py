"""`imugrade ci` from the words to the exit code, with a marker that is made up."""

from __future__ import annotations

import json
import subprocess
from contextlib import nullcontext
from dataclasses import replace
from datetime import datetime, timedelta, timezone
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import pytest

from grader.engine import traces
from grader.engine.results import Result
from grader.labs.imu import bundles
from grader.platforms import job
from grader.sandbox.isolation_levels import LEVELS, NO_ISOLATION, IsolationLevel
from tests.class_commands import Run, in_process
from tests.fake_results import check, lost, result
from tests.hostile.outputs import ENVIRONMENT as ID

LOST_6 = result(check(points=14.0, max_points=14.0, id="sensor_access.a"), lost())


def let_answer(monkeypatch: pytest.MonkeyPatch, answer: Result, isolation: IsolationLevel = LEVELS[0]) -> None:
    """Let the marker give this result, at this isolation level."""
    marker = SimpleNamespace(isolation=isolation, mark=lambda _: answer)
    monkeypatch.setattr(job, "Marker", lambda *_, **__: nullcontext(marker))
    monkeypatch.setattr(job, "open_sandbox_for", lambda *_: None)


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Run:
    """No platform's variables, a submission in the working folder, 14 of 20 points; the hidden traces are at hidden.npz."""
    others = ("GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY", "GITHUB_WORKSPACE", "IMUGRADE_SEED", "IMUGRADE_DEBUG")
    for name in (*ID, *others):
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "imu_reader.py").write_text("\ndef get_imu_readings():\n    pass\n")
    monkeypatch.chdir(tmp_path)
    let_answer(monkeypatch, LOST_6)
    public, load = bundles.shipped(), traces.load
    hidden = replace(public, name="hidden")
    monkeypatch.setattr(traces, "load", lambda path: hidden if str(path) == "hidden.npz" else load(path))
    return in_process(capsys)


def test_github_annotates_the_definition_and_adds_to_the_summary(
    run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    monkeypatch.setenv("GITHUB_WORKSPACE", str(tmp_path.parent))
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path / "summary.md"))
    (tmp_path / "summary.md").write_text("before\n")
    code, out, _ = run("ci")
    assert code == 0
    assert out.startswith(f"::error file={tmp_path.name}/imu_reader.py,line=2,title=")
    public = (tmp_path / "summary.md").read_text()
    assert public.startswith("before\n## Lab 04-01: 14 &#47; 20\n")
    assert run("ci", "--traces", "hidden.npz", "--private")[0] == 0
    hidden = (tmp_path / "summary.md").read_text().removeprefix(public)
    assert ["These are the public checks." in text for text in (public, hidden)] == [True, False]
    assert ["Graded on hidden scenarios." in text for text in (public, hidden)] == [False, True]


def test_the_exit_code_says_whether_the_points_suffice(run: Run) -> None:
    assert [run("ci", "--format", "json", "--min-score", limit)[0] for limit in ("0", "14", "14.01")] == [0, 0, 1]


@pytest.mark.parametrize("platform", ["gradescope", "classroom50"])
def test_no_platform_is_given_a_zero_for_what_was_not_judged(
    platform: str, run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name, value in ID.items():
        monkeypatch.setenv(name, value)
    let_answer(monkeypatch, result(check("not_judged", None), status="incomplete"))
    code, _, err = run("ci", "--format", platform, "-o", "results.json")
    assert code == 3
    assert "failed on a part of the submission, so there is no score to report" in err
    assert not (tmp_path / "results.json").exists()


def test_where_no_platform_is_recognised_the_answer_is_junit_with_the_instant_of_marking_in_the_file_that_is_named(
    run: Run,
) -> None:
    assert run("ci", "-o", "reports/junit.xml") == (0, "reports/junit.xml written: 14 of 20 points\n", "")
    text = Path("reports/junit.xml").read_text(encoding="utf-8")
    assert run("ci")[1].startswith(text[:30])
    at = datetime.fromisoformat(ElementTree.fromstring(text)[0].get("timestamp", ""))
    assert abs(datetime.now(timezone.utc) - at) < timedelta(minutes=5)


def test_classroom50_writes_result_json_with_the_instant_of_the_commit(
    run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    of_git = {
        f"GIT_{who}_{name}": value
        for who in ("AUTHOR", "COMMITTER")
        for name, value in (("NAME", "a"), ("EMAIL", "a@example.org"), ("DATE", "2026-11-01T12:00:00+0200"))
    }
    for name, value in (ID | of_git | {"GIT_AUTHOR_DATE": "2026-10-01T12:00:00Z"}).items():
        monkeypatch.setenv(name, value)
    subprocess.run(["git", "init", "-q", "."], check=True)
    subprocess.run(["git", "commit", "-q", "--allow-empty", "-m", "x"], check=True)
    assert run("ci")[0] == 0
    record = json.loads((tmp_path / "result.json").read_text())
    assert (record["owner"], record["score"], record["datetime"]) == ("alice", 14, "2026-11-01T10:00:00Z")


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ("nowhere --format json", "nowhere: there is no such file or folder; check the path"),
        ("--format jnit", "--format jnit: there is no such format; did you mean junit?"),
        ("--format classroom50", "--format classroom50: CLASSROOM, ASSIGNMENT, SUBMISSION_TAG, COMMIT_URL, RELEASE_URL, OWNER not set; "
                                 "run it from a Classroom 50 autograder"),
        ("--format classroom50 --min-score 5", "--min-score: leave it out; Classroom 50 reads the points from result.json"),
        ("--traces no.npz", "no.json: cannot read the manifest of the traces (No such file or directory)"),
    ],
)  # fmt: skip
def test_a_wrong_request_is_one_line_and_exit_code_2(arguments: str, line: str, run: Run) -> None:
    assert run("ci", *arguments.split()) == (2, "", f"imugrade: {line}\n")


@pytest.mark.parametrize("name", ["github", "classroom50", "junit"])
def test_hidden_scenarios_are_for_a_private_job_where_students_can_read_the_others(
    name: str, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    code, _, err = run("ci", "--format", name, "--traces", "hidden.npz")
    assert code == 2
    assert "hidden scenarios stay out of" in err
    for variable, value in ID.items():
        monkeypatch.setenv(variable, value)
    assert run("ci", "--format", name, "--traces", "hidden.npz", "--private")[0] == 0


@pytest.mark.parametrize("more", [("--format", "gradescope"), ("--format", "junit", "--private")])
def test_hidden_scenarios_are_refused_where_nothing_isolates_the_code(
    more: tuple[str, ...], run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    let_answer(monkeypatch, LOST_6, NO_ISOLATION)
    code, _, err = run("ci", *more, "--traces", "hidden.npz")
    assert code == 2
    assert "this machine cannot keep students' code from reading them" in err
    assert run("ci", *more, "--traces", "hidden.npz", "--trust-submissions")[0] == 0


def test_a_seed_in_the_environment_does_not_bring_hidden_scenarios_into_ci(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[Any] = []
    monkeypatch.setenv("IMUGRADE_SEED", "secret")
    monkeypatch.setattr(bundles, "obtain", lambda lab, seed, model: seen.append(seed) or bundles.shipped())
    assert run("ci")[0] == 0
    assert seen == [None]
