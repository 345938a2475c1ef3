"""The same fault costs the same in any style, and has the same name."""

from __future__ import annotations

import pytest

from tests.corpus.cases import Case
from tests.corpus.styles import FAULTS, SOUND, TEMPLATES, Fault, styles_of
from tests.recordings.marker import verdict

CRITERIA = {"read": "sensor_access", "collect": "data_collection", "noise": "noise_model", "low_pass": "filtering"}
SPREAD = 0.5
"""Points: a rounding of shares to two decimals stays far below it, one more lost property is above it."""
EVERYDAY = 14
"""Each fourteenth fault is written in all styles with `-m full`; the others with `-m weekly`."""


def _judged(fault: Fault) -> dict[str, tuple[float, tuple[str, ...]]]:
    """Return the points lost and the faults named, by style."""
    found = {}
    for style, files in styles_of(fault):
        case = Case("faulty", f"{fault.name} as {style}", files, criterion=CRITERIA[fault.part], fault=fault.id)
        result = verdict(case).result
        assert result is not None
        found[style] = round(100 - float(result.score or 0), 2), result.misconceptions
    return found


@pytest.mark.parametrize("part", TEMPLATES)
def test_every_style_is_sound_without_a_fault(part: str) -> None:
    assert {lost for lost, _ in _judged(Fault(part, "", {})).values()} == {0.0}


@pytest.mark.parametrize(
    "fault",
    [
        pytest.param(fault, marks=[pytest.mark.weekly] if n % EVERYDAY else [], id=fault.name)
        for n, fault in enumerate(FAULTS)
    ],
)
def test_a_fault_costs_the_same_in_every_style_and_has_its_name(fault: Fault) -> None:
    judged = _judged(fault)
    lost = [points for points, _ in judged.values()]
    assert max(lost) - min(lost) <= SPREAD, judged
    assert all(fault.id in names for _, names in judged.values()), judged


def test_every_slot_of_a_fault_is_one_of_its_templates() -> None:
    for fault in FAULTS:
        for template in TEMPLATES[fault.part].values():
            assert fault.slots.keys() <= SOUND.keys()
            assert all(f"<{slot}>" in template for slot in fault.slots)
