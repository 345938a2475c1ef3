"""macOS and Windows, as far as they can be had here: without what only Linux or POSIX has, a student's check judges as it should."""

from __future__ import annotations

import json
import ntpath
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from grader.base.files import seen_from
from grader.commands.check import _Arguments
from tests.corpus.pieces import edit, tidy
from tests.corpus.writing import write

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Sound, but that the filter ends its own process; one file and the folder are written in other letters than they are asked for."""
    ends = "import os, signal\n        os.kill(os.getpid(), signal.SIGTERM)\n        x = np"
    files = edit(tidy(), "filters.py", ("x = np", ends))
    files["IMU_Reader.py"] = files.pop("imu_reader.py")
    return write(files, tmp_path_factory.mktemp("class") / "Lab").with_name("lab")


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


@pytest.mark.weekly
@pytest.mark.parametrize(
    "arguments", [["grader", "repro", "sensor_access.follows_address", "."], ["pytest", "--imugrade", "-q", "."]]
)
def test_a_student_can_repeat_a_check_without_what_windows_lacks(lab: Path, arguments: list[str]) -> None:
    command = [sys.executable, str(ROOT / "tests" / "other_systems.py"), "win32", "-m", *arguments]
    done = subprocess.run(
        command, cwd=lab.with_name("Lab"), env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False, timeout=300
    )  # fmt: skip
    said = done.stdout + done.stderr
    assert "Traceback" not in said
    assert ("python .imugrade/repro.py" in said.replace(os.sep, "/")) if "repro" in arguments else ("80 / 100" in said)


def test_a_path_on_another_drive_of_windows_is_shown_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.path.relpath", ntpath.relpath)
    monkeypatch.setattr("os.path.abspath", ntpath.abspath)
    assert seen_from("C:\\lab", "C:\\lab\\a.py") == "a.py"  # type: ignore[arg-type] # a Path here has no drive
    assert seen_from("C:\\lab", "D:\\out\\a.py") == "D:\\out\\a.py"  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("system", "command"), [("win32", 'imugrade check "my lab"'), ("linux", "imugrade check 'my lab'")]
)
def test_a_command_is_quoted_for_the_systems_shell(monkeypatch: pytest.MonkeyPatch, system: str, command: str) -> None:
    monkeypatch.setattr(sys, "platform", system)
    assert _Arguments(Path("my lab"), None, None, None, prints=False, verbose=False, rubric=None).command == command


def test_pytest_ends_with_its_own_exit_code_on_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTEST_ADDOPTS", "")
    monkeypatch.setenv("PYTHONSAFEPATH", "1")
    monkeypatch.setattr(sys, "orig_argv", ["python"])
    from grader.pytest_plugin import own_settings

    monkeypatch.setenv("PYTHONSAFEPATH", "")
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(sys, "orig_argv", ["python", "-m", "pytest", "--imugrade"])
    monkeypatch.setattr(sys, "argv", ["-m"])
    monkeypatch.setattr(sys, "flags", SimpleNamespace(safe_path=False))
    asked: list[Any] = []
    monkeypatch.setattr(subprocess, "call", lambda again: asked.append(again) or 5)
    monkeypatch.setattr(os, "_exit", asked.append)
    monkeypatch.setattr(os, "execv", lambda *_: None)
    own_settings._start()
    assert asked == [[sys.executable, "-m", "pytest", "--imugrade"], 5]
