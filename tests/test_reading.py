"""A class is read in a process that can be ended: one submission that does not end, grows or breaks it costs itself alone."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import pytest

from grader.engine.reading import ReadingProcess
from grader.intake import Submission, read_submission
from grader.labs.imu.lab import LAB
from grader.platforms.classes import ClassEntry


@dataclass(frozen=True)
class Hostile(ClassEntry):
    """Reading it does what its id says."""

    def read(self) -> Submission:
        if self.id == "stalls":
            time.sleep(60)
        if self.id == "grows":
            return read_submission(self.path, LAB.files, id=str(bytes(2 << 30)[:1]))
        if self.id == "ends" or (self.id == "once" and not (self.path / "tried").exists()):
            (self.path / "tried").touch()
            os._exit(3)
        if self.id == "breaks":
            raise KeyError("nobody thought of it")
        return super().read()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "filters.py").write_text("answer = 42\n")
    return tmp_path


@pytest.fixture
def reader() -> Iterator[ReadingProcess]:
    with ReadingProcess(within_s=2.0, memory_bytes=1 << 30) as reader:
        yield reader


@pytest.mark.parametrize(
    ("id_", "note"),
    [
        ("stalls", "What was handed in could not be read within 2 s."),
        ("ends", "What was handed in could not be read within 2 s."),
        ("grows", "What was handed in takes too much memory to be read."),
        ("breaks", "What was handed in could not be read (KeyError)."),
    ],
)
def test_what_cannot_be_read_is_unreadable_and_the_next_one_is_read(
    folder: Path, reader: ReadingProcess, id_: str, note: str
) -> None:
    if id_ == "grows" and not hasattr(os, "fork"):
        pytest.skip("no bound on memory here")
    found = reader.read(Hostile(id_, id_, folder, LAB.files))
    assert (found.id, found.status, found.notes) == (id_, "unreadable", (note,))
    sound = ClassEntry("alice", "Alice", folder, LAB.files)
    assert reader.read(sound) == sound.read()


def test_a_submission_whose_process_ended_once_is_read_by_the_next_one(folder: Path, reader: ReadingProcess) -> None:
    assert reader.read(Hostile("once", "once", folder, LAB.files)).status == "ready"


HANGS = """
import sys, time
from functools import partial
from grader import cli
from grader.engine import reading
from grader.intake import submission

def hangs(*_):
    {hangs}

submission._gather = hangs
reading.ReadingProcess = partial(reading.ReadingProcess, within_s=0.5, memory_bytes=1 << 30)
sys.exit(cli.main(sys.argv[1:]))
"""


LATE = "What was handed in could not be read within 0.5 s."


@pytest.mark.skipif(
    sys.platform != "linux", reason="what is put in the place of the reading is not there in a fresh process"
)
@pytest.mark.parametrize(
    ("command", "hangs", "note"),
    [
        (("check", "--json", "result.json"), "time.sleep(60)", LATE),
        (("ci", "-f", "json", "-o", "result.json"), "while True: pass", LATE),
    ],
)
def test_check_and_ci_end_whatever_reading_does(folder: Path, command: tuple[str, ...], hangs: str, note: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", HANGS.format(hangs=hangs), *command],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    result = json.loads((folder / "result.json").read_text())
    assert (result["status"], result["notes"], result["score"]) == ("unreadable", [note], 0.0)


@pytest.mark.parametrize("threads", [0, 1], ids=["a copy of this process", "a new process"])
def test_the_process_ends_by_itself_when_nothing_more_is_read(
    folder: Path, threads: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It sees that the connection is closed, and nobody has to kill it; a busy machine may take its time here."""
    monkeypatch.setattr("grader.engine.reading._LEAVES_WITHIN_S", 60.0)
    wait = threading.Event()
    with ThreadPoolExecutor() as beside:
        for _ in range(threads):
            beside.submit(wait.wait)
        try:
            with ReadingProcess() as reader:
                reader.read(ClassEntry("alice", "Alice", folder, LAB.files))
                process = reader._process
        finally:
            wait.set()
    assert process is not None
    assert process.exitcode == 0
