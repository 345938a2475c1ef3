from __future__ import annotations

import subprocess
import sys

import pytest

from grader.engine.check_catalog import checks_of
from grader.engine.check_runner import known_checks
from grader.engine.faults import catalogue
from grader.engine.rubric import load
from grader.labs.imu.lab import LAB
from tests.class_commands import Run, in_process


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return in_process(capsys)


def test_a_fault_is_explained_with_what_is_wrong_and_what_is_right(run: Run) -> None:
    code, out, _ = run("explain", "view-not-copy")
    assert code == 0
    assert out.startswith(
        "# view-not-copy\n\nReturns an array that changes later: a view of sensordata, or one array that every call"
    )
    assert out.index("Wrong:\n\n```python") < out.index("Right:\n\n```python") < out.index("Try: Return new arrays")
    assert out.endswith("Read: Lab 04-01, Step 2.\n\nRerun: `imugrade check --only sensor_access`\n")


def test_a_check_is_explained_with_its_points_and_its_step(run: Run) -> None:
    code, out, _ = run("explain", "filtering.passes_constant")
    assert code == 0
    assert out == (
        "# filtering.passes_constant\n\nA constant input comes out unchanged.\n\n"
        "Worth 3 points. Read: Lab 04-01, Step 6.\n\nRerun: `imugrade check --only filtering`\n"
    )


def test_an_unknown_id_is_one_line_with_the_nearest(run: Run) -> None:
    expected = "imugrade: veiw-not-copy: no fault, check or criterion has this id; did you mean view-not-copy?\n"
    assert run("explain", "veiw-not-copy") == (2, "", expected)
    assert run("explain", "\x1b[31mzzzzzz")[2].endswith("has this id; `imugrade explain` lists all of them\n")


def test_without_an_id_everything_is_listed(run: Run) -> None:
    code, out, _ = run("explain")
    listed = {line.split()[0] for line in out.splitlines() if line.startswith("  ")}
    assert code == 0
    assert listed == {*catalogue(LAB), *(check.id for check in load(LAB).checks)}


def test_what_is_read_of_the_checks_is_what_they_are_when_they_run() -> None:
    assert checks_of(LAB) == known_checks(LAB)


def test_an_explanation_imports_nothing_slow() -> None:
    told = "import sys; from grader import cli; cli.main(['explain', 'filtering']); print(*sys.modules)"
    modules = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True).stdout.split()
    assert "grader.report.explanations" in modules
    assert not {"numpy", "pytest", "mujoco", "scipy", "matplotlib", "jinja2"}.intersection(modules)
