"""The whole corpus, judged from recordings on every change."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import pytest

from tests.recordings.losses import disagreements, pinned, pins
from tests.recordings.marker import recorded_corpus, verdict
from tests.scoreboard import Case

pytestmark = [pytest.mark.quick, pytest.mark.recorded]
FAULTY = ("faulty", "lookalikes", "pairs")
_MANY = 48
BATCHES = [recorded_corpus()[first::_MANY] for first in range(_MANY)]
"""Every case once, spread so that each batch takes about as long as another."""
_EVERYDAY = 12
"""Each twelfth batch runs without `-m full`, and every other one of them with `-m quick`."""


def _marks(batch: int) -> list[pytest.MarkDecorator]:
    """Return the markers that leave a batch out of shorter runs."""
    return [pytest.mark.slow] if batch % _EVERYDAY else [pytest.mark.longer] if batch % (2 * _EVERYDAY) else []


@pytest.mark.parametrize(
    "cases",
    [pytest.param(cases, marks=_marks(n)) for n, cases in enumerate(BATCHES)],
    ids=range(len(BATCHES)),
)
def test_every_case_is_judged_as_the_corpus_says(cases: Sequence[Case]) -> None:
    assert [line for case in cases for line in disagreements(verdict(case))] == []


def test_the_corpus_is_as_large_as_it_was() -> None:
    parts = Counter(case.part for case in recorded_corpus())
    assert parts["sound"] >= 150
    assert sum(parts[part] for part in FAULTY) >= 350
    assert parts["broken"] >= 150
    assert parts["extensions"] >= 50


def test_losses_are_pinned_of_cases_that_there_are() -> None:
    assert set(pinned()) <= {case.id for case in recorded_corpus() if pins(case)}
