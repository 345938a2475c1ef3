"""The recorded session of a student, replayed."""

from __future__ import annotations

import re

from tests.generated import STALE
from tests.session import RECORD, STEPS, replayed


def test_the_way_from_the_starter_files_to_100_is_as_it_was_recorded() -> None:
    shown = replayed()
    scores = [float(score) for score in re.findall(r"Score +([\d.]+) / 100", shown)]
    assert len(scores) == len(STEPS) == 6
    assert scores == sorted(scores)
    assert (scores[0], scores[-1]) == (0.0, 100.0)
    assert "imugrade explain sensor-id-as-address" in shown
    assert "Hand in  imu_reader.py, noisy_imu.py, filters.py, imu_data.png, filtered_imu.png" in shown
    assert shown == RECORD.read_text(encoding="utf-8"), STALE
