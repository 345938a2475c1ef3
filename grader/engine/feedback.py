"""The words: from a finding to the message, the hint and the mistakes that a student reads."""

from __future__ import annotations

import builtins
import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import yaml

from grader.engine.conversation import THERE, Missing
from grader.engine.findings import Fault, Lost, Raised, Skipped
from grader.engine.lab import Lab
from grader.engine.results import Outcome
from grader.ground.errors import Crashed, Malformed, NoAnswer, TimedOut
from grader.ground.text import printable


@dataclass(frozen=True)
class Told:
    """What one check tells: `keeps` is the share of its points that is earned."""

    outcome: Outcome
    keeps: float
    message: str
    hint: str = ""
    mistakes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Mistake:
    """One entry of the catalogue: what the code does, how to go on, and an explanation for `imugrade explain`."""

    id: str
    group: str
    means: str
    hint: str
    explanation: str
    step: int | None
    wrong: str
    right: str


@functools.cache
def catalogue(lab: Lab) -> Mapping[str, Mistake]:
    """Every mistake of a lab that has a name, by id, read from the file that the handbook is made from."""
    loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    text = (lab.folder / "mistakes.yaml").read_text(encoding="utf-8")
    groups = yaml.load(text, Loader=loader)
    return {key: Mistake(key, group, **entry) for group, entries in groups.items() for key, entry in entries.items()}


def told(finding: BaseException, earlier: str | None, mistakes: Mapping[str, Mistake]) -> Told:
    """Words for what stopped a check.

    Parameters
    ----------
    finding : `Lost`, `Skipped`, `Raised`, `Missing` or a `NoAnswer`
    earlier : title of the check that has told the same story already, or None
    mistakes : the lab's catalogue
    """
    if isinstance(finding, Lost):
        return _lost(finding, mistakes)
    if isinstance(finding, Skipped):
        return Told("skipped", 0.0, f"Needs {finding}.")
    if earlier is not None:
        return Told("skipped", 0.0, f"Not reached: see “{earlier}”.")
    if isinstance(finding, Missing):
        return Told(
            "failed",
            0.0,
            f"Expected  {finding.name}\nGot       {finding}",
            mistakes[finding.mistake].hint,
            (finding.mistake,),
        )
    if isinstance(finding, Raised):
        return _raised(finding, mistakes)
    assert isinstance(finding, NoAnswer)
    return _no_answer(finding, mistakes)


def story(finding: BaseException, part: str) -> str | None:
    """What makes two findings the same story, told once; None for findings that always speak for themselves.

    A part's calls that do not end are one story, though each has less time than the one before.
    """
    if isinstance(finding, Lost | Skipped):
        return None
    if isinstance(finding, Missing):
        return f"Missing: {finding.name}: {finding}"
    if isinstance(finding, TimedOut):
        return f"TimedOut: {part}"
    return f"{type(finding).__name__}: {finding}"


def _lost(finding: Lost, mistakes: Mapping[str, Mistake]) -> Told:
    outcome: Outcome = "partial" if finding.keeps > 0 else "failed"
    message = f"Expected  {finding.expected}\nGot       {finding.got}"
    hint = finding.hint or " ".join(mistakes[m].hint for m in finding.mistakes)
    return Told(outcome, finding.keeps, message, hint, finding.mistakes)


def _raised(finding: Raised, mistakes: Mapping[str, Mistake]) -> Told:
    fault = finding.fault
    place = f" at {fault.where}" if fault.where else ""
    said = f"{_exception_name(fault)}: {printable(fault.message, 300)}"
    if fault.type == "ModuleNotFoundError":
        said += THERE
    lines = [f"Expected  no exception while {finding.doing}", f"Got       {said}{place}"]
    lines += [f"          {line}" for line in fault.lines]
    mistake = mistake_of(fault)
    return Told("error", 0.0, "\n".join(lines), mistakes[mistake].hint, (mistake,))


def _exception_name(fault: Fault) -> str:
    """The exception's type, if it is one that Python has; a type of the student's own could be named anything."""
    known = getattr(builtins, fault.type, None)
    return fault.type if isinstance(known, type) and issubclass(known, BaseException) else "an exception"


def mistake_of(fault: Fault) -> str:
    """The mistake that an exception shows: the sheet's *Common Errors* by what MuJoCo and NumPy say, else ``raises``."""
    said = fault.message.lower()
    if fault.type in ("KeyError", "ValueError") and ("invalid name" in said or "sensor" in said):
        return "sensor-not-found"
    if fault.type == "IndexError":
        return "index-out-of-bounds"
    if fault.type == "NotImplementedError":
        return "not-written"
    if fault.type == "ModuleNotFoundError":
        return "missing-package"
    return "raises"


def _no_answer(finding: NoAnswer, mistakes: Mapping[str, Mistake]) -> Told:
    if isinstance(finding, TimedOut):
        message = f"Expected  an answer within the time limit\nGot       none: {printable(str(finding), 200)}"
        return Told("timeout", 0.0, message, mistakes["never-returns"].hint, ("never-returns",))
    if isinstance(finding, Crashed):
        message = f"Expected  an answer\nGot       none: {printable(str(finding), 200)}"
        return Told("crashed", 0.0, message, mistakes["kills-its-process"].hint, ("kills-its-process",))
    assert isinstance(finding, Malformed)
    named = ("tampering",) if "the harness was changed" in str(finding) else ()
    message = "Expected  an answer\nGot       something that is not an answer to the question asked"
    return Told("crashed", 0.0, message, mistakes=named)


NOT_UNDERSTOOD = Told(
    "failed",
    0.0,
    "Expected  an answer as the lab sheet describes it\nGot       one that could not be understood",
    "Return plain arrays and numbers of the sheet's shapes; your instructor is told to look at it.",
)
"""Words for an answer that the judging stumbles over, although it takes those of sound code."""
