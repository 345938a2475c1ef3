"""Gradescope: `results.json` as its specification has it. One test a check, numbered as in the rubric.

What could not be judged has no place in that file (a missing score reads as zero), so an incomplete result is refused: the
platform then reports that the autograder failed, and the instructor runs it again.
"""

from __future__ import annotations

import html
import json
from typing import Any, Literal

from grader import words
from grader.errors import GraderError
from grader.formats import rows
from grader.results import CheckResult, CriterionResult, Result
from grader.text import printable

Visibility = Literal["visible", "after_due_date", "after_published", "hidden"]


def gradescope(result: Result, *, hidden: bool = False, visibility: Visibility = "visible") -> str:
    """The text of `results.json`.

    Parameters
    ----------
    result
        A complete one.
    hidden
        Whether it comes from hidden scenarios: students are then told what is wrong, and none of their data.
    visibility
        When students see the tests. With "hidden" Gradescope hides their total as well.

    Raises
    ------
    GraderError
        If a part of the submission could not be judged.
    """
    if result.status == "incomplete":
        raise GraderError("a part of the submission could not be judged, so there is no score to report; run it again")
    shown = rows.held_back(result) if hidden else result
    record = {
        "score": result.total,
        "execution_time": round(result.duration_s, 3),
        "output": _output(shown, hidden),
        "output_format": "html",
        "visibility": "visible",
        "stdout_visibility": "hidden",
        "tests": [
            _test(check, part, f"{i}.{j}", visibility)
            for i, part in enumerate(rows.parts(shown), 1)
            for j, check in enumerate(part.checks, 1)
        ]
        + _extra_credit(result, visibility),
        "extra_data": _extra(result),
    }
    return json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _test(check: CheckResult, part: rows.Part, number: str, visibility: Visibility) -> dict[str, Any]:
    test: dict[str, Any] = {
        "name": f"{rows.title(part)}: {printable(check.title, 300)}",
        "name_format": "text",
        "number": number,
        "status": "passed" if check.outcome == "passed" else "failed",
        "output": _told(check, part),
        "output_format": "html",
        "tags": [part.id],
        "visibility": visibility,
    }
    # A test with a status and no points is shown as information. Extensions are: Gradescope wants the sum of `max_score` to be
    # the assignment's points, which extra credit does not change.
    points = {"score": check.points, "max_score": check.max_points}
    return {**test, **points} if isinstance(part, CriterionResult) else test


def _extra_credit(result: Result, visibility: Visibility) -> list[dict[str, Any]]:
    """What the extensions earn together, out of nothing, where the rubric gives extra credit."""
    if result.extra_credit_cap is None:
        return []
    test = {"name": "Extra credit", "score": result.extra_credit, "max_score": 0.0, "status": "passed"}
    told = f"At most {words.number(result.extra_credit_cap)}, beside the score."
    return [{**test, "output": told, "output_format": "text", "tags": ["extensions"], "visibility": visibility}]


def _told(check: CheckResult, part: rows.Part) -> str:
    """HTML, which Gradescope sanitises once more: the labels of a report, and its texts in a fixed width."""
    set_lines = [_line(line) for line in rows.lines(check, part)]
    return "".join(set_lines) or f"<p>{words.row(check, part.id).outcome.word}</p>"


def _line(line: words.Line) -> str:
    text = html.escape(line.text)
    if line.label in ("", "Try", "Read"):
        return f"<p><b>{line.label}</b> {text}</p>" if line.label else f"<p>{text}</p>"
    return f"<pre>{line.label:<10}{text}</pre>"


def _output(result: Result, hidden: bool) -> str:
    said = [words.STATUS[result.status]] if words.STATUS[result.status] else []
    said += ["Graded on hidden scenarios. `imugrade check` shows the numbers on the public ones."] if hidden else []
    said += [f"Note: {note}" for note in rows.notes(result)]
    said += [f"Known mistake: {mistake}" for mistake in words.mistakes(result)]
    return "".join(f"<p>{html.escape(line)}</p>" for line in said) or "<p>Graded.</p>"


def _extra(result: Result) -> dict[str, Any]:
    """For the instructor's export: what was recognised, and with what it was graded. No data, no seed."""
    provenance = {key: str(value) for key, value in result.provenance.items() if key != "seed"}
    return {"status": result.status, "misconceptions": list(result.misconceptions), "provenance": provenance}
