from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from functools import partial
from pathlib import Path

import pytest

from grader.course import unmarked
from grader.course.grade_request import GradeRequest
from grader.course.pool import Bounds, Outcome, Stopped, Unmarked, mark_all
from grader.course.warnings import remarks
from grader.engine import rubric
from grader.engine.results import Result
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.people.final_grade import FinalGrade
from tests.fake_results import FakeMarker, check, fake_marker, result, submission

ROOT = Path(__file__).parent.parent


DEFAULT = Bounds()


def grade(folder: Path, *ids: str, jobs: int = 1, bounds: Bounds = DEFAULT) -> dict[str, Outcome]:
    marked = mark_all(iter(map(submission, ids)), partial(fake_marker, folder), jobs, bounds)
    return {each.id: outcome for each, outcome in marked}


def test_every_submission_is_marked_once_and_every_marker_closed(tmp_path: Path) -> None:
    names = [f"s{i}" for i in range(9)]
    outcomes = grade(tmp_path, *names, jobs=2)
    assert sorted(outcomes) == sorted(FakeMarker(tmp_path).marked()) == names
    assert all(isinstance(outcome, Result) for outcome in outcomes.values())
    assert 1 <= len(list(tmp_path.glob("closed-*"))) <= 2
    assert multiprocessing.active_children() == []


def test_a_marker_that_is_killed_is_replaced_and_its_submission_marked_again(tmp_path: Path) -> None:
    outcomes = grade(tmp_path, "a", "once", "b")
    assert all(isinstance(outcome, Result) for outcome in outcomes.values())
    assert sorted(FakeMarker(tmp_path).marked()) == ["a", "b", "once", "once"]


def test_a_submission_that_kills_two_markers_is_handed_back_and_no_other_is_marked_twice(tmp_path: Path) -> None:
    outcomes = grade(tmp_path, "a", "kill", "b", "c", jobs=2)
    assert outcomes.pop("kill") == Unmarked("the marking process was killed")
    assert all(isinstance(outcome, Result) for outcome in outcomes.values())
    assert sorted(FakeMarker(tmp_path).marked()) == ["a", "b", "c", "kill", "kill"]


def test_a_fault_of_the_grader_is_handed_back_with_its_words(tmp_path: Path) -> None:
    assert grade(tmp_path, "bug")["bug"] == Unmarked("GraderError: the zygote is gone")


@pytest.mark.parametrize("id_", ["wait", "burn"])
def test_a_marker_that_does_not_answer_is_ended_and_the_others_go_on(tmp_path: Path, id_: str) -> None:
    outcomes = grade(tmp_path, "a", id_, "b", "c", jobs=2, bounds=Bounds(wall_s=2.0))
    assert outcomes.pop(id_) == Stopped("no end within 2 s")
    assert all(isinstance(outcome, Result) for outcome in outcomes.values())
    assert sorted(FakeMarker(tmp_path).marked()) == sorted(["a", "b", "c", id_, id_])
    assert all(gone(int(line.split()[-1])) for line in (tmp_path / "marked").read_text().splitlines())


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells what another process holds")
def test_a_marker_that_grows_without_end_is_ended(tmp_path: Path) -> None:
    outcomes = grade(tmp_path, "a", "fat", "b", jobs=2, bounds=Bounds(memory_bytes=300 << 20))
    assert outcomes.pop("fat") == Stopped("more than 0.292969 GB of memory")
    assert all(isinstance(outcome, Result) for outcome in outcomes.values())


def test_a_run_that_is_given_up_leaves_no_process_behind(tmp_path: Path) -> None:
    run = mark_all(iter([submission("a"), submission("b"), submission("c")]), partial(fake_marker, tmp_path), 2)
    next(run)
    run.close()
    assert multiprocessing.active_children() == []


KILLED = """
import os, pathlib, sys, threading, time
from functools import partial
from grader.course.pool import mark_all
from tests.fake_results import fake_marker, submission

def leave():
    while not (folder / "marked").exists(): time.sleep(0.05)
    time.sleep(0.5)
    os.kill(os.getpid(), 9)

if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1])
    {run}
"""
AT_ONCE = "for _ in mark_all(iter([submission('a'), submission('b')]), partial(fake_marker, folder), 1): os.kill(os.getpid(), 9)"
AT_WORK = "threading.Thread(target=leave).start(); list(mark_all(iter([submission('burn')]), partial(fake_marker, folder), 1))"


@pytest.mark.parametrize(
    "run",
    [
        pytest.param(AT_ONCE, marks=pytest.mark.skipif(sys.platform == "win32", reason="sends a signal")),
        pytest.param(
            AT_WORK, marks=pytest.mark.skipif(sys.platform != "linux", reason="elsewhere only a thread can see to it")
        ),
    ],
    ids=["after the first", "while a worker never gives way"],
)
def test_workers_leave_when_the_run_is_killed(tmp_path: Path, run: str) -> None:
    """One went on for half an hour: the thread that looks for the end of the run never had its turn."""
    script = tmp_path / "run.py"
    script.write_text(KILLED.format(run=run))
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, str(script), str(tmp_path)]
    done = subprocess.run(command, env=environment, check=False, stderr=subprocess.DEVNULL)
    assert done.returncode == -signal.SIGKILL
    assert gone(int((tmp_path / "marked").read_text().split()[1]))


def gone(pid: int, within_s: float = 10.0) -> bool:
    """Whether a process that is not our child ends in time."""
    end = time.monotonic() + within_s
    while time.monotonic() < end:
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return True
        with suppress(OSError):
            if ") Z " in Path(f"/proc/{pid}/stat").read_text():
                return True  # ended; whoever adopted it has not looked yet
    return False


def test_a_submission_that_stopped_two_markers_has_a_verdict_and_stands_on_the_list(tmp_path: Path) -> None:
    order = GradeRequest((tmp_path,), tmp_path / "out", rubric.load(LAB), bundles.shipped())
    stopped = unmarked.stopped(submission("alice"), order, "no end within 600 s")
    assert (stopped.status, stopped.score, stopped.max_score) == ("graded", 0.0, 100.0)
    rows = [check for criterion in stopped.criteria for check in criterion.checks]
    assert {(row.outcome, row.points) for row in rows} == {("timeout", 0.0)}
    assert [sum(row.max_points for row in criterion.checks) for criterion in stopped.criteria] == [20.0] * 5
    assert "ended twice (no end within 600 s)" in stopped.notes[0]
    final_grades = {
        "alice": FinalGrade("alice", stopped),
        "bob": FinalGrade("bob", result(check("timeout", 0.0), check())),
    }
    assert [line for line in remarks(final_grades, [], []) if "timed out" in line] == [
        "every check timed out (review what the code does): alice"
    ]
