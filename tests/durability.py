"""Runs of a class that are hit by SIGKILL: ``python -m tests.durability [--kills 50] [--seed 0]``.

Each time a class is graded in a fresh folder, and at a random moment the grader, one of its markers, a zygote or a worker is
killed. Then the same command is given again until it is done. The results have to be those of an undisturbed run, what was
recorded before the kill is not graded again, and nothing is left running.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import random
import re
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.classes import filters_alone
from tests.corpus.pieces import tidy
from tests.corpus.writing import write
from tests.fake_results import without_durations
from tests.hostile.decoys import below

ROOT = Path(__file__).parent.parent
TARGETS = ("grader", "marker", "zygote", "worker")
_WITHIN_S = 120.0


def hand_in(folder: Path, *, full: bool) -> Path:
    """A small class: some filters alone, which are graded fast, one that crashes, and with `full` a whole submission."""
    for number in range(3):
        write(filters_alone(0.5 + number / 10 if number else 1.0), folder / f"student{number}")
    crash = "\n\nLowPassFilter.update = lambda self, m: __import__('os')._exit(0)\n"
    write({"filters.py": f"{filters_alone(1.0)['filters.py']}{crash}"}, folder / "crashes")
    if full:
        write(tidy(), folder / "whole")
    return folder


def command(students: Path, out: Path, jobs: int) -> list[str]:
    return [sys.executable, "-m", "grader", "grade", str(students), "-o", str(out), "--jobs", str(jobs)]


def grade(students: Path, out: Path) -> subprocess.CompletedProcess[str]:
    """Grade without disturbance; one marker is enough, and costs less."""
    return subprocess.run(
        command(students, out, 1), cwd=ROOT, capture_output=True, text=True, check=False, timeout=_WITHIN_S
    )


def results(out: Path) -> dict[str, Any]:
    """Every `result.json` without its durations."""
    found = {}
    for path in sorted(out.glob("submissions/*/result.json")):
        found[path.parent.name] = without_durations(json.loads(path.read_text(encoding="utf-8")))
    return found


def recorded(out: Path) -> int:
    """How many complete results are on record."""
    path = out / "results.sqlite"
    if not path.exists():
        return 0
    with contextlib.closing(sqlite3.connect(path, timeout=10)) as database:
        try:
            return int(database.execute("SELECT count(*) FROM results WHERE status != 'incomplete'").fetchone()[0])
        except sqlite3.OperationalError:  # killed before the tables were laid out
            return 0


# --- whom to kill --------------------------------------------------------------------------------------------------------


def kinds(pid: int) -> dict[str, list[int]]:
    """The processes of a run by what they are."""
    found: dict[str, list[int]] = {"grader": [pid], "marker": [], "zygote": [], "worker": []}
    zygotes: set[int] = set()
    for child in sorted(below(pid)):
        words = _words(child)
        if "spawn_main" in words:
            found["marker"].append(child)
        elif "grader.sandbox" in words or "sandbox" in words:
            zygotes.add(child)
    for child in zygotes:
        parent = _parent(child)
        deep = parent in zygotes and _parent(parent) in zygotes
        found["worker" if deep else "zygote"].append(child)
    return found


def _words(pid: int) -> str:
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
    return ""


def _parent(pid: int) -> int:
    with contextlib.suppress(OSError, ValueError, IndexError):
        return int(Path(f"/proc/{pid}/stat").read_text(errors="replace").rpartition(")")[2].split()[1])
    return 0


@dataclass
class Run:
    """One run that was hit."""

    target: str
    hit: bool = False
    recorded_before: int = 0
    resumed: int = 0
    troubles: list[str] = field(default_factory=list)


def disturb(students: Path, out: Path, expected: dict[str, Any], target: str, chance: random.Random) -> Run:
    """Grade a class, kill one process of the kind at a random moment, and go on until it is done."""
    run = Run(target)
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(command(students, out, 2), cwd=ROOT, stdout=said, stderr=said)
        run.hit = _kill_one(process, target, chance, out)
        seen = below(process.pid)
        try:
            code = process.wait(timeout=_WITHIN_S)
        finally:
            process.kill()
        if run.hit and target == "grader":
            run.troubles += _left(seen)
        elif code:
            said.seek(0)
            run.troubles.append(f"exit code {code}: {said.read()[-300:]!r}")
    run.recorded_before = recorded(out)
    again = grade(students, out)
    if again.returncode:
        run.troubles.append(f"resumed: exit code {again.returncode}: {again.stderr[-300:]}")
    run.resumed = sum(int(number) for number in re.findall(r"(\d+) on record", again.stdout))
    if run.resumed != run.recorded_before:
        run.troubles.append(f"{run.recorded_before} results were on record, {run.resumed} were taken from there")
    found = results(out)
    for name in found.keys() | expected:
        if found.get(name) != expected.get(name):
            run.troubles.append(f"{name}: {found.get(name)} in place of {expected.get(name)}")
    if recorded(out) != len(expected):
        run.troubles.append(f"{recorded(out)} results for {len(expected)} submissions")
    return run


def _kill_one(process: subprocess.Popen[bytes], target: str, chance: random.Random, out: Path) -> bool:
    """Wait for a process of the kind, then for a random moment, then kill one; False where the run was over before.

    The grader is killed when a random number of results is on record: the next run has to go on from there.
    """
    wanted = chance.randrange(3) if target == "grader" else 0
    wait = chance.uniform(0.0, 0.1 if target == "grader" else 1.0)
    first_seen = None
    while process.poll() is None:
        waited = first_seen is not None and time.monotonic() - first_seen >= wait
        if waited and (alive := kinds(process.pid)[target]):
            with contextlib.suppress(ProcessLookupError):
                os.kill(chance.choice(alive), signal.SIGKILL)
                return True
        if first_seen is None and recorded(out) >= wanted and kinds(process.pid)[target]:
            first_seen = time.monotonic()
        time.sleep(0.005)
    return False


def _left(seen: set[int]) -> list[str]:
    """Processes of a killed run that go on; they get a moment to notice."""
    end = time.monotonic() + 15
    while time.monotonic() < end:
        alive = [pid for pid in seen if "grader" in _words(pid) or "spawn_main" in _words(pid)]
        if not alive:
            return []
        time.sleep(0.05)
    return [f"still running: {[_words(pid)[:80] for pid in alive]}"]


def campaign(kills: int, seed: int, *, full: bool) -> list[Run]:
    chance = random.Random(seed)
    runs = []
    with tempfile.TemporaryDirectory(prefix="imugrade-durability-") as scratch:
        folder = Path(scratch)
        students = hand_in(folder / "class", full=full)
        grade(students, folder / "undisturbed").check_returncode()
        expected = results(folder / "undisturbed")
        for number in range(kills):
            target = TARGETS[number % len(TARGETS)]
            run = disturb(students, folder / f"out{number}", expected, target, chance)
            runs.append(run)
            state = "; ".join(run.troubles) or ("as undisturbed" if run.hit else "as undisturbed (it was over before)")
            print(
                f"{number + 1:>3} {target:<7} {run.recorded_before} on record, {run.resumed} taken from there: {state}",
                flush=True,
            )
    return runs


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.durability", description=__doc__)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    runs = campaign(options.kills, options.seed, full=True)
    bad = [run for run in runs if run.troubles]
    print(f"{len(runs)} runs, {sum(run.hit for run in runs)} hit, {len(bad)} with trouble")
    return int(bool(bad))


if __name__ == "__main__":
    sys.exit(main())
