"""Sound pictures that are told to hide a curve, and claimed curves that are told to be seen: `python -m tests.benchmarks.pictures`.

Random figures in the styles that students choose are drawn and looked at as in a marking. A curve that is told to be hidden is held
against the whole figure, drawn as it is saved, with the curve and without it: where a reader sees the difference the finding is
false. Then one curve of each of some further figures is left out of the picture and still claimed. What was found is recorded
beside this file.

    python -m tests.benchmarks.pictures [FIGURES [FIRST_SEED]]
"""

from __future__ import annotations

import json
import sys
import time
import warnings
from pathlib import Path

import matplotlib as mpl

from grader.engine.figures import FEWEST_SEEN
from tests.random_figures import made, share_seen, share_that_differs

RECORD = Path(__file__).with_name("pictures.json")
_FAINT = 0.1
"""Difference of two colours, each channel 0 to 1, that a reader overlooks in a line as thin as a hair."""
_CLAIMED = 10  # one claimed curve to so many figures


def main(figures: int = 5000, first_seed: int = 0) -> None:
    mpl.use("Agg")
    warnings.simplefilter("ignore")
    start, seeds = time.process_time(), range(first_seed, first_seed + figures)
    sound = [(round(share_seen(sight), 2), seed, name) for seed in seeds for name, sight in made(seed).items()]
    hidden = [(seed, name) for share, seed, name in sound if share < FEWEST_SEEN]
    false = [(seed, name) for seed, name in hidden if share_that_differs(seed, name, _FAINT) >= FEWEST_SEEN]
    claimed = []
    for number, seed in enumerate(seeds[::_CLAIMED]):
        name = "abcdef"[number % 6]
        claimed.append((round(share_seen(made(seed, left_out=name)[name]), 2), seed, name))
    missed = [(seed, name) for share, seed, name in claimed if share >= FEWEST_SEEN]
    told = {
        "figures": figures, "first_seed": first_seed, "curves": len(sound), "hidden": len(hidden), "false": false,
        "least_seen": sorted(sound)[:20], "claimed": len(claimed), "missed": missed,
        "most_seen_of_claimed": sorted(claimed)[-20:],
    }  # fmt: skip
    RECORD.write_text(json.dumps(told | {"cpu_s": round(time.process_time() - start)}) + "\n")
    print(json.dumps(told))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
