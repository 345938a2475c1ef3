"""A run that is killed, or whose disk is full or read-only, loses nothing; the long campaign is `python -m tests.durability`."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from grader.engine import rubric
from grader.engine.grader import Marker
from grader.intake import read_submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.sandbox.sandbox import Worker
from grader.sandbox.wire import Frame
from tests.corpus.pieces import tidy
from tests.corpus.writing import write
from tests.durability import ROOT, campaign, hand_in

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="finds processes in /proc")


def test_killed_runs_go_on_to_the_same_results_and_leave_nothing_behind() -> None:
    runs = campaign(2, seed=5, full=False)
    assert [run.troubles for run in runs] == [[], []]
    assert sum(run.hit for run in runs) >= 1


@pytest.mark.parametrize("number", [1, 4, 9, 15])
def test_a_zygote_that_is_killed_while_it_is_asked_costs_the_submission_nothing(
    number: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked, ask = 0, Worker.ask

    def disturbed(self: Worker, *question: Any, **limits: Any) -> Frame:
        nonlocal asked
        asked += 1
        if asked == number:
            os.kill(marker._sandbox._zygote.pid, signal.SIGKILL)  # type: ignore[union-attr]
        return ask(self, *question, **limits)

    submission = read_submission(write(tidy(), tmp_path / "whole"), LAB.files)
    monkeypatch.setattr(Worker, "ask", disturbed)
    with Marker(rubric.load(LAB), bundles.shipped()) as marker:
        if not marker.isolation.isolates:
            pytest.skip("there is no zygote without isolation")
        result = marker.mark(submission)
    assert asked > number
    assert (result.status, result.score) == ("graded", 100.0)


A_LARGE_SUBMISSION = """
import os, pathlib, sys, threading
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from grader.course.pool import mark_all
from tests.fake_results import FakeMarker, submission

@contextmanager
def killed_once(folder):
    if not (folder / "killed").exists():
        (folder / "killed").touch()
        threading.Event().wait(0.5)  # by now the submission is on its way, and fills the pipe
        os.kill(os.getpid(), 9)
    yield FakeMarker(folder)

if __name__ == "__main__":
    large = replace(submission("a"), files={"imu_data.png": bytes(1_000_000)})
    for each, outcome in mark_all(iter([large]), partial(killed_once, pathlib.Path(sys.argv[1])), 1):
        print(each.id, type(outcome).__name__)
"""


def test_a_marker_that_is_killed_with_a_large_submission_on_its_way_to_it_does_not_stop_the_run(tmp_path: Path) -> None:
    """Pythons before 3.11.5 then wait for ever at their end: https://github.com/python/cpython/issues/94777."""
    script = tmp_path / "run.py"
    script.write_text(A_LARGE_SUBMISSION)
    command, environment = [sys.executable, str(script), str(tmp_path)], {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == "a Result\n"


IN_A_SMALL_DISK = """
set -u
mount -t tmpfs -o size=SIZE none "$1"
cd ROOT
PYTHON -m grader grade "$2" -o "$1/out" --jobs 1; echo "first: $?"
BETWEEN
PYTHON -m grader grade "$2" -o "$1/out" --jobs 1; echo "second: $?"
AFTER
PYTHON -m grader grade "$2" -o "$1/out" --jobs 1; echo "third: $?"
ls "$1"/out/submissions/*/result.json | wc -l
"""


def in_a_small_disk(folder: Path, *, size: str, between: str, after: str) -> subprocess.CompletedProcess[str]:
    """Grade three times on a disk of one's own; skips the test where no disk can be had."""
    unshare = shutil.which("unshare")
    if unshare is None or subprocess.run([unshare, "-Urm", "true"], check=False, capture_output=True).returncode:
        pytest.skip("no mount namespace of one's own")
    script = IN_A_SMALL_DISK.replace("SIZE", size).replace("BETWEEN", between).replace("AFTER", after)
    script = script.replace("ROOT", str(ROOT)).replace("PYTHON", sys.executable)
    disk, students = folder / "disk", hand_in(folder / "class", full=False)
    disk.mkdir()
    return subprocess.run(
        [unshare, "-Urm", "sh", "-c", script, "sh", str(disk), str(students)],
        capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip


def test_a_full_disk_is_told_in_one_line_and_the_record_goes_on_where_it_ended(tmp_path: Path) -> None:
    done = in_a_small_disk(tmp_path, size="160k", between='mount -o remount,size=20m "$1"', after=":")
    assert "first: 2" in done.stdout, done.stdout + done.stderr
    told = [line for line in done.stderr.splitlines() if line.startswith("imugrade:") and "seed" not in line]
    assert len(told) == 1
    assert "disk" in told[0] or "space" in told[0]
    assert "Traceback" not in done.stderr
    assert "second: 0" in done.stdout
    assert "third: 0" in done.stdout
    assert done.stdout.strip().endswith("6")


def test_a_read_only_folder_is_told_in_one_line_and_the_record_stays(tmp_path: Path) -> None:
    done = in_a_small_disk(tmp_path, size="20m", between='mount -o remount,ro "$1"', after='mount -o remount,rw "$1"')
    assert "first: 0" in done.stdout, done.stdout + done.stderr
    assert "second: 2" in done.stdout
    told = [line for line in done.stderr.splitlines() if line.startswith("imugrade:") and "seed" not in line]
    assert len(told) == 1
    assert str(tmp_path) in told[0]
    assert "Traceback" not in done.stderr
    assert "third: 0" in done.stdout
    assert "6 on record" in done.stdout
