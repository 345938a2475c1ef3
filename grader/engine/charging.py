"""Diagnosis and deductions of one criterion: which faults explain what deviates, and what each of them costs.

The rule: a row of the fault table lists every check of its criterion that the fault breaks, each with its share, and all of them
are deducted. A deviation that a found fault lists costs nothing more. A deviation that none lists is deducted at its own check.
A fault of the call, such as another parameter, is deducted at the checks that its row lists; it explains no wrong value there.
Shares on one check add up to at most one. Nothing is deducted in another criterion.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic, Protocol, TypeVar

from grader.base.errors import GraderError
from grader.engine.check_catalog import Check, title_of
from grader.engine.faults import FaultRow, rows
from grader.engine.findings import Charge, Charged, Cost, Deviation
from grader.engine.hypothesis import Reason, explain
from grader.engine.lab import Lab
from grader.engine.submission_session import SubmissionSession


class Measurement(Protocol):
    """Protocol of the facts that a criterion measures of a submission; its checks judge these facts alone."""

    @property
    def stopped(self) -> Mapping[str, Exception]:
        """The exceptions that kept properties from being measured, by the name of the check; the check ends with its exception."""


Facts = TypeVar("Facts", bound=Measurement)
Measure = Callable[[Facts], Deviation[Any] | None]
"""Returns how a property deviates from what its check asks, or None if it does not."""
Seen = Mapping[str, Deviation[Any]]
"""Deviations by property."""


@dataclass(frozen=True)
class Judge(Generic[Facts]):
    """Judge of one criterion: measures a submission, and decides for which faults its checks lose points.

    Attributes
    ----------
    measure : runs the student's code and returns the facts; it judges nothing
    reasons : the known faults, each with the property in which it shows
    others : functions of the facts that measure properties without a check of their own, such as other parameters, by name
    """

    lab: Lab
    id: str
    measure: Callable[[Any, Any], Facts]
    reasons: Sequence[Reason[Facts]]
    others: Mapping[str, Measure[Facts]] = field(default_factory=dict)
    checks: dict[str, tuple[Check, Measure[Facts]]] = field(default_factory=dict)

    def check(self, check_id: str, *, lab_step: int | None = None) -> Callable[[Measure[Facts]], Callable[..., None]]:
        """Return a decorator that makes a function of the facts a check for pytest; students read its docstring as the title."""

        def register(function: Measure[Facts]) -> Callable[..., None]:
            known = Check(check_id, title_of(function.__doc__ or ""), lab_step)
            self.checks[check_id] = known, function

            def run(student: SubmissionSession, truth: Any) -> None:
                # All checks of the criterion are judged together, once; this one raises its own charge.
                found = student.once((self.id, "judged"), lambda: self._judged(student, truth)).get(check_id)
                if found is not None:
                    raise found if isinstance(found, Exception) else Charged(found)

            functools.update_wrapper(run, function)
            del run.__wrapped__  # type: ignore[attr-defined] # or pytest would look for a fixture named `facts`
            run.check = known  # type: ignore[attr-defined]
            return run

        return register

    def _judged(self, student: SubmissionSession, truth: Any) -> Mapping[str, Charge | Exception]:
        """Measure the submission and return the charge, or the exception, of each check that is not passed."""
        return self.judge(self.measure(student, truth), rows(self.lab))

    def judge(self, facts: Facts, table: Mapping[str, FaultRow]) -> Mapping[str, Charge | Exception]:
        """Return the charge of each check that is not passed, or the exception that kept it from being judged.

        Raises
        ------
        GraderError
            If a check or a reason has no row in the fault table.
        """
        if lacking := {*self.checks, *(reason.cause for reason in self.reasons)} - table.keys():
            raise GraderError(f"the fault table has no row for {', '.join(sorted(lacking))}")
        stopped = {self._full(name): finding for name, finding in facts.stopped.items()}
        off: dict[str, Deviation[Any]] = {}
        for name, measure in {**{name: measure for name, (_, measure) in self.checks.items()}, **self.others}.items():
            try:
                found = None if name in stopped else measure(facts)
            except Exception as fault_of_ours:  # this check is not judged; the others are
                stopped[name] = fault_of_ours
            else:
                off |= {} if found is None else {name: found}
        return {**self._charges(off, self._faults(off, facts), table), **stopped}

    def _faults(self, off: Seen, facts: Facts) -> dict[str, Seen]:
        """Return the faults that explain the deviations, each with those in which it shows.

        A property has the cheapest of its faults that exclude each other, and all of those that hold beside others.
        """
        found: dict[str, dict[str, Deviation[Any]]] = {}
        for name in dict.fromkeys(self._full(reason.of) for reason in self.reasons):
            own = [reason for reason in self.reasons if name in off and self._full(reason.of) == name]
            cheapest = explain([reason for reason in own if not reason.beside], facts)
            beside = [reason for reason in own if reason.beside and reason.fits(facts)]
            for reason in [*([cheapest] if cheapest else []), *beside]:
                found.setdefault(reason.cause, {})[name] = off[name]
        return dict(found)

    def _charges(self, off: Seen, faults: dict[str, Seen], table: Mapping[str, FaultRow]) -> Mapping[str, Charge]:
        """Return what each check is charged: every share of every fault, and each deviation that no fault lists."""
        shares = {fault: self._shares(table[fault], seen) for fault, seen in faults.items()}
        explaining = [
            fault for fault, seen in faults.items() if table[fault].group != "any" or seen.keys() & self.checks
        ]
        for name in self.checks:
            if name in off and not any(name in shares[fault] for fault in explaining):
                explaining.append(name)
                faults[name] = {name: off[name]}
                shares[name] = self._shares(table[name], faults[name])
        charges: dict[str, Charge] = {}
        for fault, seen in faults.items():
            shown = next(iter(seen.values()))
            told_at = next((name for name in (*seen, *shares[fault]) if shares[fault].get(name)), "")
            for name, share in shares[fault].items():
                before = charges.get(name, Charge(name))
                see = self.checks[told_at][0].title if told_at not in ("", name) else ""
                if share:
                    cost = Cost(fault, share, seen.get(name, shown), off.get(name), see)
                    charges[name] = Charge(name, (*before.costs, cost))
                elif name in off:
                    charges[name] = replace(before, see=see)
        return charges

    def _shares(self, row: FaultRow, seen: Seen) -> Mapping[str, float]:
        """Return the share of points that a fault costs at each check of this criterion; 0 at one that only shows it.

        A row that lists no share costs what the checks say through which the fault was found.
        """
        of = self.id if row.group in (self.id, "checks") else row.group
        full = {name if "." in name else f"{of}.{name}": share for name, share in row.deducts.items()}
        listed = {name: share for name, share in full.items() if name in self.checks}
        if not any(listed.values()):
            listed |= {name: found.share for name, found in seen.items() if name in self.checks}
        affected = next(iter(seen.values())).affected
        return {name: share * (seen[name].affected if name in seen else affected) for name, share in listed.items()}

    def _full(self, name: str) -> str:
        """Return the full id of a check from its name in the criterion; the names in `others` stay as they are."""
        return name if name in self.others else f"{self.id}.{name}"
