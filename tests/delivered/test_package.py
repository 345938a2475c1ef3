"""What is in the sdist and in the wheel, and what those who look after packages say of them."""

from __future__ import annotations

import subprocess
import sys
import tarfile
import zipfile

import pytest

from tests.delivered.conftest import ROOT, Delivered

pytestmark = pytest.mark.delivered


def test_the_wheel_has_each_thing_once_and_nothing_else(delivered: Delivered) -> None:
    with zipfile.ZipFile(delivered.wheel) as archive:
        names = archive.namelist()
    for wanted in [
        "humanoid-sensors.xml",
        "rubric.yaml",
        "result.schema.json",
        "public.npz",
        "report.html.j2",
        "faults.yaml",
    ]:
        assert len([name for name in names if name.endswith(f"/{wanted}")]) == 1, wanted
    assert {"grader/py.typed", "reference/py.typed", "reference/models/humanoid-sensors.xml"} <= set(names)
    beside = "imugrade-pytest.pth"  # keeps pytest from the settings of a submission
    assert names.count(beside) == 1
    tops = {name.split("/")[0].removesuffix(".dist-info").split("-")[0] for name in names if name != beside}
    assert tops == {
        "grader",
        "reference",
        "imugrade",
    }  # the last is the settings of pytest, and what the package is called


def test_the_sdist_has_the_sources_and_what_the_readme_needs_and_no_junk(delivered: Delivered) -> None:
    with tarfile.open(delivered.sdist) as archive:
        inside = {name.partition("/")[2] for name in archive.getnames()}
    assert {name.partition("/")[0] for name in inside} == {
        ".ci", ".gitignore", "CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "PKG-INFO", "README.md", "SECURITY.md", "docs", "grader", "pyproject.toml", "reference",
        "rubric.yaml", "submissions_example", "tests",
    }  # fmt: skip
    assert not [name for name in inside if "__pycache__" in name or name.startswith(".venv")]


@pytest.mark.parametrize("program", ["check_wheel_contents", "validate_pyproject.cli", "pip"])
def test_those_who_look_after_packages_have_nothing_to_say(delivered: Delivered, program: str) -> None:
    python, looked_at = {
        "check_wheel_contents": (sys.executable, delivered.wheel),
        "validate_pyproject.cli": (sys.executable, ROOT / "pyproject.toml"),
        "pip": (delivered.programs / "python", "check"),  # all that it needs came with it
    }[program]
    command = [python, "-m", program, looked_at]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
