"""A run that is killed, or whose disk is full or read-only, loses nothing; the long campaign is `python -m tests.durability`."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from grader.engine import rubric
from grader.engine.grader import Marker
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.sandbox.sandbox import Worker
from grader.sandbox.wire import Frame
from tests.corpus.pieces import tidy
from tests.durability import ROOT, campaign, hand_in
from tests.single_faults import marked

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="finds processes in /proc")


def test_killed_runs_go_on_to_the_same_results_and_leave_nothing_behind() -> None:
    (run,) = campaign(1, seed=5, full=False)
    assert run.hit
    assert run.resumed >= 1
    assert run.troubles == []


@pytest.fixture(scope="module")
def own_marker() -> Iterator[Marker]:
    """A marker whose sandbox no other test uses."""
    with Marker(rubric.load(LAB), bundles.shipped()) as marker:
        if not marker.isolation.isolates:
            pytest.skip("there is no zygote without isolation")
        yield marker


@pytest.mark.parametrize("number", [1, *(pytest.param(n, marks=pytest.mark.weekly) for n in (4, 9)), 15])
def test_a_zygote_that_is_killed_while_it_is_asked_costs_the_submission_nothing(
    number: int, own_marker: Marker, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked, ask = 0, Worker.ask

    def disturbed(self: Worker, *question: Any, **limits: Any) -> Frame:
        nonlocal asked
        asked += 1
        if asked == number:
            os.kill(own_marker._sandbox._zygote.pid, signal.SIGKILL)  # type: ignore[union-attr]
        return ask(self, *question, **limits)

    monkeypatch.setattr(Worker, "ask", disturbed)
    result = marked(own_marker, tidy())
    assert asked > number
    assert (result.status, result.score) == ("graded", 100.0)


A_LARGE_SUBMISSION = """
import os, pathlib, sys, threading
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from grader.course.markers.pool import mark_all
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


GRADE_ON_A_SMALL_DISK = f"""
set -u
grade() {{ {sys.executable} -m grader grade "$2" -o "$1/out" --jobs 1; echo "exit code $?"; }}
cd {ROOT}
mount -t tmpfs -o size=160k none "$1"
grade "$@"
mount -o remount,size=20m "$1"
grade "$@"
mount -o remount,ro "$1"
grade "$@"
mount -o remount,rw "$1"
grade "$@"
ls "$1"/out/submissions/*/result.json | wc -l
"""


def test_a_full_or_read_only_disk_is_told_in_one_line_and_the_record_goes_on(tmp_path: Path) -> None:
    unshare = shutil.which("unshare")
    if unshare is None or subprocess.run([unshare, "-Urm", "true"], check=False, capture_output=True).returncode:
        pytest.skip("no mount namespace of one's own")
    disk, students = tmp_path / "disk", hand_in(tmp_path / "class", full=False)
    disk.mkdir()
    command = [unshare, "-Urm", "sh", "-c", GRADE_ON_A_SMALL_DISK, "sh", str(disk), str(students)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    codes = [line[-1] for line in done.stdout.splitlines() if line.startswith("exit code ")]
    assert codes == ["2", "0", "2", "0"], done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    full, read_only = [line for line in done.stderr.splitlines() if line.startswith("imugrade:") and "seed" not in line]
    assert "disk" in full or "space" in full
    assert str(tmp_path) in read_only
    assert "4 on record" in done.stdout
    assert done.stdout.strip().endswith("4")
