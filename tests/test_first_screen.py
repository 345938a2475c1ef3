"""What a student sees of `imugrade check` beside the table: their own prints, a screen that is watched."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from grader import cli
from grader.commands.opening import found
from grader.commands.prints import Prints
from grader.engine import lab_sandbox
from grader.engine.rubric import load
from grader.engine.submission_session import SubmissionSession
from grader.intake import read_submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.sandbox.wire import Frame
from tests import sandboxes
from tests.corpus.pieces import VERBATIM
from tests.corpus.writing import notebook, write


@pytest.fixture(autouse=True)
def _one_sandbox(monkeypatch: pytest.MonkeyPatch) -> None:
    """Use the sandbox of the other tests: to open one takes longer than a check."""
    monkeypatch.setattr(lab_sandbox, "open_sandbox_for", lambda *_: sandboxes.Lasting(sandboxes.shared()))


def test_a_flood_is_cut_and_silence_is_said() -> None:
    prints = Prints()
    assert [line.plain for line in prints.lines(LAB)] == ["", "Your code printed nothing."]
    prints.add("filtering", "\n".join(map(str, range(100))))
    assert [line.plain for line in prints.lines(LAB)][-1] == "  … 70 more lines"


PRINTING = """
print("loaded")

class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.alpha, self.value = alpha, initial_value

    def update(self, measurement):
        print("asked", flush=True)
        return measurement
"""


def test_prints_are_heard_on_public_scenarios_and_never_on_hidden_ones(tmp_path: Path) -> None:
    (tmp_path / "filters.py").write_text(PRINTING)
    submission = read_submission(tmp_path, LAB.files)
    public = bundles.obtain(LAB, None)
    heard: dict[str, str] = {}
    for name in ("public", "hidden"):
        with sandboxes.opened(replace(public, name=name)) as marker:
            marker.mark(submission, only="filtering", listen=lambda _, text, name=name: heard.update({name: text}))  # type: ignore[misc]
    assert set(heard) == {"public"}
    assert heard["public"].startswith("loaded\nasked\nasked\n")


CONFLICT = "import numpy as np\n<<<<<<< HEAD\nALPHA = 0.1\n=======\nALPHA = 0.2\n>>>>>>> main\n"


@pytest.mark.parametrize(
    ("files", "place"),
    [
        pytest.param(
            {"filters.py": CONFLICT + VERBATIM["filters.py"]},
            "filters.py has an unresolved merge conflict in line 2",
            id="a program",
        ),
        pytest.param(
            {"lab.ipynb": f'{{"cells": [\n{CONFLICT}]}}', "helper.py": "A = 1"},
            "lab.ipynb has an unresolved merge conflict in line 3",
            id="a notebook",
        ),
        pytest.param(
            {"lab.ipynb": notebook(CONFLICT)}, "lab.ipynb has an unresolved merge conflict in line 9", id="a cell"
        ),
    ],
)
def test_a_merge_conflict_is_called_that(
    files: dict[str, str], place: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cli.main(["check", str(write(files, tmp_path / "lab")), "--only", "filtering"])
    assert place in " ".join(capsys.readouterr().out.split())


def test_a_notebook_whose_cells_are_timed_is_the_right_folder(tmp_path: Path) -> None:
    book = notebook(*(f"%%time\n{source}" for source in VERBATIM.values()), lines=False)
    submission = read_submission(write({"lab.ipynb": book}, tmp_path), LAB.files)
    assert "is this the right folder" not in found(LAB, submission)


def test_a_syntax_error_is_told_once_with_its_line_and_a_caret(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "imu_reader.py").write_text("import numpy as np\n\ndef get_imu_readings(model:\n    return (1, 2\n")
    assert cli.main(["check", str(tmp_path), "--only", "sensor_access"]) == 0
    shown = capsys.readouterr().out
    assert shown.count("SyntaxError") == 1
    assert "   Got       SyntaxError: " in shown
    assert re.search(r"at imu_reader.py, line \d\n {13}(\S.*)\n {13} *\^\n", shown)
    assert cli.main(["check", str(tmp_path), "--only", "sensor_access", "-s"]) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["imu_reader.py"]
    assert capsys.readouterr().out.endswith("\n\nYour code printed nothing.\n")


def test_an_extension_that_is_not_there_is_called_that(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cli.main(["check", str(write(VERBATIM, tmp_path / "lab")), "--only", "allan_variance"])
    assert "Nothing to check: there is no allan_variance.py" in capsys.readouterr().out


def test_an_interrupt_shows_what_was_judged_until_then(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def asked(student: SubmissionSession, op: str, *arguments: object) -> Frame:
        if op == "simulate":
            raise KeyboardInterrupt
        return ask(student, op, *arguments)  # type: ignore[arg-type]

    ask = SubmissionSession.ask
    monkeypatch.setattr(SubmissionSession, "ask", asked)
    write(VERBATIM, tmp_path)
    assert cli.main(["check", str(tmp_path)]) == cli.INTERRUPTED
    said = capsys.readouterr()
    table = said.out.partition("\n\n\n")[2].splitlines()
    assert table[:2] == [" ✓ Sensor access  20 / 20", " ? Data collection  – / 20"]
    left = sum(len(criterion.checks) for criterion in load(LAB).criteria[1:])
    assert table[-1] == f" ? not judged  {left} checks, 80 points: the check was stopped before them"
    assert said.err == "imugrade: stopped; run the same command again to go on\n"
    assert not (tmp_path / ".imugrade").exists()
