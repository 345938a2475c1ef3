"""macOS and Windows, as far as they can be had here: without what only Linux or POSIX has, a student's check judges as it should."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.corpus.pieces import edit, tidy
from tests.corpus.writing import write

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Sound, but that the filter ends its own process."""
    ends = "import os, signal\n        os.kill(os.getpid(), signal.SIGTERM)\n        x = np"
    return write(edit(tidy(), "filters.py", ("x = np", ends)), tmp_path_factory.mktemp("class") / "lab")


@pytest.mark.parametrize("system", [pytest.param("darwin", marks=pytest.mark.weekly), "win32"])
def test_a_check_marks_as_it_does_on_linux(lab: Path, system: str) -> None:
    answer, page = lab.parent / "result.json", lab.parent / "report.html"
    command = [sys.executable, "tests/other_systems.py", system, "-m", "grader", "check", str(lab)]
    done = subprocess.run(
        [*command, "--json", str(answer), "--html", str(page)], cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    result = json.loads(answer.read_text(encoding="utf-8"))
    assert result["provenance"]["isolation"] == "none"
    outcomes = {
        criterion["id"]: {check["outcome"] for check in criterion["checks"]} for criterion in result["criteria"]
    }
    assert outcomes.pop("filtering") == {"crashed", "skipped"}
    assert set().union(*outcomes.values()) == {"passed"}
    assert result["score"] == 80.0
    assert "may grade with hidden scenarios" in done.stdout
    assert "<html" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "arguments", [["grader", "repro", "sensor_access.follows_address", "."], ["pytest", "--imugrade", "-q", "."]]
)
def test_a_student_can_repeat_a_check_without_what_windows_lacks(lab: Path, arguments: list[str]) -> None:
    command = [sys.executable, str(ROOT / "tests" / "other_systems.py"), "win32", "-m", *arguments]
    done = subprocess.run(
        command, cwd=lab, env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False, timeout=300
    )  # fmt: skip
    said = done.stdout + done.stderr
    assert "Traceback" not in said
    assert ("python .imugrade/repro.py" in said.replace(os.sep, "/")) if "repro" in arguments else ("80 / 100" in said)
