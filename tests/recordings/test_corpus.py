"""The corpus, judged from recordings: a row of each third fault on every change, each fault before a merge, all rows each week."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterator

import pytest

from tests.recordings.losses import disagreements, pinned, pins
from tests.recordings.marker import recorded_corpus, verdict
from tests.scoreboard import Case

pytestmark = [pytest.mark.recorded]
FAULTY = ("faulty", "lookalikes", "pairs")
_FAULTS, _EVERYDAY, _QUICK, _SLOW = 3, 16, 3, 4
"""One of so many faults is judged without `-m slow`; of the rows without a fault; of both, with `-m quick`; of those rows, with `-m slow`."""


def _rows() -> Iterator[object]:
    """Yield each case, marked by the shortest run that judges it.

    Every day: the first row of each third fault. With `-m slow`: the first row of each fault and of the checks that it costs, since a row that
    repeats both is another way to write the same. Each week: all.
    """
    seen = Counter[Hashable]()
    for case in recorded_corpus():
        fault = case.fault or tuple(case.faults or ())
        kinds = [(case.criterion, fault), (case.criterion, fault, case.loses)] if fault else []
        first, other = (seen[kind] == 0 for kind in kinds) if fault else _nth(seen[case.part])
        if first and fault:
            seen["faults"] += 1
            first = seen["faults"] % _FAULTS == 0 and case.part not in ("lookalikes", "pairs")
        seen.update([case.part, *kinds] if fault else [case.part])
        if first:
            seen["everyday"] += 1
        quick = first and seen["everyday"] % _QUICK == 0
        marks = (
            ([pytest.mark.quick] if quick else []) if first else [pytest.mark.slow] if other else [pytest.mark.weekly]
        )
        yield pytest.param(case, marks=marks, id=case.id)


def _nth(number: int) -> tuple[bool, bool]:
    return number % _EVERYDAY == 0, number % _SLOW == 0


@pytest.mark.parametrize("case", list(_rows()))
def test_a_case_is_judged_as_the_corpus_says(case: Case) -> None:
    assert disagreements(verdict(case)) == []


def test_the_corpus_is_as_large_as_it_was() -> None:
    parts = Counter(case.part for case in recorded_corpus())
    assert parts["sound"] >= 150
    assert sum(parts[part] for part in FAULTY) >= 350
    assert parts["broken"] >= 150
    assert parts["extensions"] >= 50


@pytest.mark.quick
def test_losses_are_pinned_of_cases_that_there_are() -> None:
    assert set(pinned()) <= {case.id for case in recorded_corpus() if pins(case)}
