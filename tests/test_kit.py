"""The kits: what is in them, what is not, and that they work where they are unpacked."""

from __future__ import annotations

import ast
import base64
import csv
import hashlib
import io
import os
import re
import shutil
import subprocess
import sys
import textwrap
import zipfile
from importlib.metadata import version
from pathlib import Path
from types import SimpleNamespace

import check_jsonschema
import pytest
from click.testing import CliRunner

from grader import cli
from grader.base import class_versions
from grader.base.errors import RequestError
from grader.commands.check import _keep_versions
from grader.engine import rubric
from grader.engine.faults import catalogue
from grader.engine.traces import Traces
from grader.intake import read_submission
from grader.kit import give, wheel
from grader.labs.imu.lab import LAB
from grader.platforms import github
from grader.report import words
from reference.worlds import LAB_MODEL
from tests.conftest import SECRET
from tests.corpus.pieces import VERBATIM
from tests.corpus.writing import write

ROOT = Path(__file__).parent.parent
REFERENCE = ROOT / "reference"


@pytest.fixture(scope="module")
def students(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The students' kit, written once."""
    out = tmp_path_factory.mktemp("kit") / "lab"
    give.student(LAB, out)
    return out


@pytest.fixture(scope="module")
def autograder(tmp_path_factory: pytest.TempPathFactory, hidden: Traces) -> Path:
    """An autograder.zip with hidden traces."""
    out = tmp_path_factory.mktemp("gradescope") / "autograder.zip"
    give.gradescope(LAB, out, hidden=hidden)
    return out


def unpacked(content: bytes, under: str = "") -> dict[str, bytes]:
    """The files of an archive, those of the wheels in it too."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        found = {f"{under}{name}": archive.read(name) for name in archive.namelist()}
    for wheel_ in [name for name in found if name.endswith(".whl")]:
        found |= unpacked(found[wheel_], f"{wheel_}/")
    return found


def everything(place: Path) -> dict[str, bytes]:
    """All files of a kit, those inside of archives too."""
    found: dict[str, bytes] = {}
    for path in place.rglob("*") if place.is_dir() else [place]:
        if path.is_file():
            found[str(path)] = path.read_bytes()
        if path.suffix in (".whl", ".zip"):
            found |= unpacked(path.read_bytes(), f"{path}/")
    return found


def test_check_names_the_versions_that_differ_from_the_class(tmp_path: Path) -> None:
    assert class_versions.line(tmp_path) == "", "an instructor's own install knows no class"
    file = tmp_path / class_versions.FILE
    file.write_text(class_versions.constraints(LAB.packages))
    assert class_versions.line(tmp_path) == ""
    here = version("numpy")
    file.write_text(class_versions.constraints(LAB.packages).replace(f"numpy=={here}", "numpy==1.99.0"))
    said = f"Your versions differ from your class: numpy {here} (class: 1.99.0)."
    assert class_versions.line(tmp_path) == f"{said} python -m pip install -r constraints.txt installs the same."


def test_the_versions_at_home_are_noted_where_they_differ_from_those_of_the_grading(tmp_path: Path) -> None:
    kit = SimpleNamespace(folder=tmp_path / "kit", packages=("numpy", "scipy"))
    lab = write({"imu_reader.py": "x = 1\n"}, tmp_path / "lab")
    _keep_versions(kit, lab)  # type: ignore[arg-type]
    assert not (lab / ".imugrade").exists(), "an instructor's check changes no hand-in"
    write({class_versions.FILE: ""}, kit.folder)
    _keep_versions(kit, lab)  # type: ignore[arg-type]
    assert read_submission(lab, LAB.files).notes == ()
    kept = lab / ".imugrade" / "versions.txt"
    here = version("numpy")
    kept.write_text(kept.read_text().replace(f"numpy=={here}", "numpy==1.99.0") + "<b>==<script>\nno-such==9\npip==9\n")
    (lab / ".imugrade" / "repro.py").write_text("y = 1\n")
    zipped = Path(shutil.make_archive(str(tmp_path / "zipped"), "zip", lab))
    for handed_in in (read_submission(lab, LAB.files), read_submission(zipped, LAB.files)):
        assert [*handed_in.files] == ["imu_reader.py"]
        (note,) = handed_in.notes
        assert f"with other versions: numpy 1.99.0 there, {here} here. If" in note


# --- what is in them, and what is not ---------------------------------------------------------------------------------


@pytest.mark.plain
def test_students_get_starter_files_the_model_at_the_sheets_path_motions_a_readme_and_the_wheel(students: Path) -> None:
    found = {path.relative_to(students).as_posix() for path in students.rglob("*") if path.is_file()}
    model = "textbook/assets/robot-models/mujoco/humanoid-sensors.xml"
    editors = {".devcontainer/devcontainer.json", ".vscode/settings.json", ".vscode/tasks.json"}
    motions = {f"traces/{name}.{kind}" for name in ("standing", "push", "tumbling") for kind in ("csv", "png")}
    assert found == {*VERBATIM, "README.md", "constraints.txt", words.GUIDE, model, wheel.name(), *editors, *motions}
    assert (students / model).read_bytes() == LAB_MODEL.read_bytes()


def test_the_guide_holds_every_student_page_and_works_offline(students: Path) -> None:
    text = (students / words.GUIDE).read_text(encoding="utf-8")
    titles = [
        page.read_text(encoding="utf-8").partition("\n")[0][2:] for page in (ROOT / "docs" / "students").glob("*.md")
    ]
    assert [title for title in [*titles, "All checks", "All faults"] if f">{title}</h1>" not in text] == []
    assert {f">{fault}</h3>" for fault in catalogue(LAB)} <= set(re.findall(r">[\w-]+</h3>", text))
    assert set(re.findall(r'href="#([^"]+)"', text)) <= set(re.findall(r' id="([^"]+)"', text))
    assert re.findall(r'(?:src|href)="(?!#|data:|https://)[^"]*"|<script|<link', text) == []


def test_no_kit_holds_a_piece_of_the_reference(students: Path, autograder: Path) -> None:
    solution = [path for path in REFERENCE.rglob("*") if path.is_file() and path.suffix in (".py", ".png")]
    contents = {path.read_bytes() for path in solution if path.stat().st_size}
    # traces.py shares the fingerprint of a bundle with its reader, word for word
    programs = [p.read_text(encoding="utf-8") for p in solution if p.suffix == ".py" and p.name != "traces.py"]
    telling = {line.strip() for text in programs for line in text.splitlines() if len(line.strip()) >= 50}
    telling -= {line.strip() for line in "\n".join(VERBATIM.values()).splitlines()}
    assert len(telling) > 200
    for name, content in {**everything(students), **everything(autograder)}.items():
        assert "/reference/" not in name
        assert content not in contents, name
        if name.endswith((".py", ".txt")) and "/standins/" not in name:  # stand-ins say what the sheet says
            shared = telling & {line.strip() for line in content.decode().splitlines()}
            imports = ("from ", "import ", "#")  # they are not the solution of anything
            assert {line for line in shared if not line.startswith(imports)} == set(), name


def test_no_kit_holds_a_seed_and_only_gradescope_holds_hidden_traces(students: Path, autograder: Path) -> None:
    for place in (students, autograder):
        for name, content in everything(place).items():
            assert SECRET.encode() not in content, name
    held = [name for name in everything(autograder) if name.endswith(".npz")]
    assert sorted(Path(name).name for name in held) == ["hidden.npz", "public.npz"]
    assert [Path(name).name for name in everything(students) if name.endswith(".npz")] == ["public.npz"]


@pytest.mark.parametrize("stray", ["hidden.npz", "hidden.json", "class.npz", "secret.env", "results.sqlite"])
def test_a_bundle_that_an_instructor_left_in_the_package_is_not_packed(stray: str) -> None:
    assert not wheel._belongs(Path("labs", "imu", stray))
    assert wheel._belongs(Path("labs", "imu", "public.npz"))


def test_the_wheel_is_as_pip_wants_it_and_the_same_each_time(students: Path) -> None:
    content = (students / wheel.name()).read_bytes()
    packed = unpacked(content)
    info = wheel.name().replace("-py3-none-any.whl", ".dist-info")
    rows = list(csv.reader(io.StringIO(packed[f"{info}/RECORD"].decode())))
    assert {row[0] for row in rows} == set(packed)
    for name, digest, size in rows[:-1]:
        sha = base64.urlsafe_b64encode(hashlib.sha256(packed[name]).digest()).rstrip(b"=").decode()
        assert (digest, size) == (f"sha256={sha}", str(len(packed[name])))
    assert b"extra ==" not in packed[f"{info}/METADATA"]
    assert b"Requires-Dist: mujoco>=3.0" in packed[f"{info}/METADATA"]
    assert b"MIT License" in packed[f"{info}/licenses/LICENSE"]
    assert wheel.build(LAB, rubric.shipped(LAB)) == content


def test_the_wheel_carries_the_rubric_that_is_named(tmp_path: Path) -> None:
    other = tmp_path / "rubric.yaml"
    other.write_text((ROOT / "rubric.yaml").read_text().replace("matches_truth: 6", "matches_truth: 7", 1))
    give.job("classroom50", LAB, tmp_path / "kit", other)
    packed = unpacked((tmp_path / "kit" / wheel.name()).read_bytes())
    assert packed["grader/labs/imu/rubric.yaml"] == other.read_bytes()


def test_a_rubric_that_would_stop_every_students_check_makes_no_kit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    misspelt = tmp_path / "rubric.yaml"
    misspelt.write_text((ROOT / "rubric.yaml").read_text().replace("matches_truth", "matches_trut", 1))
    assert cli.main(["kit", str(tmp_path / "kit"), "--rubric", str(misspelt)]) == 2
    assert "there is no check sensor_access.matches_trut" in capsys.readouterr().err
    assert not (tmp_path / "kit").exists()


# --- starter files ----------------------------------------------------------------------------------------------------


def signatures(source: str) -> dict[str, str]:
    """Functions, classes and methods with their parameters."""
    found = {}
    for node in ast.parse(source).body:
        members = node.body if isinstance(node, ast.ClassDef) else [node]
        prefix = f"{node.name}." if isinstance(node, ast.ClassDef) else ""
        found |= {f"{prefix}{m.name}": ast.unparse(m.args) for m in members if isinstance(m, ast.FunctionDef)}
    return found


@pytest.mark.parametrize("name", sorted(VERBATIM))
def test_the_starter_files_have_the_sheets_signatures_and_say_what_is_to_do(students: Path, name: str) -> None:
    source = (students / name).read_text(encoding="utf-8")
    assert signatures(source).items() >= signatures(VERBATIM[name]).items()
    assert source.count("TODO Step") >= len(signatures(VERBATIM[name]))


@pytest.mark.parametrize(
    ("file", "said"),
    [
        (
            "imu_reader.py",
            ".*sensors.*\n.*written: Step 2, get_imu_readings\n.*written: Step 3, simulate_and_collect\n",
        ),
        ("filters.py", ".*written: Step 6, LowPassFilter\n"),
    ],
)
def test_each_starter_file_runs_and_says_what_is_not_written(
    file: str, said: str, students: Path, tmp_path: Path
) -> None:
    shutil.copytree(students, tmp_path, dirs_exist_ok=True)
    if file == "filters.py":
        (tmp_path / "noisy_imu.py").write_text("class NoisyIMU:\n    def __init__(self, *_): ...\n")
    environ = {**os.environ, "MPLBACKEND": "Agg"}
    command = [sys.executable, file]
    done = subprocess.run(command, cwd=tmp_path, env=environ, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert re.fullmatch(said, done.stdout), done.stdout


def test_a_stand_in_uses_nothing_that_the_sheet_does_not_print() -> None:
    """The wheel has to hold the stand-ins, since checks need a sound partner. Each is a part that the sheet gives in full."""
    sheet = ast.parse((LAB.folder / "sheet.txt").read_text(encoding="utf-8"))
    given = {node.name for node in ast.walk(sheet) if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    # how rows are gathered, ids are looked up, and what a call gave is put in order
    plumbing = {"append", "array", "concatenate", "id", "integer", "reshape", "sensor", "startswith"}
    for path in (LAB.folder / "standins").glob("*.txt"):
        assert path.stem in given
        assert _attributes(ast.parse(path.read_text(encoding="utf-8"))) <= _attributes(sheet) | plumbing, path.name


def _attributes(tree: ast.AST) -> set[str]:
    return {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}


# --- what is not overwritten ------------------------------------------------------------------------------------------


def test_nothing_that_is_there_is_overwritten(tmp_path: Path, workflows: Path) -> None:
    for name in (".vscode", "filters.py"):
        (tmp_path / name).write_text("my work\n")
        with pytest.raises(RequestError, match="the folder is not empty; choose a new one"):
            give.student(LAB, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {".vscode", "filters.py"}
    with pytest.raises(RequestError, match="it is there already"):
        give.gradescope(LAB, tmp_path / "filters.py")
    with pytest.raises(RequestError, match=r"imugrade\.yml: it is there already"):
        give.job("github", LAB, workflows)


# --- platforms --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def workflows(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A repository with a kit for each platform, and the documented workflow for hidden scenarios."""
    out = tmp_path_factory.mktemp("repository")
    for kit in ("github", "gitlab", "classroom50"):
        give.job(kit, LAB, out)
    (block,) = re.findall(r"^    name: Lab 04-01, hidden.*\n(?:    .*\n)*", github.PLATFORM.help.respond, re.MULTILINE)
    (out / ".github/workflows/hidden.yml").write_text(textwrap.dedent(block), encoding="utf-8")
    return out


def test_an_audit_of_the_workflows_finds_nothing(workflows: Path, tmp_path: Path) -> None:
    """zizmor, as strict as it can be: unpinned actions, credentials left behind, permissions, templates that are injected."""
    audit = [Path(sys.executable).with_name("zizmor"), "--offline", "--no-progress", "--persona", "auditor"]
    done = subprocess.run([*audit, "--strict-collection", workflows], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    shutil.copytree(workflows, tmp_path, dirs_exist_ok=True)
    loose = tmp_path / ".github/workflows/imugrade.yml"
    loose.write_text(re.sub(r"checkout@\w+ # ", "checkout@", loose.read_text()))
    assert subprocess.run([*audit, tmp_path], capture_output=True, check=False).returncode > 10


@pytest.mark.parametrize(
    ("platform", "files"), [("github-workflows", ".github/workflows/*.yml"), ("gitlab-ci", ".*.yml")]
)
def test_what_a_ci_reads_is_what_its_schema_allows(platform: str, files: str, workflows: Path, tmp_path: Path) -> None:
    """The schemas of schemastore.org, as the validator ships them."""
    copied = [Path(shutil.copy(each, tmp_path)) for each in workflows.glob(files)]
    arguments = ["--builtin-schema", f"vendor.{platform}", *map(str, copied)]
    done = CliRunner().invoke(check_jsonschema.main, arguments)
    assert done.exit_code == 0, done.output
    for file in copied:
        file.write_text(file.read_text(encoding="utf-8").replace("script:", "skript:").replace("runs-on:", "on-runs:"))
    assert CliRunner().invoke(check_jsonschema.main, arguments).exit_code == 1


def test_the_platforms_install_the_versions_of_the_class(workflows: Path) -> None:
    for folder in (".github/imugrade", ".gitlab/imugrade", ""):
        assert (workflows / folder / "constraints.txt").read_text() == class_versions.constraints(LAB.packages)
    files = [path for path in workflows.rglob("*") if path.suffix in (".py", ".yml") and path.name != "hidden.yml"]
    assert [path for path in files if "constraints.txt" not in path.read_text(encoding="utf-8")] == []
    assert len(files) >= 3


def test_gradescope_finds_both_programs_at_the_root_and_executable(autograder: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(autograder) as archive:
        modes = {entry.filename: entry.external_attr >> 16 & 0o777 for entry in archive.infolist()}
        archive.extractall(tmp_path)
    assert (modes["setup.sh"], modes["run_autograder"]) == (0o755, 0o755)
    assert (tmp_path / "constraints.txt").read_text() == class_versions.constraints(LAB.packages)
    for name in ("setup.sh", "run_autograder"):
        assert b"\r" not in (tmp_path / name).read_bytes()
        subprocess.run(["bash", "-n", name], cwd=tmp_path, check=True)
