"""The mangled archives, rubrics, notebooks and frames of the tests, many of them: ``python -m tests.fuzz [--runs 20000] [--seed 0]``."""

from __future__ import annotations

import argparse
import json
import random
import sys
import time
import traceback
from collections.abc import Callable, Mapping

from grader.worker import notebooks
from tests.fuzz.decoder import FRAME, check_decoder
from tests.fuzz.mangling import mangled_bytes, mangled_value
from tests.fuzz.test_fuzz import ARCHIVES, BOOK, RUBRIC, check_archive, check_rubric


def check_notebook(chance: random.Random) -> None:
    book = BOOK
    for _ in range(chance.randint(1, 4)):
        book = mangled_value(book, chance)
    try:
        notebooks.code_cells(mangled_bytes(json.dumps(book).encode(), chance) if chance.random() < 0.3 else json.dumps(book).encode())
    except (ValueError, RecursionError):
        return


CHECKS: Mapping[str, Callable[[random.Random], None]] = {
    "frames": lambda chance: check_decoder(mangled_bytes(FRAME, chance)),
    "archives": lambda chance: check_archive(mangled_bytes(chance.choice(ARCHIVES), chance)),
    "notebooks": check_notebook,
    "rubrics": lambda chance: check_rubric(mangled_bytes(RUBRIC, chance)),
}


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--runs", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    bad = 0
    for name, check in CHECKS.items():
        found, started = 0, time.monotonic()
        runs = options.runs // 10 if name == "rubrics" else options.runs  # a rubric takes 30 ms, all else next to nothing
        for seed in range(options.seed, options.seed + runs):
            try:
                check(random.Random(seed))
            except Exception:
                found += 1
                print(f"{name}, seed {seed}: {traceback.format_exc(limit=-3)}", flush=True)
        print(f"{name}: {runs} runs, {time.monotonic() - started:.0f} s, {found} findings", flush=True)
        bad += found
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
