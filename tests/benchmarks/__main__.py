"""What grading costs beside the student's own code: `python -m tests.benchmarks`. Run by hand.

CPU seconds are those of the whole process tree, by wait4(2). A contender's cost per submission is the slope between a small
and a large class of the same sound submission, each copy with other bytes, so that start-up costs cancel and nothing is
reused. All contenders take turns within a round; medians over the rounds and ratios within this run are printed.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any
from unittest import mock

import psutil

from grader.engine import rubric
from grader.engine.grader import Marker
from grader.intake import read_submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.sandbox.sandbox import Worker
from tests.corpus.cases import case, of
from tests.corpus.writing import Files, write

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = {
    **os.environ, "PYTHONDONTWRITEBYTECODE": "", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "PYTHONPATH": str(ROOT), "COLUMNS": "80",
    "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
}  # fmt: skip
"""One thread, no plugins, and modules that are compiled once, as they are where they are installed."""
PLAIN_PYTEST = [
    *["-m", "pytest", "-q", "-p", "no:cacheprovider", "-c"],
    os.devnull,
    str(ROOT / "tests/benchmarks/plain.py"),
]
ROUNDS = 3
SIZES = (8, 40)
"""Of the small and the large class."""
SAMPLE = case("sound", "tidy_functions").files
"""Function style, and no library that takes long to import."""
FAULTS = ("id-as-slice-start", "reset-forgotten", "labels-without-units", "std-taken-as-variance", "starts-from-zeros")
"""One of each criterion."""
CLASSES: dict[str, Sequence[Files]] = {
    "sound": (SAMPLE,),
    "faulty": [fault.files for fault in of("faulty") if fault.name in FAULTS],
}


def cost(command: list[str], folder: Path) -> float:
    """CPU seconds of a command with everything that it starts."""
    quiet = subprocess.DEVNULL
    with subprocess.Popen(command, cwd=folder, env=ENVIRONMENT, stdout=quiet, stderr=quiet) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"{' '.join(command)[:200]}: ended with {process.returncode}")
    return used.ru_utime + used.ru_stime


def class_of(size: int, folder: Path, kinds: Sequence[Files]) -> list[str]:
    """Copies of the samples in turn, each with other bytes."""
    places = []
    for number in range(size):
        place = folder / f"{folder.name}-{number:04d}"
        write(kinds[number % len(kinds)], place)
        with (place / "imu_reader.py").open("a") as file:
            file.write(f"\n# copy {place.name}\n")
        places.append(str(place))
    return places


def questions(sample: Path) -> dict[str, Any]:
    """What the checks ask of the sample's functions."""
    asked: list[tuple[str, dict[str, Any], dict[str, Any]]] = []
    ask = Worker.ask

    def noting(self: Worker, op: str, fields: Any = None, arrays: Any = None, **limits: Any) -> Any:
        asked.append((op, dict(fields or {}), dict(arrays or {})))
        return ask(self, op, fields, arrays, **limits)

    with mock.patch.object(Worker, "ask", noting), Marker(rubric.load(LAB), bundles.shipped()) as marker:
        marker.mark(read_submission(sample, LAB.files))
    counts: dict[str, Any] = {"reads": 0, "simulations": [], "noise": [], "filters": []}
    for op, fields, arrays in asked:
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
    return counts


def contenders(counts: Path) -> dict[str, tuple[str, Callable[[list[str], Path], float]]]:
    """Each by its name: which class it grades, and how."""

    def grade(places: list[str], at: Path) -> float:
        shutil.rmtree(at / "out", ignore_errors=True)
        return cost([sys.executable, "-m", "grader", "grade", *places, "-o", str(at / "out"), "-j", "1"], at)

    def floor(places: list[str], at: Path) -> float:
        return cost([sys.executable, "-m", "tests.benchmarks.floor", str(counts), *places], at)

    def plain(places: list[str], at: Path, *options: str) -> float:
        return sum(cost([sys.executable, *PLAIN_PYTEST, *options], Path(each)) for each in places)

    return {
        "floor": ("sound", floor),
        "ours": ("sound", grade),
        "ours, one fault in each": ("faulty", grade),
        "plain pytest": ("sound", plain),
        "plain pytest -n 2": ("sound", lambda places, at: plain(places, at, "-p", "xdist.plugin", "-n", "2")),
    }


def compare(folder: Path, counts: Path) -> dict[str, float]:
    """CPU seconds per submission of each contender: the median of the rounds."""
    small, large = SIZES
    classes = {
        kind: [class_of(size, folder / f"{kind}-{size}", its) for size in SIZES] for kind, its in CLASSES.items()
    }
    slopes: dict[str, list[float]] = {}
    for _ in range(ROUNDS):
        for name, (kind, run) in contenders(counts).items():
            a, b = (run(places, folder) for places in classes[kind])
            slopes.setdefault(name, []).append((b - a) / (large - small))
    return {name: statistics.median(each) for name, each in slopes.items()}


def memory(sample: Path) -> float:
    """MB that a marker with its zygote holds for itself alone, after one submission."""
    with Marker(rubric.load(LAB), bundles.shipped()) as marker:
        marker.mark(read_submission(sample, LAB.files))
        this = psutil.Process()
        return sum(each.memory_full_info().uss for each in (this, *this.children(recursive=True))) / 2**20


def main() -> None:
    argparse.ArgumentParser(prog="python -m tests.benchmarks", description=__doc__).parse_args()
    versions = ", ".join(f"{name} {version(name)}" for name in ("mujoco", "numpy", "matplotlib", "pytest"))
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, {versions}")
    with tempfile.TemporaryDirectory(prefix="imugrade-") as scratch:
        sample, counts = Path(class_of(1, Path(scratch, "sample"), (SAMPLE,))[0]), Path(scratch, "counts.json")
        counts.write_text(json.dumps(questions(sample)))
        mebibytes = statistics.median(memory(sample) for _ in range(ROUNDS))
        median = compare(Path(scratch), counts)
    print("\n| contender | CPU s a submission | of the floor | of plain pytest |\n| --- | --- | --- | --- |")
    for name, spent in median.items():
        print(f"| {name} | {spent:.3f} | {spent / median['floor']:.2f} | {spent / median['plain pytest']:.2f} |")
    print(f"\nprivate memory of a marker with its zygote: {mebibytes:.0f} MB")


if __name__ == "__main__":
    main()
