"""Feedback on hidden scenarios: kind and size of an error, but nothing that student code could choose after seeing hidden data.

Hidden scenarios are recorded from a secret text of the instructor's. The process that runs student code gets hidden data together
with the student's files, before any of that code runs. So feedback consists of constants of the grader's code (in this module, in
the fault table, and `GraderText`) and a size in three steps. It holds no text, name, number, shape, line, file or exit code of the
student's. Messages about loading a file come from a second process with public data, see `public_session`.
"""

from __future__ import annotations

from collections.abc import Mapping

from grader.base.errors import Crashed, NoAnswer, TimedOut
from grader.engine import feedback
from grader.engine.faults import FaultRow
from grader.engine.feedback import Feedback, fault_of, hint_of, no_answer, no_more, public
from grader.engine.findings import Charge, Charged, CheckFailed, Cost, GraderText, Missing, Raised, Skipped
from grader.engine.results import Deducted, Outcome

_TOLD_TYPES = (
    "IndexError", "KeyError", "TypeError", "ValueError", "AttributeError", "NameError", "ModuleNotFoundError",
)  # fmt: skip
_PUBLIC_LOAD = "`imugrade check` loads the file with public data and tells more."
_HOLDS, _DOES_NOT = "the same result on the hidden scenarios", "a different result"
_PUBLIC = "`imugrade check` shows the numbers of the public scenarios."


def feedback_on(
    finding: Charged | CheckFailed | Skipped | Raised | NoAnswer, table: Mapping[str, FaultRow]
) -> Feedback:
    """Return what a student reads about the exception that ended a check on hidden scenarios: kind and size of the error alone.

    `table` is the lab's fault table, by id; the titles and hints come from it.
    """
    if isinstance(finding, Charged):
        return _feedback_on_charge(finding.charge, table)
    if isinstance(finding, CheckFailed):
        return _feedback_on_failure(finding, table)
    if isinstance(finding, Skipped):
        return Feedback("skipped", 0.0, f"Needs {finding}.")
    if isinstance(finding, Raised):
        kind = _kind(finding)
        if kind == "TypeError" and not finding.error.line:
            kind += " in the call itself, before a line of yours ran: compare its parameters with the sheet's"
        id_ = fault_of(finding.error, table)
        hint = f"{table[id_].hint} {_PUBLIC}"
        return Feedback(
            "error", 0.0, expected=f"no exception while {finding.doing}", got=kind, hint=hint, faults=(id_,)
        )
    return _feedback_on_no_answer(finding, table)


def cause_key(finding: BaseException, part: str) -> str | None:
    """Return a key that findings (exceptions that end checks) share if they have one cause, as `feedback.cause_key` does.

    None for a finding that each check reports for itself. The key holds no hidden data. `part` is the id of the criterion.
    """
    if isinstance(finding, Raised):
        return f"Raised: {part}: {_kind(finding)}"
    if isinstance(finding, NoAnswer):
        return f"{type(finding).__name__}: {part}"
    return feedback.cause_key(finding, part)


def missing(finding: Missing, public: Missing | None) -> Missing:
    """Return a `Missing` to show in place of `finding`, whose text may hold hidden data: `public`, or one with a constant message.

    `public` is the same finding with public data, None if there is none.
    """
    if public is not None:
        return public
    return Missing(finding.name, finding.fault, f"no definition of {finding.name} beside hidden data; {_PUBLIC_LOAD}")


def _kind(finding: Raised) -> str:
    return finding.error.type if finding.error.type in _TOLD_TYPES else "an exception"


def _feedback_on_failure(finding: CheckFailed, table: Mapping[str, FaultRow]) -> Feedback:
    """Return the feedback on a `CheckFailed`: the titles of its faults, or the size of the error if it names no fault."""
    outcome: Outcome = "partial" if finding.keeps > 0 else "failed"
    kinds = [table[id_].title for id_ in finding.faults]
    got = "; ".join(kinds) or str(finding.off or _DOES_NOT)
    own = [finding.hint] if isinstance(finding.hint, GraderText) else [table[id_].hint for id_ in finding.faults]
    return Feedback(
        outcome,
        finding.keeps,
        expected=_HOLDS,
        got=got,
        hint=" ".join(own) if finding.faults else " ".join([*own, _PUBLIC]),
        faults=finding.faults,
    )


def _feedback_on_charge(charge: Charge, rows: Mapping[str, FaultRow]) -> Feedback:
    """Return the feedback on a check's deductions: titles and hints of the faults, and sizes of errors in place of numbers."""
    if not charge.costs:
        return no_more(charge)
    sizes = [size for cost in charge.costs if (size := _size(cost, rows))]
    titles = [rows[cost.row].title for cost in charge.costs if rows[cost.row].title]
    names = public(charge, rows)
    deducted = tuple(_deducted(cost, rows) for cost in charge.costs)
    return Feedback(
        "partial" if charge.keeps else "failed",
        charge.keeps,
        expected=_HOLDS,
        got="; ".join([*titles, *dict.fromkeys(sizes)]) or _DOES_NOT,
        hint=hint_of(charge, rows) if names else f"{hint_of(charge, rows)} {_PUBLIC}",
        faults=names,
        deducted=deducted,
    )


def _deducted(cost: Cost, rows: Mapping[str, FaultRow]) -> Deducted:
    row = rows[cost.row]
    got = "; ".join(filter(None, [row.title, _size(cost, rows)])) or _DOES_NOT
    return Deducted(cost.row, cost.share, row.hint if row.explanation else f"{row.hint} {_PUBLIC}", "", _HOLDS, got)


def _size(cost: Cost, rows: Mapping[str, FaultRow]) -> str:
    """Return the size of an error; "" if none, or for a fault with an explanation: code could choose the size to reveal data."""
    return str(cost.shown.size) if cost.shown.size and not rows[cost.row].explanation else ""


def _feedback_on_no_answer(finding: NoAnswer, table: Mapping[str, FaultRow]) -> Feedback:
    if isinstance(finding, TimedOut):
        return no_answer("timeout", "no answer in time", ("never-returns",), table)
    if isinstance(finding, Crashed):
        return no_answer("crashed", "no answer, because the process ended", ("kills-its-process",), table)
    return no_answer("crashed", "an answer that the grader cannot read", (), table)
