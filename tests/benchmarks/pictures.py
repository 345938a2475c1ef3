"""Sound pictures that are told to hide a curve: `python -m tests.benchmarks.pictures 5000`.

Random figures in the styles that students choose are drawn and looked at as in a marking; the figures are recorded beside this file.
"""

from __future__ import annotations

import json
import sys
import time
import warnings
from pathlib import Path

import matplotlib as mpl

from tests.random_figures import every, shares

RECORD = Path(__file__).with_name("pictures.json")


def main(count: int) -> None:
    mpl.use("Agg")
    warnings.simplefilter("ignore")
    start, curves, hidden, fewest = time.process_time(), 0, [], 1.0
    for made in every(range(count)):
        curves += len(made.sights)
        hidden += [made.seed for sight in made.sights if sight.is_hidden]
        fewest = min(fewest, *shares(made))
    told = {"figures": count, "curves": curves, "hidden": hidden, "fewest_seen": round(fewest, 3)}
    RECORD.write_text(json.dumps(told | {"cpu_s": round(time.process_time() - start)}, indent=1) + "\n")
    print(json.dumps(told))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5000)
