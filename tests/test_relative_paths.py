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


def test_a_large_class_is_graded_regraded_and_exported_by_relative_paths(tmp_path: Path) -> None:
    """By the README's command with the shipped rubric, then with another one."""
    (tmp_path / "download").mkdir()
    kinds = [filters_alone(1.0), filters_alone(0.5), *[{"notes.txt": "Not yet."}] * 8]
    moodle(a_class(MANY, kinds), tmp_path / "download").rename(tmp_path / "moodle.zip")
    rubric_with(tmp_path / "rub.yaml", ("follows_recursion: 6", "follows_recursion: 9"))
    before, beside = files_outside(tmp_path, tmp_path / "out"), set(BESIDE_PYTHON.iterdir())
    for arguments in ((), ("--rubric", "rub.yaml", "--change")):
        done = imugrade(tmp_path, "grade", "moodle.zip", "-o", "out", *arguments)
        assert done.returncode == 0, done.stderr
        assert "out/index.html" in done.stdout
        assert str(tmp_path) not in done.stdout
    assert files_outside(tmp_path, tmp_path / "out") == before
    assert set(BESIDE_PYTHON.iterdir()) == beside

    records = tmp_path.glob("out/submissions/*/result.json")
    published = {path.parent.name: json.loads(path.read_text())["score"] for path in records}
    scores = {id_: float(total or 0) for id_, total in column(tmp_path / "out" / "gradebook.csv", "total").items()}
    assert len(published) == MANY
    assert published == pytest.approx(scores)
    export = ("export", "out", "--format", "csv", "--allow-blank", "-o", "marks.csv", "--feedback")
    exported = imugrade(tmp_path, *export, "reports.zip")
    assert exported.returncode == 0, exported.stderr
    sent = moodle_feedback((tmp_path / "reports.zip").read_bytes())
    assert sorted(sent.values()) == sorted(path.read_bytes() for path in tmp_path.glob("out/submissions/*/report.html"))

    report = sorted(tmp_path.glob("out/submissions/*/report.html"))[4]
    report.write_bytes(report.read_bytes().replace(b"</body>", b"<p>old</p></body>"))
    refused = imugrade(tmp_path, *export, "new.zip")
    assert refused.returncode == 2
    assert f"1 of {MANY} reports do not match the record ({report.parent.name})" in refused.stderr
    assert not (tmp_path / "new.zip").exists()
