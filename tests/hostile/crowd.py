"""A class with hostile submissions among the sound ones: ``python -m tests.hostile.crowd [--sound 160] [--hostile 40] [--seed 0]``.

The sound ones are graded alone, then all together. The marks of the sound ones have to be the same, every submission has to end in a
verdict, and all together may take at most twice the time of the sound ones plus the hostile ones' own budgets. Exit code 1 otherwise.
"""

from __future__ import annotations

import argparse
import random
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from grader.course.classroom import _WALL_PER_CPU
from grader.engine import rubric
from grader.labs.imu.lab import LAB
from tests.corpus.pieces import FILTER_INCREMENT, tidy
from tests.corpus.writing import Files, write
from tests.durability import ROOT, command, results
from tests.hostile.corpus import PROGRAMS
from tests.hostile.program import Program

JOBS = 2


def sound(number: int) -> Files:
    """A whole submission, one in four with a filter that is too fast: no two are the same bytes."""
    filters = str(tidy()["filters.py"]) if number % 4 else FILTER_INCREMENT.replace("self.alpha * (x", "0.5 * self.alpha * (x")
    head = "" if number % 4 else "import numpy as np\n\n\n"
    return {**tidy(), "filters.py": f"# {number}\n{head}{filters}"}


def chosen(count: int, seed: int) -> list[Program]:
    """Programs of every family, as they come by chance; those that need decoys to aim at are left to the court."""
    possible = [program for program in PROGRAMS if program.as_ != "file" and "@" not in "".join(map(str, program.files.values()))]
    return random.Random(seed).sample(possible, count)


def graded(students: Path, out: Path) -> tuple[float, int]:
    started = time.monotonic()
    code = subprocess.run(command(students, out), cwd=ROOT, stdout=subprocess.DEVNULL, check=False).returncode
    return time.monotonic() - started, code


def unfinished(out: Path) -> int:
    with closing(sqlite3.connect(out / "results.sqlite")) as database:
        return int(database.execute("SELECT count(*) FROM results WHERE status = 'incomplete'").fetchone()[0])


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.hostile.crowd", description=__doc__)
    parser.add_argument("--sound", type=int, default=160)
    parser.add_argument("--hostile", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    programs = chosen(options.hostile, options.seed)
    budget_s = len(programs) * _WALL_PER_CPU * rubric.load(LAB).limits.submission_cpu_s / JOBS
    with tempfile.TemporaryDirectory(prefix="imugrade-crowd-") as scratch:
        folder = Path(scratch)
        for where in ("alone", "together"):
            for number in range(options.sound):
                write(sound(number), folder / where / f"s{number:03}")
        for number, program in enumerate(programs):
            write(program.files, folder / "together" / f"h{number:03}-{program.name}"[:60], program.as_)
        alone_s, code = graded(folder / "alone", folder / "out-alone")
        together_s, mixed_code = graded(folder / "together", folder / "out-together")
        expected, found = results(folder / "out-alone"), results(folder / "out-together")
        same = all(found.get(name) == expected[name] for name in expected)
        left = unfinished(folder / "out-together")
    ok = same and not left and code == mixed_code == 0 and len(found) == options.sound + options.hostile
    ok = ok and together_s <= 2 * alone_s + budget_s
    print(f"{options.sound} sound alone {alone_s:.0f} s; with {options.hostile} hostile {together_s:.0f} s of {2 * alone_s + budget_s:.0f} s; "
          f"marks of the sound ones {'the same' if same else 'CHANGED'}; {left} without a verdict; exit codes {code}, {mixed_code}")  # fmt: skip
    return int(not ok)


if __name__ == "__main__":
    sys.exit(main())
