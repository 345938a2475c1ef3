"""Diagnosis and deductions of one criterion: which known faults explain the deviations, and how many points each fault costs.

The rule: an entry of the fault table lists every check of its criterion that the fault breaks, each with its share of points. All
these shares are deducted. A deviation at a check that a found fault lists costs nothing more, any other is deducted at its own
check. A fault of the call, such as parameters other than the lab sheet's, explains no deviation: one at a check that its entry
lists is deducted as well. Shares on one check add up to at most one. Nothing is deducted in another criterion.
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
    """Protocol of the record that `Judge.measure` makes of what student code did; the checks of the criterion see nothing else."""

    @property
    def stopped(self) -> Mapping[str, Exception]:
        """Exceptions that end checks whose property could not be measured, by short name (``passes_constant``); {} if none."""


Facts = TypeVar("Facts", bound=Measurement)
Measure = Callable[[Facts], Deviation[Any] | None]
"""Returns how a property deviates from what its check asks, or None if it does not."""
Seen = Mapping[str, Deviation[Any]]
"""Deviations by property."""


@dataclass(frozen=True)
class Judge(Generic[Facts]):
    """Judge of one criterion: measures a submission once, finds the faults, and divides their deductions among the checks.

    A lab makes one `Judge` for each criterion or extension. A *property* is what one check looks at in the measured record.

    Attributes
    ----------
    id : id of the criterion or extension
    measure : runs the student's code and returns the record of what it did; it judges nothing
    reasons : the known faults of this criterion, each with the property in which it shows
    others : by name, functions that look at further properties; no check judges these, but a fault may show in one
    checks : the checks by id, each with the function that looks at its property; the decorator `check` adds them
    """

    lab: Lab
    id: str
    measure: Callable[[Any, Any], Facts]
    reasons: Sequence[Reason[Facts]]
    others: Mapping[str, Measure[Facts]] = field(default_factory=dict)
    checks: dict[str, tuple[Check, Measure[Facts]]] = field(default_factory=dict)

    def check(self, check_id: str, *, lab_step: int | None = None) -> Callable[[Measure[Facts]], Callable[..., None]]:
        """Return a decorator that makes a function a check of this criterion, and replaces it by a test that pytest can run.

        The function gets the measured record and returns a `Deviation`, or None if all is right. Students read its docstring as the
        title of the check. Step `lab_step` of the lab sheet teaches what it checks; None if no single step does.
        """

        def register(function: Measure[Facts]) -> Callable[..., None]:
            known = Check(check_id, title_of(function.__doc__ or ""), lab_step)
            self.checks[check_id] = known, function

            def run(student: SubmissionSession, truth: Any) -> None:
                # All checks of the criterion are judged together, once; this one raises its own charge.
                found = student.once((self.id, "judged"), lambda: self._measure_and_judge(student, truth)).get(check_id)
                if found is not None:
                    raise found if isinstance(found, Exception) else Charged(found)

            functools.update_wrapper(run, function)
            del run.__wrapped__  # type: ignore[attr-defined] # or pytest would look for a fixture named `facts`
            run.check = known  # type: ignore[attr-defined]
            return run

        return register

    def _measure_and_judge(self, student: SubmissionSession, truth: Any) -> Mapping[str, Charge | Exception]:
        """Measure a submission; return the deductions of each check that is not passed, or the exception that ended the check."""
        return self.judge(self.measure(student, truth), rows(self.lab))

    def judge(self, facts: Facts, table: Mapping[str, FaultRow]) -> Mapping[str, Charge | Exception]:
        """Return by check id the deductions of each check that loses points or shows a fault, or the exception that ended it.

        `facts` is the measured record, `table` the lab's fault table by id (see `faults.rows`). Other checks are left out.

        Raises
        ------
        GraderError
            If a check or a known fault of this criterion has no entry in the table.
        """
        if lacking := {*self.checks, *(reason.cause for reason in self.reasons)} - table.keys():
            raise GraderError(f"the fault table has no row for {', '.join(sorted(lacking))}")
        stopped = {self._full_id(name): finding for name, finding in facts.stopped.items()}
        off: dict[str, Deviation[Any]] = {}
        for name, measure in {**{name: measure for name, (_, measure) in self.checks.items()}, **self.others}.items():
            try:
                found = None if name in stopped else measure(facts)
            except Exception as fault_of_ours:  # this check is not judged; the others are
                stopped[name] = fault_of_ours
            else:
                off |= {} if found is None else {name: found}
        return {**self._deductions(off, self._find_faults(off, facts), table), **stopped}

    def _find_faults(self, off: Seen, facts: Facts) -> dict[str, Seen]:
        """Return by id the faults that explain the deviations `off`, each with the deviations in which it shows.

        Of a property's faults that exclude each other only the cheapest that fits counts, and none if two of that cost fit. A fault
        that may hold beside others (`Reason.beside`) counts whenever it fits.
        """
        found: dict[str, dict[str, Deviation[Any]]] = {}
        for name in dict.fromkeys(self._full_id(reason.of) for reason in self.reasons):
            own = [reason for reason in self.reasons if name in off and self._full_id(reason.of) == name]
            cheapest = explain([reason for reason in own if not reason.beside], facts)
            beside = [reason for reason in own if reason.beside and reason.fits(facts)]
            for reason in [*([cheapest] if cheapest else []), *beside]:
                found.setdefault(reason.cause, {})[name] = off[name]
        return dict(found)

    def _deductions(self, off: Seen, faults: dict[str, Seen], table: Mapping[str, FaultRow]) -> Mapping[str, Charge]:
        """Return the deductions of each check: shares of the faults that list it, or its own deviation if no fault explains it.

        `off` holds all deviations. A deviation that no fault lists is added to `faults`, with the check's id as the id of its
        fault.
        """
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
        """Return by check id the share of points that a fault costs in this criterion; 0 at a check that only shows the fault.

        `row` is the fault's entry in the table, `seen` the deviations in which the fault shows. If the entry lists no share, each
        of these deviations says what it costs, but where the entry lists a 0. A share is multiplied by the affected fraction.
        """
        of = self.id if row.group in (self.id, "checks") else row.group
        full = {name if "." in name else f"{of}.{name}": share for name, share in row.deducts.items()}
        listed = {name: share for name, share in full.items() if name in self.checks}
        if not any(listed.values()):
            listed = {name: found.share for name, found in seen.items() if name in self.checks} | listed
        affected = next(iter(seen.values())).affected
        return {name: share * (seen[name].affected if name in seen else affected) for name, share in listed.items()}

    def _full_id(self, name: str) -> str:
        """Return a check's full id (``filtering.passes_constant``) from its short name; names in `others` stay as they are."""
        return name if name in self.others else f"{self.id}.{name}"
