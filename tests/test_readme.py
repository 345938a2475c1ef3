"""Tests of the README: its first screen, its length, and the command that CI runs. Its commands run in test_documented_commands."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from grader import cli

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_readme_is_short_and_its_first_screen_holds_the_two_commands() -> None:
    assert len(README.splitlines()) <= 80
    first_screen = "\n".join(README.splitlines()[:30])
    assert "pip install -q . && .venv/bin/imugrade grade submissions_example -o out" in first_screen
    assert "pip install -q -e '.[test]' && .venv/bin/python -m pytest\n" in first_screen


def test_ci_runs_the_test_command_of_the_readme() -> None:
    (command,) = re.findall(r"^.* && .*python -m pytest$", README, re.MULTILINE)
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    set_up, install, run = command.split(" && ")
    assert f'"$python" {set_up.removeprefix("python3 ")} && {install}\n' in script
    assert f"\n{run} " in script


NO_COLON = ("class LowPassFilter:", "class LowPassFilter")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("page", "example", "edit", "words", "begins"),
    [
        ("report", "s06-id-as-address", ("", ""), (), " ◐ Sensor access "),
        ("first-check", "s01-sheet-verbatim", NO_COLON, (), "Does not run\n"),
        ("first-check", "s01-sheet-verbatim", ("", ""), ("--only", "filtering"), " ✓ Filtering "),
    ],
)
def test_the_documented_report_is_what_a_terminal_shows(
    page: str, example: str, edit: tuple[str, str], words: tuple[str, ...], begins: str,
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path,
) -> None:  # fmt: skip
    text = (ROOT / "docs" / "students" / f"{page}.md").read_text(encoding="utf-8")
    (sample,) = (
        block[block.index(begins) :] for block in re.findall(r"```text\n(.*?)```", text, re.DOTALL) if begins in block
    )
    lab = shutil.copytree(ROOT / "submissions_example" / example, tmp_path / "lab")
    filters = lab / "filters.py"
    filters.write_text(filters.read_text(encoding="utf-8").replace(*edit, 1), encoding="utf-8")
    monkeypatch.chdir(lab)
    for name, value in {"FORCE_COLOR": "1", "NO_COLOR": "1", "TERM": "xterm", "COLUMNS": "80"}.items():
        monkeypatch.setenv(name, value)
    assert cli.main(["check", *words]) == 0
    shown = re.sub(r"\x1b\[\d*m", "", capsys.readouterr().out)
    # MuJoCo's last digits differ between versions; a minus takes a blank's place.
    told, wanted = (re.sub(r"[ -]\d+\.\d+", " 0.0", part) for part in (shown[shown.index(begins) :], sample))
    assert told == wanted
