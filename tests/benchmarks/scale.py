"""What a submission costs in classes of many sizes: `python -m tests.benchmarks.scale [SIZE ...] [--jobs N]`.

Each class is graded by the command, from nothing. CPU time is that of the whole tree of processes, as the kernel sums it when they
are waited for: command, markers, zygotes, workers. A marker costs its start once, so the cost of a submission is what it adds: the
difference to the size before, over the number of submissions more. Memory is proportional set size (a page that n processes share
counts 1/n in each), by samples: of a marker with all that it started, and of the command by its own high-water mark.

The submissions are three sound and two faulty ones in turn, each with a comment of its own, so that none is like another.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import psutil

from tests.corpus.pieces import edit, listy, tidy, verbatim
from tests.corpus.writing import write

ROOT = Path(__file__).parent.parent.parent
SIZES = (10, 100, 500)
KINDS = 5
_SAMPLE_EVERY_S = 2.0
_MIB = 1 << 20


def hand_in(folder: Path, size: int) -> None:
    """A class of this size."""
    swapped = edit(tidy(), "filters.py", ("self.alpha * (", "(1 - self.alpha) * ("))
    still = edit(verbatim(), "imu_reader.py", ("data.qvel[0] = 0.5", "data.qvel[0] = 0.0"))
    kinds = (tidy(), listy(), verbatim(), swapped, still)
    assert len(kinds) == KINDS
    for number in range(size):
        name = f"student{number:05}"
        files = {path: f"{text}\n# handed in by {name}\n" for path, text in kinds[number % len(kinds)].items()}
        write(files, folder / name)


@dataclass
class Cost:
    """What grading a class took; memory in bytes, of each sample."""

    size: int
    cpu_s: float = 0.0
    wall_s: float = 0.0
    marker: list[int] = field(default_factory=list)
    command: int = 0

    def further(self, before: Cost | None) -> tuple[float, float]:
        """CPU and wall seconds of each submission more than `before`."""
        if before is None:
            return self.cpu_s / self.size, self.wall_s / self.size
        more = self.size - before.size
        return (self.cpu_s - before.cpu_s) / more, (self.wall_s - before.wall_s) / more


def measure(size: int, jobs: int) -> Cost:
    cost = Cost(size)
    with tempfile.TemporaryDirectory(prefix="imugrade-scale-") as scratch:
        students, out = Path(scratch, "class"), Path(scratch, "out")
        hand_in(students, size)
        command = [sys.executable, "-m", "grader", "grade", str(students), "-o", str(out), "--jobs", str(jobs)]
        started = time.perf_counter()
        process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        code, usage = _watched(process.pid, cost)
        cost.wall_s = time.perf_counter() - started
        cost.cpu_s = usage.ru_utime + usage.ru_stime
        process.returncode = code
        graded = len(list(out.glob("submissions/*/result.json")))
        assert (code, graded) == (0, size), f"exit code {code}, {graded} of {size} graded"
    return cost


def _watched(pid: int, cost: Cost) -> tuple[int, os.struct_rusage]:  # type: ignore[name-defined]
    due = 0.0
    while True:
        ended, status, usage = os.wait4(pid, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status), usage
        cost.command = max(cost.command, _high_water(pid))
        if time.monotonic() >= due:
            cost.marker += [_proportional(marker) for marker in _markers(pid)]
            due = time.monotonic() + _SAMPLE_EVERY_S
        time.sleep(0.1)


def _high_water(pid: int) -> int:
    status = Path(f"/proc/{pid}/status").read_text(encoding="ascii", errors="replace")
    return next((int(line.split()[1]) * 1024 for line in status.splitlines() if line.startswith("VmHWM")), 0)


def _markers(pid: int) -> list[psutil.Process]:
    """The markers at work: those that have a zygote."""
    try:
        children = psutil.Process(pid).children()
        return [child for child in children if child.children()]
    except psutil.NoSuchProcess:
        return []


def _proportional(marker: psutil.Process) -> int:
    total = 0
    for process in (marker, *marker.children(recursive=True)):
        try:
            total += process.memory_full_info().pss
        except psutil.Error:
            continue  # a worker that has just ended
    return total


def row(cost: Cost, before: Cost | None) -> str:
    cpu_s, wall_s = cost.further(before)
    half = cost.marker[len(cost.marker) // 2 :] or [0]
    marker = f"{statistics.median(half) / _MIB:.0f} | {max(cost.marker or [0]) / _MIB:.0f}"
    return f"| {cost.size:,} | {cost.cpu_s:.0f} | {cpu_s:.2f} | {wall_s:.2f} | {marker} | {cost.command / _MIB:.0f} |"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.scale", description=__doc__)
    parser.add_argument("sizes", nargs="*", type=int, default=SIZES, metavar="SIZE")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, metavar="N")
    options = parser.parse_args()
    print(
        "| submissions | CPU s | CPU s each | wall s each | marker MiB, median | marker MiB, most | command MiB, most |"
    )
    print("| ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    before = None
    for size in sorted(options.sizes):
        cost = measure(size, options.jobs)
        print(row(cost, before), flush=True)
        before = cost


if __name__ == "__main__":
    main()
