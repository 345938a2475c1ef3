"""The README cannot lie: its commands exist, its options are theirs, and the machine runs the test command that it names."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import typer.main

from grader.cli import app
from grader.feedback import catalogue

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```sh\n(.*?)```", README, re.DOTALL)
COMMANDS = [line.split("#")[0].strip() for block in BLOCKS for line in block.splitlines() if "imugrade " in line]


@pytest.mark.parametrize("line", COMMANDS)
def test_every_command_and_option_of_the_readme_exists(line: str) -> None:
    words = line[line.index("imugrade ") :].split()[1:]
    group: Any = typer.main.get_command(app)
    command = group.commands[words[0]]
    options = {name for parameter in command.params for name in (*parameter.opts, *parameter.secondary_opts)}
    assert {word for word in words[1:] if word.startswith("-")} <= options


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


def test_the_mistake_that_the_readme_explains_exists() -> None:
    named = re.findall(r"imugrade explain ([\w-]+)", README)
    assert named
    assert set(named) <= set(catalogue())


def test_the_files_that_the_readme_names_are_there() -> None:
    links = re.findall(r"\]\(([^)#]+)\)", README)
    modules = re.findall(r"python -m ([\w.]+)", README)
    assert all((ROOT / link).exists() for link in links)
    wanted = [ROOT / module.replace(".", "/") for module in modules if module != "pytest" and module != "venv"]
    assert all(path.with_suffix(".py").is_file() or (path / "__main__.py").is_file() for path in wanted)
