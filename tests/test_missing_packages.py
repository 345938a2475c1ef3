"""Packages that a class imports and this machine lacks: named once, with the command, and graded again once they are there."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from grader.course.run import missing_packages
from grader.engine import rubric
from grader.engine.results import Result
from grader.intake import Submission
from grader.labs.imu.lab import LAB
from tests.class_commands import commands, graded, hand_in, result_by_comment
from tests.desk import desk_over, words
from tests.fake_results import check, result, submission

NOTE = "imu_reader.py, line 3 was skipped: ModuleNotFoundError: No module named 'pandas'; the rest of the file was used"
FAILED = replace(result(check()), notes=(NOTE,))
PIP = f"{sys.executable} -m pip install"


@pytest.mark.parametrize(
    ("files", "found"),
    [
        ({"lab.py": b"import pandas as pd\n"}, {"pandas"}),
        ({"lab.py": b"    from sklearn.decomposition import PCA\n"}, {"sklearn"}),
        ({"lab.ipynb": b'"source": ["import cv2\\n"]'}, {"cv2"}),
        ({"lab.py": b"import numpy, os, evil_package\n# import pandas\n"}, set()),
        ({"lab.py": b"import control\n", "control.py": b""}, set()),
    ],
)
def test_known_packages_that_are_no_files_of_the_submission_are_found(files: dict[str, bytes], found: set[str]) -> None:
    assert missing_packages.imported(replace(submission("a"), files=files), rubric.load(LAB)).keys() == found


def test_only_known_names_are_suggested_for_installation() -> None:
    evil = replace(FAILED, notes=("ModuleNotFoundError: No module named 'evil_package'",))
    assert missing_packages.failed(evil) == {}
    assert missing_packages.failed(FAILED).keys() == {"pandas"}


def test_a_package_is_named_once_for_a_class_and_what_lacked_it_is_graded_again_once_it_is_there(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path, ran: list[str]
) -> None:
    def lacking(submission: Submission, *made_by: Any) -> Result:
        return replace(result_by_comment(submission, *made_by), notes=(NOTE,) if submission.id != "bob" else ())

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(missing_packages, "available", lambda lab: {"numpy"})
    run = commands(monkeypatch, capsys, ran, lacking)
    names = [f"s{i}" for i in range(7)]
    hand_in(tmp_path / "class", bob=1, **dict.fromkeys(names, 1))
    assert [line for line in graded(run).splitlines() if "pandas" in line] == [
        "imugrade: pandas is not installed for student code: 7 submissions import it (s0; s1; s2; s3; s4 and 2 more)",
        f"imugrade: {PIP} pandas installs it; then `imugrade grade` grades only these again",
    ]
    with desk_over(tmp_path / "out") as desk:
        page = words(desk.get("/").text)
    assert "Package not installed 1" in page
    assert page.count(f"{PIP} pandas") == 1
    ran.clear()
    graded(run)
    assert ran == []
    monkeypatch.setattr(missing_packages, "available", lambda lab: {"numpy", "pandas"})
    graded(run)
    assert ran == names


def test_a_class_is_graded_without_packages_that_many_import_only_after_a_yes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path, ran: list[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(missing_packages, "available", lambda lab: {"numpy"})
    run = commands(monkeypatch, capsys, ran)
    hand_in(tmp_path / "class", **{f"s{i}": 1 for i in range(9)})
    for i in range(3):
        noise = tmp_path / "class" / f"s{i}" / "noisy_imu.py"
        noise.write_text(f"# {i}\nimport pandas\n\n\nclass NoisyIMU:\n    pass\n")
    (tmp_path / "class" / "s8" / "noisy_imu.py").write_text("import cv2\n")
    told = (
        "imugrade: pandas is not installed for student code: "
        "3 submissions import it (s0; s1; s2), and without it they lose up to 20 points\n"
        f"imugrade: {PIP} pandas installs it; then `imugrade grade` grades only these again\n"
    )
    code, _, err = run("grade", "class", "-o", "out")
    assert (code, err) == (
        2,
        f"{told}imugrade: packages are missing (see above); install them, or add --anyway. Nothing was graded\n",
    )
    asked: list[str] = []
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    monkeypatch.setattr("typer.confirm", lambda text: asked.append(text) or len(asked) > 1)
    assert run("grade", "class", "-o", "out")[0] == 2
    assert run("grade", "class", "-o", "out")[0] == 0
    assert (asked, len(ran)) == (["Grade without?"] * 2, 9)
    assert run("grade", "class", "-o", "other", "--anyway")[0] == 0
    assert run("grade", "class", "-o", "other")[0] == 0
