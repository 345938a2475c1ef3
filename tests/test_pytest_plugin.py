"""`pytest --imugrade`: the checks of a submission as ordinary tests, in a plain terminal and as editors and CI read them."""

from __future__ import annotations

import itertools
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from junitparser import xunit2

from grader.engine.rubric import load
from grader.labs.imu.lab import LAB
from grader.pytest_plugin import plugin
from tests.corpus.pieces import FILTERS, IMU_READER, NOISY

READER_BY_ID = IMU_READER.replace("model.sensor_adr[accel_sensor_id]", "accel_sensor_id")
NO_FILTER = (
    "class LowPassFilter:\n    def __init__(self, alpha=0.1, initial_value=None):\n        raise ValueError(alpha)\n"
)
TRAP = 'open(__file__ + ".ran", "w").close()\n\n\ndef test_no_work_no_points():\n    open(__file__ + ".ran", "w").close()\n'


PTH = Path(plugin.__file__).with_name("imugrade-pytest.pth")
INSTALLED = f"import site; site.addsitedir({str(PTH.parent)!r}); import sys, pytest; sys.exit(pytest.console_main())"
"""Python's start with our `.pth` file among the installed packages, then the command `pytest`."""


def run_installed(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """The command `pytest` as installed, run there."""
    bare = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST_", "COLUMNS"))}
    command = [sys.executable, "-c", INSTALLED, "--imugrade", *arguments]
    return subprocess.run(command, cwd=folder, env=bare, capture_output=True, text=True, timeout=300, check=False)


def run(folder: Path, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """pytest as a student runs it there, without what is set for our own tests."""
    bare = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST_", "COLUMNS"))}
    command = [sys.executable, "-m", "pytest", "--imugrade", "-p", "no:hypothesispytest", *arguments]
    return subprocess.run(
        command, cwd=folder, env=bare | environment, capture_output=True, text=True, timeout=300, check=False
    )


@pytest.fixture
def lab(tmp_path: Path) -> Path:
    """Two faults, and beside them what pytest would run by itself."""
    files = {"imu_reader.py": READER_BY_ID, "noisy_imu.py": NOISY, "filters.py": NO_FILTER}
    for name, text in {**files, "conftest.py": TRAP, "test_own.py": TRAP, "__init__.py": TRAP}.items():
        (tmp_path / name).write_text(text)
    return tmp_path


# --- a run ------------------------------------------------------------------------------------------------------------


@pytest.mark.plain
def test_lost_checks_are_failures_in_the_students_own_files_and_nothing_of_the_folder_runs_here(lab: Path) -> None:
    ran = run(lab, "-v", "--junitxml=junit.xml", "--tb=short")
    lines = ran.stdout.splitlines()
    reader = READER_BY_ID.splitlines().index("def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):") + 1
    assert ran.returncode == 1, ran.stdout + ran.stderr
    assert sum("::" in line and " PASSED " in line for line in lines) > 15
    assert any(line.startswith("imu_reader.py::sensor_access::follows_address FAILED") for line in lines)
    assert f"imu_reader.py:{reader}: partial" in lines
    assert "filters.py:3: raised" in lines
    assert "   Read      Lab 04-01, Step 2; imugrade explain sensor-id-as-address" in lines
    assert any(line.startswith("FAILED filters.py::filtering::follows_recursion - ") for line in lines)
    assert any(line.split() == ["Noise", "model", "20", "/", "20"] for line in lines)
    assert not list(lab.glob("*.ran"))
    assert "items.py" not in ran.stdout

    suites = xunit2.JUnitXml.fromfile(str(lab / "junit.xml"))
    tests = [xunit2.TestCase.fromelem(case) for suite in suites for case in suite]
    cases = {f"{case.classname}.{case.name}": case for case in tests}
    assert len(cases) == len([check for part in load(LAB).criteria for check in part.checks])
    lost = cases["imu_reader.sensor_access.follows_address"]
    told = {prop.get("name"): prop.get("value") for prop in lost._elem.iter("property")}
    facts = {"points": "3.0", "max_points": "6.0", "fault": "sensor-id-as-address"}
    assert told.items() >= facts.items()
    assert lost.result[0].message.startswith("accel = ")
    skipped = cases["filters.filtering.passes_constant"].result[0]
    assert skipped.message.startswith("Not graded until ")


@pytest.mark.weekly
def test_a_worker_of_xdist_tells_the_same_and_lf_asks_for_what_was_lost(lab: Path) -> None:
    (lab / "filters.py").write_text(FILTERS)
    with_worker = run(lab, "-n", "1", "-q", "-k", "sensor_access")
    assert with_worker.returncode == 1, with_worker.stdout + with_worker.stderr
    assert "FAILED imu_reader.py::sensor_access::follows_address" in with_worker.stdout
    assert "Sensor access      15.5 / 20" in with_worker.stdout
    again = run(lab, "--lf", "--collect-only", "-q", "-p", "no:xdist")
    lost = [f"imu_reader.py::sensor_access::{name}" for name in ("matches_truth", "follows_address")]
    assert again.stdout.splitlines()[:2] == lost
    assert "2/30 tests collected (28 deselected)" in again.stdout


TWICE = """
from _pytest.runner import runtestprotocol
def pytest_runtest_protocol(item, nextitem):
    for _ in range(2):
        for report in runtestprotocol(item, nextitem=nextitem, log=False):
            item.ihook.pytest_runtest_logreport(report=report)
    return True
"""


@pytest.mark.weekly
def test_a_check_that_another_plugin_runs_again_counts_once(
    lab: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    plugin = tmp_path_factory.mktemp("plugin") / "twice.py"
    plugin.write_text(TWICE)
    ran = run(
        lab,
        "-q",
        "-p",
        "twice",
        "-p",
        "no:xdist",
        "sensor_access",
        "--junitxml=junit.xml",
        PYTHONPATH=str(plugin.parent),
    )
    assert "Sensor access      15.5 / 20" in ran.stdout, ran.stdout + ran.stderr
    assert (lab / "junit.xml").read_text().count('name="max_points" value="6.0"') == 2


SETTINGS = {
    "pytest.ini": "[pytest]\n{}\n",
    "tox.ini": "[pytest]\n{}\n",
    "setup.cfg": "[tool:pytest]\n{}\n",
    "pyproject.toml": "[tool.pytest.ini_options]\n{}\n",
}
WAYS = {
    "a plugin": "addopts = -p evil",
    "a path and a warning": "pythonpath = .\nfilterwarnings = ignore::evil.X",
    "a rubric with checks": "addopts = --imugrade-rubric=evil.yaml",
}


@pytest.mark.parametrize(
    ("file", "way", "where"),
    [
        pytest.param(*row, marks=[pytest.mark.weekly] if n % 5 else [])  # each file, way and place on every change
        for n, row in enumerate(itertools.product(SETTINGS, WAYS, ("inside", "beside")))
    ],
)
def test_the_settings_of_a_submission_are_not_read(lab: Path, file: str, way: str, where: str) -> None:
    quoted = "\n".join(f'{key} = "{value}"' for key, value in (line.split(" = ") for line in WAYS[way].splitlines()))
    (lab / file).write_text(SETTINGS[file].format(quoted if file == "pyproject.toml" else WAYS[way]))
    (lab / "evil.py").write_text(TRAP + "class X(Warning):\n    pass\n")
    folder, arguments = (lab, []) if where == "inside" else (lab.parent, [lab.name])
    ran = run_installed(folder, *arguments, "--collect-only", "-q", "-p", "no:hypothesispytest")
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert not list(lab.glob("*.ran"))


@pytest.mark.skipif(sys.version_info < (3, 11), reason="Python 3.10 cannot be told to leave the present folder out")
@pytest.mark.parametrize(
    "command",
    [
        [sys.executable, "-mpytest"],
        [sys.executable, "-Bm", "pytest"],
        [str(Path(sys.executable).with_name("pytest")), "-n", "1"],
    ],
    ids=" ".join,
)
def test_nothing_of_the_folder_is_imported_however_pytest_and_its_workers_start(
    lab: Path, tmp_path_factory: pytest.TempPathFactory, command: list[str]
) -> None:
    for name in ("pytest", "pluggy", "execnet"):
        (lab / f"{name}.py").write_text(TRAP)
    start = tmp_path_factory.mktemp("start")
    (start / "sitecustomize.py").write_text(f"import site; site.addsitedir({str(PTH.parent)!r})")
    bare = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST_", "PYTHONSAFEPATH"))}
    ran = subprocess.run(
        [*command, "--imugrade", "-q", "-k", "nothing"],
        cwd=lab,
        env=bare | {"PYTHONPATH": str(start)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert ran.returncode in (pytest.ExitCode.USAGE_ERROR, pytest.ExitCode.NO_TESTS_COLLECTED), ran.stdout + ran.stderr
    assert not list(lab.glob("*.ran"))


def test_settings_that_pytest_has_read_all_the_same_stop_the_run(lab: Path) -> None:
    (lab / "pytest.ini").write_text("[pytest]\naddopts = -q\n")
    unseen = "import sys, pytest; sys.exit(pytest.main(['--imugrade', '-p', 'no:hypothesispytest', '--collect-only']))"
    command = [sys.executable, "-c", unseen]  # no argument by which Python's start can tell
    ran = subprocess.run(command, cwd=lab, capture_output=True, text=True, timeout=300, check=False)
    assert ran.returncode == pytest.ExitCode.USAGE_ERROR
    assert f"imugrade: pytest has read {lab}/pytest.ini, and settings may run code." in ran.stderr


# --- what is found without running anything ---------------------------------------------------------------------------

AS_AN_EDITOR = """
import json, os
def pytest_collection_finish(session):
    told = []
    for item in session.items:
        path, tail = os.fspath(item.path), item.nodeid.split("::")[1:]
        levels, folder = 0, item.parent.path.parent
        while folder != session.path:  # the editor's own loop, which ends nowhere for a file that lies elsewhere
            levels, folder = levels + 1, folder.parent
            assert levels < 100
        told.append({"id": "::".join([path, *tail]), "path": path, "line": item.location[1] + 1})
    with open(os.environ["TOLD"], "w") as file:
        json.dump(told, file)
"""


def test_an_editor_finds_each_check_once_at_the_students_own_definition(lab: Path, tmp_path: Path) -> None:
    (lab / "plugins").mkdir()
    (lab / "plugins" / "editor.py").write_text(AS_AN_EDITOR)
    (lab / "filters.py").unlink()
    ran = run(lab, "--collect-only", "-q", "-p", "editor", PYTHONPATH=str(lab / "plugins"), TOLD=str(lab / "told"))
    told = json.loads((lab / "told").read_text())
    where = {each["id"]: (each["path"], each["line"]) for each in told}
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert len(where) == len(told)
    noisy = NOISY.splitlines().index("class NoisyIMU:") + 1
    assert where[f"{lab}/noisy_imu.py::noise_model::noise_size"] == (f"{lab}/noisy_imu.py", noisy)
    assert where[f"{lab}/filters.py::filtering::follows_recursion"] == (f"{lab}/filters.py", 1)
    chosen = f"{lab}/imu_reader.py::data_collection::matches_truth"
    assert run(lab, "--collect-only", "-q", chosen).stdout.splitlines()[0] == chosen.removeprefix(f"{lab}/")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nowhere"], "imugrade: nowhere: there is no such file or folder"),
        (["filtering::nothing"], "imugrade: no check has this name"),
        (["plugins"], "imugrade: plugins: This submission contains nothing that the lab asks for."),
        (["--imugrade-rubric", "no.yaml"], "there is no such file; give the path of a rubric.yaml"),
    ],
)
def test_a_request_that_cannot_be_met_is_one_line(
    lab: Path, arguments: list[str], said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (lab / "plugins").mkdir()
    monkeypatch.chdir(lab)
    assert pytest.main(["--imugrade", *arguments]) == pytest.ExitCode.USAGE_ERROR
    assert said in capsys.readouterr().err


# --- unless asked -----------------------------------------------------------------------------------------------------


def test_a_run_that_does_not_ask_loads_two_options_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text(
        "import sys\n\n\ndef test_it():\n"
        "    ours = sorted(name for name in sys.modules if name.split('.')[0] == 'grader')\n"
        "    assert ours == ['grader', 'grader.pytest_plugin', 'grader.pytest_plugin.plugin']\n"
    )
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "error", "test_it.py"]
    bare = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    ran = subprocess.run(command, cwd=tmp_path, env=bare, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout
