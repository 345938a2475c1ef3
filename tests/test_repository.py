"""What the repository holds: nothing that makes a clone of it heavy, and in its metadata every package that it imports."""

from __future__ import annotations

import ast
import importlib.metadata
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.conftest import LEFT_OUT

ROOT = Path(__file__).parents[1]
MOST_BYTES = 1_500_000
"""Most that a file may have; the largest today, the public traces, has 1.1 MB."""


def test_no_tracked_file_is_large() -> None:
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        pytest.skip("not a git checkout")
    paths = [ROOT / name for name in listed.stdout.split("\0") if name]
    assert [str(path) for path in paths if path.is_file() and path.stat().st_size > MOST_BYTES] == []


@pytest.mark.skipif(shutil.which("git") is None or shutil.which("bash") is None, reason="needs git and bash")
def test_commits_that_add_a_large_file_are_refused_also_where_it_was_deleted_again(tmp_path: Path) -> None:
    def git(*arguments: str) -> None:
        identity = ("-c", "user.name=n", "-c", "user.email=e@example.org", "-c", "commit.gpgsign=false")
        subprocess.run(["git", *identity, *arguments], cwd=tmp_path, check=True, capture_output=True)

    def checked() -> tuple[int, str]:
        command = [ROOT / ".ci" / "large-files", "base"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        return done.returncode, done.stdout

    git("init")
    git("commit", "--allow-empty", "-m", "base")
    git("tag", "base")
    (tmp_path / "small").write_bytes(bytes(MOST_BYTES))
    git("add", "small")
    git("commit", "-m", "small")
    assert checked() == (0, "")
    (tmp_path / "large").write_bytes(bytes(MOST_BYTES + 1))
    git("add", "large")
    git("commit", "-m", "large")
    git("rm", "large")
    git("commit", "-m", "gone")
    text = "These commits add files of more than 1500000 bytes:\n  large: 1500001 bytes\n"
    assert checked() == (1, text)


def test_the_weekly_run_refuses_a_part_that_it_does_not_have() -> None:
    page = ROOT / "docs" / "contributors" / "weekly.md"
    before = page.read_bytes()
    done = subprocess.run([ROOT / ".ci" / "weekly", "nonsense"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("no part nonsense; the parts are: isolation_levels ordinary_user ")
    assert page.read_bytes() == before


def test_the_summary_of_a_plain_run_tells_about_how_many_tests_it_left_out(request: pytest.FixtureRequest) -> None:
    slow = [item for item in request.session.items if item.get_closest_marker("slow")]
    if len(slow) < LEFT_OUT / 2:
        pytest.skip("only some of the slow tests are chosen")
    assert len(slow) == pytest.approx(LEFT_OUT, rel=0.05)


OURS = {"grader", "reference"}
#: What runs in a sandbox imports what a student handed in, and the sandbox's modules under a name of their own.
OF_A_SUBMISSION = {"imu_reader", "noisy_imu", "filters"}


def imported() -> Iterator[str]:
    """Top names of all absolute imports."""
    for folder in OURS:
        for path in (ROOT / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Import):
                    yield from (alias.name.partition(".")[0] for alias in node.names)
                elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                    yield node.module.partition(".")[0]


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def test_every_package_that_is_imported_is_asked_for_by_name() -> None:
    """By what an install brings, or its extras."""
    needs = importlib.metadata.requires("imugrade") or []
    asked = [each for each in needs if "extra ==" not in each or each.endswith(("'cluster'", "'desk'"))]
    declared = {_normal(re.split(r"[^\w.-]", need)[0]) for need in asked}
    brought_by = importlib.metadata.packages_distributions()
    others = set(imported()) - set(sys.stdlib_module_names) - OURS - OF_A_SUBMISSION
    assert others >= {"numpy", "mujoco", "PIL"}
    assert {name for name in others if not declared & {_normal(by) for by in brought_by.get(name, [name])}} == set()
