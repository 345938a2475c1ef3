"""The worked check, fault and bug report of the contributors' pages: their patches apply, and grade as the pages say."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs" / "contributors" / "worked-check.md").read_text(encoding="utf-8")
CHECK, FAULT = re.findall(r"```diff\n(.*?)```", PAGE, re.DOTALL)
REPORT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
BUG = "zero_deviation_taken_for_none"
SMALL, FAILS, MEND = (
    textwrap.dedent(re.findall(rf"^ {{3}}```\w+\n( {{3}}{begin}.*?)^ {{3}}```", REPORT, re.DOTALL | re.MULTILINE)[0])
    for begin in (BUG, f"sound/{BUG}", "---")
)
NEW, ROW = "filtering.takes_alpha_one", "alpha-at-most-nine-tenths"
CHECK_EACH = """
import sys
from pathlib import Path
from grader.engine.grader import Marker
from grader.engine.results import to_json
from grader.engine.rubric import load
from grader.intake import read_submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from tests.corpus.cases import of
from tests.corpus.pieces import tidy
from tests.corpus.writing import write
rows = {case.name: case.files for case in of("faulty")} | {"sound": tidy()}
with Marker(load(LAB), bundles.shipped()) as marker:
    for name in sys.argv[1:]:
        submission = read_submission(write(rows[name], Path(name)), LAB.files)
        Path(f"{name}.json").write_text(to_json(marker.mark(submission, only="filtering")))
"""


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of what the patches change, and of what grades."""
    copy = tmp_path_factory.mktemp("tree")
    for name in ("grader", "reference", "tests/corpus"):
        shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("rubric.yaml", "tests/__init__.py", "tests/scoreboard.py", "tests/recordings/__init__.py"):
        (copy / name).parent.mkdir(exist_ok=True)
        shutil.copyfile(ROOT / name, copy / name)
    return copy


def patched(tree: Path, patch: str, *words: str, way: tuple[str, ...] = (), check: bool = True) -> str:
    """Apply a patch to the copy, run Python there, and return what it prints."""
    subprocess.run(["git", "apply", *way, "-"], cwd=tree, input=patch, text=True, check=True)
    environment = {**os.environ, "PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, *words]
    return subprocess.run(command, cwd=tree, env=environment, text=True, stdout=subprocess.PIPE, check=check).stdout


def lost(tree: Path, patch: str, *names: str) -> list[dict[str, dict[str, Any]]]:
    """Apply a patch, check these rows of the corpus, and return what each does not pass, by check."""
    patched(tree, patch, "-c", CHECK_EACH, *names)
    results = [json.loads((tree / f"{name}.json").read_text(encoding="utf-8")) for name in names]
    checks = [[check for part in result["criteria"] for check in part["checks"]] for result in results]
    return [{check["id"]: check for check in each if check["outcome"] not in ("passed", "skipped")} for each in checks]


@pytest.mark.quick
@pytest.mark.parametrize(
    ("page", "patch", "way"),
    [("docs/contributors/worked-check.md", CHECK + FAULT, ()), ("CONTRIBUTING.md", MEND, ("-R",))],
)
def test_the_patches_of_a_page_apply_to_the_present_files(page: str, patch: str, way: tuple[str, ...]) -> None:
    tried = subprocess.run(
        ["git", "apply", "--check", *way, "-"], cwd=ROOT, input=patch, text=True, capture_output=True, check=False
    )
    assert not tried.returncode, f"mend the patches of {page} by hand: {tried.stderr}"


@pytest.mark.slow
def test_the_worked_bug_report_fails_without_its_mend_as_the_page_says(tree: Path) -> None:
    assert textwrap.indent(SMALL, "  ") in (ROOT / "tests/corpus/sound_habits.yaml").read_text(encoding="utf-8")
    told = patched(tree, MEND, "-m", "tests.scoreboard", "--only", BUG, way=("-R",), check=False)
    patched(tree, MEND, "-c", "")
    assert [line for line in FAILS.splitlines() if line.removesuffix(" …") not in told] == []
    shown = re.findall(r"(?:Expected|Got) +[^\\']+", told)
    assert len(shown) == 2
    assert all(text in REPORT for text in shown)


@pytest.mark.slow
def test_the_worked_check_and_fault_apply_and_grade_as_the_page_says(tree: Path) -> None:
    sound, new = lost(tree, CHECK, "sound", ROW)
    assert sound == {}
    assert [*new] == [NEW]
    assert (new[NEW]["points"], new[NEW]["max_points"], new[NEW]["misconceptions"]) == (0, 1, [])
    assert all(line.strip() in PAGE for line in new[NEW]["message"].splitlines())

    named, swapped = lost(tree, FAULT, ROW, "weights-exchanged")
    assert [*named] == [NEW]
    assert named[NEW]["misconceptions"] == ["alpha-limited"]
    assert [*swapped] == ["filtering.follows_recursion"]
