"""What another rubric costs a class that is on record: `python -m tests.benchmarks.remarking [SIZE]`.

Five kinds of submissions are marked in a sandbox, once each; the rest of the class is on record as if it had been. Then a weight, the price
of a mistake and a late policy change: what the class would get (`under`), and the same command again (`grade`), which writes
the pages of all whose marks moved.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from grader import __version__
from grader.course import regrade
from grader.course.publishing import publish
from grader.course.record import Key, Store
from grader.engine import rubric
from grader.engine.grader import Marker
from grader.intake import read_submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.people.final_grade import HandIn, Person
from tests.benchmarks.scale import KINDS, ROOT, hand_in

OTHER = (("follows_recursion: 6", "follows_recursion: 9"), ("limits:", "mistakes: {alpha-swapped: 4}\nlimits:"))


@contextmanager
def timed(what: str) -> Iterator[None]:
    started, before = time.perf_counter(), sum(os.times()[:4])
    yield
    print(f"{what}: {time.perf_counter() - started:.2f} s, of CPU {sum(os.times()[:4]) - before:.2f} s", flush=True)


def on_record(students: Path, out: Path) -> None:
    """The class as `grade` leaves it, but for the pages."""
    by, truth = rubric.load(LAB), bundles.shipped()
    folders = sorted(students.iterdir())
    with Marker(by, truth) as marker, Store(out) as store:
        marked = [marker.mark(read_submission(folder, LAB.files)) for folder in folders[:KINDS]]
        for number, folder in enumerate(folders):
            sha = read_submission(folder, LAB.files).sha256
            found = marked[number % KINDS]
            own = replace(found, submission=folder.name, provenance={**found.provenance, "submission_sha256": sha})
            store.keep(Key(folder.name, sha, by.sha256, truth.sha256, __version__), own)
            store.keep_hand_in(folder.name, HandIn((Person(folder.name, folder.name),)))


def grade(students: Path, out: Path, *more: str) -> None:
    command = [sys.executable, "-m", "grader", "grade", str(students), "-o", str(out), *more]
    subprocess.run(command, check=True, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.remarking", description=__doc__)
    parser.add_argument("size", nargs="?", type=int, default=2000, metavar="SIZE")
    size = parser.parse_args().size
    text = rubric.shipped(LAB).read_text(encoding="utf-8")
    for old, new in OTHER:
        text = text.replace(old, new, 1)
    with tempfile.TemporaryDirectory(prefix="imugrade-remarking-") as scratch:
        students, out, other = Path(scratch, "class"), Path(scratch, "out"), Path(scratch, "other.yaml")
        other.write_text(text + "late: {due: 2026-11-20T23:59+01:00}\n", encoding="utf-8")
        hand_in(students, size)
        on_record(students, out)
        with Store(out) as store:
            with timed("what it would cost"):
                regrade.under(store.final_grades(), rubric.load(LAB, other))
            with timed("another rubric kept, with gradebook and class page"):
                after = regrade.remark(out, store, rubric.load(LAB, other))
            with timed("the pages of the students"):
                for final_grade in after.values():
                    publish(out, final_grade, store, LAB)
        with timed("grade by that rubric: nothing to do"):
            grade(students, out, "--rubric", str(other))
        with timed("grade by the first rubric again, pages included"):
            grade(students, out)


if __name__ == "__main__":
    main()
