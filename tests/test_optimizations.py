"""Tests that no optimization changes points: submissions are graded with all of them and without any."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

from grader.engine import check_runner, grader, lab_sandbox, rubric
from grader.engine.grader import Marker
from grader.engine.lab_sandbox import WORKER_CODE
from grader.engine.results import to_json
from grader.intake import read_submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from tests.examples import FOLDER
from tests.fake_results import without_durations

CHOSEN = ("s01-sheet-verbatim", "s07-no-units", "s11-kills-its-interpreter")

PICTURES_IN_FULL = (
    "\n\ndef reads_pictures_back(sources):\n    return True\n\n\ndef _undrawn_artists(axes):\n    return ()\n"
)
"""Further code of drawing.py: every picture is drawn as the student's code asks, and looked at."""


def marks(marker: Marker, folder: Path) -> object:
    return without_durations(json.loads(to_json(marker.mark(read_submission(folder, LAB.files)))))


@contextmanager
def without_savings(folder: Path) -> Iterator[Marker]:
    """A marker that does nothing beforehand and draws in full."""
    worker_code = shutil.copytree(WORKER_CODE, folder / "worker", ignore=shutil.ignore_patterns("__pycache__"))
    drawing = worker_code / "drawing.py"
    own = drawing.read_text(encoding="utf-8")
    replaced = re.findall(r"^def (\w+)\(", PICTURES_IN_FULL, re.MULTILINE)
    assert all(f"\ndef {each}(" in own for each in replaced), "there is no such saving"
    drawing.write_text(own + PICTURES_IN_FULL, encoding="utf-8")
    with mock.patch.object(lab_sandbox, "WORKER_CODE", worker_code):
        sandbox = lab_sandbox.open_sandbox(LAB, thorough=False)
    with (
        mock.patch.object(grader, "libraries_of", return_value=()),
        Marker(rubric.load(LAB), bundles.shipped(), sandbox=sandbox) as slow,
    ):
        yield slow


def test_no_saving_changes_a_mark(marker: Marker, tmp_path: Path) -> None:
    chosen = [FOLDER / name for name in CHOSEN]
    cheap = {folder.name: marks(marker, folder) for folder in chosen}
    with without_savings(tmp_path) as slow:
        for folder in chosen:
            check_runner.session.cache_clear()  # the checks are collected anew for each submission
            assert marks(slow, folder) == cheap[folder.name], folder.name
