"""Submissions with one fault, and the deductions of a fair marker: those checks, those points, and nothing else."""

from __future__ import annotations

from dataclasses import dataclass

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


@dataclass(frozen=True)
class SingleFault:
    """A submission with one fault: which checks lose how many points by it, by which names."""

    name: str
    files: Files
    lost: dict[str, float]
    named: tuple[str, ...] = ()


def marked(player: Marking, files: Files) -> Result:
    return player.mark(Submission("s", "s", {name: text.encode() for name, text in files.items()}, (), "ready", ""))


def lost_by(result: Result) -> dict[str, float]:
    checks = [check for part in result.criteria for check in part.checks]
    return {check.id: check.max_points - (check.points or 0.0) for check in checks if check.points != check.max_points}


def assert_loses(slip: SingleFault, player: Marking) -> None:
    """It loses these points alone, by these names, and every check that could be asked says what to do."""
    result = marked(player, slip.files)
    lost = lost_by(result)
    assert lost == slip.lost
    assert set(result.misconceptions) == set(slip.named)
    checks = [check for part in result.criteria for check in part.checks]
    assert [check.id for check in checks if check.id in lost and not check.hint and check.outcome != "skipped"] == []
