"""Run the hostile corpus: ``python -m tests.hostile [--isolation LEVEL] [--only NAME] [--write]``.

Prints a line for each attack that fell, and a table of held and fell for each family and isolation level. Exit code 1 if one fell on a
level that isolates; on the lowest isolation level falls are counted and listed, for nothing is promised there. With ``--write`` the
results of this isolation level and user are written to docs/isolation.json.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence

from grader.sandbox.isolation_levels import LEVELS
from grader.sandbox.level_choice import probe
from tests.hostile import record
from tests.hostile.corpus import PROGRAMS
from tests.hostile.judging import AttackJudge, Verdict
from tests.hostile.program import FAMILIES, Program


def run(isolation_level: str, programs: Sequence[Program]) -> list[Verdict]:
    verdicts = []
    with AttackJudge(isolation_level) as attack_judge:
        for program in programs:
            verdict = attack_judge.try_(program)
            verdicts.append(verdict)
            for trouble in verdict.troubles:
                print(f"{isolation_level:<10} {program.family}/{program.name}: FELL: {trouble}", flush=True)
    return verdicts


def table(isolation_level: str, verdicts: Iterable[Verdict]) -> str:
    lines = []
    for family in FAMILIES:
        of = [verdict for verdict in verdicts if verdict.program.family == family]
        fell = sum(bool(verdict.troubles) for verdict in of)
        if of:
            lines.append(f"{isolation_level:<10}  {family:<8}  held {len(of) - fell:>3}  fell {fell:>3}")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.hostile", description=__doc__)
    parser.add_argument("--isolation", choices=[isolation_level.name for isolation_level in LEVELS], action="append", help="may be given more than once; all that there are")
    parser.add_argument("--only", default="", help="programs whose name holds this")
    parser.add_argument("--write", action="store_true", help="write the results to docs/isolation.json")
    options = parser.parse_args(arguments)
    if options.write and options.only:
        parser.error("--write needs the whole corpus")
    programs = [program for program in PROGRAMS if options.only in program.name]
    tables, fell = [], 0
    for tried in probe():
        isolation_level = tried.isolation_level.name
        if options.isolation and isolation_level not in options.isolation:
            continue
        if not tried.usable:
            print(f"{isolation_level}: not here: {tried.reason}")
            continue
        verdicts = run(isolation_level, programs)
        if options.write:
            record.keep(isolation_level, verdicts)
        tables.append(table(isolation_level, verdicts))
        fell += sum(bool(verdict.troubles) for verdict in verdicts) if tried.isolation_level.isolates else 0
    print("\n".join(tables))
    return int(fell > 0)


if __name__ == "__main__":
    sys.exit(main())
