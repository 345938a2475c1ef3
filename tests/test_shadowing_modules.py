"""Tests with a `numpy.py` or `signal.py` in the student's folder: the grader imports its own modules, also if it is started there."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.corpus.pieces import tidy
from tests.corpus.writing import write

COMMAND = str(Path(sys.executable).with_name("imugrade"))
PACKAGES = (
    "PIL", "_pytest", "click", "conftest", "distributed", "grader", "jinja2", "markupsafe", "matplotlib", "mujoco", "numpy", "pluggy", "pytest",
    "reference", "rich", "scipy", "sitecustomize", "typer", "usercustomize", "yaml",
)  # fmt: skip
READ_BEFORE = frozenset([
    "__future__", "collections", "contextlib", "functools", "grader", "importlib", "keyword", "operator", "pkgutil", "reprlib", "runpy",
    "types", "warnings",
])  # fmt: skip
"""What Python itself reads before the first line of a program that is called by `-m`, in one version or another."""
TELLS = """\
import posix, sys
line = b"{name} by %r\\n" % " ".join(getattr(sys, "orig_argv", sys.argv)).encode()
try:
    posix.write(posix.open({told!r}, posix.O_WRONLY | posix.O_APPEND), line)
except OSError:
    pass
raise ImportError("a student's {name}")
"""


@pytest.mark.parametrize(
    ("program", "words", "but"),
    [
        ([COMMAND], ["check", "../lab"], frozenset()),
        pytest.param([COMMAND], ["grade", "../lab", "-o", "../out"], frozenset(), marks=pytest.mark.weekly),
        pytest.param([COMMAND], ["traces", "list"], frozenset(), marks=pytest.mark.weekly),
        ([sys.executable, "-m", "grader"], ["grade", "../lab", "-o", "../out"], READ_BEFORE),
    ],
    ids=["check", "grade", "traces", "python -m grader"],
)
def test_the_command_imports_nothing_from_the_folder_that_it_is_called_in(
    tmp_path: Path, program: list[str], words: list[str], but: frozenset[str]
) -> None:
    """Each module that the grader imports has a namesake there, which writes to a file when it is run."""
    write(tidy(), tmp_path / "lab")
    told = tmp_path / "told"
    told.touch()
    told.chmod(0o666)
    names = {*sys.stdlib_module_names, *PACKAGES} - {"posix", "sys", *but}
    namesakes = {f"{name}.py": TELLS.format(name=name, told=str(told)) for name in names}
    here = write({**namesakes, "pytest.ini": "[pytest]\naddopts = --no-such-option\n"}, tmp_path / "here")
    done = subprocess.run([*program, *words], cwd=here, capture_output=True, text=True, check=False)
    assert told.read_text(encoding="utf-8") == ""
    assert done.returncode == 0, done.stderr
