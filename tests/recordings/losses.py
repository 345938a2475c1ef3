"""What each faulty submission of the corpus loses, pinned in `losses.yaml`, which `python -m tests.regenerate` writes.

The file pins partial credit: for every case the checks that it loses, each with the share of its points that is kept, and nothing
where the check could not be asked. Where a change of the judging moves a mark, the file says which, and the change of the file is
read before it is committed.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path

import yaml

from grader.engine.results import Result
from tests.generated import differs
from tests.recordings.marker import recorded_corpus, verdict
from tests.scoreboard import Case, Verdict

FILE = Path(__file__).parent / "losses.yaml"
PARTS = ("faulty", "lookalikes", "pairs", "extensions")
"""Whose every mark is meant. What broken submissions lose depends on when they broke, and the corpus says what they keep."""

Losses = Mapping[str, float | None]


def losses(result: Result) -> Losses:
    """The share of its points that each lost check keeps; None for one that could not be asked."""
    checks = [check for part in (*result.criteria, *result.extensions) for check in part.checks]
    return {
        check.id: None if check.outcome == "skipped" else round((check.points or 0.0) / check.max_points, 2)
        for check in checks
        if check.outcome != "passed"
    }


@cache
def pinned() -> Mapping[str, Losses]:
    """What `losses.yaml` says, by case."""
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    said: Mapping[str, Losses] = yaml.load(FILE.read_text(encoding="utf-8"), Loader=loader)
    return said


def pins(case: Case) -> bool:
    """Whether the file has to say what a case loses."""
    return case.part in PARTS


def disagreements(said: Verdict) -> list[str]:
    """Return where a case is judged otherwise than the corpus says, a line each; note where `losses.yaml` says otherwise."""
    case = said.case
    again = f"repeat: python -m tests.scoreboard --only {case.name}"
    found = [f"{case.id}: {kind}: {text}; {again}" for kind, text in said.troubles]
    if (
        pins(case)
        and said.result is not None
        and (lost := losses(said.result)) != (before := pinned().get(case.id, {}))
    ):
        differs(FILE, f"{case.id}: expected to keep {dict(before)}, keeps {dict(lost)}; {again}")
    return found


def all_losses() -> str:
    """Judge all cases whose losses are pinned, and return the text of the file."""
    chosen = [case for case in recorded_corpus() if pins(case)]
    with ProcessPoolExecutor(2) as pool:
        judged = pool.map(_lost_by, chosen, chunksize=10)
        found = {case.id: dict(its) for case, its in zip(chosen, judged, strict=True) if its}
    return yaml.safe_dump(found, sort_keys=True, width=200, allow_unicode=True)


def _lost_by(case: Case) -> Losses:
    result = verdict(case).result
    assert result is not None, case.id
    return losses(result)
