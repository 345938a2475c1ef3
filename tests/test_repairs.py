"""Repairs: a person's patch, graded by the ordinary path, less a deduction; the record keeps what was handed in."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime, timezone
from importlib.resources import files
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import jsonschema
import pytest

from grader.course.repairs import renewing
from grader.course.repairs.suggestions import Suggestion
from grader.course.run import classroom
from grader.engine.results import from_dict, to_json
from grader.platforms.gradescope import gradescope
from grader.platforms.junit import junit
from tests.class_commands import Run, column, commands, hand_in, result_by_comment, rubric_with

FIXED, WORSE = "# 1\n", "# 0\n"
WHY = ("--comment", "a colon was missing", "--author", "Eve")


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], ran: list[str], tmp_path: Path) -> Run:
    """A graded class; `ran` holds what was graded: by the class, ids; by a repair, the text of filters.py."""

    @contextmanager
    def marker(rubric: Any, traces: Any, *_: Any) -> Iterator[Any]:
        def mark(submission: Any, cpu_s: float | None = None) -> Any:
            ran.append(submission.files["filters.py"].decode())
            return result_by_comment(submission, rubric, traces)

        yield SimpleNamespace(mark=mark)

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(classroom, "guarded_marker", marker)
    hand_in(tmp_path / "class", alice=0.5, bob=1)
    (tmp_path / "fixed.py").write_text(FIXED)
    command = commands(monkeypatch, capsys, ran)
    assert command("grade", "class", "-o", "out")[0] == 0
    return command


def result(id_: str = "alice") -> dict[str, Any]:
    found: dict[str, Any] = json.loads(Path("out", "submissions", id_, "result.json").read_text())
    return found


def total(id_: str = "alice") -> float:
    return float(column(Path("out/gradebook.csv"), "total")[id_])


def repaired(run: Run, *more: object, deduct: float = 1) -> tuple[int, str, str]:
    return run("repair", "out", "alice", "filters.py", *(more or ("--with", "fixed.py")), "--deduct", deduct, *WHY)


def test_the_repaired_copy_counts_less_the_deduction_and_the_report_shows_what_was_changed(run: Run) -> None:
    before = total()
    code, out, _ = repaired(run)
    assert (code, out) == (0, f"alice: filters.py repaired, {before:g} points before, 99 points now\n")
    assert (total(), total("bob")) == (99.0, 100.0)
    assert column(Path("out/gradebook.csv"), "repair_deduction") == {"alice": "1", "bob": "0"}
    told = result()
    jsonschema.validate(told, json.loads(files("grader.engine").joinpath("result.schema.json").read_text()))
    (repair,) = told["repairs"]
    assert repair.pop("at")
    assert repair == {
        "file": "filters.py",
        "diff": "--- a/filters.py\n+++ b/filters.py\n@@ -1 +1 @@\n-# 0.5\n+# 1\n",
        "deduction": 1.0,
        "author": "Eve",
        "comment": "a colon was missing",
        "score_before": before,
    }
    assert told["score"] == 99.0
    assert "repairs" not in result("bob")
    pages = {id_: Path("out", "submissions", id_, "report.html").read_text() for id_ in ("alice", "bob")}
    section = pages["alice"].partition('<h2 id="repairs">')[2].partition("</section>")[0]
    assert '<p class="num">−1</p>' in section
    assert "Eve: a colon was missing" in section
    assert f"never below {before:g}, the score of the files that you handed in" in section
    assert '<span class="removed">-# 0.5\n</span><span class="added">+# 1\n</span>' in section
    assert '<h2 id="repairs">' not in pages["bob"]


def test_a_repair_that_earns_less_is_refused_and_the_final_grade_is_never_below_the_original(run: Run) -> None:
    before = total()
    Path("worse.py").write_text(WORSE)
    code, _, err = repaired(run, "--with", "worse.py")
    assert (code, total()) == (2, before)
    assert "nothing was recorded" in err
    assert run("repair", "out", "--list")[1] == "no repairs on record\n"
    assert repaired(run, deduct=100)[0] == 0
    assert (total(), result()["score"]) == (before, before)


def test_a_repair_is_listed_and_taken_back(run: Run) -> None:
    before, page = total(), Path("out/submissions/alice/report.html").read_text()
    repaired(run)
    out = run("repair", "out", "--list")[1]
    assert out.startswith("alice filters.py -1  ")
    assert " by Eve: a colon was missing\n    @@ -1 +1 @@\n    -# 0.5\n    +# 1\n" in out
    assert run("repair", "out", "alice", "--undo", "--author", "Frank")[1] == (
        f"alice: repair of filters.py taken back, {before:g} points now\n"
    )
    assert (total(), Path("out/submissions/alice/report.html").read_text()) == (before, page)
    assert "repairs" not in result()
    assert "(taken back by Frank at " in run("repair", "out", "--list")[1]
    assert run("repair", "out", "alice", "--undo")[0] == 2


def test_a_second_repair_is_made_on_the_first(run: Run, ran: list[str]) -> None:
    Path("half.py").write_text("# 0.75\n")
    repaired(run, "--with", "half.py")
    code, _, _ = repaired(run)
    assert (code, total(), ran[-2:]) == (0, 98.0, ["# 0.75\n", "# 1\n"])
    assert [repair["diff"].splitlines()[-2:] for repair in result()["repairs"]] == [
        ["-# 0.5", "+# 0.75"],
        ["-# 0.75", "+# 1"],
    ]
    run("repair", "out", "alice", "--undo")
    assert result()["score"] < 98.0
    assert len(result()["repairs"]) == 1


def test_a_regrade_keeps_the_repair_and_another_version_of_the_file_ends_it_and_that_is_told(
    run: Run, ran: list[str]
) -> None:
    repaired(run)
    ran.clear()
    assert run("grade", "class", "-o", "out")[0] == 0
    assert (total(), ran) == (99.0, [])
    assert run("grade", "class", "-o", "out", "--only", "alice", "--force")[0] == 0
    assert (total(), ran) == (99.0, ["alice"])
    hand_in(Path("class"), alice=0.25)
    code, _, err = run("grade", "class", "-o", "out")
    assert code == 0
    told = "alice: the repair of filters.py by Eve does not count: the student handed in another version of the file"
    assert told in err
    assert "repairs" not in result()
    for own, points in ((1, 100.0), (0.5, 99.0)):  # repaired by the student, and as it was before
        hand_in(Path("class"), alice=own)
        run("grade", "class", "-o", "out")
        assert total() == points


WRONG = {
    "alice fliters.py --with fixed.py": "alice has no file fliters.py (did you mean filters.py?)",
    "nobody filters.py --with fixed.py": "repair: no submission nobody",
    "alice filters.py": "give the repaired file with --with",
    "alice filters.py --with fixed.py --deduct -1": "--deduct takes points from 0 to 100",
    "bob filters.py --with fixed.py": "nothing in filters.py changes",
}


def test_a_wrong_request_is_refused_in_one_line(run: Run) -> None:
    for arguments, said in WRONG.items():
        code, _, err = run("repair", "out", *arguments.split(), *WHY)
        assert (code, err.count("\n")) == (2, 1)
        assert said in err


# ---- repairs that the rubric applies ----

SUGGESTED = ("# repairs:\n#   apply: suggested # or none\n#   deduct: 5", "repairs:\n  apply: suggested\n  deduct: 5")


@pytest.fixture
def suggestions(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Ids for which a repair was looked for; one is always found."""
    asked: list[str] = []

    def suggest(handed_in: Any, original: Any, lab: Any, mark: Any) -> Suggestion:
        asked.append(handed_in.id)
        made = mark(replace(handed_in, files={**handed_in.files, "filters.py": FIXED.encode()}))
        return Suggestion("filters.py", FIXED.encode(), "", made, 0)

    monkeypatch.setattr(renewing, "suggest", suggest)
    return asked


def test_a_suggested_repair_is_applied_only_if_the_rubric_says_so_and_stays_taken_back(
    run: Run, suggestions: list[str]
) -> None:
    Path("class/alice/filters.py").write_text("stops\n")
    run("grade", "class", "-o", "out")
    assert (total(), suggestions) == (94.0, [])
    rubric_with(Path("auto.yaml"), SUGGESTED)
    code, _, err = run("grade", "class", "-o", "out", "--rubric", "auto.yaml")
    assert code == 2
    told = "repairs are applied by themselves: no score changes, 1 that does not run may get a repair; add --change"
    assert told in err
    code, _, err = run("grade", "class", "-o", "out", "--rubric", "auto.yaml", "--change")
    assert (code, total(), total("bob"), suggestions) == (0, 95.0, 100.0, ["alice"])
    assert "repaired automatically (review the change): alice" in err
    (repair,) = result()["repairs"]
    assert (repair["author"], repair["deduction"]) == ("imugrade", 5.0)
    assert "Applied automatically: with this edit of one place the code runs." in repair["comment"]
    page = Path("out/submissions/alice/report.html").read_text()
    assert "imugrade: Applied automatically" in page
    run("repair", "out", "alice", "--undo", "--author", "Eve")
    run("grade", "class", "-o", "out", "--force")
    assert (total(), suggestions) == (94.0, ["alice"])
    rubric_with(Path("auto.yaml"), SUGGESTED, ("time_axis: 3", "time_axis: 4"))  # the search is made again
    run("grade", "class", "-o", "out", "--rubric", "auto.yaml", "--change")
    assert (total(), suggestions) == (94.0, ["alice", "alice"])


# ---- where a repair shows ----

REPAIRED = "filters.py was repaired by Eve (−1 points): a colon was missing"


TEMPLATES = {
    "canvas": ("Student", "Lab (1)", "Student,ID,SIS User ID,SIS Login ID,Section,Lab (1)\n    Points Possible,,,,,100\nalice,1,alice,alice,A,\nbob,2,bob,bob,A,\n"),
    "moodle": ("ID number", "Grade", "Identifier,ID number,Grade,Maximum Grade\nParticipant 1,alice,,100\nParticipant 2,bob,,100\n"),
}  # fmt: skip
"""By platform the column of the ids, that of the grades, and the gradebook that it exports."""


def test_every_gradebook_has_the_repaired_grade_and_every_format_of_a_job_tells_the_repair(run: Run) -> None:
    repaired(run)
    for platform, (name, title, template) in TEMPLATES.items():
        Path("template.csv").write_text(template)
        made = run("export", "out", "--format", platform, "--template", "template.csv", "-o", "upload.csv")
        assert made[0] == 0, platform
        assert column(Path("upload.csv"), title, name).items() >= {("alice", "99"), ("bob", "100")}, platform
    told = from_dict(result())
    assert json.loads(to_json(told))["repairs"] == result()["repairs"]
    of_gradescope = json.loads(gradescope(told))
    assert of_gradescope["score"] == 99.0
    assert REPAIRED in of_gradescope["output"]
    text = junit(told, datetime(2026, 11, 20, tzinfo=timezone.utc))
    (suite,) = ElementTree.fromstring(text).findall("testsuite[@name='repairs']")
    facts = {each.get("name"): each.get("value") for each in suite.iter("property")}
    assert facts == {"score": "-1", "repair.1": REPAIRED}


def test_diff_tells_what_was_repaired_and_what_no_longer_is(run: Run) -> None:
    before = total()
    shutil.copytree("out", "before")
    repaired(run)
    told = run("diff", "before", "out")[1]
    assert f"alice  {before:g} → 99\n" in told
    assert f"  {REPAIRED}\n" in told
    assert "bob" not in told
    assert f"  no longer: {REPAIRED}\n" in run("diff", "out", "before")[1]
