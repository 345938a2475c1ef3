"""Mutants of the reference, handed in and graded: `python -m tests.mutants [--file NAME] [--only TEXT] [--jobs 2]`; with `--judging`,
mutants of checks, diagnosis, findings and rubric, tested without a sandbox: `--judging [--sample N] [--seed S]`.

A mutant is killed when it loses points, or when a test or a case of the corpus says that it judges otherwise. One that is not must stand in
`equivalent.yaml` or `judging.yaml` with the reason why it is as good as the original; a survivor without one, and a reason without a
survivor, make the command end with 1.
"""

from __future__ import annotations

import argparse
import difflib
import random
import sys
from collections.abc import Iterable, Iterator, Sequence

from tests.mutants import grading, judging
from tests.mutants.grading import FILES, SHEET, Reasons
from tests.mutants.operators import Mutant

_SAMPLE = 200
"""Mutants of the judging that are drawn where nobody says how many: a quarter of an hour on two cores."""


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("--judging", action="store_true", help="mutants of what judges, not of the reference")
    parser.add_argument(
        "--file",
        action="append",
        help="a file, or the end of its name; may be given twice; default: the three files of the sheet, or all that judge",
    )
    parser.add_argument("--only", default="", help="mutants whose key holds this")
    parser.add_argument("--sample", type=int, help=f"so many of them, drawn by chance; of those that judge, {_SAMPLE}")
    parser.add_argument("--seed", type=int, default=0, help="of what is drawn")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args(arguments)
    there = judging.files() if options.judging else FILES
    files = [file for file in there if file.endswith(tuple(options.file))] if options.file else None
    if files == []:
        parser.error(f"no such file; there are {', '.join(there)}")
    made = judging.judging_mutants(files or there) if options.judging else grading.all_mutants(files or SHEET)
    chosen = [mutant for mutant in made if options.only in mutant.key]
    if size := options.sample or (_SAMPLE if options.judging and not options.only else 0):
        drawn = random.Random(options.seed).sample(chosen, min(size, len(chosen)))
        chosen = sorted(drawn, key=chosen.index)
    if options.judging:
        every = judging.judging_mutants(there)
        tried = [mutant for mutant in chosen if judging.is_python(mutant)]
        told: list[int] = []

        def tell(ended: Iterator[tuple[Mutant, judging.End]]) -> None:
            as_text = ((mutant, str(end)) for mutant, end in ended)
            told.append(_report(as_text, judging.reasons(), every, said=True))

        judging.ends(tried, options.jobs, tell)
        return told[0]
    ended = ((mutant, ", ".join(lost)) for mutant, lost in grading.grade_all(chosen, options.jobs))
    return _report(ended, grading.reasons(), grading.all_mutants(FILES), said=False)


def _report(ended: Iterable[tuple[Mutant, str]], known: Reasons, every: Sequence[Mutant], *, said: bool) -> int:
    """Count how mutants ended, show those that survived, and say whether all is explained; a killed one is `said` by name or not.

    A reason is stale if all the mutants that it speaks of, out of `every` one that there is, were tried and none survived.
    """
    counts = dict.fromkeys(("killed", "equivalent", "survived"), 0)
    used: set[str] = set()
    untried = {mutant.key: mutant for mutant in every}
    for mutant, killed_by in ended:
        untried.pop(mutant.key)
        fitting = known.of(mutant) if not killed_by else set()
        end = "killed" if killed_by else "equivalent" if fitting else "survived"
        counts[end] += 1
        used |= fitting
        if said and end == "killed":
            print(f"killed by {killed_by}: {mutant.file}:{mutant.line}: {mutant.change}", flush=True)
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
    path = judging.ROOT / mutant.file if "/" in mutant.file else grading.REFERENCE / mutant.file
    before = path.read_text(encoding="utf-8").splitlines(keepends=True)
    lines = difflib.unified_diff(before, mutant.source.splitlines(keepends=True), n=0)
    return (f"    {line}" for line in lines if not line.startswith(("---", "+++", "@@")))


if __name__ == "__main__":
    sys.exit(main())
