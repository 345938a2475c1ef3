"""Two faults at once: no points come back, nothing is lost elsewhere, and no name belongs to neither. `python -m tests.pairs` judges all pairs."""

from __future__ import annotations

import pytest

from tests.pairs import Fault, judged, pairs
from tests.recordings import Marking

ROWS = [pytest.param(*pair, id=f"{pair[0][0]} and {pair[1][0]}") for pair in pairs(every=600)]


@pytest.mark.parametrize(("first", "second"), ROWS)
def test_a_second_fault_gives_nothing_back_and_costs_nothing_elsewhere(
    first: Fault, second: Fault, player: Marking
) -> None:
    assert judged(player, first, second).troubles == []
