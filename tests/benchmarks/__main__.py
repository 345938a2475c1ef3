"""What grading costs beside the student's own code: python -m tests.benchmarks [--size N] [--rounds R]. Run by hand.

CPU seconds are those of the whole process tree, by wait4(2). A contender's cost per submission is the slope between a small
and a large class of the same sound submission, each copy with other bytes, so that start-up costs cancel and nothing is
reused. All contenders take turns within a round; medians over the rounds and ratios within this run are printed.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import shlex
import shutil
import statistics
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any
from unittest import mock

from grader.engine import rubric
from grader.engine.grader import Marker
from grader.intake import read_submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.sandbox.sandbox import Worker
from tests.benchmarks.measuring import PLAIN_PYTEST, cost
from tests.corpus.cases import case, of
from tests.corpus.writing import Files, write

SAMPLE = case("sound", "tidy_functions").files
"""Function style, and no library that takes long to import."""
SHEET = case("sound", "sheet_verbatim").files
"""The sheet's own layout: its demos run at module level."""
FAULTS = ("id-as-slice-start", "reset-forgotten", "labels-without-units", "std-taken-as-variance", "starts-from-zeros")
"""One of each criterion."""
CLASSES: dict[str, Sequence[Files]] = {
    "sound": (SAMPLE,),
    "sheet": (SHEET,),
    "faulty": [fault.files for fault in of("faulty") if fault.name in FAULTS],
}


def class_of(size: int, folder: Path, kinds: Sequence[Files] = (SAMPLE,)) -> list[str]:
    """Copies of the samples in turn, each with other bytes."""
    places = []
    for number in range(size):
        place = folder / f"{folder.name}-{number:04d}"
        write(kinds[number % len(kinds)], place)
        with (place / "imu_reader.py").open("a") as file:
            file.write(f"\n# copy {place.name}\n")
        places.append(str(place))
    return places


def questions(sample: Path) -> tuple[dict[str, Any], list[tuple[str, float, int]]]:
    """What the checks ask of the sample's functions, and its questions, the most expensive first: (name, CPU ms, how often)."""
    asked: list[tuple[str, dict[str, Any], dict[str, Any], float]] = []
    ask = Worker.ask

    def noting(self: Worker, op: str, fields: Any = None, arrays: Any = None, **limits: Any) -> Any:
        before = self.cpu_s
        try:
            return ask(self, op, fields, arrays, **limits)
        finally:
            asked.append((op, dict(fields or {}), dict(arrays or {}), self.cpu_s - before))

    with Marker(rubric.load(LAB), bundles.shipped()) as marker:
        submission = read_submission(sample, LAB.files)
        marker.mark(submission)
        with mock.patch.object(Worker, "ask", noting):
            started = time.process_time()
            marker.mark(submission)
            own_s = time.process_time() - started
    counts: dict[str, Any] = {"reads": 0, "simulations": [], "noise": [], "filters": []}
    for op, fields, arrays, _ in asked:
        if op == "read":
            counts["reads"] += len(arrays["qpos"]) * len(arrays["pairs"])
        elif op == "simulate":
            counts["simulations"].append((fields["duration_s"], fields["timestep"] or 0.002))
        elif op == "noise":
            counts["noise"].append(len(arrays["qpos"]) * fields["reads"])
        elif op == "noise_twins":
            counts["noise"] += [fields["reads"]] * len(fields["twins"])
        elif op == "default_bias":
            counts["noise"] += [fields["reads"]] * fields["instances"]
        elif op == "filter":
            counts["filters"] += [len(arrays[case["input"]]) for case in fields["cases"]]
    spent: Counter[str] = Counter()
    for op, _, _, cpu_s in asked:
        spent[op] += cpu_s
    often = Counter(op for op, *_ in asked)
    parts = [("the marker itself", 1000 * own_s, 1), *((op, 1000 * s, often[op]) for op, s in spent.items())]
    return counts, sorted(parts, key=lambda part: -part[1])


Run = Callable[[list[str], Path], tuple[float, float]]


def contenders(counts: Mapping[str, Path]) -> dict[str, tuple[str, Run]]:
    """Each by its name: which class it grades, and how."""

    def grade(jobs: int, cores: Collection[int] = ()) -> Run:
        def run(places: list[str], at: Path) -> tuple[float, float]:
            out = at / f"out-{jobs}"
            shutil.rmtree(out, ignore_errors=True)
            command = [sys.executable, "-m", "grader", "grade", *places, "-o", str(out), "-j", str(jobs)]
            return cost(command, at, cores)

        return run

    def floor(kind: str, processes: int = 1) -> Run:
        def run(places: list[str], at: Path) -> tuple[float, float]:
            one = shlex.join([sys.executable, "-m", "tests.benchmarks.floor", str(counts[kind]), *places])
            cpu_s, wall_s = cost(["sh", "-c", f"{f'{one} & ' * (processes - 1)}{one}; wait"], at)
            return cpu_s / processes, wall_s / processes

        return run

    def plain(*options: str) -> Run:
        def run(places: list[str], at: Path) -> tuple[float, float]:
            each = [cost([sys.executable, *PLAIN_PYTEST, *options], Path(place)) for place in places]
            return sum(cpu for cpu, _ in each), sum(wall for _, wall in each)

        return run

    return {
        "floor": ("sound", floor("sound")),
        "two floors side by side": ("sound", floor("sound", 2)),
        "ours, one marker": ("sound", grade(1)),
        "ours, one marker on one core": ("sound", grade(1, [0])),
        "ours, two markers": ("sound", grade(2)),
        "plain pytest": ("sound", plain()),
        "plain pytest -n 2": ("sound", plain("-p", "xdist.plugin", "-n", "2")),
        "floor of the sheet's own layout": ("sheet", floor("sheet")),
        "ours, the sheet's own layout": ("sheet", grade(1)),
        "ours, one fault in each": ("faulty", grade(1)),
    }


def compare(
    small: int, large: int, rounds: int, folder: Path, counts: Mapping[str, Path]
) -> dict[str, list[tuple[float, float]]]:
    """CPU and wall seconds per submission of each contender, by round."""
    classes = {
        kind: [class_of(size, folder / f"{kind}-{size}", its) for size in (small, large)]
        for kind, its in CLASSES.items()
    }
    slopes: dict[str, list[tuple[float, float]]] = {}
    for _ in range(rounds):
        for name, (kind, run) in contenders(counts).items():
            a, b = (run(places, folder) for places in classes[kind])
            slopes.setdefault(name, []).append(((b[0] - a[0]) / (large - small), (b[1] - a[1]) / (large - small)))
    return slopes


def memory(sample: Path) -> float:
    """MB that a marker with its zygote holds for itself alone, after one submission."""
    with Marker(rubric.load(LAB), bundles.shipped()) as marker:
        marker.mark(read_submission(sample, LAB.files))
        zygote = marker._sandbox._zygote
        pids = [os.getpid()] + ([zygote.pid, *_children(zygote.pid)] if zygote else [])
        return sum(_private_kb(pid) for pid in pids) / 1024


def _children(pid: int) -> list[int]:
    return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def _private_kb(pid: int) -> int:
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    return sum(int(line.split()[1]) for line in lines if line.startswith(("Private_Clean", "Private_Dirty")))


def main() -> int:
    options = argparse.ArgumentParser(prog="python -m tests.benchmarks", description=__doc__)
    options.add_argument("--size", type=int, default=40)
    options.add_argument("--rounds", type=int, default=3)
    given = options.parse_args()
    versions = ", ".join(f"{name} {version(name)}" for name in ("mujoco", "numpy", "matplotlib", "pytest"))
    machine = f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, {versions}"
    print(machine)
    with tempfile.TemporaryDirectory(prefix="imugrade-") as scratch:
        sample, sheet = (Path(class_of(1, Path(scratch, kind), CLASSES[kind])[0]) for kind in ("sound", "sheet"))
        (counts, parts), (of_sheet, _) = questions(sample), questions(sheet)
        mebibytes = [memory(sample) for _ in range(given.rounds)]
        asked = {"sound": Path(scratch, "sound.json"), "sheet": Path(scratch, "sheet.json")}
        for kind, its in (("sound", counts), ("sheet", of_sheet)):
            asked[kind].write_text(json.dumps(its))
        rows = compare(max(5, given.size // 5), given.size, given.rounds, Path(scratch), asked)
    cpu = {name: [spent for spent, _ in each] for name, each in rows.items()}
    median = {name: statistics.median(each) for name, each in cpu.items()}
    print("\n| contender | CPU s a submission | of the floor | of plain pytest |\n| --- | --- | --- | --- |")
    for name, spent in median.items():
        print(f"| {name} | {spent:.3f} | {spent / median['floor']:.2f} | {spent / median['plain pytest']:.2f} |")
    print("\n| part of a submission | CPU ms | share | times |\n| --- | --- | --- | --- |")
    whole = sum(spent for _, spent, _ in parts)
    for name, spent, times in parts[:10]:
        print(f"| {name} | {spent:.0f} | {100 * spent / whole:.0f} % | {times} |")
    print(f"\nprivate memory of a marker with its zygote: {statistics.median(mebibytes):.0f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
