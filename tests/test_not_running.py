"""Code that does not run costs the checks that need it and no others; nobody's code is edited to make it run."""

from __future__ import annotations

import pytest

from tests.corpus.cases import Case, of
from tests.recordings import Marking
from tests.single_faults import lost_by, marked

DEFINED_IN = {
    "imu_reader.py": {"sensor_access", "data_collection", "visualization"},
    "noisy_imu.py": {"noise_model"},
    "filters.py": {"filtering"},
}
"""The criteria whose definitions stand in each file."""


@pytest.mark.parametrize("case", of("repairable"), ids=lambda case: case.name)
def test_it_costs_what_needs_it_alone(case: Case, player: Marking) -> None:
    lost = {check.partition(".")[0] for check in lost_by(marked(player, case.files))}
    assert lost <= DEFINED_IN[case.file]
    assert len(lost) == (len(DEFINED_IN[case.file]) if case.name.startswith("syntax") else 1)
