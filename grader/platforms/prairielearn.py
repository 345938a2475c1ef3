"""PrairieLearn: results of an external grader. A submission that cannot be graded is no zero, and costs no attempt."""

from __future__ import annotations

from typing import Any

from grader.base.text import printable
from grader.engine.results import CheckResult, LabName, Result
from grader.platforms import rows
from grader.platforms.platform import Help, Platform
from grader.report import words

SUBMISSION = "grade/student"
LIMIT_BYTES = 1_000_000  # PrairieLearn refuses more


def prairielearn(result: Result) -> str:
    """Return the text of PrairieLearn's `results.json`, without tests and output if it would be larger than PrairieLearn accepts.

    A submission that is empty, unreadable or not fully judged is "not gradable", which costs the student no attempt.
    """
    text = rows.as_json(_record(result))
    return text if len(text.encode()) <= LIMIT_BYTES else rows.as_json({**_record(result), "tests": [], "output": ""})


def _record(result: Result) -> dict[str, Any]:
    if result.status == "incomplete":
        return {"gradable": False, "score": 0.0, "message": rows.with_help(words.STATUS["incomplete"], result)}
    if result.status in ("empty", "unreadable"):
        problem = [words.STATUS[result.status], *rows.notes(result)]
        return {"gradable": False, "score": 0.0, "format_errors": problem, "message": rows.with_help("", result)}
    # PrairieLearn refuses a score above 1, so extra credit can only make up for lost points.
    share = min(result.total / result.max_score, 1.0) if result.max_score else 0.0
    return {
        "gradable": True,
        "score": round(share, 6),
        "message": rows.with_help(words.total_points(result), result),
        "output": "\n".join(f"Note: {note}" for note in rows.notes(result)),
        "tests": [_test(check, part, result.lab) for part in rows.parts(result) for check in part.checks],
    }


def _test(check: CheckResult, part: rows.ResultPart, lab: LabName) -> dict[str, Any]:
    return {
        "name": f"{rows.title(part)}: {printable(check.title, 300)}",
        "points": check.points,
        "max_points": check.max_points,
        "message": words.row(check, part.id, lab).outcome.word,
        "output": rows.plain_text(check, part, lab),
    }


PLATFORM = Platform(
    name="prairielearn",
    title="PrairieLearn",
    help=Help(
        respond="""\
An external grader whose `entrypoint` runs `imugrade ci --format prairielearn`. What cannot be graded (an empty or unreadable
submission, a failure of the grader) comes back as not gradable and costs no attempt.""",
    ),
    respond=lambda result, _: prairielearn(result),
    recognise=lambda _, root: (root / SUBMISSION).is_dir(),
    submission=SUBMISSION,
    answer="grade/results/results.json",
    keeps_secrets=True,
)
