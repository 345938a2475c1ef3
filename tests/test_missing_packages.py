"""Packages that a class imports and this machine lacks: named once, with the command, and graded again once they are there."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from grader.course import missing_packages
from grader.course.classroom import installed_since
from grader.course.record import Key, Store
from grader.course.warnings import remarks
from grader.desk.review_queue import items
from grader.labs.imu.lab import LAB
from grader.people.final_grade import FinalGrade
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
    assert missing_packages.imported(replace(submission("a"), files=files)) == found


def test_only_known_names_are_suggested_for_installation() -> None:
    evil = replace(FAILED, notes=("ModuleNotFoundError: No module named 'evil_package'",))
    assert missing_packages.failed(evil) == set()
    assert missing_packages.failed(FAILED) == {"pandas"}


def test_a_class_is_told_once_which_package_for_whom_and_how_to_install_it() -> None:
    names = [f"s{i}" for i in range(7)]
    told = list(remarks({name: FinalGrade(name, FAILED) for name in names}, (), ()))
    assert [line for line in told if "pandas" in line] == [
        "pandas is not installed for student code: 7 submissions import it (s0; s1; s2; s3; s4 and 2 more)",
        f"{PIP} pandas installs it; then `imugrade grade` grades only these again",
    ]


def test_the_review_queue_has_one_item_for_all_of_them() -> None:
    grades = {"a": FinalGrade("a", FAILED), "b": FinalGrade("b", result(check())), "c": FinalGrade("c", FAILED)}
    (item,) = [each for each in items(grades, (), {}, (), {}, LAB) if each.reason.kind == "missing-package"]
    assert item.ids == ("a", "c")
    assert item.reason.title == "Package not installed"
    assert f"{PIP} pandas" in item.reason.sentence


def test_what_failed_is_graded_again_once_the_package_is_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with Store(tmp_path) as store:
        for name, made in (("a", FAILED), ("b", result(check()))):
            store.keep(Key(name, "0" * 64, "0" * 64, "0" * 64, "1"), replace(made, submission=name))
        monkeypatch.setattr(missing_packages, "available", lambda: {"numpy"})
        assert installed_since(store) == set()
        monkeypatch.setattr(missing_packages, "available", lambda: {"numpy", "pandas"})
        assert installed_since(store) == {"a"}
