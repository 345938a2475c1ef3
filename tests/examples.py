"""The submissions of `submissions_example/` and what each must get: the table `examples.yaml`, which `python -m tests.regenerate` writes.

Read the difference before you commit it: a changed mark breaks a promise, or keeps one at last.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

import yaml

from grader.engine import rubric
from grader.engine.grader import Marker
from grader.engine.results import CheckResult, Result
from grader.intake import read_submission
from grader.intake.names import is_litter
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB

FOLDER = Path(__file__).resolve().parent.parent / "submissions_example"
TABLE = Path(__file__).resolve().parent / "examples.yaml"


def folders() -> list[Path]:
    """Return the example submissions, without what a user's tools left beside them."""
    return sorted(path for path in FOLDER.iterdir() if path.is_dir() and not is_litter([path.name]))


def files(example: str) -> list[Path]:
    """Return the files of an example, without what a user's tools left in it."""
    folder = FOLDER / example
    found = (path for path in folder.rglob("*") if path.is_file())
    return sorted(path for path in found if not is_litter(path.relative_to(folder).parts))


@cache
def expected() -> dict[str, dict[str, Any]]:
    """Return the table: the summary of each example's result, by its name."""
    table: dict[str, dict[str, Any]] = yaml.safe_load(TABLE.read_text(encoding="utf-8"))
    return table


def summary(result: Result) -> dict[str, Any]:
    """Return what does not depend on versions and machines; a check that is not listed earned all its points."""
    told = {
        "status": result.status,
        "score": result.score,
        "criteria": {criterion.id: criterion.points for criterion in result.criteria},
        "lost": _lost(check for criterion in result.criteria for check in criterion.checks),
        "extensions": {each.id: _lost(each.checks) for each in result.extensions if each.attempted},
        "misconceptions": list(result.misconceptions),
        "notes": list(result.notes),
    }
    return {name: value for name, value in told.items() if value not in ({}, [])}


def _lost(checks: Iterable[CheckResult]) -> dict[str, list[Any]]:
    return {check.id: [check.outcome, check.points] for check in checks if check.outcome != "passed"}


def table() -> str:
    """Grade all examples and return the table."""
    with Marker(rubric.load(LAB), bundles.shipped(), isolation_level=os.environ.get("IMUGRADE_RUNG")) as marker:
        found = {folder.name: summary(marker.mark(read_submission(folder, LAB.files))) for folder in folders()}
    return yaml.safe_dump(found, sort_keys=False, width=140, default_flow_style=None, allow_unicode=True)
