"""No second copy: what lies beside the grader that runs (an install, a checkout, an egg) is not to be read in any sandbox."""

from __future__ import annotations

import json
import shutil
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

import grader
import reference
from grader.sandbox import surroundings, visible_copies
from grader.sandbox.plan import Contents
from grader.sandbox.sandbox import Sandbox

from .conftest import ISOLATING, WORKER_CODE, run

SOLUTION = Path(reference.__file__).parent
PACKAGE = Path(grader.__file__).parent


def installed(folder: Path, name: str, files: list[str], *, requires: str = "", options_of: bool = False) -> None:
    """Write the record of a distribution as pip does."""
    record = folder / f"{name}-1.0.dist-info"
    record.mkdir(parents=True)
    (record / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\n{requires}\n\nWords.\n")
    (record / "RECORD").write_text("".join(f"{file},sha256=x,1\n" for file in [*files, f"{record.name}/METADATA,,"]))
    (record / "direct_url.json").write_text(
        json.dumps({"url": "file:///home/prof/imugrade", "dir_info": {"editable": True}})
    )
    if options_of:
        (record / "REQUESTED").write_text("")


def write(folder: Path, name: str, text: str) -> None:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout with a virtual environment in it, which holds an installed copy, an egg, a path file and packages for students."""
    place = tmp_path / "checkout"
    shutil.copytree(SOLUTION, place / "reference")
    folder = place / ".venv/lib/python3/site-packages"
    for name, source in (("reference", SOLUTION), ("grader/labs/imu/standins", PACKAGE / "labs" / "imu" / "standins")):
        shutil.copytree(source, folder / name)
    write(folder, "grader/__init__.py", "")
    installed(folder, "imugrade", ["grader/__init__.py", "reference/filters.py"], requires="Requires-Dist: ourtool\n")
    shutil.copytree(SOLUTION, folder / "imugrade-0.0.9-py3.11.egg/reference")
    write(folder, "__editable__.imugrade-0.1.0.pth", str(place))
    write(folder, "_imugrade.pth", str(place))
    shutil.copytree(SOLUTION, folder / "stray")
    shutil.copytree(SOLUTION, folder / "solutions")
    installed(folder, "solutions", ["solutions/filters.py", "reference/filters.py"])
    write(folder, "labtools/__init__.py", "from labneeds import ANSWER")
    installed(
        folder,
        "labtools",
        ["labtools/__init__.py", "labtools.pth"],
        requires='Requires-Dist: Lab_Needs[fast] ; python_version > "3"\n',
    )
    write(folder, "labneeds.py", "ANSWER = 42")
    installed(folder, "lab.needs", ["labneeds.py", "../../../bin/labneeds"])
    for tool, options_of in (("ourtool", False), ("theirtool", True)):
        write(folder, f"{tool}.py", "")
        installed(folder, tool, [f"{tool}.py"], options_of=options_of)
    with zipfile.ZipFile(folder / "imugrade-0.1.0-py3-none-any.whl", "w") as archive:
        archive.write(SOLUTION / "filters.py", "reference/__init__.py")
    for path in (str(place), str(folder)):
        monkeypatch.syspath_prepend(path)
    return place


# The libraries of the system are left to the search of the doctor, below.
SEARCH = """
import os
found, seen = [], set()
for root in ROOTS:
    for top, folders, names in os.walk(root):
        if top in seen or top.startswith(("/proc", "/sys", "/dev", "/lib", "/usr")):
            folders.clear()
            continue
        seen.add(top)
        for path in (os.path.join(top, name) for name in names):
            try:
                with open(path, "rb", buffering=0) as file:
                    if PHRASE in file.read(1 << 20): found.append(path)
            except OSError:
                pass
result = sorted(set(found))
"""


@pytest.mark.parametrize(
    "isolating_sandbox",
    [pytest.param(name, marks=[pytest.mark.weekly] if n else []) for n, name in enumerate(ISOLATING)],
    indirect=True,
)
def test_a_submission_finds_no_copy_wherever_it_searches_and_what_was_installed_for_students(
    isolating_sandbox: Sandbox, checkout: Path
) -> None:
    roots = [str(checkout), str(checkout.parent), "/", *sys.path, *surroundings.visible()]
    phrase = b"get_imu_readings"
    assert phrase in (checkout / "reference/imu_reader.py").read_bytes()
    level = isolating_sandbox.isolation_level.name
    with Sandbox(Contents(WORKER_CODE), isolation_level=level) as sandbox, sandbox.worker() as worker:
        source = SEARCH.replace("ROOTS", repr(list(dict.fromkeys(roots)))).replace("PHRASE", repr(phrase))
        assert run(worker, source, cpu_s=120) == {"result": []}
        for name in ("reference", "grader", "stray", "solutions", "ourtool"):
            assert run(worker, f"import {name}")["error"] == "ModuleNotFoundError"
        assert run(worker, "import labtools, theirtool; result = labtools.ANSWER") == {"result": 42}
        names = "import importlib.metadata as m; result = sorted(d.name for d in m.distributions() if d.name.startswith('lab'))"
        assert run(worker, names) == {"result": ["lab.needs", "labtools"]}


def test_the_search_of_the_doctor_finds_a_copy_where_one_is_shown(
    checkout: Path, monkeypatch: pytest.MonkeyPatch, best: Sandbox
) -> None:
    """Three copies that the sandbox must not show, shown all the same: by name, by content, and within an archive."""
    folder = checkout / ".venv/lib/python3/site-packages"
    shown = tuple(str(folder / name) for name in ("grader", "stray", "imugrade-0.1.0-py3-none-any.whl"))
    visible = surroundings.visible
    monkeypatch.setattr(surroundings, "visible", lambda extra=(), libraries=(): (*visible(extra, libraries), *shown))
    found = visible_copies.search(best.isolation_level).found
    assert {f"{shown[0]}/__init__.py", f"{shown[1]}/filters.py", shown[2]} <= set(found)
    assert not [path for path in found if not path.startswith(str(folder))]


# What is shown --------------------------------------------------------------------------------------------------------


def test_no_folder_of_users_or_of_the_system_is_shown_whole_but_for_its_libraries() -> None:
    shown = set(surroundings.visible())
    assert not shown & {"/", "/etc", "/home", "/root", "/tmp", "/usr", "/var", str(Path.home()), str(Path.cwd())}
    assert not shown & {sys.prefix, f"{sys.prefix}/lib", sysconfig.get_path("purelib")}
    assert not [path for path in shown if path.endswith((".pth", ".egg-link"))]


def test_packages_of_every_python_in_a_folder_of_libraries_are_hidden(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    packages = ("python3/dist-packages", "python3.11/site-packages", "hash-numpy/lib/python3.11/site-packages")
    for name in packages:
        write(tmp_path, f"{name}/grader/__init__.py", "")
    monkeypatch.setattr(surroundings, "LIBRARIES", (str(tmp_path),))
    assert {str(tmp_path / name) for name in packages} <= set(surroundings.hidden())
