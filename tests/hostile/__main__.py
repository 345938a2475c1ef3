"""Run the hostile corpus: ``python -m tests.hostile [--isolation LEVEL] [--only NAME] [--write]``.

Prints a line for each attack that succeeded, and a table of those held for each family and isolation level. Exit code 1 if one
succeeded. The lowest level is left out, for nothing is promised there: an attack could harm this machine. With ``--write`` the results
of these isolation levels and this user are written to docs/isolation.json.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from grader.sandbox.isolation_levels import LEVELS
from grader.sandbox.level_choice import probe
from tests.hostile.corpus import PROGRAMS
from tests.hostile.judging import AttackJudge, Verdict
from tests.hostile.program import FAMILIES

RECORD = Path(__file__).resolve().parents[2] / "docs" / "isolation.json"
"""The last results, one entry per isolation level, user and family."""


def entries_of(isolation_level: str, verdicts: Sequence[Verdict]) -> list[dict[str, Any]]:
    """The results of one isolation level, an entry for each family that was run."""
    by_family = {family: [verdict for verdict in verdicts if verdict.program.family == family] for family in FAMILIES}
    return [
        {
            "isolation_level": isolation_level,
            "user": "an ordinary user" if os.geteuid() else "root",
            "family": family,
            "programs": len(of),
            "held": sum(not verdict.troubles for verdict in of),
            "date": datetime.date.today().isoformat(),
            "system": f"{platform.system()} {'.'.join(platform.release().split('.')[:2])}",
            "python": platform.python_version(),
        }
        for family, of in by_family.items()
        if of
    ]


def write_down(new: Sequence[Mapping[str, Any]]) -> None:
    """Put the entries in the place of those of the same isolation level, user and family."""

    def place(entry: Mapping[str, Any]) -> tuple[int, bool, int]:
        levels = [isolation_level.name for isolation_level in LEVELS]
        return levels.index(entry["isolation_level"]), entry["user"] != "root", FAMILIES.index(entry["family"])

    kept = {place(entry): entry for entry in (*json.loads(RECORD.read_text(encoding="utf-8")), *new)}
    text = json.dumps([kept[where] for where in sorted(kept)], indent=1, ensure_ascii=False)
    RECORD.write_text(text + "\n", encoding="utf-8")


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.hostile", description=__doc__)
    parser.add_argument("--isolation", choices=[level.name for level in LEVELS if level.isolates], action="append", help="may be given more than once; all that isolate here")
    parser.add_argument("--only", default="", help="programs whose name holds this")
    parser.add_argument("--write", action="store_true", help="write the results to docs/isolation.json")
    options = parser.parse_args(arguments)
    if options.write and options.only:
        parser.error("--write needs the whole corpus")
    programs = [program for program in PROGRAMS if options.only in program.name]
    lines, succeeded = [], 0
    for tried in probe():
        isolation_level = tried.isolation_level.name
        if not tried.isolation_level.isolates or isolation_level not in (options.isolation or [isolation_level]):
            continue
        if not tried.usable:
            print(f"{isolation_level}: not here: {tried.reason}")
            continue
        verdicts = []
        with AttackJudge(isolation_level) as attack_judge:
            for program in programs:
                verdicts.append(attack_judge.try_(program))
                for trouble in verdicts[-1].troubles:
                    print(f"{isolation_level:<10} {program.family}/{program.name}: SUCCEEDED: {trouble}", flush=True)
        entries = entries_of(isolation_level, verdicts)
        if options.write:
            write_down(entries)
        for entry in entries:
            lines.append(f"{isolation_level:<10}  {entry['family']:<8}  held {entry['held']:>3} of {entry['programs']:>3}")
            succeeded += entry["programs"] - entry["held"]
    print("\n".join(lines))
    return int(succeeded > 0)


if __name__ == "__main__":
    sys.exit(main())
