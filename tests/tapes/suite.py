"""Single submissions that tests mark, from tapes as the corpus is; they are recorded by running those tests."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path

from grader.engine import rubric
from grader.engine.lab_box import open_box
from grader.engine.marking import Marker
from grader.engine.results import Result
from grader.intake import Submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from tests.tapes import Marking, PlayingBox, RecordingBox, Tape
from tests.tapes.storing import Shelf, store

FILE = Path(__file__).parent / "suite.tape"
RECORDS = "IMUGRADE_RECORDS_TAPES"
TESTS = (
    "tests/test_absent.py",
    "tests/test_assembling.py",
    "tests/test_module_level.py",
    "tests/test_nothing.py",
    "tests/test_once.py",
    "tests/test_gaps.py",
    "tests/test_castings.py",
    "tests/test_own_habits.py",
    "tests/test_returned_forms.py",
    "tests/test_two_faults.py",
    "tests/test_unforeseen_habits.py",
    "tests/test_unforeseen_noise_filter.py",
    "tests/test_unforeseen_plots.py",
    "tests/test_unforeseen_reader_collect.py",
)


class Player:
    """A marker whose box is the tape of what it is handed."""

    def __init__(self) -> None:
        self._shelf = Shelf(FILE)
        self._box = PlayingBox(self._shelf.rung)
        self._marker = _marker(self._box)

    def mark(self, submission: Submission, only: str | None = None) -> Result:
        self._box.tape = self._shelf[_name(submission, only)]
        return self._marker.mark(submission, only=only)


class Recorder:
    """A marker with a box that keeps a tape of everything that it marks."""

    def __init__(self) -> None:
        self._box = RecordingBox(open_box(LAB))
        self._marker = _marker(self._box)
        self.tapes: dict[str, Tape] = {}

    def mark(self, submission: Submission, only: str | None = None) -> Result:
        self.tapes[_name(submission, only)] = self._box.begin()
        return self._marker.mark(submission, only=only)


@contextmanager
def opened() -> Iterator[Marking]:
    """A player, or a recorder where the tapes are made."""
    if RECORDS not in os.environ:
        yield Player()
        return
    recorder = Recorder()
    yield recorder
    store(recorder.tapes, FILE)


def _marker(box: PlayingBox | RecordingBox) -> Marker:
    return Marker(_without_charts(), bundles.shipped(), box=box)  # type: ignore[arg-type] # speaks as a box does


@cache
def _without_charts() -> rubric.Rubric:
    return rubric.parse(replace(LAB, charts=lambda student, truth: ()), rubric.shipped(LAB).read_bytes())


def _name(submission: Submission, only: str | None) -> str:
    digest = hashlib.sha256(repr((only, submission.notes, sorted(submission.files.items()))).encode())
    return digest.hexdigest()[:20]


def record() -> int:
    """Run those tests with a box; what pytest ends with."""
    command = [sys.executable, "-m", "pytest", "-n", "0", *TESTS]
    return subprocess.run(command, env={**os.environ, RECORDS: "1"}, check=False).returncode


if __name__ == "__main__":
    sys.exit(record())
