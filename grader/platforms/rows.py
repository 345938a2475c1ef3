"""Texts that several CI formats share: the parts of a result, a check's feedback, and notes."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from grader.base.errors import GraderError
from grader.base.text import printable
from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, LabName, Result
from grader.report import causes, words
from grader.report.causes import Cause

ResultPart = CriterionResult | ExtensionResult

NOTES_LIMIT = 20
HIDDEN = "Graded on hidden scenarios. `imugrade check` shows the numbers on the public ones."


def parts(result: Result) -> Iterator[ResultPart]:
    """Yield the parts of a result that platforms show: all criteria, then those extensions that were attempted and have checks."""
    yield from result.criteria
    yield from (extension for extension in result.extensions if extension.attempted and extension.checks)


def require_complete(result: Result) -> None:
    """Raise GraderError if a check was not judged; formats that hold only points call this, as a zero would be unfair.

    The platform then reports that the autograder failed, and the instructor runs it again.
    """
    if result.status == "incomplete":
        raise GraderError("the grader failed on a part of the submission, so there is no score to report; run it again")


def as_json(record: Mapping[str, Any]) -> str:
    """Return the text of a platform's JSON file: indented, with non-ASCII letters as they are."""
    return json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def title(part: ResultPart) -> str:
    """Return the title of a criterion or extension, as ``Sensor access`` or ``Extension: allan variance``."""
    if isinstance(part, CriterionResult):
        return printable(part.title, words.NAME_LIMIT)
    return f"Extension: {part.id.replace('_', ' ')}"


def lines(check: CheckResult, part: ResultPart, lab: LabName) -> list[words.LabelledLine]:
    """Return a check's feedback as labelled lines: Expected, Got, Try, Read (a step of `lab`), Rerun (of `part`); no empty ones."""
    row = words.row(check, part.id, lab)
    more = (words.LabelledLine("Read", row.read), words.LabelledLine("Rerun", row.again))
    return [*row.lines, *(line for line in more if line.text)]


def plain_text(check: CheckResult, part: ResultPart, lab: LabName) -> str:
    """Return a check's feedback as plain text with labels (Expected, Got, …), the step of `lab` to read and how to rerun `part`."""
    return "\n".join(_plain_line(line) for line in lines(check, part, lab))


def text_of_cause(cause: Cause, lab: LabName) -> str:
    """Return the feedback of all checks that failed from one cause as plain text: each sentence once, then `lab` steps to read."""
    said = [line for _, lines in causes.lines_by_check(cause) for line in lines]
    again = [causes.again(cause)] if words.tells(cause.checks[0]) else []
    return "\n".join(_plain_line(line) for line in [*said, *causes.next_lines(cause, lab), *again])


def _plain_line(line: words.LabelledLine) -> str:
    text = line.text.replace("\n", "\n" + " " * 10)
    return f"{line.label:<10}{text}" if line.label else line.text


def with_help(text: str, result: Result) -> str:
    """Return a text with a last line that names the students' guide, if something was lost."""
    return "\n".join(filter(None, [text, *map(_plain_line, words.help_lines(result))]))


def notes(result: Result) -> list[str]:
    """Return a line on each repair by an instructor, then the grader's notes on files; after `NOTES_LIMIT`, one counts the rest."""
    lines = [*words.repairs(result), *words.notes(result)]
    more = [f"… and {len(lines) - NOTES_LIMIT} more"] if len(lines) > NOTES_LIMIT else []
    return lines[:NOTES_LIMIT] + more
