"""Submissions that are a base with some text replaced, and what they lose."""

from __future__ import annotations

from grader.engine.results import Result
from grader.intake import Submission
from tests.corpus.writing import Files
from tests.recordings import Marking

Changes = dict[str, str]
"""What stands in the place of what, in one file."""


def changed(files: Files, path: str, changes: Changes) -> Files:
    text = files[path]
    for old, new in changes.items():
        assert old in text, f"{path} holds no {old!r}"
        text = text.replace(old, new)
    return files | {path: text}


def marked(player: Marking, files: Files, only: str | None = None) -> Result:
    content = {name: str(text).encode() for name, text in files.items()}
    return player.mark(Submission("s", "s", content, (), "ready", ""), only=only)


def lost_by(result: Result) -> dict[str, float]:
    checks = [check for part in result.criteria for check in part.checks]
    return {check.id: check.max_points - (check.points or 0.0) for check in checks if check.points != check.max_points}
