from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from grader import cli
from grader.commands import checking, opening
from grader.intake import read_submission
from grader.labs.imu.lab import LAB
from tests.fake_results import result


def hand_in(folder: Path, *names: str) -> Path:
    folder.mkdir(exist_ok=True)
    for name in names:
        (folder / name).write_text("x = 1\n")
    return folder


def test_the_second_line_says_what_was_found_and_what_was_not(tmp_path: Path) -> None:
    submission = read_submission(hand_in(tmp_path / "me", "filters.py", "imu_reader.py"), LAB.files)
    assert opening.found(LAB, submission) == (
        "imu_reader.py, filters.py found; no noisy_imu.py, no imu_data.png, no filtered_imu.png"
    )


def test_a_name_of_a_folder_cannot_colour_the_terminal(tmp_path: Path) -> None:
    assert "\x1b" not in opening.checking_line(tmp_path / "\x1b[31mred")


def test_what_is_checked_is_said_before_it_is_read_but_not_of_what_is_not_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(hand_in(tmp_path / "me"))
    assert opening.checking_line(Path()) == "checking me …"
    assert cli.main(["check", "nowhere"]) == 2
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(("secret", "said"), [("a secret", "hidden scenarios wait"), ("  ", "may grade with hidden")])
def test_these_lines_stand_above_the_result_and_know_of_the_secret_by_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], secret: str, said: str
) -> None:
    monkeypatch.setenv("IMUGRADE_SEED", secret)
    monkeypatch.setattr(checking, "check", lambda *_, **__: result())
    assert cli.main(["check", str(hand_in(tmp_path / "me", "filters.py"))]) == 0
    first, second, third, fourth = capsys.readouterr().out.splitlines()[:4]
    assert first == "checking me …"
    assert second.startswith("filters.py found")
    assert "public checks. " in third
    assert said in third
    assert fourth == ""


def test_the_first_line_waits_for_no_simulator_and_no_pytest() -> None:
    code = (
        "import sys; from grader.commands import opening; from grader.engine import rubric; from grader.intake import read_submission\n"
        "print([name for name in ('mujoco', 'matplotlib', 'scipy', 'pytest', 'grader.engine.grader') if name in sys.modules])"
    )
    environ = {**os.environ, "PYTHONPATH": str(Path(cli.__file__).parent.parent)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environ)
    assert done.stdout.strip() == "[]"


def test_the_box_is_opened_before_anything_slow_is_imported() -> None:
    code = (
        "import sys; from grader import cli; from grader.intake import read_submission; from grader.engine.lab_sandbox import open_sandbox_for\n"
        "from grader.labs.imu.lab import LAB\n"
        "box = open_sandbox_for(LAB, {})\n"
        "print(sorted({'numpy', 'mujoco', 'matplotlib', 'pytest', 'yaml', 'grader.engine.results'} & set(sys.modules)))\n"
        "box.close()"
    )
    environ = {**os.environ, "PYTHONPATH": str(Path(cli.__file__).parent.parent)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environ)
    assert done.stdout.strip() == "[]"
