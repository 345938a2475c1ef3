"""The handbook's record of what the corpus did, one entry a rung and user: `grader/handbook/isolation.json`."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import grader
from grader.sandbox.plan import RUNGS
from tests.hostile.judging import Verdict
from tests.hostile.program import FAMILIES

RECORD = Path(grader.__file__).parent / "handbook" / "isolation.json"


def keep(rung: str, verdicts: Sequence[Verdict]) -> None:
    """Put the figures of a whole run in the place of those of the same rung and user."""
    user = "an ordinary user" if os.geteuid() else "root"
    kept = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.is_file() else []
    others = [entry for entry in kept if (entry["rung"], entry["user"]) != (rung, user)]
    entries = sorted([*others, _entry(rung, user, verdicts)], key=lambda e: (RUNGS.index(e["rung"]), e["user"] != "root"))
    RECORD.write_text(json.dumps(entries, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def _entry(rung: str, user: str, verdicts: Sequence[Verdict]) -> dict[str, Any]:
    families = {}
    for family in FAMILIES:
        of = [verdict for verdict in verdicts if verdict.program.family == family]
        fell = {verdict.program.name: verdict.troubles[0] for verdict in of if verdict.troubles}
        families[family] = {"programs": len(of), "fell": fell}
    return {
        "rung": rung,
        "user": user,
        "system": f"{platform.system()} {'.'.join(platform.release().split('.')[:2])}",
        "python": platform.python_version(),
        "minutes": round(sum(verdict.seconds for verdict in verdicts) / 60, 1),
        "families": families,
    }
