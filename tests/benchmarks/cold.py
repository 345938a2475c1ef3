"""Where the time of a first `imugrade check` goes, on a warm disk: ``python -m tests.benchmarks.cold [--rounds 9]``.

A check in a fresh process and plain pytest in a fresh process with the same imports (mujoco, numpy, matplotlib, scipy.special) take
turns on the same sound submission; medians of one run. A check is two processes side by side: while the sandbox starts, with walls and
imports of its own, the grader imports what it judges with. The parts are stretches of the clock.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from pathlib import Path

from tests.benchmarks.measuring import ENVIRONMENT, PLAIN_PYTEST, ROOT, cost
from tests.corpus.pieces import tidy
from tests.corpus.writing import write

BARE = "import mujoco, numpy, matplotlib.pyplot"
SAME = f"{BARE}, scipy.special, pytest"
PARTS = {
    "begun": "Python and the command line: the first line",
    "found": "the submission read, a zygote started behind walls, the rubric: the second line",
    "imported": "the grader's imports and traces, while the zygote imports mujoco and matplotlib",
    "ready": "waiting for the zygote",
    "judged": "thirty checks judged",
    "gathered": "what the report shows beside the marks",
    "shown": "the table on the terminal",
    "ended": "the sandbox closed, both processes ended",
}
"""What ends each part, in order, and what it is."""


def measure(rounds: int, sample: Path) -> dict[str, list[float]]:
    """By round: seconds of each contender and of each part of a check by the clock, and `… cpu` seconds."""
    seen: dict[str, list[float]] = {}
    for _ in range(rounds):
        told = {
            "plain": cost([sys.executable, *PLAIN_PYTEST, "-p", "scipy.special"], sample),
            "same": cost([sys.executable, "-c", SAME], ROOT),
            "bare": cost([sys.executable, "-c", BARE], ROOT),
            "check": cost([sys.executable, "-m", "grader", "check", str(sample)], ROOT),
            "help": cost([sys.executable, "-m", "grader", "--help"], ROOT),
            "explain": cost([sys.executable, "-m", "grader", "explain", "view-not-copy"], ROOT),
        }
        for name, (cpu, wall) in told.items():
            seen.setdefault(f"{name} cpu", []).append(cpu)
            seen.setdefault(name, []).append(wall)
        told_by_watch = watched(sample)
        for name, seconds in {**parts(sample), "again": told_by_watch}.items():
            seen.setdefault(name, []).append(seconds)
    return seen


def table(seen: dict[str, list[float]]) -> str:
    """The medians as Markdown: seconds by the clock, against plain pytest and against the bare imports."""
    median = {name: statistics.median(values) for name, values in seen.items()}
    rows = {
        "`imugrade check`": "check",
        "plain pytest, fifteen assertions, the same imports": "plain",
        "these imports alone": "same",
        f"`{BARE}`": "bare",
        "`imugrade --help`": "help",
        "`imugrade explain view-not-copy`": "explain",
    }
    lines = ["| from a cold start | seconds | of plain pytest | of bare imports | CPU s |", "| --- |" + " ---: |" * 4]
    for said, name in rows.items():
        wall, cpu = median[name], median[f"{name} cpu"]
        lines.append(
            f"| {said} | {wall:.2f} | {wall / median['plain']:.2f} | {wall / median['bare']:.2f} | {cpu:.2f} |"
        )
    lines += ["", f"`imugrade check --watch`, from a save to the verdict: {median['again']:.2f} s"]
    lines += ["", "| part of a check | seconds | share |", "| --- | ---: | ---: |"]
    whole = sum(median[name] for name in PARTS)
    lines += [f"| {said} | {median[name]:.2f} | {100 * median[name] / whole:.0f} % |" for name, said in PARTS.items()]
    return "\n".join(lines)


def parts(sample: Path) -> dict[str, float]:
    """How long each part of one check took."""
    with tempfile.TemporaryDirectory() as scratch:
        stamps = Path(scratch, "stamps")
        command = [sys.executable, "-m", "tests.benchmarks.stamped", str(stamps), str(sample)]
        before = time.perf_counter()
        subprocess.run(command, cwd=ROOT, env=ENVIRONMENT, stdout=subprocess.DEVNULL, check=True)
        told = {**json.loads(stamps.read_text()), "ended": time.perf_counter()}
    spent = {}
    for name in PARTS:
        spent[name], before = told[name] - before, told[name]
    return spent


def watched(sample: Path) -> float:
    """Seconds from a save to the verdict of a check that watches the folder and is warm."""
    command = [sys.executable, "-m", "grader", "check", str(sample), "--watch"]
    with subprocess.Popen(command, cwd=ROOT, env=ENVIRONMENT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            _next_verdict(process.stdout)
            saved = sample / "filters.py"
            before = time.perf_counter()
            saved.write_text(saved.read_text(encoding="utf-8") + "\n", encoding="utf-8")
            _next_verdict(process.stdout)
            return time.perf_counter() - before
        finally:
            process.terminate()  # where a shell starts a background job, an interrupt is ignored


def _next_verdict(lines: Iterable[str]) -> None:
    if not any("checked at" in line for line in lines):
        raise SystemExit("imugrade check --watch ended without a verdict")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.cold", description=__doc__)
    parser.add_argument("--rounds", type=int, default=9)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="imugrade-") as scratch:
        print(table(measure(options.rounds, write(tidy(), Path(scratch, "tidy")))))


if __name__ == "__main__":
    main()
