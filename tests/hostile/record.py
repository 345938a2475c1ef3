"""Results of the hostile corpus, one entry per isolation level, user and family: `docs/isolation.json`."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from grader.sandbox.isolation_levels import LEVELS
from tests.hostile.judging import Verdict
from tests.hostile.program import FAMILIES

RECORD = Path(__file__).resolve().parents[2] / "docs" / "isolation.json"


def keep(isolation_level: str, verdicts: Sequence[Verdict]) -> None:
    """Put the figures in the place of those of the same isolation level, user and family."""
    kept = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.is_file() else []
    new = [_entry(isolation_level, family, verdicts) for family in FAMILIES]
    others = [entry for entry in kept if all(_place(entry) != _place(each) for each in new)]
    text = json.dumps(sorted([*others, *new], key=_place), indent=1, ensure_ascii=False)
    RECORD.write_text(text + "\n", encoding="utf-8")


def _place(entry: Mapping[str, Any]) -> tuple[int, bool, int]:
    return [isolation_level.name for isolation_level in LEVELS].index(entry["isolation_level"]), entry["user"] != "root", FAMILIES.index(entry["family"])


def _entry(isolation_level: str, family: str, verdicts: Sequence[Verdict]) -> dict[str, Any]:
    of = [verdict for verdict in verdicts if verdict.program.family == family]
    return {
        "isolation_level": isolation_level,
        "user": "an ordinary user" if os.geteuid() else "root",
        "family": family,
        "programs": len(of),
        "fell": {verdict.program.name: verdict.troubles[0] for verdict in of if verdict.troubles},
        "longest_s": round(max(verdict.seconds for verdict in of), 1),
        "system": f"{platform.system()} {'.'.join(platform.release().split('.')[:2])}",
        "python": platform.python_version(),
    }
