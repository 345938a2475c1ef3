"""The corpus, judged from recordings: on every change a row of each fault, all rows each week."""

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

    Without `-m slow`: the first row of each fault that `tests/judging` does not show by a made-up student. With it: the first row of each fault.
    Each week: all; what repeats a fault is another way to write it, or breaks less.
    """
    seen, shown = Counter[Hashable](), faults_shown()
    for case in recorded_corpus():
        kind = case.fault or tuple(case.faults or ()) or case.part
        number, faulty = seen[kind], kind != case.part
        seen[kind] += 1
        before_a_merge = number == 0 if faulty else number % _SLOW == 0
        everyday = (
            number == 0 and case.part not in ("lookalikes", "pairs") and kind not in shown
            if faulty
            else number % _EVERYDAY == 0
        )  # fmt: skip
        marks = [] if everyday else [pytest.mark.slow] if before_a_merge else [pytest.mark.weekly]
        if everyday:
            seen["everyday"] += 1
            marks = [pytest.mark.quick] * (seen["everyday"] % _QUICK == 0)
        yield pytest.param(case, marks=marks, id=case.id)


ROWS = list(_rows())


@pytest.mark.parametrize("case", ROWS)
def test_a_case_is_judged_as_the_corpus_says(case: Case) -> None:
    found = disagreements(verdict(case))
    assert not found, "\n".join(found)


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
