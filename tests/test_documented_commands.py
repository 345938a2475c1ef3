"""Run every command of the README and the documentation, with the files that they assume.

A command that is newly documented is run without a word here; one of a new kind fails until there is a line on what comes of it.
"""

from __future__ import annotations

import csv
import difflib
import functools
import io
import itertools
import os
import re
import runpy
import shutil
import signal
import subprocess
import sys
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import redirect_stderr, redirect_stdout
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest
import uvicorn

from grader import cli
from grader.commands import checking, machine
from grader.course.markers.pool import MarkerAnswer, OpenMarker
from grader.course.run import classroom
from grader.engine import lab_sandbox
from grader.engine.grader import Marker
from grader.engine.results import Result
from grader.engine.rubric import load, shipped
from grader.intake import Submission
from grader.kit import give
from grader.labs.imu import bundles, handout, motions
from grader.labs.imu.lab import LAB
from grader.pytest_plugin import items
from grader.report import truth
from tests import sandboxes
from tests.classes import Student, canvas, canvas_gradebook, filters_alone, moodle, moodle_worksheet
from tests.conftest import SECRET
from tests.corpus.pieces import VERBATIM, tidy
from tests.corpus.writing import write
from tests.documents import ROOT, Command, commands, documents

COMMANDS = tuple(commands(documents()))
STUDENTS = {
    "alice": Student(0, "Alice", "Adams", filters_alone(1.0)),
    "bob": Student(1, "Bob", "Brown", filters_alone(0.5)),
}
EXAMPLE = "s06-id-as-address"
STANDS_FOR = {"SUBMISSIONS": "submissions", "OUT": "out-monday", "DOWNLOAD": "submissions", "ID": "view-not-copy"}
STANDS_FOR |= {"R": "none", "F": "poison", "...": SECRET}
CRITERIA = tuple(criterion.id for criterion in load(LAB).criteria)
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}
PLATFORMS_SAY = ("GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY", "GITHUB_WORKSPACE", "CLASSROOM", "IMUGRADE_SEED")
CI = (ROOT / ".ci" / "run").read_text(encoding="utf-8")

SAYS = {
    "calibrate": "^written to ",
    "adjust": r"^(alice|s06-id-as-address) .* (\S+, final \d+|by .*)$|^no overrides on record$",
    "check": r"public checks[\s\S]* \d+ / (20|100)$|; again on every save, Ctrl-C ends$",
    "ci": r"^<testsuites |^\S+ written: 100 of 100 points$",
    "ci --format json": '"score": 100.0',
    "ci --format github": "^::notice .*100 / 100$",
    "ci --format prairielearn": '^  "message": "100 / 100"',
    "diff": "filtering override  none → 3",
    "diff out out-next": "^0 of 2 moved; mean of graded",
    "doctor": "import no known package that is missing here|landlock",
    "explain": r"^# \S|sensor-id-as-address",
    "export": r"  [1-9]\d* grades(, \d+ blank)?$",
    "grade": r"^[1-9] graded · mean|^0 would be graded · 2 on record$|^0 graded · 2 on record · mean|^adamsalice_10000 ",
    "kit": "  for students; public scenarios$",
    "kit --classroom50": "  for Classroom 50; public scenarios",
    "kit --github": "  for GitHub Actions; public scenarios",
    "kit --gitlab": "  for GitLab CI; public scenarios",
    "kit --gradescope": "  for Gradescope; (public|hidden) scenarios",
    "repair": "^alice(: | filters.py -5 )|^no repairs on record$",
    "repro": r"^\.imugrade/repro\.py written; run it with: python \.imugrade/repro\.py\n",
    "review": r"^http://127\.0\.0\.1:\d+/enter\?token=\S{40,}$",
    "traces list": "^(public|hidden) traces, ",
    "traces plot": r"^plots/\w+\.png$",
    "traces record": "hidden.npz$",
}
"""What a command that begins with these words prints when it has done what it is documented for."""
WRITES = ("-o", "--out", "--html", "--feedback", "--gradescope", "--classroom50", "--github", "--gitlab")
LEAVE_NOTHING = ("check", "ci", "doctor", "explain", "kit", "repro", "review", "traces", "--help")
"""What they write is read by no other documented command."""


# --- what the documents assume ----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ready(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A class that has handed in, its downloads and tables, gradings of it, and a student's own work.

    All commands of this process use one sandbox, which takes longer to open than what they do in it, and one result of a submission.
    """
    place, one, every = tmp_path_factory.mktemp("ready"), sandboxes.shared(), motions._moving
    with pytest.MonkeyPatch.context() as here:
        here.setattr(Marker, "mark", _marked_once(Marker.mark))
        here.setattr(os, "cpu_count", lambda: 1)
        for name in PLATFORMS_SAY:
            here.delenv(name, raising=False)
        here.setattr(lab_sandbox, "Sandbox", lambda *_, **__: sandboxes.Lasting(one))
        here.setattr(classroom, "mark_all", _mark_all)
        # what the doctor tries for ten seconds is tried in its own tests
        here.setattr(machine.visible_copies, "search", lambda *_: machine.visible_copies.Search(1, ()))
        here.setattr(machine, "try_recording", lambda lab: bundles.shipped())
        here.setattr(machine, "probe", functools.cache(machine.probe))
        # each picture takes a quarter of a second: that of one motion is drawn, and for the kits once
        here.setattr(motions, "_moving", lambda traces: [it for it in every(traces) if it.name == handout._MOTIONS[1]])
        here.setattr(handout, "handout", functools.cache(handout.handout))
        _hand_in(place)
        here.chdir(place)
        truth.save(bundles.obtain(LAB, SECRET, None), place)
        assert run(["grade", "submissions", "-o", "out-monday", "--roster", "roster.csv"])[0] == 0
        with here.context() as graded:
            graded.setenv("IMUGRADE_SEED", SECRET)
            assert run(["grade", "submissions", "-o", "out-hidden"])[0] == 0
        shutil.copytree("out-monday", "out-tuesday")
        adjustment = ["--criterion", "filtering", "--points", "3", "--comment", "as told"]
        assert run(["adjust", "out-tuesday", "alice", *adjustment])[0] == 0
        yield place


def _marked_once(mark: Callable[..., Result]) -> Callable[..., Result]:
    known: dict[object, Result] = {}

    def marked(marker: Marker, submission: Submission, *limit: float, **asked: Any) -> Result:
        key = (submission.name, submission.sha256, marker._rubric.sha256, marker._traces.sha256, asked.get("only"))
        if key not in known:
            known[key] = mark(marker, submission, *limit, **asked)
        return known[key]

    return marked


def _mark_all(
    submissions: Iterator[Submission], opener: OpenMarker, *_: Any
) -> Iterator[tuple[Submission, MarkerAnswer]]:
    """Mark in this process, as another one starts for seconds."""
    with opener() as marker:
        for submission in submissions:
            yield submission, marker.mark(submission)


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
    for person, points in (("a", 18), ("b", 17.5)):
        row = f"id,criterion,points,comment\nalice,filtering,{points},starts late\n"
        (place / f"marks-{person}.csv").write_text(row, encoding="utf-8")
    shutil.copy(shipped(LAB), place / "rubric.yaml")
    shutil.copytree(ROOT / "submissions_example" / EXAMPLE, place / "submissions_example" / EXAMPLE)
    (place / "requests.csv").write_text("id,request\nalice,My filter is right\n", encoding="utf-8")
    for folder in ("my_lab", "lab", "student"):
        write(tidy(), place / folder)
    write(tidy(), place / "my_lab", "zip")
    give.student(LAB, place / "kit")
    write(VERBATIM, place / "kit")
    sound = str(tidy()["filters.py"])
    broken = sound.replace(":\n", "\n", 1)
    write({"filters.py": broken}, place / "broken" / "alice")
    (place / "fixed.py").write_text(sound, encoding="utf-8")
    patch = difflib.unified_diff(broken.splitlines(True), sound.splitlines(True), "filters.py", "filters.py")
    (place / "fix.diff").write_text("".join(patch), encoding="utf-8")


def _grades_another_class(document: str) -> bool:
    """Return whether the first command with OUT grades others than the class that is graded already: a download, or the examples."""
    first = next((each.words for each in COMMANDS if each.document == document and "out" in each.words), ())
    return "grade" in first and "submissions" not in first


def run(words: list[str]) -> tuple[int, str, str]:
    """The command in this process: its exit code, stdout and stderr."""
    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()) as err:
        code = cli.main(words)
    return code, out.getvalue(), err.getvalue()


# --- each command -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ran() -> set[str]:
    """What need not run again for another document, or for another criterion: its folder says nothing to it."""
    return set()


@pytest.mark.parametrize("document", dict.fromkeys(command.document for command in COMMANDS))
def test_the_commands_of_a_document_do_what_they_are_documented_for(
    document: str, ready: Path, ran: set[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In one test, as one builds on the other: what an adjustment withdraws was adjusted above."""
    folder = shutil.copytree(ready, tmp_path / "folder")
    if not _grades_another_class(document):
        shutil.copytree(folder / "out-monday", folder / "out")
    for command in COMMANDS:
        program = command.words[0].rpartition("/")[2]
        alike = re.sub(rf"--only ({'|'.join(CRITERIA)})", "--only CRITERION", str(command))
        leaves_something = program == "imugrade" and command.words[1] not in LEAVE_NOTHING
        if command.document != document or (alike in ran and command.place != "heading" and not leaves_something):
            continue
        ran.add(alike)
        with monkeypatch.context() as here:
            for name, value in command.environment:
                here.setenv(name, STANDS_FOR.get(value, value))
            here.chdir(folder)
            try:
                PROGRAMS[program](command, folder, here)
            except Exception as problem:
                raise AssertionError(f"{document}: {command}") from problem


def test_there_are_commands_of_every_kind_to_be_found() -> None:
    found = [str(command) for command in COMMANDS]
    places = Counter(command.place for command in COMMANDS)
    assert (places["block"] > 120, places["prose"] > 50, places["heading"] >= 15) == (True, True, True)
    assert {command.words[1] for command in COMMANDS if command.words[0] == "imugrade"} >= {
        key.split()[0] for key in SAYS
    }
    assert "imugrade grade submissions -o out" in found


# --- imugrade ---------------------------------------------------------------------------------------------------------


def imugrade(command: Command, folder: Path, here: pytest.MonkeyPatch) -> None:
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
    if words[0] in ("check", "ci", "repro"):
        path = words[2 if words[0] == "repro" else 1 :]
        if not path or path[0].startswith("-"):  # the student's own folder
            folder /= "kit" if command.document.startswith("the students'") else "my_lab"
            here.chdir(folder)
    if words[0] == "review":
        here.setattr(uvicorn.Server, "main_loop", ended_by_ctrl_c(uvicorn.Server.main_loop))
    if words[0] == "repair":  # what does not run; a patch is for the file as it was handed in
        assert run(["grade", "broken", "-o", "out"])[0] == 0
        if "--patch" in words:
            run(["repair", "out", "alice", "--undo"])
    if "--watch" in words:
        here.setattr(checking, "saves", functools.partial(interrupted_after_one, checking.saves))
    if words[0] == "grade":
        of_one_secret(words, here)
    code, out, err = run(words)
    assert code == 0, err
    beginnings = (" ".join(words[:n]) for n in range(len(words), 0, -1))
    said = [SAYS[each] for each in beginnings if each in SAYS]
    assert said, (
        f"what does `imugrade {words[0]}` print when it has done its work? tests/test_documented_commands.py: SAYS"
    )
    assert re.search(said[0], out, re.MULTILINE), out
    for option, name in itertools.pairwise(words):
        if option in WRITES:
            assert any((folder / name).iterdir()) if (folder / name).is_dir() else (folder / name).stat().st_size
    assert words[:2] != ["kit", "--gradescope"] or ("hidden" in out) == ("IMUGRADE_SEED" in os.environ)
    if words[0] == "grade" and not {"--list", "--dry-run"} & {*words}:
        graded(words, err)
    if words[0] == "repro":
        assert "the sensors say" in _lines([".imugrade/repro.py"], folder)


def subcommands(words: tuple[str, ...]) -> list[str]:
    """The first words, as long as they are names of commands."""
    group: Any = cli.command()
    names: list[str] = []
    for word in words:
        if word not in getattr(group, "commands", {}):
            break
        group = group.commands[word]
        names.append(word)
    return names


def interrupted_after_one(saves: Callable[..., Iterator[None]], *arguments: Any) -> Iterator[None]:
    yield from itertools.islice(saves(*arguments), 1)
    raise KeyboardInterrupt


def ended_by_ctrl_c(serve: Callable[..., Any]) -> Callable[..., Any]:
    def interrupted(server: uvicorn.Server) -> Any:
        signal.raise_signal(signal.SIGINT)
        return serve(server)

    return interrupted


def of_one_secret(words: list[str], here: pytest.MonkeyPatch) -> None:
    """A class has one secret: whoever graded it has that in the environment, or grades into another OUT."""
    at = words.index("-o") + 1
    known = classroom.on_record(Path(words[at]))
    if known is not None and known.hidden:
        here.setenv("IMUGRADE_SEED", os.environ.get("IMUGRADE_SEED", SECRET))
    elif known is not None and "IMUGRADE_SEED" in os.environ:
        words[at] = "out-hidden"


def graded(words: list[str], err: str) -> None:
    assert ("no seed" in err) != ("IMUGRADE_SEED" in os.environ)
    out = Path(words[words.index("-o") + 1])
    with open(out / "gradebook.csv", encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert {row["status"] for row in rows} == {"graded"}
    assert len(rows) >= len(STUDENTS)
    assert all((out / "submissions" / row["id"] / "report.html").is_file() for row in rows)
    assert "--roster" not in words or {row["section"] for row in rows} & {"B", "Tue, 10:00"}


# --- other programs ---------------------------------------------------------------------------------------------------


def python(command: Command, folder: Path, here: pytest.MonkeyPatch) -> None:
    if command.words[1] == ".imugrade/repro.py":
        return  # it is run as soon as it is written
    if command.words[1] != "-m":
        _lines([*command.words[1:]], folder / "kit")
        assert (folder / "kit" / "imu_data.png").stat().st_size > 10_000
        return
    module, *words = command.words[2:]
    if module == "pip":
        pip(Command(command.document, ("pip", *words)), folder, here)
    elif module == "grader":
        imugrade(Command(command.document, ("imugrade", *words, "--help")), folder, here)
    elif module == "venv":
        offline = [word for word in words if word != "--upgrade-deps"]  # it asks the package index, as CI does
        _lines(["-m", "venv", "--without-pip", *offline], folder)  # what pip then does is its own
        assert (folder / offline[0] / "pyvenv.cfg").is_file()
    elif module == "pytest":  # the tests do not run themselves: the files and markers exist, and CI runs all tests
        markers = re.findall(r'^    "(\w+): ', (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE)
        assert {word for before, word in itertools.pairwise(words) if before == "-m"} <= set(markers)
        assert [word for word in words if word.endswith(".py") and not (ROOT / word).exists()] == []
        assert "\n.venv/bin/python -m pytest 2>&1 " in CI
    else:  # campaigns of minutes to hours: they start, and know these options and values of them
        words = [*(STANDS_FOR.get(word, word) for word in words), "--help"]
        here.setattr(sys, "argv", ["", *words])
        with redirect_stdout(io.StringIO()) as out, warnings.catch_warnings():
            warnings.simplefilter("ignore")  # most of it was imported by this process
            with pytest.raises(SystemExit, match=r"^0$"):
                runpy.run_module(module, run_name="__main__", alter_sys=True)
        assert out.getvalue().startswith(f"usage: python -m {module} ")
        assert {word for word in words if word.startswith("-")} <= set(re.findall(r"--?[\w-]+", out.getvalue()))


def pip(command: Command, folder: Path, _here: pytest.MonkeyPatch) -> None:
    """What it would install is there to be installed; the repository itself is installed before the tests run."""
    _, action, *words = command.words
    assert action == "install"
    if words[-1].partition("[")[0] in (".", "/imugrade"):
        assert ".venv/bin/pip install -q -e '.[test]'\n" in CI
        return
    if files := [path.name for path in (folder / "kit").glob(words[-1])]:
        trial = ["--disable-pip-version-check", "install", "--no-index", "--no-deps", "--dry-run"]
        _lines(["-m", "pip", *trial, *words[:-1], *files], folder / "kit")
        return
    name, _, extra = words[-1].strip("]").partition("[")
    assert extra in ["", *metadata.metadata(name).get_all("Provides-Extra", [])]


def dask(command: Command, folder: Path, _: pytest.MonkeyPatch) -> None:
    """Dask has this command with these options. The tests of the cluster start workers."""
    usage = _lines(["-m", *command.words[:2], "--help"], folder)
    assert {word for word in command.words if word.startswith("-")} <= set(re.findall(r"--[\w-]+", usage))


def bash(command: Command, _folder: Path, _: pytest.MonkeyPatch) -> None:
    """It runs these tests, so they do not run it."""
    subprocess.run(["bash", "-n", *command.words[1:]], cwd=ROOT, check=True)
    assert ".venv/bin/python -m pytest" in CI


def plugin(command: Command, folder: Path, here: pytest.MonkeyPatch) -> None:
    """`pytest --imugrade` passes in the folder of a sound submission. It checks in this process, as the other commands do."""

    def check(line: list[str], **_: object) -> subprocess.CompletedProcess[bytes]:
        code, _out, err = run(line[line.index("check") :])
        return subprocess.CompletedProcess(line, code, stderr=err.encode())

    here.chdir(folder if "my_lab" in command.words else folder / "my_lab")
    here.setattr(items.subprocess, "run", check)
    with redirect_stdout(io.StringIO()) as out:
        code = pytest.main([*command.words[1:]])
    assert code == 0, out.getvalue()


PROGRAMS: Mapping[str, Callable[[Command, Path, pytest.MonkeyPatch], None]] = {
    "imugrade": imugrade,
    "python": python,
    "python3": python,
    "pip": pip,
    "pytest": plugin,
    "dask": dask,
    "bash": bash,
}


def _lines(words: list[str], folder: Path) -> str:
    """What python prints, warnings included."""
    done = subprocess.run(
        [sys.executable, *words], cwd=folder, env=ENVIRONMENT, timeout=120, check=False, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    return done.stdout
