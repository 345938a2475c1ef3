"""Tests with a `numpy.py` or `signal.py` in the student's folder: the grader imports its own modules, also if it is started there."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.corpus.pieces import tidy
from tests.corpus.writing import write
from tests.shadowing_modules import write_shadowing_modules

COMMAND = str(Path(sys.executable).with_name("imugrade"))
#: What Python itself reads before the first line of a program that is called by `-m`, in one version or another.
READ_BEFORE = frozenset([
    "__future__", "collections", "contextlib", "functools", "grader", "importlib", "keyword", "operator", "pkgutil", "reprlib", "runpy",
    "types", "warnings",
])  # fmt: skip


def called(command: list[str], cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    "words",
    [["check", "../lab"], ["grade", "../lab", "-o", "../out"], ["traces", "list"]],
    ids=lambda words: words[0],
)  # fmt: skip
def test_the_command_imports_nothing_from_the_folder_that_it_is_called_in(tmp_path: Path, words: list[str]) -> None:
    write(tidy(), tmp_path / "lab")
    here = write_shadowing_modules(tmp_path / "here", tmp_path / "told")
    done = called([COMMAND, *words], here)
    assert (tmp_path / "told").read_text(encoding="utf-8") == ""
    assert done.returncode == 0, done.stderr


def test_python_m_grader_imports_nothing_more_from_there_once_it_runs(tmp_path: Path) -> None:
    write(tidy(), tmp_path / "lab")
    here = write_shadowing_modules(tmp_path / "here", tmp_path / "told", but=READ_BEFORE)
    done = called([sys.executable, "-m", "grader", "grade", "../lab", "-o", "../out"], here)
    assert (tmp_path / "told").read_text(encoding="utf-8") == ""
    assert done.returncode == 0, done.stderr
