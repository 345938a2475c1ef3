from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from grader import cli, opening, selfcheck, traces
from grader.intake import read_submission
from grader.results import Result
from grader.rubric import load
from tests.made_up import result


def hand_in(folder: Path, *names: str) -> Path:
    folder.mkdir(exist_ok=True)
    for name in names:
        (folder / name).write_text("x = 1\n")
    return folder


def test_the_first_line_says_what_was_found_and_what_was_not(tmp_path: Path) -> None:
    submission = read_submission(hand_in(tmp_path / "me", "filters.py", "imu_reader.py"))
    assert opening.found(submission) == (
        "me: imu_reader.py, filters.py found; no noisy_imu.py, no imu_data.png, no filtered_imu.png"
    )


def test_a_notebook_alone_is_said_to_have_none_of_the_files(tmp_path: Path) -> None:
    submission = read_submission(hand_in(tmp_path / "me", "lab.py"))
    assert opening.found(submission).startswith("me: no imu_reader.py, no noisy_imu.py")


def test_a_name_of_a_folder_cannot_colour_the_terminal(tmp_path: Path) -> None:
    assert "\x1b" not in opening.found(read_submission(hand_in(tmp_path / "\x1b[31mred", "filters.py")))


@pytest.mark.parametrize(("only", "count"), [("filtering", "6 public checks."), ("sensor_access", "5 public checks.")])
def test_the_second_line_counts_the_public_checks(tmp_path: Path, only: str, count: str) -> None:
    submission = read_submission(hand_in(tmp_path / "me", "filters.py"))
    line = opening.waiting(submission, load(), traces.shipped(), only)
    assert line.startswith(count)
    assert "hidden scenarios wait" in line


def test_an_extension_that_was_tried_adds_its_checks(tmp_path: Path) -> None:
    rubric, bundle = load(), traces.shipped()
    some = hand_in(tmp_path / "me", "filters.py")
    before = int(opening.waiting(read_submission(some), rubric, bundle, None).split()[0])
    after = int(opening.waiting(read_submission(hand_in(some, "multi_imu.py")), rubric, bundle, None).split()[0])
    assert after - before == len(next(part for part in rubric.extensions if part.id == "multiple_imus").checks) > 0


def test_the_scenarios_that_no_seed_changes_are_told_apart(tmp_path: Path) -> None:
    public, hidden = traces.obtain(None, tmp_path), traces.obtain("another seed", tmp_path)
    same = {
        name
        for name, scenario in public.scenarios.items()
        if {k: v.tobytes() for k, v in scenario.items()} == {k: v.tobytes() for k, v in hidden[name].items()}
    }
    assert same == opening.SAME_FOR_ALL
    assert public.scenarios.keys() == hidden.scenarios.keys()


def test_both_lines_stand_above_the_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def checked(*_: object, **__: object) -> Result:
        return result()

    monkeypatch.setattr(selfcheck, "check", checked)
    assert cli.main(["check", str(hand_in(tmp_path / "me", "filters.py"))]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("me: filters.py found")
    assert "public checks. " in lines[1]
    assert lines[2] == ""


def test_nothing_is_said_of_files_where_nothing_was_handed_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(selfcheck, "check", lambda *_, **__: result(status="empty"))
    assert cli.main(["check", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    assert " found\n" not in shown
    assert "public checks" not in shown


def test_the_first_line_waits_for_no_simulator_and_no_pytest() -> None:
    code = (
        "import sys; from grader import opening, rubric; from grader.intake import read_submission\n"
        "print([name for name in ('mujoco', 'matplotlib', 'scipy', 'pytest', 'grader.marking') if name in sys.modules])"
    )
    environ = {**os.environ, "PYTHONPATH": str(Path(cli.__file__).parent.parent)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environ)
    assert done.stdout.strip() == "[]"


def test_the_box_is_opened_before_anything_slow_is_imported() -> None:
    code = (
        "import sys; from grader import cli; from grader.intake import read_submission; from grader.lab_box import open_box_for\n"
        "box = open_box_for({})\n"
        "print(sorted({'numpy', 'mujoco', 'matplotlib', 'pytest', 'yaml', 'grader.results'} & set(sys.modules)))\n"
        "box.close()"
    )
    environ = {**os.environ, "PYTHONPATH": str(Path(cli.__file__).parent.parent)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environ)
    assert done.stdout.strip() == "[]"
