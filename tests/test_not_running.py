"""Code that does not run costs the checks that need it and no others; a part that does nothing keeps a few points for its form."""

from __future__ import annotations

from collections import defaultdict

import pytest

from tests.corpus.cases import Case, of
from tests.recordings import Marking
from tests.scoreboard import graded_by
from tests.single_faults import lost_by, marked

DEFINED_IN = {
    "imu_reader.py": {"sensor_access", "data_collection", "visualization"},
    "noisy_imu.py": {"noise_model"},
    "filters.py": {"filtering"},
}
"""The criteria whose definitions stand in each file."""


def _judged() -> list[Case]:
    """Return the first and the last case of each group in each file; the others end in the same way, and only their repair differs."""
    alike = defaultdict[tuple[str, str], list[Case]](list)
    for case in of("repairable"):
        alike[case.name.partition(":")[0], case.file].append(case)
    return [case for cases in alike.values() for case in (cases if len(cases) < 2 else (cases[0], cases[-1]))]


@pytest.mark.parametrize("case", _judged(), ids=lambda case: case.name)
def test_it_costs_what_needs_it_alone(case: Case, player: Marking) -> None:
    lost = {check.partition(".")[0] for check in lost_by(marked(player, case.files))}
    assert lost <= DEFINED_IN[case.file]
    assert len(lost) == (len(DEFINED_IN[case.file]) if case.name.startswith("syntax") else 1)


@pytest.mark.parametrize("nothing", of("nothing"), ids=lambda nothing: nothing.name)
def test_a_part_that_does_nothing_keeps_a_few_points_for_its_form(nothing: Case, player: Marking) -> None:
    assert graded_by(player, nothing).troubles == []
