"""Tests that files with names in capitals count as the same files in lower case do."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.corpus.pieces import tidy
from tests.examples import FOLDER

NOTE = "Read under a name in small letters, as Python needs it: "


@pytest.fixture(scope="module")
def graded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A class of sound code with suffixes in capitals, all in capitals, in an archive in capitals, and of a notebook."""
    here = tmp_path_factory.mktemp("capitals")
    programs = {name: text.encode() for name, text in tidy().items()}
    (notebook,) = (FOLDER / "s03-notebook").glob("*.ipynb")
    for name, files in {
        "suffix": {name.replace(".py", ".PY"): data for name, data in programs.items()},
        "capitals": {name.upper(): data for name, data in programs.items()},
        "notebook": {"LAB.IPYNB": notebook.read_bytes()},
    }.items():
        (here / "class" / name).mkdir(parents=True)
        for file, data in files.items():
            (here / "class" / name / file).write_bytes(data)
    with zipfile.ZipFile(here / "class" / "LAB4.ZIP", "w") as archive:
        for file, data in programs.items():
            archive.writestr(file.upper(), data)
    command = [sys.executable, "-m", "grader", "grade", "class", "-o", "out", "-j1"]
    done = subprocess.run(command, cwd=here, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return here


def test_capitals_cost_nothing_and_are_noted(graded: Path) -> None:
    with open(graded / "out" / "gradebook.csv", encoding="utf-8", newline="") as table:
        assert {row["id"]: row["total"] for row in csv.DictReader(table)} == {
            "LAB4": "100",
            "capitals": "100",
            "notebook": "100",
            "suffix": "100",
        }
    notes = json.loads((graded / "out" / "submissions" / "suffix" / "result.json").read_text())["notes"]
    assert f"{NOTE}filters.PY, imu_reader.PY, noisy_imu.PY." in notes


def test_a_folder_of_files_in_capitals_is_one_submission(graded: Path) -> None:
    command = [sys.executable, "-m", "grader", "grade", "class/capitals", "-o", "one", "--list"]
    done = subprocess.run(command, cwd=graded, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.split()[0]) == (0, "capitals")
