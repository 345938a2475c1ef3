"""The words: from a finding to the message, the hint and the mistakes that a student reads."""

from __future__ import annotations

import builtins
import functools
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from .answers import Fault
from .conversation import Missing
from .errors import Crashed, Malformed, NoAnswer, TimedOut
from .results import Outcome
from .text import printable
from .verdicts import Lost, Raised, Skipped


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
def catalogue() -> Mapping[str, Mistake]:
    """Every mistake that has a name, by id, read from the file that the handbook is made from."""
    loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    text = (Path(__file__).parent / "data" / "mistakes.yaml").read_text(encoding="utf-8")
    groups = yaml.load(text, Loader=loader)
    return {key: Mistake(key, group, **entry) for group, entries in groups.items() for key, entry in entries.items()}


def told(finding: BaseException, earlier: str | None, *, hidden: bool) -> Told:
    """Words for what stopped a check.

    Parameters
    ----------
    finding : `Lost`, `Skipped`, `Raised`, `Missing` or a `NoAnswer`
    earlier : title of the check that has told the same story already, or None
    hidden : whether the scenario is hidden: then the size and the kind of the error are told, never data, and no text that
        came out of a process that has seen the data
    """
    if isinstance(finding, Lost):
        return _lost(finding, hidden=hidden)
    if isinstance(finding, Skipped):
        return Told("skipped", 0.0, f"Needs {finding}.")
    if earlier is not None:
        return Told("skipped", 0.0, f"Not reached: see “{earlier}”.")
    if isinstance(finding, Missing):
        return Told(
            "failed", 0.0, f"Expected  {finding.name}\nGot       {finding}", _hint(finding.mistake), (finding.mistake,)
        )
    if isinstance(finding, Raised):
        return _raised(finding, hidden=hidden)
    assert isinstance(finding, NoAnswer)
    return _no_answer(finding)


def story(finding: BaseException) -> str | None:
    """What makes two findings the same story, told once; None for findings that always speak for themselves."""
    if isinstance(finding, Lost | Skipped):
        return None
    return f"{type(finding).__name__}: {finding}"


_VECTOR = re.compile(r"\[[-+\d.e\s…]*\]")
_QUOTED = re.compile(r"“[^”]*”|'[^']*'|\"[^\"]*\"")
_TYPE = re.compile(r"of type .*", re.DOTALL)


def _without_data(text: str) -> str:
    """A sentence without vectors and without words of the student's, which could carry them."""
    return _TYPE.sub("of another type", _QUOTED.sub("“…”", _VECTOR.sub("[hidden]", text)))


def _lost(finding: Lost, *, hidden: bool) -> Told:
    outcome: Outcome = "partial" if finding.keeps > 0 else "failed"
    expected, got = finding.expected, finding.got
    if hidden:
        expected, got = _without_data(expected), finding.off or _without_data(got)
    message = f"Expected  {expected}\nGot       {got}"
    hint = finding.hint or " ".join(_hint(m) for m in finding.mistakes)
    return Told(outcome, finding.keeps, message, hint, finding.mistakes)


def _raised(finding: Raised, *, hidden: bool) -> Told:
    fault = finding.fault
    place = f" at {fault.where}" if fault.where else ""
    said = f"{_exception_name(fault)}: {printable(fault.message, 300)}"
    if hidden:
        said, place = _exception_name(fault), f" at line {fault.line}" if fault.line else ""
        if fault.type == "TypeError" and not fault.line:
            said += " in the call itself, before a line of yours ran: compare its parameters with the sheet's"
    lines = [f"Expected  no exception while {finding.doing}", f"Got       {said}{place}"]
    if fault.text and not hidden:
        lines.append(f"          {printable(fault.text, 160)}")
    mistake = mistake_of(fault)
    return Told("error", 0.0, "\n".join(lines), _hint(mistake), (mistake,))


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
    return "raises"


def _no_answer(finding: NoAnswer) -> Told:
    if isinstance(finding, TimedOut):
        message = f"Expected  an answer within the time limit\nGot       none: {printable(str(finding), 200)}"
        return Told("timeout", 0.0, message, _hint("never-returns"), ("never-returns",))
    if isinstance(finding, Crashed):
        message = f"Expected  an answer\nGot       none: {printable(str(finding), 200)}"
        return Told("crashed", 0.0, message, _hint("kills-its-process"), ("kills-its-process",))
    assert isinstance(finding, Malformed)
    mistakes = ("tampering",) if "the harness was changed" in str(finding) else ()
    message = "Expected  an answer\nGot       something that is not an answer to the question asked"
    return Told("crashed", 0.0, message, mistakes=mistakes)


def _hint(mistake: str) -> str:
    return catalogue()[mistake].hint
