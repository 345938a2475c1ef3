"""Mutants of the reference, handed in and graded: `python -m tests.mutants [--file NAME] [--only TEXT] [--jobs 2]`.

A mutant is killed when it loses points. One that is not must stand in `equivalent.yaml` with the reason why it is as good as the original; a
survivor without one, and a reason without a survivor, make the command end with 1.
"""

from __future__ import annotations

import argparse
import difflib
import sys
from collections.abc import Iterator, Sequence

from tests.mutants import grading
from tests.mutants.grading import FILES, SHEET
from tests.mutants.operators import Mutant


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument(
        "--file", action="append", choices=FILES, help="may be given twice; default: the files of the sheet"
    )
    parser.add_argument("--only", default="", help="mutants whose key holds this")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args(arguments)
    chosen = [mutant for mutant in grading.all_mutants(options.file or SHEET) if options.only in mutant.key]
    return _report(chosen, options.jobs)


def _report(chosen: Sequence[Mutant], jobs: int) -> int:
    """Grade mutants, count how they ended, show those that survived, and say whether all is explained.

    A reason is stale if all the mutants that it speaks of were tried and none survived.
    """
    known = grading.reasons()
    counts = dict.fromkeys(("killed", "equivalent", "survived"), 0)
    used: set[str] = set()
    untried = {mutant.key: mutant for mutant in grading.all_mutants(FILES)}
    for mutant, lost in grading.grade_all(chosen, jobs):
        untried.pop(mutant.key)
        fitting = known.of(mutant) if not lost else set()
        end = "killed" if lost else "equivalent" if fitting else "survived"
        counts[end] += 1
        used |= fitting
        if end == "survived":
            print(f"survived: {mutant.file}:{mutant.line}: {mutant.operator}: {mutant.key}", flush=True)
            print("".join(_difference(mutant)), end="", flush=True)
    print(", ".join(f"{count} {end}" for end, count in counts.items()))
    stale = sorted(known.patterns - used - {pattern for mutant in untried.values() for pattern in known.of(mutant)})
    for pattern in stale:
        print(f"explains no survivor: {pattern}")
    return int(bool(counts["survived"]) or bool(stale))


def _difference(mutant: Mutant) -> Iterator[str]:
    """The lines that the mutant changes."""
    before = (grading.REFERENCE / mutant.file).read_text(encoding="utf-8").splitlines(keepends=True)
    lines = difflib.unified_diff(before, mutant.source.splitlines(keepends=True), n=0)
    return (f"    {line}" for line in lines if not line.startswith(("---", "+++", "@@")))


if __name__ == "__main__":
    sys.exit(main())
