"""PrairieLearn: the results of an external grader. What cannot be graded is told apart from zero, and costs no attempt."""

from __future__ import annotations

import json
from typing import Any

from grader import words
from grader.formats import rows
from grader.results import CheckResult, Result
from grader.text import printable

LIMIT_BYTES = 1_000_000  # PrairieLearn refuses more


def prairielearn(result: Result, *, hidden: bool = False) -> str:
    """The text of `results.json`; `hidden` holds back what may contain data of hidden scenarios."""
    shown = rows.held_back(result) if hidden else result
    text = _text(_record(shown))
    return text if len(text.encode()) <= LIMIT_BYTES else _text({**_record(shown), "tests": [], "output": ""})


def _text(record: dict[str, Any]) -> str:
    return json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _record(result: Result) -> dict[str, Any]:
    if result.status == "incomplete":
        return {"gradable": False, "score": 0.0, "message": words.STATUS["incomplete"]}
    if result.status in ("empty", "unreadable"):
        problem = [words.STATUS[result.status], *rows.notes(result)]
        return {"gradable": False, "score": 0.0, "format_errors": problem}
    # A score above 1 would be refused: extra credit can fill a gap and no more.
    share = min(result.total / result.max_score, 1.0) if result.max_score else 0.0
    return {
        "gradable": True,
        "score": round(share, 6),
        "message": words.total_points(result),
        "output": "\n".join(f"Note: {note}" for note in rows.notes(result)),
        "tests": [_test(check, part) for part in rows.parts(result) for check in part.checks],
    }


def _test(check: CheckResult, part: rows.Part) -> dict[str, Any]:
    return {
        "name": f"{rows.title(part)}: {printable(check.title, 300)}",
        "points": check.points,
        "max_points": check.max_points,
        "message": words.row(check, part.id).outcome.word,
        "output": rows.plain(check, part),
    }
