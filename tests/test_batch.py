"""A class is marked by processes of the pool: what becomes of the others when one is killed, hangs, grows or is given up."""

from __future__ import annotations

import multiprocessing
import os
import re
import select
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from multiprocessing import connection
from pathlib import Path

import pytest

from grader.course.markers.pool import Bounds, Ended, MarkerAnswer, Unmarked, mark_all
from grader.course.run import unmarked
from grader.course.run.grade_request import GradeRequest
from grader.course.run.warnings import remarks
from grader.engine import rubric
from grader.engine.processes import starting_processes
from grader.engine.results import Result
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.people.final_grade import FinalGrade
from tests.fake_results import FakeMarker, check, fake_marker, result, submission

ROOT = Path(__file__).parent.parent
ON_LINUX = pytest.mark.skipif(
    sys.platform != "linux", reason="only Linux tells what another process holds, and when it ends"
)
NO_BOUNDS = Bounds()


def grade(folder: Path, *ids: str, bounds: Bounds = NO_BOUNDS) -> dict[str, MarkerAnswer]:
    marked = mark_all(iter(map(submission, ids)), partial(fake_marker, folder), 2, bounds)
    return {each.id: outcome for each, outcome in marked}


def test_every_submission_is_marked_once_and_every_marker_closed(tmp_path: Path) -> None:
    names = [f"s{i}" for i in range(9)]
    outcomes = grade(tmp_path, *names)
    assert sorted(outcomes) == sorted(FakeMarker(tmp_path).marked()) == names
    assert all(isinstance(outcome, Result) for outcome in outcomes.values())
    assert 1 <= len(list(tmp_path.glob("closed-*"))) <= 2
    assert multiprocessing.active_children() == []


def test_what_kills_its_marker_is_marked_again_and_handed_back_the_second_time_and_no_other_is_marked_twice(
    tmp_path: Path,
) -> None:
    outcomes = grade(tmp_path, "a", "once", "kill", "b", "c")
    assert outcomes.pop("kill") == Unmarked("the marking process was killed")
    assert all(isinstance(outcome, Result) for outcome in outcomes.values())
    assert sorted(FakeMarker(tmp_path).marked()) == ["a", "b", "c", "kill", "kill", "once", "once"]


def test_a_fault_of_the_grader_is_handed_back_with_its_words_and_no_other_is_marked_twice(tmp_path: Path) -> None:
    names = [f"s{i}" for i in range(6)]
    outcomes = grade(tmp_path, "bug", *names)
    found = outcomes.pop("bug")
    assert isinstance(found, Unmarked)
    assert re.fullmatch(r"GraderError at grader/\S+:\d+ in \w+: the zygote is gone", found.reason)
    assert sorted(outcomes) == names
    assert sorted(FakeMarker(tmp_path).marked()) == ["bug", "bug", *names]


@pytest.mark.parametrize(
    ("id_", "bounds", "reason"),
    [
        ("wait", Bounds(wall_s=1.0), "no end within 1 s"),
        ("burn", Bounds(wall_s=1.0), "no end within 1 s"),
        pytest.param("fat", Bounds(memory_bytes=300 << 20), "more than 0.292969 GB of memory", marks=ON_LINUX),
    ],
)
def test_a_marker_that_does_not_answer_or_grows_without_end_is_ended_and_the_others_go_on(
    tmp_path: Path, id_: str, bounds: Bounds, reason: str
) -> None:
    outcomes = grade(tmp_path, "a", id_, "b", "c", bounds=bounds)
    assert outcomes.pop(id_) == Ended(reason)
    assert all(isinstance(outcome, Result) for outcome in outcomes.values())
    assert sorted(FakeMarker(tmp_path).marked()) == sorted(["a", "b", "c", id_, id_])
    assert multiprocessing.active_children() == []


def test_a_run_that_is_given_up_leaves_no_process_behind(tmp_path: Path) -> None:
    run = mark_all(iter([submission("a"), submission("b"), submission("c")]), partial(fake_marker, tmp_path), 2)
    next(run)
    run.close()
    assert multiprocessing.active_children() == []


KILLED = """
import os, pathlib, sys, threading, time
from functools import partial
from grader.course.markers.pool import mark_all
from tests.fake_results import fake_marker, submission

def leave():
    while not (folder / "marked").exists(): time.sleep(0.05)
    time.sleep(0.5)
    os.kill(os.getpid(), 9)

folder = pathlib.Path(sys.argv[1])
"""
AT_ONCE = "for _ in mark_all(iter([submission('a'), submission('b')]), partial(fake_marker, folder), 1): os.kill(os.getpid(), 9)"
AT_WORK = "threading.Thread(target=leave).start(); list(mark_all(iter([submission('burn')]), partial(fake_marker, folder), 1))"


@ON_LINUX
@pytest.mark.parametrize("run", [AT_ONCE, AT_WORK], ids=["after the first", "while a worker never gives way"])
def test_workers_leave_when_the_run_is_killed(tmp_path: Path, run: str) -> None:
    """One went on for half an hour: the thread that looks for the end of the run never had its turn."""
    command = [sys.executable, "-c", KILLED + run, str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, check=False, stderr=subprocess.DEVNULL)
    assert done.returncode == -signal.SIGKILL
    with suppress(ProcessLookupError):  # it has ended already
        worker = os.pidfd_open(int((tmp_path / "marked").read_text().split()[1]))
        assert select.select([worker], [], [], 10)[0], "the worker is still there after 10 s"


def test_ctrl_c_while_processes_start_stops_the_run_and_not_the_processes() -> None:
    ours, theirs = multiprocessing.Pipe()
    with pytest.raises(KeyboardInterrupt):
        _press_ctrl_c_while_starting(theirs)
    assert ours.poll(60)
    assert ours.recv() == "still here"


def _press_ctrl_c_while_starting(line: connection.Connection[str, None]) -> None:
    with starting_processes() as begin:
        process = multiprocessing.get_context("spawn").Process(target=_answer_interrupted, args=(line, begin))
        process.start()
        os.kill(process.pid or 0, signal.SIGINT)
        signal.raise_signal(signal.SIGINT)


def _answer_interrupted(line: connection.Connection[str, None], begin: Callable[[], None]) -> None:
    begin()
    signal.raise_signal(signal.SIGINT)
    line.send("still here")


def test_a_submission_that_stopped_two_markers_has_a_verdict_and_stands_on_the_list(tmp_path: Path) -> None:
    order = GradeRequest((tmp_path,), tmp_path / "out", rubric.load(LAB), bundles.shipped())
    stopped = unmarked.stopped(submission("alice"), order, "no end within 600 s")
    assert (stopped.status, stopped.score, stopped.max_score) == ("graded", 0.0, 100.0)
    assert {(row.outcome, row.points) for part in stopped.criteria for row in part.checks} == {("timeout", 0.0)}
    assert [sum(row.max_points for row in criterion.checks) for criterion in stopped.criteria] == [20.0] * 5
    assert "ended twice (no end within 600 s)" in stopped.notes[0]
    bob = result(check("timeout", 0.0), check())
    final_grades = {"alice": FinalGrade("alice", stopped), "bob": FinalGrade("bob", bob)}
    assert [line for line in remarks(final_grades, [], []) if "timed out" in line] == [
        "every check timed out (review what the code does): alice"
    ]
