"""A lab of another package is checked, explained, graded, reviewed and exported by the commands, once it is installed beside them."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from urllib.parse import urljoin
from urllib.request import HTTPCookieProcessor, build_opener

import pytest

from tests.class_commands import in_process
from tests.documents import ROOT
from tests.labs.test_toy import FORGETFUL, SOUND

TOY = Path(__file__).parent / "toy"
Run = Callable[..., tuple[int, str]]


# once a process: the package stays imported from there, also where tests of others come between
@pytest.fixture(scope="session")
def here(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a class of two, and beside it the toy lab as pip installs it: a package and its entry points."""
    folder = tmp_path_factory.mktemp("toy")
    package = shutil.copytree(TOY, folder / "site" / "toy_lab", ignore=shutil.ignore_patterns("__pycache__"))
    for module in package.rglob("*.py"):
        module.write_text(module.read_text("utf-8").replace("tests.labs.toy", "toy_lab"), "utf-8")
    about = folder / "site" / "toy_lab-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: toy-lab\nVersion: 1.0\n", "utf-8")
    (about / "entry_points.txt").write_text(
        "[imugrade.labs]\ntoy = toy_lab.lab\nalias = toy_lab.lab\n", "utf-8"
    )  # the second under an id that is not the lab's
    for id_, files in {"ann": SOUND, "bea": FORGETFUL}.items():
        for name, content in files.items():
            (folder / "class" / id_).mkdir(parents=True, exist_ok=True)
            (folder / "class" / id_ / name).write_bytes(content)
    return folder


@pytest.fixture
def run(here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs a command there with `IMUGRADE_LAB` set to `lab`; its exit code and what it prints."""
    monkeypatch.chdir(here)
    monkeypatch.syspath_prepend(here / "site")
    monkeypatch.delenv("IMUGRADE_SEED", raising=False)

    def command(*arguments: str, lab: str = "") -> tuple[int, str]:
        monkeypatch.setenv("IMUGRADE_LAB", lab)
        code, out, err = in_process(capsys)(*arguments)
        return code, out + err

    return command


def test_a_submission_is_checked(run: Run) -> None:
    code, said = run("check", "class/bea", lab="toy")
    assert (code, "Score  4 / 10" in said, "Lab 0, Step 1; imugrade explain no-offset" in said) == (0, True, True), said


def test_its_faults_are_explained(run: Run) -> None:
    assert "Take 32 off first." in run("explain", "no-offset", lab="toy")[1]


def test_a_graded_class_remembers_its_lab(run: Run, here: Path) -> None:
    """Whoever exports it or grades it again need not name the lab, and cannot take it for another."""
    code, said = run("grade", "class", "-o", "out", "--jobs", "1", lab="toy")
    assert code == 0, said
    assert run("export", "out", "--format", "csv", "-o", "marks.csv")[0] == 0
    rows = (here / "marks.csv").read_text("utf-8").splitlines()
    assert rows[1:] == ["ann,ann,ann,6,4,10,10,graded", "bea,bea,bea,0,4,4,4,graded"]
    assert run("adjust", "out", "bea", "--criterion", "bonus", "--points", "1", "--comment", "neat")[0] == 0
    path = os.pathsep.join((str(here / "site"), str(ROOT)))
    review = [sys.executable, "-m", "grader", "review", "out"]
    with subprocess.Popen(review, env={**os.environ, "PYTHONPATH": path}, stdout=subprocess.PIPE, text=True) as desk:
        try:
            address = re.findall(r"http:\S+", desk.stdout.readline())[0]  # type: ignore[union-attr]
            browser = build_opener(HTTPCookieProcessor())
            browser.open(address)
            page = browser.open(urljoin(address, "/submission/bea")).read().decode()
        finally:
            desk.terminate()
    assert ("Lab 0 · review desk" in page, "final 5 = score 4 + bonus 1" in page) == (True, True)
    again = run("grade", "class", "-o", "out", "--dry-run")
    assert (again[0], "0 would be graded" in again[1]) == (0, True), again
    code, said = run("grade", "class", "-o", "out", "--dry-run", lab="imu")
    assert (code, "holds grades of the lab toy" in said) == (2, True), said


def test_a_lab_that_is_not_installed_is_refused_with_the_labs_that_are(run: Run) -> None:
    code, said = run("explain", lab="camera")
    assert (code, "choose alias, imu, toy in IMUGRADE_LAB" in said) == (2, True), said


def test_a_lab_under_another_id_is_refused(run: Run) -> None:
    """A class on record would not find it again."""
    code, said = run("explain", lab="alias")
    assert (code, "toy_lab.lab is registered as the lab alias; its id is toy" in said) == (3, True), said
