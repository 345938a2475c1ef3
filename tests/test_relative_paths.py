"""Commands given with relative paths, by a class large enough that pages are written by several processes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.class_commands import column, rubric_with
from tests.classes import a_class, filters_alone, moodle, moodle_feedback

MANY = 50
"""Students of the class; most handed in nothing that can be graded: their pages are written all the same."""
BESIDE_PYTHON = Path(os.__file__).parent
"""Where the processes of the grader start: nothing may be left there."""


def imugrade(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "grader", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def files_outside(folder: Path, out: Path) -> set[Path]:
    return {path for path in folder.rglob("*") if not path.is_relative_to(out)}


@pytest.fixture(scope="module")
def graded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a class, graded twice by the README's command: with the shipped rubric, then with another one."""
    here = tmp_path_factory.mktemp("evening")
    (here / "download").mkdir()
    kinds = [filters_alone(1.0), filters_alone(0.5), *[{"notes.txt": "Not yet."}] * 8]
    moodle(a_class(MANY, kinds), here / "download").rename(here / "moodle.zip")
    rubric_with(here / "rub.yaml", ("follows_recursion: 6", "follows_recursion: 9"))
    before, beside = files_outside(here, here / "out"), set(BESIDE_PYTHON.iterdir())
    for arguments in ((), ("--rubric", "rub.yaml", "--change")):
        done = imugrade(here, "grade", "moodle.zip", "-o", "out", *arguments)
        assert done.returncode == 0, done.stderr
        assert "out/index.html" in done.stdout
        assert str(here) not in done.stdout
    assert files_outside(here, here / "out") == before
    assert set(BESIDE_PYTHON.iterdir()) == beside
    return here


def test_pages_and_the_feedback_are_those_of_the_last_rubric(graded: Path) -> None:
    records = graded.glob("out/submissions/*/result.json")
    published = {path.parent.name: json.loads(path.read_text())["score"] for path in records}
    scores = {id_: float(total or 0) for id_, total in column(graded / "out" / "gradebook.csv", "total").items()}
    assert len(published) == MANY
    assert published == pytest.approx(scores)
    where = ("-o", "marks.csv", "--feedback", "reports.zip")
    exported = imugrade(graded, "export", "out", "--format", "csv", "--allow-blank", *where)
    assert exported.returncode == 0, exported.stderr
    sent = moodle_feedback((graded / "reports.zip").read_bytes())
    assert sorted(sent.values()) == sorted(path.read_bytes() for path in graded.glob("out/submissions/*/report.html"))


def test_changed_pages_are_refused_by_export_and_written_anew_by_grade(graded: Path) -> None:
    report = sorted(graded.glob("out/submissions/*/report.html"))[4]
    page = report.read_bytes()
    report.write_bytes(page.replace(b"</body>", b"<p>old</p></body>"))
    refused = imugrade(graded, "export", "out", "--format", "csv", "-o", "new.csv", "--feedback", "new.zip")
    assert refused.returncode == 2
    assert f"1 of {MANY} reports do not match the record ({report.parent.name})" in refused.stderr
    assert not (graded / "new.zip").exists()
    again = imugrade(graded, "grade", "moodle.zip", "-o", "out", "--rubric", "rub.yaml")
    assert again.returncode == 0, again.stderr
    assert report.read_bytes() == page
