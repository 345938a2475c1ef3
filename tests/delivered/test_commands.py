"""Every command, from an empty folder, with the sources gone: hidden scenarios from a secret wherever they may be used."""

from __future__ import annotations

import json
import shutil
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from grader.engine.results import from_dict
from grader.platforms.registry import LISTED
from tests.corpus.pieces import VERBATIM
from tests.corpus.writing import write
from tests.delivered.conftest import PIP, SECRET, Delivered
from tests.examples import expected, summary

pytestmark = pytest.mark.delivered

HIDDEN = {"environ": {"IMUGRADE_SEED": SECRET}}
WITH_A_SECRET = ("s01-sheet-verbatim", "s06-id-as-address", "s11-kills-its-interpreter", "s14-empty", "s15-extensions")
"""A sound submission and one of each kind: wrong, hostile, empty and with extensions."""


def results(out: Path) -> dict[str, bytes]:
    return {path.parent.name: path.read_bytes() for path in sorted(out.glob("submissions/*/result.json"))}


def marks(out: Path) -> dict[str, Any]:
    return {name: summary(from_dict(json.loads(result))) for name, result in results(out).items()}


@pytest.fixture(scope="session")
def out(delivered: Delivered) -> Path:
    """A part of the example class, graded with a secret by an ordinary user in an empty folder."""
    here = delivered.empty()
    for name in WITH_A_SECRET:
        shutil.copytree(delivered.examples / name, here / "class" / name)
    done = delivered.run("grade", "class", "-o", "out", cwd=here, **HIDDEN)
    assert done.returncode == 0, done.stderr
    return here / "out"


@pytest.fixture
def lab(delivered: Delivered) -> Path:
    """The sheet's own code, in a folder of the user's."""
    return write(VERBATIM, delivered.empty() / "lab")


# --- a class ----------------------------------------------------------------------------------------------------------


def test_the_first_command_of_the_readme_gives_the_example_class_its_marks(delivered: Delivered) -> None:
    assert marks(delivered.graded) == expected()
    assert (delivered.graded / "index.html").is_file()


def test_with_a_secret_examples_get_the_same_marks_and_no_page_tells_it(delivered: Delivered, out: Path) -> None:
    assert marks(out) == {name: expected()[name] for name in WITH_A_SECRET}
    written = [path for path in out.rglob("*") if path.is_file()]
    assert [path for path in written if SECRET.encode() in path.read_bytes()] == []
    hidden, public = (
        {json.loads(result)["provenance"].get("traces_sha256") for result in results(folder).values()}
        for folder in (out, delivered.graded)
    )
    assert (hidden, len(public)) == ({None}, 1)


# --- one submission ---------------------------------------------------------------------------------------------------


def test_a_student_checks_their_own_work_in_their_own_folder(delivered: Delivered, lab: Path) -> None:
    done = delivered.run("check", "--html", "../report.html", "--json", "../result.json", cwd=lab)
    assert done.returncode == 0, done.stderr
    assert json.loads((lab.parent / "result.json").read_text(encoding="utf-8"))["score"] == 100.0
    assert "</html>" in (lab.parent / "report.html").read_text(encoding="utf-8")


def test_ci_answers_with_a_secret_and_without_one(delivered: Delivered, lab: Path) -> None:
    """Gradescope's answer is that of its kit, below."""
    for words, more in ((("-o", "junit.xml"), {}), (("--format", "json", "-o", "result.json"), HIDDEN)):
        done = delivered.run("ci", lab, *words, cwd=lab.parent, **more)
        assert done.returncode == 0, done.stderr
    suites = ElementTree.parse(lab.parent / "junit.xml").getroot()
    assert {suite.get("failures") for suite in suites} == {"0"}
    assert json.loads((lab.parent / "result.json").read_text(encoding="utf-8"))["score"] == 100.0


def test_every_platform_is_there_with_all_that_it_imports(delivered: Delivered) -> None:
    code = "from grader.platforms.registry import LISTED, platform; print(*(platform(name).name for name in LISTED))"
    done = delivered.run(delivered.programs / "python", "-c", code, cwd=delivered.empty())
    assert done.stdout.split() == list(LISTED), done.stderr


# --- kits, traces, and what else there is -------------------------------------------------------------------------------


def test_each_kit_is_written(delivered: Delivered) -> None:
    here = delivered.empty()
    done = delivered.run("kit", "lab", "--classroom50", "classroom", "--github", "repository", cwd=here)
    assert done.returncode == 0, done.stderr
    assert (here / "lab/textbook/assets/robot-models/mujoco/humanoid-sensors.xml").stat().st_size > 1000
    wheels = [path for path in here.rglob("*.whl") if path.is_file()]
    assert len(wheels) == 3
    with zipfile.ZipFile(wheels[0]) as archive:
        assert {"grader/labs/imu/rubric.yaml", "grader/py.typed"} <= set(archive.namelist())


def test_the_gradescope_kit_of_a_secret_sets_itself_up_and_grades(delivered: Delivered) -> None:
    """As Gradescope does it: its archive, `setup.sh` and `run_autograder` alone."""
    here = delivered.empty()
    assert delivered.run("kit", "--gradescope", "autograder.zip", cwd=here, **HIDDEN).returncode == 0
    for folder in ("source", "submission", "results"):
        delivered.user.owns(here / folder)
    write(VERBATIM, here / "submission")
    unpacked = delivered.run(delivered.programs / "python", "-m", "zipfile", "-e", "autograder.zip", "source", cwd=here)
    assert unpacked.returncode == 0, unpacked.stderr
    there = {**PIP, "AUTOGRADER_ROOT": str(here), "AUTOGRADER_PYTHON": str(delivered.python)}
    for program in ("setup.sh", "run_autograder"):
        done = delivered.run(Path("/bin/bash"), here / "source" / program, cwd=here, environ=there)
        assert done.returncode == 0, done.stderr
    answer = json.loads((here / "results" / "results.json").read_text(encoding="utf-8"))
    assert answer["score"] == 100.0
    assert "hidden scenarios" in answer["output"]


def test_traces_are_listed_plotted_and_recorded_from_a_secret(delivered: Delivered) -> None:
    here = delivered.empty()
    assert "push: " in delivered.run("traces", "list", cwd=here).stdout
    assert delivered.run("traces", "plot", "-o", "plots", cwd=here).returncode == 0
    assert delivered.run("traces", "record", "-o", "traces", cwd=here, **HIDDEN).returncode == 0
    assert len(list((here / "plots").glob("*.png"))) > 1
    assert (here / "traces" / "hidden.npz").stat().st_size > 100_000


def test_the_reference_is_shown_live_on_a_screen(delivered: Delivered) -> None:
    xvfb = shutil.which("xvfb-run")
    if xvfb is None:
        pytest.skip("no virtual screen: xvfb is not installed")
    python, here = delivered.programs / "python", delivered.empty()
    if delivered.run(python, "-c", "import tkinter", cwd=here).returncode:
        pytest.skip("this Python has no tkinter to open a window with")
    words = [Path(xvfb), "-a", python, "-m", "reference.live_plot", "--seconds", "0.2"]
    done = delivered.run(*words, cwd=here, environ={"MPLBACKEND": "TkAgg"})
    assert (done.returncode, done.stdout, list(here.iterdir())) == (0, "", []), done.stderr
