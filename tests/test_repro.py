"""`imugrade repro`: a check as a program of a few lines that needs nothing of the grader."""

from __future__ import annotations

import ast
import io
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from grader.base.errors import RequestError
from grader.commands import repeating
from grader.engine.rubric import load
from grader.intake import read_submission
from grader.labs.imu.lab import LAB
from grader.labs.imu.repeating import WRITTEN, program
from grader.report.terminal import screen
from tests import sandboxes
from tests.classes import filters_alone
from tests.corpus.pieces import IMU_READER, edit, tidy
from tests.corpus.writing import write
from tests.examples import FOLDER
from tests.fake_results import lost, result

TRAP = "import sys\nsys.modules['grader'] = sys.modules['pytest'] = None  # as where nobody has installed us\n"


@pytest.fixture(autouse=True)
def _one_sandbox(monkeypatch: pytest.MonkeyPatch) -> None:
    """Use the sandbox of the other tests: to open one takes longer than the calls."""
    monkeypatch.setattr(repeating, "open_sandbox_for", lambda *_: sandboxes.Lasting(sandboxes.shared()))


def ran(written: Path, elsewhere: Path) -> str:
    """What the program prints, called from another folder."""
    called = TRAP + f"import runpy\nrunpy.run_path({str(written)!r}, run_name='__main__')"
    done = subprocess.run(
        [sys.executable, "-c", called], cwd=elsewhere, capture_output=True, text=True, timeout=100, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_program_shows_what_the_check_saw(tmp_path: Path) -> None:
    faulty = {"imu_reader.py": IMU_READER.replace("model.sensor_adr[accel_sensor_id]", "accel_sensor_id")}
    lab = write(faulty, tmp_path / "lab")
    written = repeating.write(load(LAB), "sensor_access.follows_address", lab, lab / ".imugrade")
    text = written.read_text()
    assert "get_imu_readings(model, data, accel_id, gyro_id)" in text
    got = text.split("Got       accel = [")[1].split("]")[0].split()
    shown = ran(written, tmp_path)
    assert all(f"{float(number):.2f}"[:-1] in shown for number in got)
    assert [path.name for path in lab.iterdir() if path.is_file()] == ["imu_reader.py"]


@pytest.mark.parametrize(
    ("check_id", "files", "said"),
    [
        ("filtering.follows_recursion", filters_alone(0.5), "output: row 1 is the first that differs, of 60: yours"),
        (
            "data_collection.matches_truth",
            edit(tidy(), "imu_reader.py", ('"angular_velocity": angular', '"angular_velocity": -angular')),
            "angular_velocity: row 1 is the first that differs, of 600: yours",
        ),
        ("data_collection.sample_count", edit(tidy(), "imu_reader.py", ("round(duration", "round(0.5 * duration")), "acceleration: 300 rows, and 600 are expected"),
    ],
)  # fmt: skip
def test_the_first_row_that_differs_stands_beside_the_expected_one(
    check_id: str, files: dict[str, str], said: str, tmp_path: Path
) -> None:
    own = write(files, tmp_path / "own")
    shown = ran(repeating.write(load(LAB), check_id, own, own / ".imugrade"), tmp_path)
    assert said in shown
    assert "expected" in shown.split(said)[1] or "are expected" in said


def test_every_kind_of_question_is_a_program_that_runs(tmp_path: Path) -> None:
    sound = FOLDER / "s15-extensions"
    student, judgements = repeating.recorded_calls(load(LAB), read_submission(sound, LAB.files))
    asked = {id_: student.questions(id_) for id_ in judgements}
    silent = {id_ for id_, questions in asked.items() if not questions}
    assert silent == {id_ for id_ in judgements if id_.startswith("realtime_visualization.")}
    kinds = {each.op: each for questions in asked.values() for each in questions}
    # twins are asked only where something is to be told apart; here only the gyroscope is noisy
    noise, biases = kinds["noise"], {"biases": np.arange(1.0, 7.0).reshape(1, 2, 3)}
    twins = {**noise.fields, "twins": [{"accel_noise_std": 0.0, "gyro_noise_std": 0.1}], "states": [0]}
    kinds["noise_twins"] = replace(noise, op="noise_twins", fields=twins, arrays={**noise.arrays, **biases})
    assert set(kinds) == set(WRITTEN)
    several = [replace(each, number=number) for number, each in enumerate(kinds.values(), 1)]
    text = program("everything", "All of it is earned.", several, os.path.relpath(sound, tmp_path))
    model = {LAB.model: student.robot.xml}
    shown = ran(repeating.write_program(tmp_path, text, several, model), tmp_path)
    yours, sensors, *_ = shown.splitlines()
    assert yours.startswith("ids {} and {}: yours ".format(*kinds["read"].arrays["pairs"][0]))
    assert yours.partition("yours ")[2] == sensors.partition("the sensors say ")[2]
    clean, noisy = (np.array(re.sub(r"[][]", " ", line).split()[-6:], float) for line in shown.splitlines()[-2:])
    assert (np.abs(noisy - clean - np.arange(1.0, 7.0)) < [1e-6] * 3 + [0.5] * 3).all()
    assert "roll and pitch, first and last:" in shown
    assert (tmp_path / "imu_data.png").is_file()


@pytest.mark.parametrize("text", ['a """ b', "a \\ b", "Got  C:\\new\n'''", 'it ends in "'])
def test_no_text_of_a_students_ends_the_programs_own(text: str) -> None:
    tree = ast.parse(program("filtering.follows_recursion", text, [], "."))
    assert isinstance(tree.body[1], ast.Import)


def test_what_cannot_be_asked_again_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "filters.py").write_text("x = 1\n")
    (tmp_path / "lab.zip").touch()
    with pytest.raises(RequestError, match=r"no check has this id; imugrade explain lists them"):
        repeating.write(load(LAB), "filtering.nothing", tmp_path, tmp_path)
    with pytest.raises(RequestError, match=r"lab\.zip is not a folder; unpack the archive"):
        repeating.write(load(LAB), "filtering.follows_recursion", tmp_path / "lab.zip", tmp_path)
    with pytest.raises(RequestError, match=r"called no \.py file here, so there is nothing to reproduce"):
        repeating.write(load(LAB), "filtering.follows_recursion", tmp_path, tmp_path)


def test_the_folder_of_a_program_is_ignored_by_git_and_never_handed_in(tmp_path: Path) -> None:
    (tmp_path / "filters.py").write_text("alpha = 0.1\n")
    before = read_submission(tmp_path, LAB.files)
    folder = repeating.folder_in(tmp_path)
    (folder / "repro.py").write_text("x = 1\n")
    assert read_submission(tmp_path, LAB.files) == before
    assert (folder / ".gitignore").read_text() == "*\n!versions.txt\n"


def test_a_lost_check_ends_with_the_call_and_how_to_get_it_as_a_program() -> None:
    console = Console(file=io.StringIO(), width=100, force_terminal=False)
    lines = [line.plain.strip() for line in screen(result(lost()), console, LAB, repeat="imugrade repro {} my_lab")]
    assert "Reproduce imugrade repro sensor_access.follows_address my_lab" in lines
    assert "with the same input as here: accel, gyro = get_imu_readings(model, data, accel_id, gyro_id)" in lines


def test_a_link_in_the_folder_leads_no_file_elsewhere(tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    lab = write({"imu_reader.py": tidy()["imu_reader.py"]}, tmp_path / "lab")
    elsewhere.mkdir()
    (lab / ".imugrade").mkdir()
    (lab / ".imugrade" / "textbook").symlink_to(elsewhere)
    with pytest.raises(RequestError, match="textbook is a link; remove it, or choose another folder with -o"):
        repeating.write(load(LAB), "sensor_access.matches_truth", lab, lab / ".imugrade")
    assert not list(elsewhere.rglob("*"))


def test_a_file_whose_name_is_no_identifier_is_imported_by_its_name(tmp_path: Path) -> None:
    lab = write({"class.py": tidy()["imu_reader.py"]}, tmp_path / "lab")
    written = repeating.write(load(LAB), "sensor_access.matches_truth", lab, lab / ".imugrade")
    ran(written, tmp_path)
