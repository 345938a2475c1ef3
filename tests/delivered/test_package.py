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
    for wanted in (
        "humanoid-sensors.xml",
        "rubric.yaml",
        "result.schema.json",
        "public.npz",
        "report.html.j2",
        "faults.yaml",
    ):
        assert len([name for name in names if name.endswith(f"/{wanted}")]) == 1, wanted
    assert {"grader/py.typed", "reference/py.typed", "reference/models/humanoid-sensors.xml"} <= set(names)
    assert {name.split("/")[0].removesuffix(".dist-info").split("-")[0] for name in names} == {
        "grader",
        "reference",
        "imugrade",
    }


def test_the_sdist_has_the_sources_and_what_the_readme_needs_and_no_junk(delivered: Delivered) -> None:
    with tarfile.open(delivered.sdist) as archive:
        inside = {name.partition("/")[2] for name in archive.getnames()}
    assert {name.partition("/")[0] for name in inside} == {
        ".ci", ".gitignore", "CHANGELOG.md", "LICENSE", "PKG-INFO", "README.md", "SECURITY.md", "docs", "grader", "pyproject.toml", "reference",
        "rubric.yaml", "submissions_example", "tests",
    }  # fmt: skip
    assert not [name for name in inside if "__pycache__" in name or name.startswith(".venv")]


@pytest.mark.parametrize("program", ["check_wheel_contents", "validate_pyproject.cli"])
def test_those_who_look_after_packages_have_nothing_to_say(delivered: Delivered, program: str) -> None:
    looked_at = delivered.wheel if program == "check_wheel_contents" else ROOT / "pyproject.toml"
    command = [sys.executable, "-m", program, str(looked_at)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_all_that_it_needs_came_with_it(delivered: Delivered) -> None:
    done = subprocess.run(
        [delivered.programs / "python", "-m", "pip", "check"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
