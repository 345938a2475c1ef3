"""Show a failed check in pytest: the text of the report, then the student's own line in a form that editors can open."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from grader.engine.lab import Lab
from grader.engine.results import CheckResult, LabName
from grader.report import causes, words

_INDENT, _LABEL_WIDTH = 3, 10


class Writer(Protocol):
    """The methods of pytest's terminal writer that `CheckFailure` uses."""

    def line(self, s: str = "", **markup: bool) -> None: ...


@dataclass(frozen=True)
class Crash:
    """Place and message of a failed check, from which pytest makes its short summary and JUnit file."""

    path: str
    lineno: int
    message: str

    def __str__(self) -> str:
        return f"{self.path}:{self.lineno}: {self.message}"


class CheckFailure:
    """A failed check as pytest's report of a failure: it prints the text of the student's report.

    Parameters
    ----------
    check, lab
        The check, and its lab, whose name stands in the text.
    path, line
        The student's file and the line in it at which pytest shows the failure.
    """

    def __init__(self, check: CheckResult, lab: Lab, path: str, line: int) -> None:
        row = words.row(check, check.id.partition(".")[0], LabName(lab.label, lab.title))
        got = next((each.text.partition("\n")[0] for each in row.lines if each.label == "Got"), row.title)
        self.reprcrash = Crash(path, line, got)
        self._lines = [f"{row.title}  {row.points}", *(line for each in row.lines for line in _labelled(each))]
        read = "; ".join([row.read, *(f"imugrade explain {id_}" for id_ in causes.faults_of(check))]).removeprefix("; ")
        self._lines += _labelled(words.LabelledLine("Read", read)) if read else []
        self._lines += (
            _labelled(words.LabelledLine("Reproduce", f"imugrade repro {check.id}")) if lab.call_of(check.id) else []
        )
        self._end = f"{path}:{line}: {row.outcome.word}"

    def toterminal(self, tw: Writer) -> None:
        for line in self._lines:
            tw.line(line)
        tw.line()
        tw.line(self._end, bold=True, red=True)

    def __str__(self) -> str:
        return "\n".join((*self._lines, "", self._end))


def _labelled(line: words.LabelledLine) -> list[str]:
    first, *others = line.text.split("\n")
    indent = " " * (_INDENT + _LABEL_WIDTH)
    return [" " * _INDENT + line.label.ljust(_LABEL_WIDTH) + first, *(indent + other for other in others)]


class NotJudgedError(Exception):
    """Exception of a check that the grader could not judge; pytest shows an error of the grader's, not a failure."""
