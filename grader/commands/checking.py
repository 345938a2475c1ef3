"""Check a submission on one's own machine again whenever a file in it is saved, for `imugrade check --watch`."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Collection, Iterator
from pathlib import Path

from grader.engine.grader import Marker
from grader.engine.lab_sandbox import open_sandbox_for
from grader.engine.reading import ReadingProcess, SingleSubmission
from grader.engine.results import Result
from grader.engine.rubric import Rubric
from grader.engine.session import Listener
from grader.engine.traces import Traces
from grader.intake.names import is_litter

PAUSE_S = 0.2
STILL_S = 1.0
"""Seconds without a change before a save is checked: an editor may empty a file, or remove it, half a second before it writes."""


def _nothing() -> None:
    pass


def check_on_save(
    path: Path,
    rubric: Rubric,
    traces: Traces,
    *,
    only: str | None = None,
    isolation_level: str | None = None,
    written: Collection[Path] = (),
    begins: Callable[[], None] = _nothing,
    waits: Callable[[], None] = _nothing,
    waiting: Callable[[str], None] | None = None,
    listen: Listener | None = None,
) -> Iterator[Result]:
    """Yield a submission's result now and after every change, until interrupted; worker processes stay loaded, to save time.

    Parameters
    ----------
    traces : the ground truth to grade with: true sensor readings of each simulated motion
    only : id of the criterion or extension (extra task of the sheet) to check; None checks all
    isolation_level : level of the sandbox; None takes the best that works here
    written : files that the caller writes for each result; their changes are ignored
    begins, waits : called before each grading, and repeatedly between two gradings, so that the caller can refresh its display
    waiting : called during a grading if student code is slow to answer, with a message to show that says what is awaited
    listen : called with what the student's code prints
    """
    handed_in = SingleSubmission(path, rubric.lab.files)
    with (
        ReadingProcess() as reader,
        Marker(
            rubric, traces, sandbox=open_sandbox_for(rubric.lab, reader.read(handed_in).files, isolation_level)
        ) as marker,
    ):
        for _ in saves(path, written, waits):
            begins()
            yield marker.mark(reader.read(handed_in), only=only, waiting=waiting, listen=listen)


def saves(path: Path, written: Collection[Path] = (), waits: Callable[[], None] = _nothing) -> Iterator[None]:
    """Yield once at the start, then after each change of a file under `path`, when all files have been unchanged for a second.

    Hidden files, files that tools leave behind and those in `written`, the caller's reports, do not count. Between two changes
    `waits` is called every `PAUSE_S` seconds. The iterator never ends by itself.
    """
    ours = {os.path.realpath(each) for each in written}
    marked: object = None
    seen, since = None, 0.0
    while True:
        now = frozenset(stamp for stamp in _stamps(path) if os.path.realpath(stamp[0]) not in ours)
        if now != seen:
            seen, since = now, time.monotonic()
        if now != marked and (marked is None or time.monotonic() - since >= STILL_S):
            marked = now
            yield
        else:
            waits()
            time.sleep(PAUSE_S)


def _stamps(path: Path) -> frozenset[tuple[str, int, int]]:
    """Return names, times and sizes of the files to see changes, without hidden files and files that tools leave behind."""
    stamps = set()
    for folder, subfolders, names in os.walk(path):
        subfolders[:] = [name for name in subfolders if not name.startswith(".") and not is_litter([name])]
        stamps |= {_stamp(Path(folder, name)) for name in names if not name.startswith(".")}
    return frozenset(stamps or {_stamp(path)})


def _stamp(path: Path) -> tuple[str, int, int]:
    try:
        status = path.lstat()
    except OSError:  # an editor is replacing the file
        return str(path), 0, 0
    return str(path), status.st_mtime_ns, status.st_size
