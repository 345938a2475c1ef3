"""The corpus, judged from recordings: on every change a row of each fault that no made-up student shows, of each fault before a merge, all rows each week."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterator
from typing import Any

import pytest

from grader.engine.faults import catalogue
from grader.labs.imu.lab import LAB
from tests.judging.fake_students import faults_shown
from tests.recordings.losses import disagreements, pinned, pins
from tests.recordings.marker import recorded_corpus, verdict
from tests.scoreboard import Case

pytestmark = [pytest.mark.recorded]
FAULTY = ("faulty", "lookalikes", "pairs")
_EVERYDAY, _QUICK, _SLOW = 17, 3, 8
"""One of so many rows without a fault is judged without `-m slow`; of all that are, with `-m quick`; of rows without a fault, with `-m slow`."""


def _rows() -> Iterator[Any]:
    """Yield each case, marked by the shortest run that judges it.

    Every day: the first row of each fault that `tests/judging` does not show by a made-up student. With `-m slow`: the first row of each fault
    and of the checks that it costs, since a row that repeats both is another way to write the same. Each week: all.
    """
    seen, shown = Counter[Hashable](), faults_shown()
    for case in recorded_corpus():
        fault = case.fault or tuple(case.faults or ())
        kinds = [fault, (case.criterion, fault, case.loses)] if fault else []
        first, other = (seen[kind] == 0 for kind in kinds) if fault else _nth(seen[case.part])
        if fault:
            first = first and case.part not in ("lookalikes", "pairs") and fault not in shown
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


ROWS = list(_rows())


@pytest.mark.parametrize("case", ROWS)
def test_a_case_is_judged_as_the_corpus_says(case: Case) -> None:
    assert disagreements(verdict(case)) == []


@pytest.mark.quick
def test_every_fault_is_shown_without_the_slow_tests() -> None:
    everyday = [row.values[0] for row in ROWS if not {mark.name for mark in row.marks} & {"slow", "weekly"}]
    judged = {name for case in everyday for name in (case.fault, *case.also)}
    assert set(catalogue(LAB)) - faults_shown() - judged == set()


def test_the_corpus_is_as_large_as_it_was() -> None:
    parts = Counter(case.part for case in recorded_corpus())
    assert parts["sound"] >= 150
    assert sum(parts[part] for part in FAULTY) >= 350
    assert parts["broken"] >= 150
    assert parts["extensions"] >= 50


@pytest.mark.quick
def test_losses_are_pinned_of_cases_that_there_are() -> None:
    assert set(pinned()) <= {case.id for case in recorded_corpus() if pins(case)}
