"""What each faulty submission of the corpus loses, pinned in `losses.yaml`, which `python -m tests.regenerate` writes.

The file pins partial credit: for every case the checks that it loses, each with the share of its points that is kept, and nothing
where the check could not be asked. Where a change of the judging moves a mark, the file says which, and the change of the file is
read before it is committed.
"""

from __future__ import annotations

import sys
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


def of_rows(only: str) -> list[Case]:
    """Return the cases with this in their id whose losses are pinned."""
    return [case for case in recorded_corpus() if pins(case) and only in case.id]


def all_losses(only: str = "") -> str:
    """Judge all cases whose losses are pinned, or those with `only` in their id, tell the progress, and return the text of the file."""
    chosen = of_rows(only)
    found = {id_: dict(its) for id_, its in pinned().items()} if only else {}
    with ProcessPoolExecutor(2) as pool:
        for number, (case, its) in enumerate(zip(chosen, pool.map(_lost_by, chosen), strict=True), 1):
            print(f"{number} of {len(chosen)} submissions judged", end="\r", file=sys.stderr, flush=True)
            found.pop(case.id, None)
            if its:
                found[case.id] = dict(its)
    return yaml.safe_dump(found, sort_keys=True, width=200, allow_unicode=True)


def _lost_by(case: Case) -> Losses:
    result = verdict(case).result
    assert result is not None, case.id
    return losses(result)
