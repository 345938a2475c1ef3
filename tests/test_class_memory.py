"""A class remembers what it was graded by: nothing changes a score on record without being told and agreed to."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from grader.base.errors import RequestError
from grader.course.record.database import FILE_NAME
from grader.course.run.class_grading import settings_on_record
from grader.course.run.secret_strength import guessable
from grader.desk.overviews import queue
from grader.engine.traces import Traces
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.platforms.gradescope import gradescope
from tests.class_commands import CHECK, Run, column, commands, graded, hand_in, late_policy, rubric_with
from tests.conftest import SECRET
from tests.desk import desk_over, words
from tests.fake_results import result

HEAVIER = ("follows_recursion: 6", "follows_recursion: 9")
DUE = "due: 2026-11-20T12:00Z"
LATE = late_policy(DUE)
ROSTER = "id,name,submitted\nalice,Alice A,2026-11-21T13:00Z\nbob,Bob B,2026-11-20T11:00Z\n"


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], ran: list[str], tmp_path: Path) -> Run:
    monkeypatch.chdir(tmp_path)
    hand_in(tmp_path / "class", alice=1, bob=0.5, carol=0)
    return commands(monkeypatch, capsys, ran)


def totals(title: str = "total") -> dict[str, float]:
    return {id_: float(cell) for id_, cell in column(Path("out/gradebook.csv"), title).items()}


def refused(run: Run, *more: object) -> str:
    """What is said of a run that is refused."""
    code, _, err = run("grade", "class", "-o", "out", *more)
    assert code == 2
    return err


@pytest.fixture
def before(run: Run, tmp_path: Path) -> dict[str, float]:
    """Scores of a class that was graded by a rubric of its own."""
    rubric_with(tmp_path / "rub.yaml", HEAVIER)
    graded(run, "--rubric", "rub.yaml")
    return totals()


def test_rubric_roster_and_attempt_rule_of_a_class_need_not_be_given_again_and_others_are_told(
    run: Run, ran: list[str]
) -> None:
    rubric_with(Path("late.yaml"), HEAVIER, LATE)
    graded(run, "--rubric", "late.yaml", "--attempts", "best", roster=ROSTER)
    before = totals("final")
    assert before["alice"] == 80.0
    Path("late.yaml").unlink()
    Path("roster.csv").unlink()
    for _ in range(2):
        assert graded(run) == (
            "imugrade: the late policy deducts nothing from 1 of 3 hand-ins: their time is unknown (add a column `submitted` to the roster)\n"
            "imugrade: 1 warning, unchanged since the last run (`imugrade review` lists them)\n"
        )
    assert totals("final") == before
    hand_in(Path("class"), dora=0.5)
    graded(run)
    assert (totals("final"), ran) == ({**before, "dora": before["bob"]}, ["alice", "bob", "carol", "dora"])
    assert "another attempt rule (latest in place of best)" in refused(run, "--attempts", "latest")
    Path("roster.csv").write_text(ROSTER.replace("11-20T11", "11-20T13"))
    assert "another roster: 1 of 4 scores change, mean" in refused(run, "--roster", "roster.csv")
    assert totals("final")["bob"] == before["bob"]


def test_files_that_are_current_are_left_and_changed_or_missing_ones_are_written_again(run: Run) -> None:
    graded(run)
    files = {path: (path.read_bytes(), path.stat().st_mtime_ns) for path in Path("out").glob("submissions/*/*")}
    assert len(files) == 2 * 3
    Path("out/submissions/alice/report.html").write_text("another page")
    Path("out/submissions/bob/result.json").unlink()
    graded(run)
    assert {path: path.read_bytes() for path in files} == {path: content for path, (content, _) in files.items()}
    assert {path.parent.name for path, (_, at) in files.items() if path.stat().st_mtime_ns != at} == {"alice", "bob"}


def test_another_rubric_is_told_waits_for_consent_and_is_for_all(
    run: Run, before: dict[str, float], ran: list[str]
) -> None:
    rubric_with(Path("asks.yaml"), HEAVIER, ("submission_cpu_s: 120", "submission_cpu_s: 60"))
    assert "another rubric: 3 on record are graded again" in refused(run, "--rubric", "asks.yaml")
    rubric_with(Path("rub2.yaml"))
    assert refused(run, "--rubric", "rub2.yaml", "--only", "bob", "--change").startswith(
        "imugrade: --only cannot change the settings of the whole class"
    )
    err = refused(run, "--rubric", "rub2.yaml")
    told = f"another rubric: 2 of 3 scores change, mean of graded {sum(before.values()) / 3:.1f} to"
    assert err.startswith(f"imugrade: {told}")
    assert err.endswith("Nothing was changed\n")
    assert totals() == before
    code, out, err = run("grade", "class", "-o", "out", "--rubric", "rub2.yaml", "--dry-run")
    assert (code, err) == (0, "")
    assert out.splitlines()[0] == "0 would be graded · 3 on record"
    assert told in out.splitlines()[1]
    assert totals() == before
    assert told in graded(run, "--rubric", "rub2.yaml", "--change")
    assert totals()["alice"] == before["alice"] == 100.0
    assert totals()["bob"] > before["bob"]
    assert ran == ["alice", "bob", "carol"]


def test_a_yes_on_a_terminal_is_consent(run: Run, before: dict[str, float], monkeypatch: pytest.MonkeyPatch) -> None:
    rubric_with(Path("rub2.yaml"))
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    asked: list[str] = []
    answers = iter([False, True])
    monkeypatch.setattr("typer.confirm", lambda text: asked.append(text) or next(answers))
    refused(run, "--rubric", "rub2.yaml")
    assert totals() == before
    graded(run, "--rubric", "rub2.yaml")
    assert totals()["bob"] > before["bob"]
    assert len(asked) == 2
    assert asked[0].endswith(". Change them?")


def test_the_version_before_stays_and_diff_compares_with_it_and_says_a_changed_weight_once(
    run: Run, before: dict[str, float]
) -> None:
    told = "imugrade: out: no change of the settings has changed a score; give two folders to compare\n"
    assert run("diff", "out") == (2, "", told)
    rubric_with(Path("rub2.yaml"), ("follows_recursion: 6", "follows_recursion: 12"))
    hand_in(Path("class"), alice=0)
    graded(run, "--rubric", "rub2.yaml", "--change")
    code, out, _ = run("diff", "out")
    assert code == 0
    assert f"bob  {before['bob']:g} → {totals()['bob']:g}" in out
    assert out.startswith("changed for all: the rubric\n")
    assert "3 of 3 moved" in out
    lines = out.splitlines()
    assert lines.count(f"{CHECK}  worth 7.82 → 9.23 points") == 1
    assert f"  {CHECK}  passed 7.82 / 7.82 → failed 0 / 9.23" in lines
    assert sum(line.startswith(f"  {CHECK}") for line in lines) == 1


def test_without_its_secret_a_class_is_not_graded(
    run: Run, ran: list[str], monkeypatch: pytest.MonkeyPatch, hidden: Traces
) -> None:
    monkeypatch.setenv("IMUGRADE_SEED", SECRET)
    graded(run)
    scores, so_far = totals(), list(ran)
    assert SECRET not in Path("out", FILE_NAME).read_bytes().decode("latin-1")
    hand_in(Path("class"), dora=1)
    monkeypatch.delenv("IMUGRADE_SEED")
    without = "imugrade: the class on record was graded on hidden scenarios; set IMUGRADE_SEED"
    for more in ((), ("--change",), ("--dry-run",)):
        assert refused(run, *more).startswith(without)
    monkeypatch.setenv("IMUGRADE_SEED", "another secret")
    told = "other scenarios (another secret or model, or another version of MuJoCo or imugrade): 3 on record are graded again"
    with monkeypatch.context() as here:  # what another secret records takes seconds to make
        here.setattr(bundles, "obtain", lambda *_, **__: replace(hidden, sha256="another"))
        assert told in refused(run)
        with pytest.raises(RequestError, match="the class on record was graded on other scenarios"):
            settings_on_record(LAB, Path("out"), "another secret")
    assert (totals(), ran) == (scores, so_far)
    monkeypatch.setenv("IMUGRADE_SEED", SECRET)
    graded(run)
    assert ran == [*so_far, "dora"]


def test_a_weaker_isolation_level_than_that_of_the_class_is_refused(run: Run, before: dict[str, float]) -> None:
    hand_in(Path("class"), dora=None)
    command = [sys.executable, "-m", "grader", "grade", "class", "-o", "out", "-j1"]
    command += ["--isolation", "none", "--trust-submissions"]
    refused = subprocess.run(command, capture_output=True, text=True, check=False)
    assert refused.returncode == 2
    assert "the class was graded at the isolation level full, and this machine offers none" in refused.stderr
    assert totals() == before
    done = subprocess.run([*command, "--change"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert column(Path("out/gradebook.csv"), "total").keys() == {*before, "dora"}


def test_dates_that_come_later_grade_nothing_and_the_mean_is_that_of_the_final_grades_of_the_graded_everywhere(
    run: Run, tmp_path: Path, ran: list[str]
) -> None:
    hand_in(tmp_path / "class", dora=None)
    graded(run)
    rubric_with(tmp_path / "late.yaml", LATE)
    told = graded(run, "--rubric", "late.yaml", "--change", roster=ROSTER)
    assert "another late policy, a roster: 1 of 4 scores change, mean of graded 97.0 to 90.3\n" in told
    assert "mean of graded 90.3\n" in run("grade", "class", "-o", "out")[1]
    assert "mean of graded 90.3" in words(Path("out/index.html").read_text(encoding="utf-8"))
    rubric_with(tmp_path / "later.yaml", late_policy(DUE, "20%"))
    assert "mean of graded 90.3 to 83.7\n" in graded(run, "--rubric", "later.yaml", "--change")
    assert "mean of graded 90.3 → 83.7\n" in run("diff", "out")[1]
    with desk_over(Path("out").absolute()) as desk:
        assert "mean of graded 83.7 → 90.3" in words(desk.get("/what-if?late:per_day=10%25").text)
        assert desk.post("/what-if", {f"weight:{CHECK}": "9", "do": "mark"}).status == 303
        desk.book.settled()
    final = column(Path("out/gradebook.csv"), "final")
    assert final["alice"] == "60"  # the late policy stays
    graded(run)
    assert column(Path("out/gradebook.csv"), "final") == final
    assert sorted(ran) == ["alice", "bob", "carol", "dora"]


@pytest.mark.parametrize(
    "secret",
    ["a-secret", "...", "internationalization", "Password2026!", "another secret", "123456789012345", "ababababababab"],
)
def test_a_secret_that_can_be_guessed_is_refused_before_anything_is_graded(
    run: Run, monkeypatch: pytest.MonkeyPatch, secret: str
) -> None:
    monkeypatch.setenv("IMUGRADE_SEED", secret)
    for command in (("grade", "class", "-o"), ("kit", "--gradescope"), ("traces", "record", "-o")):
        code, _, err = run(*command, "out")
        told = err.startswith("imugrade: the secret in IMUGRADE_SEED can be guessed: it ")
        assert (code, told) == (2, True), command
    assert not Path("out").exists()


@pytest.mark.parametrize("secret", ["37970201460518101fcb681721997cf3", "correct horse battery staple", SECRET])
def test_random_characters_and_four_words_are_a_secret(secret: str) -> None:
    assert guessable(secret) == ""


def test_nothing_that_a_student_gets_holds_a_digest_of_hidden_traces(
    run: Run, monkeypatch: pytest.MonkeyPatch, hidden: Traces
) -> None:
    monkeypatch.setenv("IMUGRADE_SEED", SECRET)
    with monkeypatch.context() as here:
        here.setattr(bundles, "obtain", lambda *_, **__: hidden)
        graded(run)
    for name in ("result.json", "report.html"):
        assert hidden.sha256[:16] not in Path("out/submissions/alice", name).read_text(encoding="utf-8")
    extra = gradescope(replace(result(), provenance={"traces_sha256": hidden.sha256, "hidden": True}), hidden=True)
    assert hidden.sha256[:16] not in extra


def test_a_folder_of_results_is_its_owners_alone(run: Run) -> None:
    graded(run)
    assert Path("out").stat().st_mode & 0o077 == 0


# ---- what people said ----


def test_an_override_says_that_the_weight_beneath_it_has_changed(run: Run, before: dict[str, float]) -> None:
    wish = ("--criterion", CHECK, "--points", 2, "--comment", "seen in the lab hour")
    assert run("adjust", "out", "carol", *wish)[0] == 0
    assert graded(run) == ""
    rubric_with(Path("rub2.yaml"), ("follows_recursion: 6", "follows_recursion: 12"))
    now = "the automatic points are now 0 / 9.23. Adjust it again or withdraw it\n"
    told = f"imugrade: carol: {CHECK} was overridden with 2 when it had 0 / 7.82; {now}"
    assert told in graded(run, "--rubric", "rub2.yaml", "--change")
    assert totals("adjusted")["carol"] == 92.77  # 2 of 9.23
    assert told in graded(run)
    with desk_over(Path("out").absolute()) as desk:
        assert f"{CHECK} was set to 2" in words(desk.get("/").text)
    assert run("adjust", "out", "carol", *wish)[0] == 0
    assert graded(run) == ""


def test_an_override_above_its_maximum_is_told_wherever_it_comes_from_and_stops_an_export(
    run: Run, before: dict[str, float]
) -> None:
    assert run("adjust", "out", "alice", "--criterion", "filtering", "--points", 19, "--comment", "seen")[0] == 0
    rubric_with(Path("less.yaml"), ("title: Filtering\n    points: 20", "title: Filtering\n    points: 15"))
    why = "alice: the override of filtering with 19 is above its maximum, which is now 15; override it again or withdraw it"
    assert f"imugrade: {why}\n" in graded(run, "--rubric", "less.yaml", "--change")
    assert why in words(Path("out/index.html").read_text(encoding="utf-8"))
    export = ("export", "out", "-f", "csv", "-o", "marks.csv")
    code, _, err = run(*export)
    assert (code, why in err, Path("marks.csv").exists()) == (2, True, False)
    assert run(*export, "--anyway")[0] == 0
    assert run("adjust", "out", "alice", "--criterion", "filtering", "--points", 15, "--comment", "seen")[0] == 0
    assert run(*export)[0] == 0


def test_an_empty_submission_that_was_marked_as_reviewed_is_exported(run: Run, before: dict[str, float]) -> None:
    hand_in(Path("class"), dora=None)
    graded(run)
    assert column(Path("out/gradebook.csv"), "total")["dora"] == ""
    assert run("export", "out", "-f", "csv", "-o", "marks.csv")[:2] == (0, "marks.csv  3 grades, 1 blank\n")
    pages = [Path("out/index.html"), Path("out/submissions/dora/report.html")]
    assert [page.read_text(encoding="utf-8").count("– <small>/ 100") for page in pages] == [0, 1]
    assert "dora – – – – – – empty" in words(pages[0].read_text(encoding="utf-8"))
    with desk_over(Path("out").absolute()) as desk:
        assert "dora – / 100" in words(desk.get("/submission/dora").text)
        looks = desk.book.on_thread(lambda: queue(desk.book))
        (key,) = [look.key for look in looks if look.reason.kind == "empty"]
        assert desk.post("/reviewed", {"look": key, "done": "yes"}).status == 303
        desk.book.settled()
    assert column(Path("out/gradebook.csv"), "total")["dora"] == "0"
    assert "dora 0 0 0 0 0 0 empty" in words(pages[0].read_text(encoding="utf-8"))
    assert "0 <small>/ 100" in pages[1].read_text(encoding="utf-8")
    code, _, err = run("export", "out", "-f", "csv", "-o", "marks.csv")
    assert (code, err) == (0, "imugrade: graded: 4\n")
    assert column(Path("marks.csv"), "final")["dora"] == "0"


def test_a_download_of_resubmissions_reports_nobody_as_missing(run: Run, tmp_path: Path) -> None:
    roster = "id,name\nalice,Alice A\nbob,Bob B\ncarol,Carol C\ndora,Dora D\n"
    assert "no submission: Dora D\n" in graded(run, roster=roster)
    hand_in(tmp_path / "again", bob=0.25)
    err = graded(run, folder="again", roster=roster.replace("Alice A", "Alice Adams"))
    assert column(Path("out/gradebook.csv"), "name")["alice"] == "Alice Adams"
    assert "Alice Adams" in Path("out/submissions/alice/report.html").read_text(encoding="utf-8")
    assert err.splitlines() == [
        "imugrade: another roster: no score changes",
        "imugrade: other files than on record count now: bob (97 → 95.5)",
        "imugrade: 1 warning, unchanged since the last run (`imugrade review` lists them)",
    ]
    lines = run("export", "out", "-f", "csv", "-o", "marks.csv")[2].splitlines()
    assert lines[1] == "imugrade: blank: 1 (Dora D: no submission)"


def test_an_older_download_that_brings_earlier_files_back_is_told(run: Run, tmp_path: Path) -> None:
    hand_in(tmp_path / "class", dora=1.0)
    graded(run)
    hand_in(tmp_path / "again", bob=1, carol=0)  # half of the class
    err = graded(run, folder="again")
    assert "count now: bob (97 → 100)\n" in err
    assert "on record and in the gradebook, but not in this download: alice; dora\n" in err
    told = "other files than on record would count: bob\n"
    assert run("grade", "class", "-o", "out", "--dry-run")[1] == f"0 would be graded · 4 on record\n{told}"
    assert graded(run) == "imugrade: other files than on record count now: bob (100 → 97)\n"
    assert "other files" not in graded(run)


def test_those_who_are_not_in_the_download_stay_as_they_are_and_that_is_told(
    run: Run, before: dict[str, float]
) -> None:
    rubric_with(Path("rub2.yaml"))
    hand_in(Path("again"), bob=0.5)
    change = "1 of 1 scores change, mean of graded 96.1 to 97.0, 2 not in the download stay as they are"
    assert f"another rubric: {change}\n" in graded(run, "--rubric", "rub2.yaml", "--change", folder="again")
    assert totals() == {**before, "bob": 97.0}
    others = "imugrade: graded by other settings than the class: alice, carol (grade them again)\n"
    assert run("export", "out", "-f", "csv", "-o", "marks.csv")[2] == f"imugrade: graded: 3\n{others}"
    graded(run)
    assert run("export", "out", "-f", "csv", "-o", "marks.csv")[2] == "imugrade: graded: 3\n"
