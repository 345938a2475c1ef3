"""Record the tapes of the corpus and of the tests of `suite` anew: `python -m tests.tapes [--only NAME]`; some ten minutes."""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import cache

from grader.engine import rubric
from grader.engine.lab_box import open_box
from grader.engine.marking import Marker
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from tests.scoreboard import Case, handed_in
from tests.tapes import RecordingBox, Tape, suite
from tests.tapes.storing import shelf, store, taped


@cache
def _recording() -> tuple[RecordingBox, Marker]:
    box = RecordingBox(open_box(LAB))
    return box, Marker(rubric.load(LAB), bundles.shipped(), box=box).__enter__()  # type: ignore[arg-type] # speaks as a box does


def record(case: Case) -> tuple[str, Tape]:
    """The tape of one case."""
    box, marker = _recording()
    tape = box.begin()
    marker.mark(handed_in(case), only=case.only)
    return case.id, tape


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.tapes", description=__doc__)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument(
        "--only", default="", help="cases of the corpus whose name holds this; all others keep their tapes"
    )
    options = parser.parse_args()
    chosen = [case for case in taped() if options.only in case.id]
    with ProcessPoolExecutor(options.jobs) as pool:
        tapes: dict[str, Tape] = {case.id: shelf()[case.id] for case in taped() if case not in chosen}
        for count, (name, tape) in enumerate(pool.map(record, chosen, chunksize=4), 1):
            tapes[name] = tape
            if sys.stderr.isatty():
                print(f"\r{count}/{len(chosen)}", end="", file=sys.stderr, flush=True)
    store(tapes)
    return 0 if options.only else suite.record()


if __name__ == "__main__":
    sys.exit(main())
