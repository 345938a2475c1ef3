"""Two faults at once, judged in pairs of the corpus: `python -m tests.pairs [--every N] [--only NAME]`.

A pair is two patches of one file of the sheet's solution that do not touch the same lines. The command prints a line for each trouble and
a table, and ends with 1 if a larger share of the pairs has a trouble than `KNOWN` says.
"""

from __future__ import annotations

import argparse
import ast
import itertools
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache

from grader.engine.results import Result
from tests.corpus.cases import CRITERIA, patched
from tests.corpus.pieces import read, verbatim
from tests.recordings import Marking
from tests.recordings.marker import RecordedMarker, without_charts
from tests.single_faults import lost_by, marked

Fault = tuple[str, str, str]
"""The name of a row of the corpus, the file that it patches, and the patch."""
ONLY_FOR_THE_OWN = ("record-and-plot", "filter-kept-beside-the-measurement")
"""Plots and scripts that fit one form only, in which the submission's own recorder or filter returns its numbers. They may lose points
of *Visualization* beside a recorder that raises, ends early or returns numbers that cannot be told apart, or beside a faulty filter: no
sound part returns that form, so that nothing is left to try them with. A note asks a person to give the points."""
OTHER_NAMES = {
    "index-out-of-bounds", "raises", "nothing-simulated", "not-gaussian", "bias-not-random", "first-output-missing",
}  # fmt: skip
"""Faults that two others together amount to: two components of three cannot be put in another order, for example."""
KNOWN = {"cheaper than one fault alone": 0.025, "points of another criterion": 0.005, "a name of neither": 0.03}
"""The largest share of pairs with each trouble. Of one in three pairs 0.020, 0.002 and 0.026 have it, as the page on fairness counts."""


def faults(criterion: str) -> Iterator[Fault]:
    """Yield the faults of a criterion that patch one file of the sheet's solution."""
    rows = read(criterion)
    for name, row in {**rows.get("faulty", {}), **rows.get("lookalikes", {})}.items():
        files = [path for path in row if path.endswith(".py")]
        if row.get("base") == "verbatim" and len(files) == 1 and "append" not in row and "files" not in row:
            yield name, files[0], row[files[0]]


def together(*chosen: Fault) -> dict[str, str] | None:
    """Return the solution with these faults; None if one patch takes the lines of another, or if no program comes of both."""
    files = verbatim()
    try:
        for _, path, patch in chosen:
            files[path] = patched(files[path], patch)
        ast.parse(files[path])
    except (SyntaxError, ValueError):
        return None
    return files


def pairs(every: int = 1) -> Iterator[tuple[Fault, Fault]]:
    """Yield the pairs, or one of so many, that make a program in both orders."""
    both = (pair for criterion in CRITERIA for pair in itertools.combinations(faults(criterion), 2))
    for pair in itertools.islice(both, 0, None, every):
        if together(*pair) is not None and together(*pair[::-1]) is not None:
            yield pair


@dataclass(frozen=True)
class JudgedPair:
    """A pair of faults with the results of each alone and of both."""

    names: tuple[str, str]
    alone: tuple[Result, Result]
    both: Result

    @property
    def cost(self) -> str:
        """Whether both together cost what both cost apart, less or more."""
        apart, beside = sum(map(_points, self.alone)), _points(self.both)
        return "cost what both cost" if abs(beside - apart) < 0.02 else "cost less" if beside < apart else "cost more"

    @property
    def named(self) -> str:
        """How many of the two faults are named; "both" also where one has no public name."""
        told = set(self.both.misconceptions)
        seen = [set(each.misconceptions) <= told for each in self.alone]
        return "both named" if all(seen) else "one named" if any(seen) else "none named"

    @property
    def troubles(self) -> list[str]:
        """Keys of `KNOWN`: points given back, lost in a criterion that neither fault costs alone, or a name of neither."""
        own = any(name.startswith(ONLY_FOR_THE_OWN) for name in self.names)
        elsewhere = (
            _criteria(self.both) - set().union(*map(_criteria, self.alone)) - ({"visualization"} if own else set())
        )
        known = {name for each in self.alone for name in each.misconceptions}
        found = (
            _points(self.both) < max(map(_points, self.alone)) - 0.01,
            bool(elsewhere),
            not own and not set(self.both.misconceptions) - OTHER_NAMES <= known,
        )
        return list(itertools.compress(KNOWN, found))


def _points(result: Result) -> float:
    return sum(lost_by(result).values())


def _criteria(result: Result) -> set[str]:
    return {check.partition(".")[0] for check in lost_by(result)}


def judged(marker: Marking, first: Fault, second: Fault) -> JudgedPair:
    alone = marked(marker, together(first) or {}), marked(marker, together(second) or {})
    return JudgedPair((first[0], second[0]), alone, marked(marker, together(first, second) or {}))


@cache
def _marker() -> RecordedMarker:
    return RecordedMarker(without_charts())


def _judged(pair: tuple[Fault, Fault]) -> JudgedPair:
    return judged(_marker(), *pair)


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.pairs", description=__doc__)
    parser.add_argument("--every", type=int, default=1, help="judge one of so many pairs")
    parser.add_argument("--only", default="", help="pairs with a fault whose name holds this")
    options = parser.parse_args(arguments)
    chosen = [pair for pair in pairs(options.every) if any(options.only in name for name, *_ in pair)]
    counts = Counter[str]()
    with ProcessPoolExecutor(2) as pool:
        for number, each in enumerate(pool.map(_judged, chosen), 1):
            print(f"{number} of {len(chosen)} pairs judged", end="\r", file=sys.stderr, flush=True)
            counts.update([each.cost, each.named, *each.troubles])
            for trouble in each.troubles:
                print(f"{' and '.join(each.names)}: {trouble}", flush=True)
    print(f"{len(chosen)} pairs", *(f"{name}: {counts[name]}" for name in sorted(counts)), sep="\n")
    return int(any(counts[name] > most * len(chosen) for name, most in KNOWN.items()))


if __name__ == "__main__":
    sys.exit(main())
