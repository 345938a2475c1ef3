from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from grader.batch import Unmarked, mark_all
from grader.errors import RequestError
from grader.results import Result
from tests.made_up import FakeMarker, fake_marker, no_marker, submission

ROOT = Path(__file__).parent.parent


def grade(folder: Path, *ids: str, jobs: int = 1) -> dict[str, Result | Unmarked]:
    marked = mark_all(iter(map(submission, ids)), partial(fake_marker, folder), jobs)
    return {each.id: outcome for each, outcome in marked}


def test_every_submission_is_marked_once_and_every_marker_closed(tmp_path: Path) -> None:
    names = [f"s{i}" for i in range(9)]
    outcomes = grade(tmp_path, *names, jobs=2)
    assert sorted(outcomes) == sorted(FakeMarker(tmp_path).marked()) == names
    assert all(isinstance(outcome, Result) for outcome in outcomes.values())
    assert 1 <= len(list(tmp_path.glob("closed-*"))) <= 2
    assert multiprocessing.active_children() == []


def test_markers_stay_warm_from_one_submission_to_the_next(tmp_path: Path) -> None:
    grade(tmp_path, "a", "b", "c")
    pids = {line.split()[1] for line in (tmp_path / "marked").read_text().splitlines()}
    assert len(pids) == 1
    assert pids != {str(os.getpid())}


def test_nothing_is_started_when_there_is_nothing_to_mark(tmp_path: Path) -> None:
    assert list(mark_all(iter(()), partial(no_marker, tmp_path), 4)) == []


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


def test_a_marker_that_cannot_be_opened_ends_the_run(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match=f"no marker for {tmp_path.name}"):
        list(mark_all(iter([submission("a")]), partial(no_marker, tmp_path), 1))
    assert multiprocessing.active_children() == []


def test_a_run_that_is_given_up_leaves_no_process_behind(tmp_path: Path) -> None:
    run = mark_all(iter([submission("a"), submission("b"), submission("c")]), partial(fake_marker, tmp_path), 2)
    next(run)
    run.close()
    assert multiprocessing.active_children() == []


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal")
def test_workers_leave_when_the_run_is_killed(tmp_path: Path) -> None:
    program = (
        "import os, sys, pathlib\n"
        "from functools import partial\n"
        "from grader.batch import mark_all\n"
        "from tests.made_up import fake_marker, submission\n"
        "if __name__ == '__main__':\n"
        "    opener = partial(fake_marker, pathlib.Path(sys.argv[1]))\n"
        "    for done in mark_all(iter([submission('a'), submission('b')]), opener, 1):\n"
        "        os.kill(os.getpid(), 9)\n"
    )
    script = tmp_path / "run.py"
    script.write_text(program)
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, str(script), str(tmp_path)], env=environment, check=False, stderr=subprocess.DEVNULL
    )
    assert done.returncode == -signal.SIGKILL
    worker = int((tmp_path / "marked").read_text().split()[1])
    assert gone(worker)


def gone(pid: int, within_s: float = 10.0) -> bool:
    """Whether a process that is not our child ends in time."""
    end = time.monotonic() + within_s
    while time.monotonic() < end:
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return True
        if Path(f"/proc/{pid}/stat").exists() and ") Z " in Path(f"/proc/{pid}/stat").read_text():
            return True  # ended; whoever adopted it has not looked yet
    return False
