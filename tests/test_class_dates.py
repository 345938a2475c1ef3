"""Dates of a class: time zones by name, grace days, and times that contradict each other."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.class_commands import Run, column, commands, graded, hand_in, late_policy, rubric_with
from tests.classes import a_class, gradescope
from tests.corpus.writing import zipped

LOCAL = "2026-10-24T20:00"
"""The clocks in Berlin go back by an hour in the night that follows."""
IN_BERLIN = f"due: {LOCAL}, tz: Europe/Berlin"
CAME = "id,name,submitted\nann,Ann A,2026-10-25T19:30+01:00\nbob,Bob B,2026-10-25T20:30+01:00\ncy,Cy C,2026-10-24T20:30+02:00\n"


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Run:
    monkeypatch.chdir(tmp_path)
    hand_in(tmp_path / "class", ann="1", bob="1.0", cy="1.00")
    return commands(monkeypatch, capsys)


def deducted(run: Run, late: str, roster: str = CAME) -> dict[str, str]:
    """The points that a late policy takes off, as the gradebook has them."""
    rubric_with(Path("rub.yaml"), late_policy(late))
    assert graded(run, "--rubric", "rub.yaml", roster=roster) == ""
    return column(Path("out/gradebook.csv"), "late_deduction")


@pytest.mark.parametrize(
    ("due", "ann"), [(IN_BERLIN, "10"), (f"due: {LOCAL}+02:00, tz: Europe/Berlin", "10"), (f"due: {LOCAL}+02:00", "20")]
)
def test_days_are_counted_by_the_clock_of_the_time_zone_and_have_24_hours_without_one(
    run: Run, due: str, ann: str
) -> None:
    assert deducted(run, due) == {"ann": ann, "bob": "20", "cy": "10"}


def test_a_cut_off_is_by_the_clock_as_well(run: Run) -> None:
    deducted(run, f"{IN_BERLIN}, cut_off_days: 1")
    assert column(Path("out/gradebook.csv"), "late") == {"ann": "1", "bob": "refused", "cy": "1"}


def test_grace_days_of_a_student_are_taken_off_the_days_that_count(run: Run) -> None:
    head, *rows = CAME.splitlines()
    roster = "\n".join([f"{head},grace_days", f"{rows[0]},2", f"{rows[1]},1", f"{rows[2]},"])
    assert deducted(run, IN_BERLIN, roster) == {"ann": "0", "bob": "10", "cy": "10"}
    assert column(Path("out/gradebook.csv"), "grace_days_used") == {"ann": "1", "bob": "1", "cy": "0"}
    Path("roster.csv").write_text(roster.replace(",2\n", ",two\n"))
    refused = run("grade", "class", "-o", "out", "--roster", "roster.csv")
    assert refused[::2] == (2, "imugrade: roster.csv:2: grace days must be a whole number, not two\n")


def test_the_time_of_the_platform_goes_before_that_of_the_roster(run: Run) -> None:
    path = gradescope(a_class(2, [{"filters.py": "# 1\n"}]), Path())
    roster = "sid,submitted\ns00000,2026-11-21T09:00Z\ns00001,2026-11-20T21:00Z\n"
    err = graded(run, folder=path, roster=roster)
    assert (
        "imugrade: Jürgen_Müßig_s00000: submitted 2026-11-20T21:00:00+00:00 by the platform, which counts, "
        "and 2026-11-21T09:00:00+00:00 by the roster\n"
    ) in err
    assert "s00001: submitted" not in err
    assert set(column(Path("out/gradebook.csv"), "submitted").values()) == {"2026-11-20T21:00:00+00:00"}


def test_a_late_mark_vouches_for_those_without_one_and_a_roster_that_contradicts_it_is_told(run: Run) -> None:
    files = {"doejane_LATE_101_900_filters.py": b"# 1\n", "roe_102_901_filters.py": b"# 0\n"}
    Path("marked.zip").write_bytes(zipped(files))
    Path("plain.zip").write_bytes(zipped({name.replace("LATE_", ""): data for name, data in files.items()}))
    Path("roster.csv").write_text(
        "canvas_user_id,name,submitted\n101,Jane Doe,2026-10-24T18:00+02:00\n102,Roe,2026-10-24T18:00+02:00\n"
    )
    rubric_with(Path("rub.yaml"), late_policy(f"{IN_BERLIN}, extensions: {{ROE: {LOCAL}, jim: {LOCAL}}}"))
    err = run("grade", "marked.zip", "-o", "marked", "--rubric", "rub.yaml")[2]
    assert "late, but without a time (add a column `submitted` to the roster): doejane_101\n" in err
    assert "with an extension in the rubric, but no submission has this name: jim\n" in err
    assert "hand-ins: their time" not in err
    assert column(Path("marked/gradebook.csv"), "final")["doejane_101"] == "100"
    unknown = "the late policy deducts nothing from 2 of 2 hand-ins: their time"
    assert unknown in run("grade", "plain.zip", "-o", "plain", "--rubric", "rub.yaml")[2]
    code, _, err = run("grade", "marked.zip", "-o", "out", "--rubric", "rub.yaml", "--roster", "roster.csv")
    assert code == 0
    assert "imugrade: late on the platform, but in time by the roster and the late policy: doejane_101\n" in err
