"""Tests of overrides, regrades and changed grades: the command on a class that a fake marker grades."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from grader.engine.results import Result
from grader.intake import Submission
from grader.labs.imu.lab import LAB
from grader.platforms.classes import read_class
from tests.class_commands import Run, commands, hand_in
from tests.corpus.writing import write
from tests.fake_results import check, result

PART = ("--criterion", "sensor_access")
WISH = (*PART, "--comment", "x", "--points")


def by_words(submission: Submission, *_: object) -> Result:
    """What the first line of filters.py asks for: ``# 14`` has 14 of 20, ``# open`` is not judged."""
    wanted = submission.files["filters.py"].decode().strip("# \n")
    if wanted == "open":
        return result(check("not_judged", None), status="incomplete", name=submission.id)
    made = result(check(points=float(wanted), max_points=20.0), name=submission.id)
    return replace(made, provenance={**made.provenance, "submission_sha256": submission.sha256})


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], ran: list[str]) -> Run:
    return commands(monkeypatch, capsys, ran, by_words)


@pytest.fixture
def out(tmp_path: Path, run: Run) -> Path:
    run("grade", hand_in(tmp_path / "class", alice=14, bob=20), "-o", tmp_path / "out")
    return tmp_path / "out"


# ---- adjust ----


def test_points_by_hand_are_told_listed_and_kept_apart_from_the_marks(run: Run, out: Path) -> None:
    before = (out / "submissions" / "alice" / "result.json").read_bytes()
    words = (*PART, "--points", 18, "--comment", "shown in the lab hour", "--author", "prof")
    assert run("adjust", out, "alice", *words) == (0, "alice sensor_access 18, final 18\n", "")
    assert (out / "submissions" / "alice" / "result.json").read_bytes() == before
    assert "override by prof" in (out / "submissions" / "alice" / "report.html").read_text(encoding="utf-8")
    assert "\nalice,alice,14,14,18,18,graded\n" in (out / "gradebook.csv").read_text()
    (line,) = run("adjust", out)[1].splitlines()
    when = line.split()[3]
    assert line == f"alice sensor_access 18  {when} by prof: shown in the lab hour"
    assert when.endswith("+00:00")


def test_the_same_again_changes_nothing_and_withdrawing_brings_the_automatic_points_back(run: Run, out: Path) -> None:
    for wish, told in (
        ((*WISH, 18), "18"),
        ((*WISH, 18), "18 (as before)"),
        ((*PART, "--points", 18, "--comment", "another reason"), "18"),
        ((*WISH, 18), "18"),
    ):
        assert run("adjust", out, "alice", *wish)[1] == f"alice sensor_access {told}, final 18\n"
    for told in ("withdrawn", "withdrawn (as before)"):
        line = f"alice sensor_access {told}, final 14\n"
        assert run("adjust", out, "alice", *WISH[:-1], "--withdraw") == (0, line, "")
    assert [line.split()[2] for line in run("adjust", out)[1].splitlines()] == ["18", "18", "18", "withdrawn"]
    assert "adjusted" not in (out / "gradebook.csv").read_text()


def test_a_table_of_adjustments_is_taken_whole_or_not_at_all_as_a_spreadsheet_saves_it(
    run: Run, out: Path, tmp_path: Path
) -> None:
    table = tmp_path / "a.csv"
    table.write_text(
        "\ufeffid,criterion,points,comment\nalice,sensor_access,18,ok\nalicia,sensor_access,1,x\nbob,sensoraccess,1,x\n"
        "bob,sensor_access,21,x\nbob,sensor_access,1.005,x\nbob,sensor_access,٣,x\nbob,sensor_access,1,\nbob,sensor_access,,x\n"
    )
    code, _, err = run("adjust", out, "--csv", table)
    assert code == 2
    assert err.replace(f"imugrade: {table}:", "").splitlines() == [
        "3: there is no submission alicia (did you mean alice?)",
        "4: there is no criterion sensoraccess (did you mean sensor_access?)",
        "5: points must be a number from 0 to 20 with at most two decimals, not 21",
        "6: points must be a number from 0 to 20 with at most two decimals, not 1.005",
        "7: points must be a number from 0 to 20 with at most two decimals, not ٣",
        "8: say why in a comment of at most 2000 characters",
        "9: bob has no adjustment of sensor_access to withdraw",
    ]
    assert run("adjust", out)[1] == "no overrides on record\n"
    head, end = ("ID", "Criterion", "Points", "Comment"), ("", "", "", "")
    for points, encoding, sign in (("18", "cp1252", ";"), ("19", "utf-8-sig", ","), ("19.5", "utf-16", "\t")):
        rows = (head, *((id_, "sensor_access", points, '"für, ""später"""') for id_ in ("alice", "bob")), end)
        table.write_bytes("".join(f"{sign.join(row)}\r\n" for row in rows).encode(encoding))
        told = "".join(f"{id_} sensor_access {points}, final {points}\n" for id_ in ("alice", "bob"))
        assert run("adjust", out, "--csv", table) == (0, told, ""), encoding
    assert run("adjust", out)[1].count(': für, "später"\n') == 6


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ("alice", "give --points or --withdraw"),
        ("alice --csv x", "give exactly one of ID, --csv, --having and --take-back"),
        ("alice --points 1", "say for what with --criterion: sensor_access, one of their checks, total or bonus"),
    ],
)
def test_a_wish_that_is_not_whole_is_one_line(arguments: str, line: str, run: Run, out: Path) -> None:
    assert run("adjust", out, *arguments.split()) == (2, "", f"imugrade: adjust: {line}\n")


# ---- several attempts ----


@pytest.mark.parametrize(
    ("points", "which", "total"),
    [((14, 20, 16), "latest", "16"), ((14, 20, 16), "best", "20"), ((14, "open", 16), "best", "")],
)
def test_of_several_attempts_the_latest_or_the_best_counts(
    points: tuple[object, ...], which: str, total: str, run: Run, tmp_path: Path
) -> None:
    downloads = [
        write({f"doe_1_{100 + i}_filters.py": f"# {p}\n"}, tmp_path / str(i), "zip") for i, p in enumerate(points)
    ]
    run("grade", *downloads, "-o", tmp_path / "out", "--attempts", which)
    row = (tmp_path / "out" / "gradebook.csv").read_text().splitlines()[1]
    assert row.split(",")[3] == total
    record = json.loads((tmp_path / "out" / "submissions" / "doe_1" / "result.json").read_text())
    assert record["status"] == ("graded" if total else "incomplete")


def test_of_equally_good_attempts_the_first_counts(run: Run, tmp_path: Path) -> None:
    files = ({f"doe_1_{100 + i}_filters.py": f"# {points}\n"} for i, points in enumerate(("20", "20.0")))
    downloads = [write(each, tmp_path / str(i), "zip") for i, each in enumerate(files)]
    run("grade", *downloads, "-o", tmp_path / "out", "--attempts", "best")
    (first,) = read_class(downloads[:1], LAB.files).entries
    record = json.loads((tmp_path / "out" / "submissions" / "doe_1" / "result.json").read_text())
    assert record["provenance"]["submission_sha256"] == first.read().sha256


# ---- diff ----


def test_two_gradings_are_told_apart_by_checks_causes_and_hand(run: Run, out: Path, tmp_path: Path) -> None:
    other = tmp_path / "other"
    run("grade", hand_in(tmp_path / "class2", alice=17, bob=20, carol=1), "-o", other)
    run("adjust", other, "bob", *WISH, 19)
    assert run("diff", out, other) == (
        0,
        "alice  14 → 17\n"
        "  sensor_access.follows_address  passed 14 / 20 → passed 17 / 20\n"
        "  changed: the submission\n"
        "bob  20 → 19\n"
        "  sensor_access override  none → 19\n"
        "carol  only in the second: 1\n"
        "2 of 2 moved; mean of graded 17.0 → 18.0\n",
        "",
    )
    assert run("diff", out, out)[1] == "0 of 2 moved; mean of graded 17.0 → 17.0\n"
