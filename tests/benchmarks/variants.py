"""Two hundred secrets: `python -m tests.benchmarks.variants [--secrets 200]`.

Draws the lab model's variant of each, which is drawn again until it keeps the sheet's facts, and tells how far apart the pushes
are from the public one and from each other's. `tests/test_variants.py` asks the same of twenty.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from reference import worlds
from reference.lab_variants import lab_variant
from reference.scene import generator
from tests.variety import LEAST, distances, push_of


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.variants", description=__doc__)
    parser.add_argument("--secrets", type=int, default=200)
    count = parser.parse_args().secrets
    started = time.perf_counter()
    texts = [lab_variant(worlds.lab(), generator("hidden", f"secret {number}", "lab")) for number in range(count)]
    made = time.perf_counter()
    apart = distances([push_of(text) for text in (worlds.lab(), *texts)])
    print(f"{count} variants in {made - started:.1f} s, compared in {time.perf_counter() - made:.1f} s")
    print(f"nearest to the public push: {min(apart[0].min(), apart[:, 0].min()):.3f} of its spread")
    print(f"nearest to each other: {apart[1:, 1:].min():.3f}; median {np.median(apart[np.isfinite(apart)]):.3f}")
    return int(apart.min() < LEAST)


if __name__ == "__main__":
    raise SystemExit(main())
