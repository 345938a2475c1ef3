"""What is told of a definition that does not fit in as the sheet's does."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from grader.engine.findings import Lost
from grader.ground.text import printable
from grader.labs.imu.checks.fitting import fits_in


@pytest.mark.quick
def test_a_misspelt_name_is_told_as_it_can_be_shown_and_cut() -> None:
    own = "Low\x1bPass" + "s" * 80
    student: Any = SimpleNamespace(completed_in=lambda name: (), misspelt=lambda name: (name, own))
    with pytest.raises(Lost) as lost:
        fits_in(student, "LowPassFilter", ())
    assert lost.value.got == f"{printable(own, 60)}, which was taken for it"
    assert "\x1b" not in lost.value.got
