"""Every mutant of the reference, handed in and graded: `python -m tests.mutants [--file NAME] [--only TEXT] [--jobs 2]`.

A mutant is killed when it loses points. One that does not must stand in `equivalent.yaml` with the reason why it is as good as the
original; a survivor without one, and a reason without a survivor, make the command end with 1.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence

from tests.mutants.grading import FILES, SHEET, all_mutants, grade_all, reasons


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument(
        "--file",
        choices=FILES,
        action="append",
        help="a file of the reference; may be given twice; default: the three files of the sheet",
    )
    parser.add_argument("--only", default="", help="mutants whose key holds this")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args(arguments)
    chosen = [mutant for mutant in all_mutants(options.file or SHEET) if options.only in mutant.key]
    known = reasons()
    counts: dict[str, Counter[str]] = {"killed": Counter(), "equivalent": Counter(), "survived": Counter()}
    used: set[str] = set()
    for mutant, lost in grade_all(chosen, options.jobs):
        fitting = known.of(mutant) if not lost else set()
        end = "killed" if lost else "equivalent" if fitting else "survived"
        counts[end][mutant.operator] += 1
        used |= fitting
        if end == "survived":
            print(f"survived: {mutant.operator}, line {mutant.line}: {mutant.key}", flush=True)
    print(_table(counts))
    stale = sorted(known.patterns - used) if len(chosen) == len(all_mutants()) else []
    for pattern in stale:
        print(f"explains no survivor: {pattern}")
    return int(bool(counts["survived"]) or bool(stale))


def _table(counts: dict[str, Counter[str]]) -> str:
    """One line an operator: how many mutants it made and how they ended."""
    operators = sorted({operator for ends in counts.values() for operator in ends})
    rows = [(operator, *(counts[end][operator] for end in counts)) for operator in operators]
    rows.append(("all", *(sum(row[i] for row in rows) for i in (1, 2, 3))))
    head = f"{'operator':<12}{'mutants':>9}{'killed':>9}{'equivalent':>12}{'survived':>10}"
    return "\n".join([head, *(f"{name:<12}{k + e + s:>9}{k:>9}{e:>12}{s:>10}" for name, k, e, s in rows)])


if __name__ == "__main__":
    sys.exit(main())
