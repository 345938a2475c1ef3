"""What the repository holds: nothing that makes a clone of it heavy."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

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
