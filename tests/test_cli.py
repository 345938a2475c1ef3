from __future__ import annotations

import io
import json
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import nullcontext, redirect_stdout
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest

import grader
from grader import cli
from grader.base.errors import GraderError, RequestError
from grader.commands import checking
from grader.course.run import classroom
from grader.engine import recording, rubric, traces
from grader.engine.results import Result
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.sandbox.isolation_levels import LEVELS, NO_ISOLATION
from grader.sandbox.level_choice import LevelResult
from grader.sandbox.visible_copies import Search
from tests.class_commands import NO_SEED, Run, hand_in, in_process
from tests.corpus.writing import write
from tests.fake_results import FakeMarker, check, fake_marker, lost, result

ROOT = Path(__file__).parent.parent
RUBRIC = rubric.load(LAB)
CHECKS = {part.id: len(part.checks) for part in (*RUBRIC.criteria, *RUBRIC.extensions)}


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    for name in ("IMUGRADE_SEED", "IMUGRADE_DEBUG"):
        monkeypatch.delenv(name, raising=False)
    return in_process(capsys)


@pytest.fixture
def marker(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> FakeMarker:
    """A class is marked by a made-up marker that does what a submission's id says."""
    folder = tmp_path / "marker"
    folder.mkdir()
    (folder / "marked").touch()
    monkeypatch.setattr(classroom, "opener", lambda order: partial(fake_marker, folder))
    return FakeMarker(folder)


@pytest.fixture
def students(tmp_path: Path) -> Path:
    return hand_in(tmp_path / "class", alice=1, bob=1, carol=1)


def checked(monkeypatch: pytest.MonkeyPatch, answer: Result | BaseException) -> None:
    """Let the check of one submission end like this; no sandbox is started, which takes half a second."""

    def check_one(*_: object, **__: object) -> Result:
        if isinstance(answer, BaseException):
            raise answer
        return answer

    marker = nullcontext(SimpleNamespace(mark=check_one))
    monkeypatch.setattr("grader.engine.grader.Marker", lambda *_, **__: marker)
    monkeypatch.setattr("grader.engine.lab_sandbox.open_sandbox_for", lambda *_: nullcontext())


# --- requests that are wrong (one line, exit code 2), and other ends ---------------------------------------------------

INSIDE = "is one of the submissions; choose another folder for the results"
WRONG = {
    "check --nonsense": "No such option: --nonsense…; see imugrade check --help",
    "grade x": "Missing option '--out' / '-o'…; see imugrade grade --help",
    "check HERE/nowhere": "HERE/nowhere: there is no such file or folder; check the path",
    "grade HERE/no/where.zip -o HERE/out": "HERE/no/where.zip: there is no such file or folder; check the path",
    "grade HERE/class -o HERE/out --rubric HERE/none": "HERE/none: there is no such file; give the path of a rubric.yaml",
    "grade HERE/class -o HERE/out --rubric HERE/bad.yaml": "HERE/bad.yaml:1: …",
    "grade HERE/class -o HERE/bad.yaml": "HERE/bad.yaml: cannot write there: File exists; choose another folder with -o",
    "grade HERE/none -o HERE/out": "HERE/none: no submission found there; give a folder of submissions or an archive…",
    "grade HERE/class -o HERE/out --only alicia": "--only alicia: no submission has this id, name, number or address (did you"
    " mean alice?); --list shows all",
    "grade HERE/class -o HERE/class": f"-o HERE/class: {INSIDE}",
    "grade HERE/class -o HERE/class/alice": f"-o HERE/class/alice: {INSIDE}",
}


@pytest.mark.parametrize("request_", WRONG)
def test_a_wrong_request_is_one_line_and_nothing_is_marked(
    run: Run, students: Path, tmp_path: Path, marker: FakeMarker, request_: str
) -> None:
    (tmp_path / "none").mkdir()
    (tmp_path / "bad.yaml").write_text("criteria: 7\n")
    code, out, err = run(*request_.replace("HERE", str(tmp_path)).split())
    assert (code, out, marker.marked()) == (2, "", [])
    line = re.escape("imugrade: " + WRONG[request_].replace("HERE", str(tmp_path))).replace("…", ".*")
    assert all(re.fullmatch(line, each) for each in err.splitlines())
    assert len(err.splitlines()) == 1 or "bad.yaml:1" in WRONG[request_]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("end", "code", "line"),
    [
        (GraderError("the sandbox is gone"), 3, "the grader itself failed: the sandbox is gone"),
        (ZeroDivisionError("x\ny"), 3, "the grader itself failed: "),
        (result(check("not_judged", None), status="incomplete"), 3, ""),
    ],
)
def test_a_check_that_does_not_end_well_is_told_in_one_line(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, end: Result | BaseException, code: int, line: str
) -> None:
    checked(monkeypatch, end)
    ended, out, err = run("check", tmp_path)
    assert ended == code
    assert out.startswith(f"checking {tmp_path.name} …\n")
    assert err.startswith(f"imugrade: {line}") if line else err == ""
    assert all(line.startswith("imugrade: ") for line in err.splitlines())


@pytest.mark.parametrize("text", ["٣", "1_0", "nan"])
@pytest.mark.parametrize(
    "words", ["ci x --min-score", "grade x -o out --min-score", "repair out a f --deduct", "adjust out a --points"]
)
def test_an_option_that_takes_points_refuses_what_is_no_number_in_a_form(run: Run, words: str, text: str) -> None:
    code, out, err = run(*words.split(), text)
    assert (code, out) == (2, "")
    assert f"{text} is not a number. Write it like 2.5" in err


# --- check ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("secret", "said"), [("a secret", "hidden scenarios wait"), ("  ", "may grade with hidden")])
def test_a_check_says_what_it_checks_what_was_found_and_whether_there_is_a_secret_and_writes_what_was_asked_for(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, secret: str, said: str
) -> None:
    checked(monkeypatch, result(lost()))
    monkeypatch.setenv("IMUGRADE_SEED", secret)
    folder = tmp_path / "\x1b[31mred"  # the name of a folder cannot colour the terminal
    folder.mkdir()
    (folder / "filters.py").touch()
    monkeypatch.chdir(folder)
    code, out, err = run("check", "--html", "../r.html", "--json", "../r.json")
    assert (code, err) == (0, "")
    first, second, third, fourth = out.splitlines()[:4]
    assert first == r"checking \x1b[31mred …"
    assert second == "filters.py found; no imu_reader.py, no noisy_imu.py, no imu_data.png, no filtered_imu.png"
    assert "public checks. " in third
    assert said in third
    assert fourth == ""
    assert " ✗ failed  Reads the right sensor  0 / 6\n" in out
    assert "<h1>alice</h1>" in (tmp_path / "r.html").read_text(encoding="utf-8")
    assert json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))["score"] == 0.0


def test_of_one_criterion_alone_its_own_checks_are_counted_whatever_else_is_there(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    checked(monkeypatch, result(lost()))
    for name in ("filters.py", "complementary_filter.py"):
        (tmp_path / name).touch()
    monkeypatch.chdir(tmp_path)
    for part in ("filtering", "complementary_filter"):
        assert run("check", "--only", part)[1].splitlines()[2].startswith(f"{CHECKS[part]} public checks.")


def test_watching_checks_again_after_each_save_and_not_in_between(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pauses: list[float] = []

    def pause(seconds: float) -> None:
        pauses.append(seconds)
        match len(pauses):
            case 2:
                hand_in(tmp_path, me=0.5)  # as an editor that empties a file, and writes it half a second later
            case 4:
                hand_in(tmp_path, me=0.25)
            case 9:
                write({"__pycache__/filters.pyc": "", "venv/filters.py": ""}, tmp_path)
            case 10:
                (tmp_path / "report.html").touch()  # our own answer: to look at it would never end
            case 16:
                raise KeyboardInterrupt

    monkeypatch.setattr("grader.commands.checking.time.sleep", pause)
    monkeypatch.setattr("grader.commands.checking.time.monotonic", lambda: len(pauses) / 4)
    hand_in(tmp_path, me=1)
    seen: list[int] = []
    with pytest.raises(KeyboardInterrupt):  # noqa: PT012 - each save is seen until then
        for _ in checking.saves(tmp_path, [tmp_path / "sub" / ".." / "report.html"]):
            seen.append(len(pauses))
    assert seen == [0, 8], "a second after the last change"


def test_a_watching_check_says_at_once_that_it_checks_and_is_ended_by_an_interrupt(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def marked(*_: object, begins: Callable[[], None], **__: object) -> Iterator[Result]:
        for made in (result(lost()), result(check(id=lost().id))):
            begins()
            yield made
        raise KeyboardInterrupt

    monkeypatch.setattr(checking, "check_on_save", marked)
    code, out, err = run("check", hand_in(tmp_path, me=1) / "me", "--watch")
    lines = [re.sub(r"\d\d:\d\d:\d\d", "TIME", line) for line in out.splitlines()]
    assert (code, err) == (0, "")
    assert lines[:3] == ["me  checking …", "me  checking …", "me  checked at TIME; again on every save, Ctrl-C ends"]
    assert [line for line in lines if "Score" in line] == [
        "   Score  0 / 6",
        "   Score  6 / 6  +6 since the last check",
    ]


# --- grade ------------------------------------------------------------------------------------------------------------


@pytest.fixture
def grade(run: Run, students: Path, tmp_path: Path, marker: FakeMarker) -> Run:
    """Grade the class of students into the folder out, in one process: to start another takes longer than all else."""
    return lambda *more: run("grade", students, "-o", tmp_path / "out", "--jobs", 1, *more)


def test_grade_writes_the_folder_that_the_contract_names(grade: Run, tmp_path: Path) -> None:
    out = tmp_path / "out"
    code, told, err = grade()
    assert (code, err) == (0, NO_SEED)
    names = ("alice", "bob", "carol")
    pages = [f"submissions/{name}/{file}" for name in names for file in ("report.html", "result.json")]
    written = sorted(str(path.relative_to(out)) for path in out.rglob("*") if path.is_file())
    assert written == ["gradebook.csv", "index.html", "results.sqlite", *pages]
    rows = "".join(f"{name},{name},20,20,graded\n" for name in names)
    assert (out / "gradebook.csv").read_text() == f"id,name,sensor_access,total,status\n{rows}"
    lines = "1/3 alice 20\n2/3 bob 20\n3/3 carol 20\n3 graded · mean of graded 20.0\n"
    assert told == f"{lines}Open {out}/index.html\n"


def test_a_second_run_marks_only_what_changed_and_writes_again_what_was_lost_or_changed(
    grade: Run, students: Path, tmp_path: Path, marker: FakeMarker
) -> None:
    assert grade("--min-score", "20")[0] == 0
    hand_in(students, bob=0.5)
    published = sorted((tmp_path / "out" / "submissions" / "alice").iterdir())
    before = [path.read_bytes() for path in published]
    for path in published:
        path.write_text("{}")
    report = tmp_path / "out" / "submissions" / "carol" / "report.html"
    report.unlink()
    code, told, _ = grade("--min-score", "20.5")
    assert (code, sorted(marker.marked())) == (1, ["alice", "bob", "bob", "carol"])
    assert "1 graded · 2 on record · mean of graded 20.0" in told
    assert ([path.read_bytes() for path in published], report.is_file()) == (before, True)


def test_a_submission_that_kills_its_markers_is_incomplete_told_and_tried_again(
    grade: Run, run: Run, students: Path, tmp_path: Path, marker: FakeMarker
) -> None:
    hand_in(students, kill=1)
    out = tmp_path / "out"
    code, told, _ = grade()
    assert code == 3
    assert "Not judged, because the grader failed: kill. Run the command again: only these are graded again." in told
    record = json.loads((out / "submissions" / "kill" / "result.json").read_text())
    assert record["status"] == "incomplete"
    points = [each["points"] for criterion in record["criteria"] for each in criterion["checks"]]
    number = sum(CHECKS[criterion["id"]] for criterion in record["criteria"])
    assert points == [None] * number
    assert "kill,kill,,,,,,,incomplete\n" in (out / "gradebook.csv").read_text()
    _, report, _ = run("doctor", "--report", out)
    assert report.splitlines()[-3:] == [
        "lab: imu", f"faults: {number} checks of 4 submissions",
        f"{number}x the marking process was killed; first in sensor_access.returns_two_vectors",
    ]  # fmt: skip
    assert f"imugrade: {grader.__version__}\n" in report
    assert [word for word in ("kill\n", "alice", str(tmp_path), str(Path.home())) if word in report] == []
    grade()
    assert [marker.marked().count(name) for name in ("kill", "alice")] == [4, 1]


def test_without_isolation_a_class_is_refused_unless_it_is_trusted(monkeypatch: pytest.MonkeyPatch) -> None:
    unwalled = SimpleNamespace(isolation=NO_ISOLATION, mark=lambda *_, **__: result())
    monkeypatch.setattr(classroom, "Marker", lambda *_, **__: nullcontext(unwalled))
    with pytest.raises(RequestError, match=r"cannot isolate students' code .*add --trust-submissions"):
        classroom.guarded_marker(None, None, None, False).__enter__()  # type: ignore[arg-type]
    with classroom.guarded_marker(None, None, None, True) as marker:  # type: ignore[arg-type]
        assert marker.mark(None).status == "graded"  # type: ignore[arg-type]


# --- what the commands tell of themselves -----------------------------------------------------------------------------


def test_the_version_is_one_line(run: Run) -> None:
    assert run("--version") == run("-V") == (0, f"imugrade {grader.__version__}\n", "")


@pytest.mark.parametrize(
    ("code", "slow"),
    [
        ("from grader import cli; cli.main(['--help'])", "numpy mujoco rich jinja2 yaml pytest matplotlib"),
        ("from grader.commands import opening; from grader.engine import rubric; from grader.intake import read_submission",
         "mujoco matplotlib scipy pytest grader.engine.grader"),
        ("from grader import cli; from grader.intake import read_submission; from grader.engine.lab_sandbox import open_sandbox_for; "
         "from grader.labs.imu.lab import LAB; open_sandbox_for(LAB, {}).close()",
         "numpy mujoco matplotlib pytest yaml grader.engine.results"),
    ],
    ids=["help", "the first lines of a check", "the sandbox of a check"],
)  # fmt: skip
def test_what_comes_first_waits_for_no_slow_import(code: str, slow: str) -> None:
    program = f"{code}\nimport sys\nprint(sorted(set({slow.split()}) & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize("command", ["explain", "traces list", "check submissions_example/s14-empty"])
def test_a_reader_that_has_gone_is_neither_a_low_score_nor_a_failure(command: str) -> None:
    line = [sys.executable, "-m", "grader", *command.split()]
    with subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=ROOT) as done:
        assert done.stdout is not None
        assert done.stderr is not None
        done.stdout.close()
        assert done.stderr.read() == b""
    assert done.returncode == cli.UNREAD


def test_a_terminal_without_the_signs_gets_question_marks(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    checked(monkeypatch, result())
    screen = io.TextIOWrapper(io.BytesIO(), "ascii", write_through=True)
    with redirect_stdout(screen):
        assert run("check", tmp_path) == (0, "", "")
    assert b" ? Sensor access" in screen.buffer.getvalue()  # type: ignore[attr-defined] # it is the BytesIO


# --- doctor and traces ------------------------------------------------------------------------------------------------


def test_doctor_tells_each_level_with_its_reason_the_one_in_use_and_a_second_copy_that_can_be_opened(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    full, _, landlock, none = LEVELS
    works = [LevelResult(level, True, "") for level in (landlock, none)]
    tried = [LevelResult(full, False, "no user namespaces"), *works]
    monkeypatch.setattr("grader.commands.machine.probe", lambda: tried)
    monkeypatch.setattr("grader.commands.machine.try_recording", lambda _: None)  # it takes a second
    monkeypatch.setattr("grader.sandbox.visible_copies.search", lambda *_: Search(21_894, ()))
    code, out, err = run("doctor")
    told = [" ".join(line.split()) for line in out.splitlines()]
    says = ("looking at this machine …", "testing the isolation levels …", "recording traces …")
    assert (code, err) == (0, "".join(f"imugrade: {line}\n" for line in says))
    assert told[:4] == ["Isolation", "✗ full no user namespaces", "✓ landlock works here", "✓ in use landlock"]
    assert " ".join(told[4:6]) == "✓ hidden the 21,894 files that code in the sandbox can open contain no grader files"
    assert f"imugrade {grader.__version__}" in told
    found = ("/lib/a/filters.py", "/lib/a/imu_reader.py")
    monkeypatch.setattr("grader.sandbox.visible_copies.search", lambda *_: Search(9, found))
    told = " ".join(run("doctor")[1].split())
    assert "✗ hidden code in the sandbox can open 2 grader files; the first is /lib/a/filters.py" in told


def test_doctor_records_from_a_throw_away_secret_and_keeps_nothing(
    run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("grader.commands.machine.probe", lambda: [LevelResult(NO_ISOLATION, True, "")])
    monkeypatch.setenv(recording.CACHE_VARIABLE, str(tmp_path))
    told = " ".join(run("doctor")[1].split())
    assert told.endswith(f"✓ reference recorded {len(bundles.shipped().scenarios)} scenarios from a throw-away secret")
    assert list(tmp_path.iterdir()) == []


def test_a_written_bundle_is_the_one_in_use_and_private(run: Run, tmp_path: Path) -> None:
    (tmp_path / "new").mkdir()
    (tmp_path / "new" / "public.npz").touch(0o644)
    code, out, _ = run("traces", "record", "-o", tmp_path / "new")
    assert (code, out) == (0, f"{tmp_path}/new/public.npz\n")
    assert traces.load(tmp_path / "new" / "public.npz").sha256 == bundles.obtain(LAB, None).sha256
    assert {path.stat().st_mode & 0o077 for path in (tmp_path / "new").iterdir()} == {0}


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal")
def test_a_run_that_is_interrupted_keeps_what_it_had(grade: Run, students: Path, tmp_path: Path) -> None:
    (students / "bob").rename(students / "interrupt")
    stopped = "imugrade: stopped; run the same command again to go on\n"
    assert grade() == (130, "1/3 alice 20\n2/3 carol 20\n", stopped)
    assert (tmp_path / "out" / "gradebook.csv").read_text().count("\n") == 3
