"""Run every command of the README and the documentation, with the files that they assume.

A command that is newly documented is run without a word here; one of a new kind fails until there is a line on what comes of it.
"""

from __future__ import annotations

import csv
import difflib
import functools
import importlib
import inspect
import io
import itertools
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
import typer.main

from grader import cli
from grader.commands import machine
from grader.course import classroom, pool
from grader.engine import lab_sandbox
from grader.engine.rubric import load, shipped
from grader.intake import Submission
from grader.kit import give, wheel
from grader.labs.imu import bundles, handout, motions
from grader.labs.imu.lab import LAB
from grader.platforms import registry
from grader.pytest_plugin import items
from grader.report import truth
from tests import sandboxes
from tests.classes import Student, canvas, canvas_gradebook, filters_alone, moodle, moodle_worksheet
from tests.corpus.pieces import VERBATIM, tidy
from tests.corpus.writing import write
from tests.documents import ROOT, Command, commands, documents
from tests.test_cluster import Site, until

COMMANDS = tuple(commands(documents()))
STUDENTS = {
    "alice": Student(0, "Alice", "Adams", filters_alone(1.0)),
    "bob": Student(1, "Bob", "Brown", filters_alone(0.5)),
}
EXAMPLE = "s06-id-as-address"
STANDS_FOR = {"SUBMISSIONS": "submissions", "OUT": "out-monday", "DOWNLOAD": "submissions", "ID": "view-not-copy"}
STANDS_FOR |= {"R": "none", "F": "poison"}
CRITERIA = tuple(criterion.id for criterion in load(LAB).criteria)
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}
PLATFORMS_SAY = ("GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY", "GITHUB_WORKSPACE", "CLASSROOM", "IMUGRADE_SEED")


# --- what the documents assume ----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ready(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A class that has handed in, its downloads and tables, gradings of it, and a student's own work."""
    place = tmp_path_factory.mktemp("ready")
    _hand_in(place)
    with pytest.MonkeyPatch.context() as here:
        here.setenv("IMUGRADE_CACHE", str(tmp_path_factory.mktemp("cache")))
        here.setattr(os, "cpu_count", lambda: 1)
        for name in PLATFORMS_SAY:
            here.delenv(name, raising=False)
        _share_a_sandbox(here)
        _draw_few_motions(here)
        here.chdir(place)
        truth.save(bundles.obtain(LAB, "...", None), place)
        assert run(["grade", "submissions", "-o", "out-monday", "--roster", "roster.csv"])[0] == 0
        with here.context() as graded:
            graded.setenv("IMUGRADE_SEED", "a-secret")
            assert run(["grade", "submissions", "-o", "out-hidden"])[0] == 0
        shutil.copytree("out-monday", "out-tuesday")
        adjustment = ["--criterion", "filtering", "--points", "3", "--comment", "as told"]
        assert run(["adjust", "out-tuesday", "alice", *adjustment])[0] == 0
        yield place


def _share_a_sandbox(here: pytest.MonkeyPatch) -> None:
    """Let all commands of this process use one sandbox: each would open its own, which takes longer than what they do in it.

    A command that needs one marker gets one of this process, as another process starts for seconds. With `--jobs` a pool is started.
    """
    one = sandboxes.shared()
    here.setattr(lab_sandbox, "Sandbox", lambda *_, **__: sandboxes.Lasting(one))
    here.setattr(classroom, "mark_all", _mark_all)
    here.setattr(machine, "examine", functools.cache(machine.examine))  # five documents examine this machine


def _mark_all(
    submissions: Iterator[Submission], open_marker: pool.OpenMarker, jobs: int, bounds: pool.Bounds
) -> Iterator[tuple[Submission, pool.Outcome]]:
    if jobs > 1:
        yield from pool.mark_all(submissions, open_marker, jobs, bounds)
        return
    with open_marker() as marker:
        for submission in submissions:
            yield submission, marker.mark(submission)


def _draw_few_motions(here: pytest.MonkeyPatch) -> None:
    """Draw the motions that a kit has, three of ten: each picture takes a quarter of a second."""
    every = motions._moving
    here.setattr(motions, "_moving", lambda traces: [each for each in every(traces) if each.name in handout._MOTIONS])


def _hand_in(place: Path) -> None:
    for name, student in STUDENTS.items():
        write(student.files, place / "submissions" / name)
    shutil.copytree(place / "submissions", place / "submissions_example")
    everyone = list(STUDENTS.values())
    canvas(everyone, place).rename(place / "canvas.zip")
    moodle(everyone, place).rename(place / "moodle.zip")
    (place / "gradebook.csv").write_bytes(canvas_gradebook(everyone))
    (place / "worksheet.csv").write_bytes(moodle_worksheet(everyone))
    rows = "".join(f"{id_},{each.name},{each.email},B\n" for id_, each in STUDENTS.items())
    (place / "roster.csv").write_text(f"id,name,email,section\n{rows}", encoding="utf-8")
    table = "id,criterion,points,comment\nalice,filtering,17,in a table\n"
    (place / "adjustments.csv").write_text(table, encoding="utf-8")
    shutil.copy(shipped(LAB), place / "rubric.yaml")
    shutil.copytree(ROOT / "submissions_example" / EXAMPLE, place / "submissions_example" / EXAMPLE)
    (place / "requests.csv").write_text("id,request\nalice,My filter is right\n", encoding="utf-8")
    write(tidy(), place / "my_lab")
    write(tidy(), place / "lab")
    write(tidy(), place / "student")
    write(tidy(), place / "my_lab", "zip")
    give.student(LAB, place / "kit")
    write(VERBATIM, place / "kit")


def _grades_another_class(document: str) -> bool:
    """Return whether the first command with OUT grades others than the class that is graded already: a download, or the examples."""
    first = next((each.words for each in COMMANDS if each.document == document and "out" in each.words), ())
    return "grade" in first and "submissions" not in first


class Scene:
    """The folder of each document, and the cluster, which starts when it is asked for."""

    def __init__(self, ready: Path, scratch: Path) -> None:
        self._ready, self._scratch = ready, scratch
        self._cluster: tuple[Site, subprocess.Popen[bytes]] | None = None
        self.seen: set[str] = set()

    def folder(self, document: str) -> Path:
        place = self._scratch / document.replace("/", "-")
        if not place.exists():
            shutil.copytree(self._ready, place)
            if not _grades_another_class(document):
                shutil.copytree(place / "out-monday", place / "out")
        return place

    def cluster(self) -> Site:
        """A scheduler with the worker that the documentation starts, but one process in place of sixteen."""
        if self._cluster is None:
            site = Site(self._scratch)
            (command,) = {each.words for each in COMMANDS if each.words[0] == "dask"}
            words = [{"ADDRESS": site.address, "16": "1"}.get(word, word) for word in command]
            worker = subprocess.Popen(
                [sys.executable, "-m", *words], cwd=self._scratch, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                env={**ENVIRONMENT, "DASK_TEMPORARY_DIRECTORY": str(self._scratch)},
            )  # fmt: skip
            self._cluster = site, worker
            with site.client() as client:
                until(lambda: list(client.nthreads().values()) == [1])
        return self._cluster[0]

    def close(self) -> None:
        if self._cluster is not None:
            site, worker = self._cluster
            worker.terminate()  # its nanny ends the process that it has started
            worker.wait(60)
            site.close()


@pytest.fixture(scope="module")
def scene(ready: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Scene]:
    with closing(Scene(ready, tmp_path_factory.mktemp("documents"))) as scene:
        yield scene


# --- each command -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("document", dict.fromkeys(command.document for command in COMMANDS))
def test_the_commands_of_a_document_do_what_they_are_documented_for(
    document: str, scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In one test, as one builds on the other: what an adjustment withdraws was adjusted above."""
    for command in COMMANDS:
        if command.document == document:
            try:
                _do(command, scene, monkeypatch)
            except Exception as problem:
                raise AssertionError(f"{document}: {command}") from problem


def _do(command: Command, scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    program = command.words[0].rpartition("/")[2]
    if program != "imugrade" or command.words[1] in LEAVE_NOTHING:
        alike = re.sub(rf"--only ({'|'.join(CRITERIA)})", "--only CRITERION", str(command))
        if alike in scene.seen and command.place != "heading":
            return  # it ran for another document, or for another criterion, and its folder says nothing to it
        scene.seen.add(alike)
    folder = scene.folder(command.document)
    with monkeypatch.context() as here:
        for name, value in command.environment:
            here.setenv(name, value)
        here.chdir(folder)
        PROGRAMS[program](command, folder, scene)


TEXT = """# `imugrade grade PATH`

As `imugrade grade` says, not as `imugrade` or `a | b` do; see `python
-m grader`.

```sh
cd . && SEED=a imugrade one "two words"   # why
```

    script:
      - pip install x
        imugrade three     what it does
"""


def test_every_way_of_naming_a_command_is_found() -> None:
    found = [(command.place, str(command)) for command in commands({"text": TEXT})]
    assert found == [
        ("heading", "imugrade grade PATH"),
        ("prose", "imugrade grade"),
        ("prose", "python -m grader"),
        ("block", "SEED=a imugrade one 'two words'"),
        ("block", "pip install x"),
        ("block", "imugrade three"),
    ]


def test_there_are_commands_of_every_kind_to_be_found() -> None:
    found = [str(command) for command in COMMANDS]
    assert len(found) > 120
    assert {command.words[1] for command in COMMANDS if command.words[0] == "imugrade"} >= set(OUTCOMES)
    assert "IMUGRADE_SEED=a-secret imugrade grade submissions -o out" in found


# --- imugrade ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Done:
    """What came of `imugrade WORDS` in a folder."""

    words: list[str]
    folder: Path
    out: str
    err: str

    def after(self, *names: str) -> str | None:
        """What stands behind an option."""
        return next((self.words[i + 1] for i, word in enumerate(self.words) if word in names), None)

    def file(self, *names: str) -> Path | None:
        """The file or folder that an option names."""
        word = self.after(*names)
        return None if word is None else self.folder / word


def one_secret(folder: Path, out: str, here: pytest.MonkeyPatch) -> str:
    """Return the OUT that a class is graded into: a class has one secret, and whoever graded it has that in the environment."""
    known = classroom.on_record(folder / out)
    if known is not None and known.hidden and "IMUGRADE_SEED" not in os.environ:
        here.setenv("IMUGRADE_SEED", "a-secret")
    return "out-hidden" if known is not None and not known.hidden and "IMUGRADE_SEED" in os.environ else out


def imugrade(command: Command, folder: Path, scene: Scene) -> None:
    """As it stands; with --help where it is a heading, or a name in the middle of words."""
    names = subcommands(command.words[1:])
    bare = command.place == "prose" and len(names) == len(command.words) - 1
    if bare or command.place == "heading" or command.words[-1] == "--help":
        code, out, _ = run([*names, "--help"])
        usage = " ".join(out.split())
        assert code == 0
        assert usage.startswith("Usage: " + " ".join(["imugrade", *names, ""]))
        assert all(word in usage for word in command.words)
        return
    words = [STANDS_FOR.get(word, word) for word in command.words[1:]]
    if "--cluster" in words:
        words[words.index("--cluster") + 1] = scene.cluster().address
    if command.words[1] in ("check", "ci", "repro"):
        folder = where_a_student_is(command, folder)
    if words[0] == "review":
        review(words, folder)
        return
    with pytest.MonkeyPatch.context() as here:
        here.chdir(folder)
        if words[0] == "repair":
            hand_in_what_does_not_run(folder)
            if "--patch" in words:  # it is for the file as it was handed in
                run(["repair", "out", "alice", "--undo"])
        if words[0] == "grade":
            at = words.index("-o") + 1
            words[at] = one_secret(folder, words[at], here)
        watches = "--watch" in words
        code, out, err = run(words, InterruptedOnceChecked() if watches else None)
        assert code == 0, err
        (watched if watches else OUTCOMES[words[0]])(Done(words, folder, out, err))


def hand_in_what_does_not_run(folder: Path) -> None:
    """Let alice have handed in a filter that does not parse, and put the file as it should be, and the patch, beside the class."""
    fixed, handed_in = folder / "fixed.py", folder / "submissions" / "alice" / "filters.py"
    if not fixed.exists():
        sound = str(tidy()["filters.py"])
        broken = sound.replace(":\n", "\n", 1)
        fixed.write_text(sound, encoding="utf-8")
        handed_in.write_text(broken, encoding="utf-8")
        patch = difflib.unified_diff(broken.splitlines(True), sound.splitlines(True), "filters.py", "filters.py")
        (folder / "fix.diff").write_text("".join(patch), encoding="utf-8")
        code, _, err = run(["grade", "submissions", "-o", "out", "--only", "alice"])
        assert code == 0, err


def repaired(done: Done) -> None:
    assert "alice" in done.out


def subcommands(words: tuple[str, ...]) -> list[str]:
    """The first words, as long as they are names of commands."""
    group: Any = typer.main.get_command(cli.app)
    names: list[str] = []
    for word in words:
        if word not in getattr(group, "commands", {}):
            break
        group = group.commands[word]
        names.append(word)
    return names


def run(words: list[str], output: io.StringIO | None = None) -> tuple[int, str, str]:
    """The command in this process: its exit code, stdout and stderr."""
    with redirect_stdout(output or io.StringIO()) as out, redirect_stderr(io.StringIO()) as err:
        code = cli.main(words)
    return code, out.getvalue(), err.getvalue()


def where_a_student_is(command: Command, folder: Path) -> Path:
    """Without a path it is the working folder that is looked at: a student's own."""
    path = command.words[3 if command.words[1] == "repro" else 2 :]
    if path and not path[0].startswith("-"):
        return folder
    return folder / ("kit" if command.document.startswith("the students'") else "my_lab")


class InterruptedOnceChecked(io.StringIO):
    """Output of `check --watch`, ended by Ctrl-C once it has answered, as its first line says."""

    def write(self, text: str) -> int:
        written = super().write(text)
        # "checking …" twice, what was checked when, and the first line of the result
        if self.getvalue().count("\n") == 4:
            signal.raise_signal(signal.SIGINT)
        return written


def watched(done: Done) -> None:
    assert done.out.splitlines()[0].endswith("checking …")
    assert "Ctrl-C ends" in done.out


def review(words: list[str], folder: Path) -> None:
    """Ended by Ctrl-C once it has said where it is."""
    line = [sys.executable, "-m", "grader", *words]
    with subprocess.Popen(line, cwd=folder, env=ENVIRONMENT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        told = next(each for each in process.stdout if each.startswith("http"))
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 0
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/enter\?token=\S{40,}\n", told)


def checked(done: Done) -> None:
    assert "public" in done.out
    part = done.after("--only")
    assert re.search(r"\d+ / 20" if part else r"Score +\d+ / 100", done.out)
    if page := done.file("--html"):
        assert "<html" in page.read_text(encoding="utf-8")


def graded(done: Done) -> None:
    if "--list" in done.words:
        assert "alice" in done.out
        return
    out = done.file("-o")
    assert out is not None
    with open(out / "gradebook.csv", encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert {row["status"] for row in rows} == {"graded"}
    assert len(rows) >= len(STUDENTS)
    assert all((out / "submissions" / row["id"] / "report.html").is_file() for row in rows)
    assert (out / "index.html").is_file()
    assert ("no seed" in done.err) != ("IMUGRADE_SEED" in os.environ)
    if "--roster" in done.words:
        assert {row["section"] for row in rows} & {"B", "Tue, 10:00"}


def adjusted(done: Done) -> None:
    target = done.after("--criterion") or ("bonus" if "--take-back" in done.words else "filtering")
    told = next(line for line in done.out.splitlines() if line.startswith(f"alice {target} "))
    back = {"--withdraw", "--undo", "--take-back"} & set(done.words)
    assert ("withdrawn" in done.out) == bool(back) or len(done.words) == 2
    if points := done.after("--points"):
        assert told.startswith(f"alice {target} {points}, final ")


def told_apart(done: Done) -> None:
    assert "filtering override  none → 3" in done.out


def exported(done: Done) -> None:
    made = done.file("-o") or next((done.folder / "out").glob(f"{done.after('--format')}.csv"))
    assert len(made.read_text(encoding="utf-8-sig").splitlines()) > len(STUDENTS)
    assert re.search(r"\d grades", done.out)
    assert " 0 grades" not in done.out
    if reports := done.file("--feedback"):
        assert zipfile.is_zipfile(reports)


def explained(done: Done) -> None:
    assert (done.words[1:] or ["sensor-id-as-address"])[0] in done.out


def examined(done: Done) -> None:
    if done.words[1:]:
        assert "submissions import no known package that is missing here" in done.out
        return
    assert "landlock" in done.out
    assert "mujoco" in done.out.lower()


def given(done: Done) -> None:
    made = next(path for option in KITS if (path := done.file(option))) if done.words[1].startswith("-") else None
    held = made or done.folder / done.words[1]
    names = zipfile.ZipFile(held).namelist() if held.is_file() else [path.name for path in held.rglob("*")]
    assert wheel.name() in names
    assert KITS[done.words[1] if made else ""] in names
    if made and made.suffix == ".zip":
        assert ("hidden.npz" in names) == ("IMUGRADE_SEED" in os.environ)


KITS = {
    "": "filters.py",
    "--gradescope": "run_autograder",
    "--classroom50": "autograder.py",
    "--github": "imugrade.yml",
    "--gitlab": ".gitlab-ci.yml",
}


def answered(done: Done) -> None:
    """By a platform's job: something that its reader takes."""
    made = done.file("-o", "--out")
    text = made.read_text(encoding="utf-8") if made else done.out
    kind = done.after("--format") or "junit"
    assert kind in registry.names("respond")
    if kind == "junit":
        assert ElementTree.fromstring(text).tag == "testsuites"
    elif kind == "github":
        assert "::notice" in text
    else:
        assert json.loads(text)["score"] in (1.0, 100.0)


def traced(done: Done) -> None:
    made = done.file("-o", "--out")
    kinds = {"plot": "*.png", "record": "*.npz"}
    assert made is None if done.words[1] == "list" else made and list(made.rglob(kinds[done.words[1]]))
    assert done.out


def repeated(done: Done) -> None:
    assert done.out == ".imugrade/repro.py written; run it with: python .imugrade/repro.py\n"
    assert "the sensors say" in _lines([".imugrade/repro.py"], done.folder)


OUTCOMES: Mapping[str, Callable[[Done], None]] = {
    "check": checked,
    "grade": graded,
    "adjust": adjusted,
    "diff": told_apart,
    "export": exported,
    "ci": answered,
    "repair": repaired,
    "kit": given,
    "explain": explained,
    "repro": repeated,
    "doctor": examined,
    "traces": traced,
}
LEAVE_NOTHING = ("check", "ci", "doctor", "explain", "kit", "repro", "review", "traces", "--help")
"""What they write is read by no other documented command."""


# --- other programs ---------------------------------------------------------------------------------------------------


def python(command: Command, folder: Path, scene: Scene) -> None:
    if command.words[1] == ".imugrade/repro.py":
        return  # it is run as soon as it is written
    if command.words[1] != "-m":
        _lines([*command.words[1:]], folder / "kit")
        assert (folder / "kit" / "imu_data.png").stat().st_size > 10_000
        return
    module, *words = command.words[2:]
    if module == "pip":
        pip(Command(command.document, ("pip", *words)), folder, scene)
    elif module == "venv":
        offline = [word for word in words if word != "--upgrade-deps"]  # it asks the package index, as CI does
        _lines(["-m", "venv", "--without-pip", *offline], folder)  # what pip then does is its own
        assert (folder / offline[0] / "pyvenv.cfg").is_file()
    elif module == "pytest":
        pytest_arguments(words)
    else:
        by_hand(module, words)


def pytest_arguments(words: list[str]) -> None:
    """The tests do not run themselves: the files and markers exist, and CI runs all tests."""
    markers = re.findall(r'^    "(\w+): ', (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE)
    assert {word for before, word in itertools.pairwise(words) if before == "-m"} <= set(markers)
    assert [word for word in words if word.endswith(".py") and not (ROOT / word).exists()] == []
    assert ".venv/bin/python -m pytest -m full " in _ci()


def by_hand(module: str, words: list[str]) -> None:
    """Campaigns of minutes to hours: they start, and know these options and values of them."""
    if not words and any(each.words[2:3] == (module,) and each.words[3:] for each in COMMANDS):
        return  # named with options elsewhere
    words = [*(STANDS_FOR.get(word, word) for word in words), "--help"]
    if module == "grader":
        assert _lines(["-m", module, *words], ROOT).startswith("Usage: imugrade")
        return
    usage = _said_by(module, words)
    assert usage.startswith(f"usage: python -m {module} ")
    assert {word for word in words if word.startswith("-")} <= set(re.findall(r"--?[\w-]+", usage))


def _said_by(module: str, words: list[str]) -> str:
    """What `python -m module` says, by its `main`: in this process, which has imported most of it."""
    program = importlib.import_module(f"{module}.__main__" if Path(ROOT, *module.split(".")).is_dir() else module)
    assert re.search(r'if __name__ == "__main__":\n.*\bmain\(\)\)?\n$', inspect.getsource(program), re.DOTALL)
    with pytest.MonkeyPatch.context() as here, redirect_stdout(io.StringIO()) as out:
        here.setattr(sys, "argv", [f"python -m {module}", *words])
        try:
            code = program.main()
        except SystemExit as ended:
            code = ended.code
    assert code in (0, None)
    return out.getvalue()


def pip(command: Command, folder: Path, _: Scene) -> None:
    """What it would install is there to be installed; the repository itself is installed before the tests run."""
    _, action, *words = command.words
    assert action == "install"
    if words[-1].partition("[")[0] in (".", "/imugrade"):
        assert ".venv/bin/pip install -q -e '.[test]'\n" in _ci()
        return
    files = [path.name for path in (folder / "kit").glob(words[-1])] or [words[-1]]
    trial = ["--disable-pip-version-check", "install", "--no-index", "--no-deps", "--dry-run"]
    done = _done(["-m", "pip", *trial, *words[:-1], *files], folder / "kit")
    assert done.returncode == 0, done.stderr
    assert "does not provide the extra" not in done.stderr


def dask(_command: Command, _folder: Path, scene: Scene) -> None:
    """The worker is started as documented, and takes one submission at a time."""
    with scene.cluster().client() as client:
        assert list(client.nthreads().values()) == [1]


def bash(command: Command, _folder: Path, _scene: Scene) -> None:
    """It runs these tests, so they do not run it."""
    subprocess.run(["bash", "-n", *command.words[1:]], cwd=ROOT, check=True)
    assert ".venv/bin/python -m pytest" in _ci()


def plugin(command: Command, folder: Path, _scene: Scene) -> None:
    """`pytest --imugrade` passes in the folder of a sound submission. It checks in this process, as the other commands do."""

    def check(line: list[str], **_: object) -> subprocess.CompletedProcess[bytes]:
        code, _out, err = run(line[line.index("check") :])
        return subprocess.CompletedProcess(line, code, stderr=err.encode())

    with pytest.MonkeyPatch.context() as here, redirect_stdout(io.StringIO()) as out:
        here.chdir(folder if "my_lab" in command.words else folder / "my_lab")
        here.setattr(items.subprocess, "run", check)
        code = pytest.main([*command.words[1:]])
    assert code == 0, out.getvalue()


PROGRAMS: Mapping[str, Callable[[Command, Path, Scene], None]] = {
    "imugrade": imugrade,
    "python": python,
    "python3": python,
    "pip": pip,
    "pytest": plugin,
    "dask": dask,
    "bash": bash,
}


def _done(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, *words]
    return subprocess.run(line, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, check=False, timeout=120)


def _lines(words: list[str], folder: Path) -> str:
    done = _done(words, folder)
    assert done.returncode == 0, done.stderr
    return done.stdout


def _ci() -> str:
    return (ROOT / ".ci" / "run").read_text(encoding="utf-8")
