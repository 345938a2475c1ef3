"""Feedback: turn a finding (the exception that ended a check) into the message, hint and fault ids that a student reads."""

from __future__ import annotations

import builtins
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

from grader.base.errors import Crashed, Malformed, NoAnswer, TimedOut
from grader.base.text import printable
from grader.engine.faults import FaultRow
from grader.engine.findings import (
    Charge,
    Charged,
    CheckFailed,
    Cost,
    Missing,
    Raised,
    Skipped,
    StudentError,
    Unusable,
    Where,
)
from grader.engine.load_report import not_handed_in
from grader.engine.results import Deducted, Outcome, message_of


@dataclass(frozen=True)
class Feedback:
    """Feedback to a student on one check: `keeps` is the share earned, `faults` has fault ids; other fields as in `CheckResult`."""

    outcome: Outcome
    keeps: float
    said: str = ""
    hint: str = ""
    faults: tuple[str, ...] = ()
    expected: str = ""
    got: str = ""
    where: Where | None = None
    not_understood: bool = False
    deducted: tuple[Deducted, ...] = ()

    @property
    def message(self) -> str:
        """The whole message: the sentence `said`, then the expected and the actual value, as far as there are any."""
        return message_of(self.said, self.expected, self.got)


def feedback_on(finding: BaseException, earlier: str | None, table: Mapping[str, FaultRow]) -> Feedback:
    """Return what a student reads about the exception that ended a check; it may quote values and text of the student's code.

    Parameters
    ----------
    finding : `Charged`, `CheckFailed`, `Skipped`, `Raised`, `Missing` or a `NoAnswer`, nothing else. Of hidden scenarios,
        only a `Missing` without hidden text or any that has an `earlier` check; `hidden_feedback.feedback_on` is for the rest
    earlier : title of an earlier check with the same cause (see `cause_key`), to which the feedback refers; None without one
    table : the entries of the lab's fault table
    """
    if isinstance(finding, Charged):
        return _feedback_on_charge(finding.charge, table)
    if isinstance(finding, Skipped):
        return Feedback("skipped", 0.0, f"Needs {finding}.")
    if earlier is not None:
        return not_reached(earlier)
    if isinstance(finding, CheckFailed):
        return _feedback_on_failure(finding, table)
    if isinstance(finding, Missing):
        return Feedback(
            "failed",
            0.0,
            expected=finding.name,
            got=str(finding),
            where=finding.where,
            hint=table[finding.fault].hint,
            faults=(finding.fault,),
        )
    if isinstance(finding, Raised):
        return _feedback_on_exception(finding, table)
    assert isinstance(finding, NoAnswer)
    return _feedback_on_no_answer(finding, table)


def cause_key(finding: BaseException, part: str) -> str | None:
    """Return a key that findings (exceptions that end checks) share if they have the same cause, so that one check reports it.

    None for a finding that each check reports for itself, such as `Charged`. `part` is the id of the criterion. All timeouts of
    a criterion share a key, although their messages differ: each call has less time than the one before.
    """
    if isinstance(finding, Unusable):
        return f"Unusable: {part}"
    if isinstance(finding, Charged | CheckFailed | Skipped):
        return None
    if isinstance(finding, Missing):
        return f"Missing: {finding.name}: {finding}"
    if isinstance(finding, TimedOut):
        return f"TimedOut: {part}"
    return f"{type(finding).__name__}: {finding}"


STEP_BY_STEP = "Compare this part of your code line by line with the step in the lab sheet."
"""Hint of a finding that names no fault."""


def not_reached(title: str) -> Feedback:
    """Return the feedback of a check that cannot be judged until the problem under the check with this `title` is fixed."""
    return Feedback("skipped", 0.0, f"Not graded until “{title}” is fixed.")


def no_more(charge: Charge) -> Feedback:
    """Return the feedback of a check that shows a fault and passes, as the check titled `charge.see` lost the points for it."""
    return Feedback("passed", 1.0, f"No further deduction: the same fault was deducted under “{charge.see}”.")


def _feedback_on_charge(charge: Charge, rows: Mapping[str, FaultRow]) -> Feedback:
    """Return the feedback on a check's deductions: the message of the first fault, and hints and public ids of all."""
    if not charge.costs:
        return no_more(charge)
    deducted = tuple(_deducted(charge.check, cost, rows) for cost in charge.costs)
    first, see = deducted[0], charge.costs[0].see
    places = [cost.shown.error.at for cost in charge.costs if cost.shown.error]
    return Feedback(
        "partial" if charge.keeps else "failed",
        charge.keeps,
        first.said or (f"Broken by the same fault as “{see}”." if not first.expected else ""),
        expected=first.expected,
        got=first.got,
        where=next(iter(places), None),
        hint=hint_of(charge, rows),
        faults=public(charge, rows),
        deducted=deducted,
    )


def _deducted(check: str, cost: Cost, rows: Mapping[str, FaultRow]) -> Deducted:
    """Return one fault's deduction at a check with its text: the template of the fault's entry, else that of the check's entry.

    A template that the measured numbers cannot fill is left out. Without a text the fault's title is the sentence, but only at the
    check that reports the fault (`cost.see` is "").
    """
    told = Deducted(cost.row, cost.share, rows[cost.row].hint)
    known = ((rows[cost.row], cost.shown), (rows[check], cost.own))
    for row, deviation in known:
        if row.expected and deviation is not None:
            with suppress(LookupError, ValueError, TypeError):
                numbers = deviation.numbers
                return replace(told, expected=row.expected.format_map(numbers), got=row.got.format_map(numbers))
    title = rows[cost.row].title or "this does not hold"
    return told if cost.see else replace(told, said=f"{title[:1].upper()}{title[1:]}.")


def hint_of(charge: Charge, rows: Mapping[str, FaultRow]) -> str:
    """Return as one text the hints that the fault table `rows` has for a check's deductions, each hint once."""
    return " ".join(dict.fromkeys(rows[cost.row].hint for cost in charge.costs))


def public(charge: Charge, rows: Mapping[str, FaultRow]) -> tuple[str, ...]:
    """Return the ids in a check's deductions for `Feedback.faults`: faults with an `explanation` in `rows`, no check's own id."""
    return tuple(cost.row for cost in charge.costs if rows[cost.row].explanation)


def _feedback_on_failure(finding: CheckFailed, table: Mapping[str, FaultRow]) -> Feedback:
    """Return the feedback on a `CheckFailed`, which checks raise that have no `charging.Judge`, such as an instructor's own."""
    outcome: Outcome = "partial" if finding.keeps > 0 else "failed"
    hint = finding.hint or " ".join(table[m].hint for m in finding.faults) or STEP_BY_STEP
    return Feedback(
        outcome,
        finding.keeps,
        expected=finding.expected,
        got=finding.got,
        where=finding.where,
        hint=hint,
        faults=finding.faults,
    )


def _feedback_on_exception(finding: Raised, table: Mapping[str, FaultRow]) -> Feedback:
    """Return the feedback on an exception of the student's code: its message, place and source line, and a hint."""
    error = finding.error
    place = f" at {error.where}" if error.where else ""
    said = f"{_exception_name(error)}: {printable(error.message, 300)}"
    said += not_handed_in(error)
    fault = fault_of(error, table)
    return Feedback(
        "error",
        0.0,
        expected=f"no exception while {finding.doing}",
        got="\n".join([f"{said}{place}", *error.lines]),
        where=error.at,
        hint=table[fault].hint,
        faults=(fault,),
    )


def _exception_name(error: StudentError) -> str:
    """Return the name of a built-in exception type, else "an exception": the name of a student's own type may be any text."""
    known = getattr(builtins, error.type, None)
    return error.type if isinstance(known, type) and issubclass(known, BaseException) else "an exception"


def fault_of(error: StudentError, table: Mapping[str, FaultRow]) -> str:
    """Return the id of the fault that an exception of the student's code shows, to find its hint in the fault table.

    It is ``missing-package`` for a ModuleNotFoundError, else the first in the table whose rules on type, missing name and source
    line all hold (`FaultRow.shown_by`), ``raises`` if there is none.
    """
    if error.type == "ModuleNotFoundError":
        return "missing-package"
    return next((id_ for id_, each in table.items() if each.shown_by(error)), "raises")


def _feedback_on_no_answer(finding: NoAnswer, table: Mapping[str, FaultRow]) -> Feedback:
    """Return the feedback on a question to student code that timed out, crashed or gave no valid answer."""
    if isinstance(finding, TimedOut):
        return no_answer("timeout", f"none: {printable(str(finding), 200)}", ("never-returns",), table)
    if isinstance(finding, Crashed):
        return no_answer("crashed", f"none: {printable(str(finding), 200)}", ("kills-its-process",), table)
    assert isinstance(finding, Malformed)
    told = no_answer("crashed", "an answer that the grader cannot read", (), table)
    tampers = "the worker code was changed" in str(finding)
    return replace(told, faults=("tampering",), not_understood=False) if tampers else told


def no_answer(outcome: Outcome, got: str, named: tuple[str, ...], table: Mapping[str, FaultRow]) -> Feedback:
    """Return the feedback on a check whose call of student code got no usable answer; the check earns nothing.

    `outcome` (such as "timeout") and the text `got` say what came instead. The hints are those that `table` has for the fault ids
    in `named`. If `named` is empty, the hint is to return plain arrays and numbers, and a person reviews the answer, as for
    `NOT_UNDERSTOOD`.
    """
    expected = "an answer within the time limit" if outcome == "timeout" else "an answer"
    hint = " ".join(table[id_].hint for id_ in named) or NOT_UNDERSTOOD.hint
    return Feedback(outcome, 0.0, expected=expected, got=got, hint=hint, faults=named, not_understood=not named)


NOT_UNDERSTOOD = Feedback(
    "failed",
    0.0,
    expected="an answer as the lab sheet describes it",
    got="an answer that the grader cannot read",
    hint="Return plain arrays and numbers with the sheet's shapes. A note asks your instructor to look at it.",
    not_understood=True,
)
"""Feedback for an answer on which a check raised an unexpected exception, although it can judge sound code."""
