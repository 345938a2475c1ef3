"""Kill matrix: which tests fail for which mutant, and a small set of tests that kills all that the corpus does not."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

from tests.mutants.judging import End
from tests.mutants.operators import Mutant


def read(matrix: Path) -> dict[str, End]:
    """Return what killed each mutant on record, by its key."""
    rows = map(json.loads, matrix.read_text("utf-8").splitlines()) if matrix.exists() else ()
    return {row.pop("mutant"): End(**{**row, "tests": tuple(row["tests"])}) for row in rows}


def written(ended: Iterator[tuple[Mutant, End]], matrix: Path) -> Iterator[tuple[Mutant, End]]:
    """Append each mutant, as it ends, with what killed it: a JSON line each."""
    with matrix.open("a", encoding="utf-8") as file:
        for mutant, end in ended:
            file.write(json.dumps({"mutant": mutant.key, **asdict(end)}) + "\n")
            file.flush()
            yield mutant, end


def cover(matrix: Path) -> dict[str, int]:
    """Return a small set of tests that together kill each mutant that no case kills, with how many each adds.

    The test that kills most of those that are left comes next, of equal ones the first by name.
    """
    left = [frozenset(end.tests) for end in read(matrix).values() if end.tests and not end.case]
    chosen: dict[str, int] = {}
    while left:
        kills = Counter(test for tests in left for test in tests)
        best = min(kills, key=lambda test: (-kills[test], test))
        chosen[best] = kills[best]
        left = [tests for tests in left if best not in tests]
    return chosen
