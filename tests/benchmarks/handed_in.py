"""Honest pictures that are not recognised, and others that are: `python -m tests.benchmarks.handed_in`.

Random pictures of the sheet's recording and of other things, as people hand them in, go the way of a picture that no code draws.

    python -m tests.benchmarks.handed_in [PICTURES [FIRST_SEED]]
"""

from __future__ import annotations

import io
import json
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

from grader.labs.imu import bundles
from grader.labs.imu.diagnosis.handed_in import sensors_shown
from grader.worker.pictures import decode
from tests import handed_pictures

RECORD = Path(__file__).with_name("handed_in.json")
_BOTH = {0, 1}


def main(pictures: int = 250, first_seed: int = 0) -> None:
    mpl.use("Agg")
    warnings.simplefilter("ignore")
    seeds = range(first_seed, first_seed + pictures)
    honest, honest_s = _looked_at(handed_pictures.honest, seeds)
    other, other_s = _looked_at(handed_pictures.other, seeds)
    layouts = Counter(how["layout"] for _, how, _ in honest)
    seen = Counter(how["layout"] for _, how, shown in honest if shown == _BOTH)
    told = {
        "pictures": pictures, "first_seed": first_seed,
        "recognised": {layout: [seen[layout], count] for layout, count in sorted(layouts.items())},
        "missed": [seed for seed, _, shown in honest if shown != _BOTH],
        "false": [(seed, how["kind"]) for seed, how, shown in other if shown == _BOTH],
        "cpu_s": {"honest": [round(f(honest_s), 2) for f in (np.mean, np.max)],
                  "other": [round(f(other_s), 2) for f in (np.mean, np.max)]},
    }  # fmt: skip
    RECORD.write_text(json.dumps(told) + "\n")
    print(json.dumps(told))


def _looked_at(
    draw: Callable[[int], tuple[Any, dict[str, Any]]], seeds: range
) -> tuple[list[tuple[int, dict[str, Any], set[int]]], list[float]]:
    """The sensors that are recognised on each, and the seconds of the processor that this took."""
    push = bundles.shipped()["push"]
    series = {key: push[key] for key in ("time", "acceleration", "angular_velocity")}
    found, seconds = [], []
    for seed in seeds:
        picture, how = draw(seed)
        stream = io.BytesIO()
        picture.save(stream, "PNG", compress_level=1)
        _, arrays = decode({}, {"bytes": np.frombuffer(stream.getvalue(), np.uint8)})
        start = time.process_time()
        found.append((seed, how, sensors_shown(arrays["preview"], arrays["palette"], series)))
        seconds.append(time.process_time() - start)
    return found, seconds


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
