"""The words of a hidden run: kind and size of an error, and nothing that code could have chosen after it had seen hidden data.

They are made of our own sentences alone: those of this module, the catalogue's and those marked as `Ours`, and a power of ten. No
text, name, number, shape, line, file or exit code of the student's gets here, so there is nothing to scrub.
"""

from __future__ import annotations

from collections.abc import Mapping

from grader.engine.feedback import Told, mistake_of, no_answer
from grader.engine.findings import Lost, Ours, Raised, Skipped
from grader.engine.mistakes import Mistake
from grader.engine.results import Outcome
from grader.ground.errors import Crashed, NoAnswer, TimedOut

_TOLD_TYPES = (
    "IndexError",
    "KeyError",
    "TypeError",
    "ValueError",
    "AttributeError",
    "NameError",
    "ModuleNotFoundError",
)
_PUBLIC = "`imugrade check` shows the numbers of the public scenarios."


def told(finding: Lost | Skipped | Raised | NoAnswer, mistakes: Mapping[str, Mistake]) -> Told:
    """Words for what stopped a check."""
    if isinstance(finding, Lost):
        return _lost(finding, mistakes)
    if isinstance(finding, Skipped):
        return Told("skipped", 0.0, f"Needs {finding}.")
    if isinstance(finding, Raised):
        kind = finding.fault.type if finding.fault.type in _TOLD_TYPES else "an exception"
        if kind == "TypeError" and not finding.fault.line:
            kind += " in the call itself, before a line of yours ran: compare its parameters with the sheet's"
        id_ = mistake_of(finding.fault, mistakes)
        hint = f"{mistakes[id_].hint} {_PUBLIC}"
        return Told("error", 0.0, expected=f"no exception while {finding.doing}", got=kind, hint=hint, mistakes=(id_,))
    return _no_answer(finding, mistakes)


def _lost(finding: Lost, mistakes: Mapping[str, Mistake]) -> Told:
    outcome: Outcome = "partial" if finding.keeps > 0 else "failed"
    kinds = [mistakes[id_].means for id_ in finding.mistakes]
    got = "; ".join([*kinds, *([str(finding.off)] if finding.off else [])]) or "it does not"
    own = [finding.hint] if isinstance(finding.hint, Ours) else [mistakes[id_].hint for id_ in finding.mistakes]
    return Told(
        outcome,
        finding.keeps,
        expected="this to hold in the hidden scenarios, too",
        got=got,
        hint=" ".join(own) if finding.mistakes else " ".join([*own, _PUBLIC]),
        mistakes=finding.mistakes,
    )


def _no_answer(finding: NoAnswer, mistakes: Mapping[str, Mistake]) -> Told:
    if isinstance(finding, TimedOut):
        return no_answer("timeout", "", ("never-returns",), mistakes)
    named = ("kills-its-process",) if isinstance(finding, Crashed) else ()
    return no_answer("crashed", " that can be read", named, mistakes)
