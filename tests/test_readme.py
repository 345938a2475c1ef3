"""The README's first screen, its links, and the test command that the machine runs, too; its commands are run by test_documented_commands."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from grader import cli
from tests.corpus.broken import BROKEN
from tests.corpus.extensions import FAULTY_EXTENSIONS, SOUND_EXTENSIONS
from tests.corpus.faulty import FAULTY, LOOKALIKES, PAIRS
from tests.corpus.sound import SOUND
from tests.examples import FOLDER

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


def test_what_the_readme_shows_of_a_check_is_what_a_terminal_shows(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (sample,) = re.findall(r"```\n( . Sensor access .*?)```", README, re.DOTALL)
    monkeypatch.chdir(shutil.copytree(FOLDER / "s06-id-as-address", tmp_path / "lab"))
    for name, value in {"FORCE_COLOR": "1", "NO_COLOR": "1", "TERM": "xterm", "COLUMNS": "80"}.items():
        monkeypatch.setenv(name, value)
    assert cli.main(["check"]) == 0
    shown = re.sub(r"\x1b\[\d*m", "", capsys.readouterr().out)
    assert _without_digits(shown[shown.index(" ◐ Sensor access") :]) == _without_digits(sample)


def _without_digits(text: str) -> str:
    """MuJoCo's last digits differ between versions; a minus takes a blank's place."""
    return re.sub(r"[ -]\d+\.\d+", " 0.0", text)


def test_the_files_that_the_readme_names_are_there() -> None:
    links = re.findall(r"\]\(([^)#]+)\)", README)
    assert [link for link in links if not (ROOT / link).exists()] == []


def test_the_scoreboard_of_the_readme_is_that_of_this_corpus() -> None:
    rows = dict(re.findall(r"^\| (.+?) \| (\d+) \| .+ \|$", README, re.MULTILINE))
    faults = len(FAULTY) + len(LOOKALIKES) + len(PAIRS)
    assert int(rows["sound submissions with false deductions"]) == len(SOUND)
    assert (
        int(rows["faults missed (one fault, look-alikes, pairs)"])
        == int(rows["points lost in other criteria"])
        == faults
    )
    assert int(rows["broken submissions without a clear verdict"]) == len(BROKEN)
    sound, faulty = sum(map(len, SOUND_EXTENSIONS.values())), len(FAULTY_EXTENSIONS)
    assert f"{sound} sound and {faulty}\nfaulty submissions in `tests/test_extensions.py`" in README
