"""Diagnosis and deductions of one criterion: find the fault behind each deviation, and charge it to a check once.

A check returns how its measured property deviates, or None. Each property is explained by its own cheapest reason that fits. A
property without one may be predicted by the reason found for another property. A deviation that nothing explains is charged to
its check with that check's own row. A fault deducts once, however many checks see it.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, Protocol, TypeVar

from grader.engine.check_catalog import Check, title_of
from grader.engine.faults import Mistake, rows
from grader.engine.findings import Charge, Charged, Deviation
from grader.engine.hypothesis import Reason, explain
from grader.engine.lab import Lab
from grader.engine.submission_session import SubmissionSession


class Measurement(Protocol):
    """The facts of one criterion."""

    @property
    def stopped(self) -> Mapping[str, Exception]:
        """The findings that kept a property from being measured, by check."""


Facts = TypeVar("Facts", bound=Measurement)
Measure = Callable[[Facts], Deviation | None]
"""Returns how a property deviates from what its check asks, or None if it does not."""


@dataclass(frozen=True)
class Part(Generic[Facts]):
    """Judging rules of one criterion: its measurement, its checks and its known faults.

    Attributes
    ----------
    measure : runs the student's code and returns the facts; it judges nothing
    reasons : the known faults, each with the property that it explains; the reasons of one property are adjacent
    others : properties that no check measures, by name
    together : ids of faults that do not exclude each other: all that fit are named, and only the cheapest deducts
    only_names : if True, a fault deducts nothing by itself: each check loses its own share and names the fault
    """

    lab: Lab
    id: str
    measure: Callable[[Any, Any], Facts]
    reasons: Sequence[Reason[Facts]]
    others: Mapping[str, Measure[Facts]] = field(default_factory=dict)
    checks: dict[str, tuple[Check, Measure[Facts]]] = field(default_factory=dict)
    together: frozenset[str] = frozenset()
    only_names: bool = False

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

    def judge(self, facts: Facts, table: Mapping[str, Mistake]) -> Mapping[str, Charge | Exception]:
        """Return the charge of each check that is not passed, or the exception that kept it from being judged."""
        stopped = {self._full(name): finding for name, finding in facts.stopped.items()}
        off: dict[str, Deviation] = {}
        for name, measure in {**{name: measure for name, (_, measure) in self.checks.items()}, **self.others}.items():
            try:
                found = None if name in stopped else measure(facts)
            except Exception as fault_of_ours:  # this check is not judged; the others are
                stopped[name] = fault_of_ours
            else:
                off |= {} if found is None else {name: found}
        reasons = self._reasons(off, facts)
        charges = self._charged(off, reasons, table, stopped)
        return {**stopped, **{name: self._with_others(charge, facts) for name, charge in charges.items()}}

    def _with_others(self, charge: Charge, facts: Facts) -> Charge:
        """Add the other faults of `together` that fit to a charge for one of them; they deduct nothing more."""
        named = {row for row, _ in charge.found}
        if self.together.isdisjoint(named):
            return charge
        own = [r for r in self.reasons if self._full(r.of) == charge.check and r.cause in self.together - named]
        for row in dict.fromkeys(each.cause for each in own if each.fits(facts)):
            charge = charge.plus(row, 0.0, charge.found[0][1])
        return charge

    def _reasons(self, off: Mapping[str, Deviation], facts: Facts) -> dict[str, Reason[Facts]]:
        """Return the reason for each deviating property that has reasons of its own.

        If the reasons that fit best disagree, or none fits, the general reason (the one named as the property) is returned.
        Properties are in the order of `reasons`: a fault is charged to the first of them that shows it.
        """
        found: dict[str, Reason[Facts]] = {}
        order = list(dict.fromkeys(self._full(reason.of) for reason in self.reasons))
        for name in sorted(set(off).intersection(order), key=order.index):
            own = [reason for reason in self.reasons if self._full(reason.of) == name]
            general = [reason for reason in own if reason.cause == name]
            if (reason := explain(own, facts) or next(iter(general), None)) is not None:
                found[name] = reason
        return found

    def _charged(
        self,
        off: Mapping[str, Deviation],
        reasons: Mapping[str, Reason[Facts]],
        table: Mapping[str, Mistake],
        stopped: Collection[str],
    ) -> Mapping[str, Charge]:
        """Return the charge of each deviating check: to the fault that explains it, once, or to the check itself."""
        at: dict[str, str] = {}  # fault -> the check that charges it
        charges: dict[str, Charge] = {}
        taken: dict[str, str] = {}
        for name, reason in reasons.items():
            if reason.cause in at and not self.only_names:
                continue
            row = table[reason.cause]
            deducts = {name: off[name].share} if self.only_names else self._deducts(row) or {name: 1.0}
            place = name if name in deducts else next((each for each in deducts if each in off), next(iter(deducts)))
            if place in stopped:
                continue
            at[reason.cause] = place
            before = charges.get(place, Charge(place, 1.0))
            seen = off[name] if name in self.others else off.get(place, off[name])
            charges[place] = before.plus(reason.cause, deducts[place] * seen.affected, seen)
            taken |= dict.fromkeys(map(self._full, {*row.takes, *reason.takes}), place)
        charges |= {name: Charge(name, 0.0, see=self._title(place)) for name, place in taken.items()}
        for name in [name for name in off if name in self.checks and name not in charges]:
            place = self._seen_elsewhere(name, reasons, at)
            charges[name] = Charge(name, 1.0, see=self._title(place)) if place else Charge.of(name, off[name])
        return charges

    def _seen_elsewhere(self, name: str, reasons: Mapping[str, Reason[Facts]], at: Mapping[str, str]) -> str:
        """Return the check that is already charged for the deviation that this check sees too; "" if there is none.

        A fault that belongs to a stopped check is charged nowhere.
        """
        predicting = [each for each in reasons.values() if name in map(self._full, each.predicts)]
        causes = [reasons[name].cause] if name in reasons else [each.cause for each in predicting]
        return next((at[cause] for cause in causes if cause in at), "")

    def _deducts(self, row: Mistake) -> Mapping[str, float]:
        """Return the share of points that a fault deducts from each check of this criterion."""
        group = row.group if row.group == self.id else ""
        shares = {name if "." in name else f"{group}.{name}": share for name, share in row.deducts.items()}
        return {name: share for name, share in shares.items() if name in self.checks}

    def _full(self, name: str) -> str:
        """Return the full id of a check from its name in the criterion; the names in `others` stay as they are."""
        return name if name in self.others else f"{self.id}.{name}"

    def _title(self, check_id: str) -> str:
        return self.checks[check_id][0].title
