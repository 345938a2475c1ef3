"""The README's first screen, its links, and the test command that the machine runs, too; its commands are run by test_documented_commands."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```sh\n(.*?)```", README, re.DOTALL)


def test_the_first_screen_holds_the_two_commands() -> None:
    first_screen = "\n".join(README.splitlines()[:24])
    assert "pip install -q . && .venv/bin/imugrade grade submissions_example -o out" in first_screen
    assert "pip install -q -e '.[test]' && .venv/bin/python -m pytest" in first_screen


def test_ci_runs_the_test_command_of_the_readme() -> None:
    (command,) = (line for block in BLOCKS for line in block.splitlines() if line.endswith("python -m pytest"))
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    set_up, install, run = command.split(" && ")
    assert f'"$python" {set_up.removeprefix("python3 ")} && {install}\n' in script
    assert script.rstrip().endswith(run)


def test_the_files_that_the_readme_names_are_there() -> None:
    links = re.findall(r"\]\(([^)#]+)\)", README)
    assert [link for link in links if not (ROOT / link).exists()] == []
