"""The bits that a grading under a secret lets out by ten checks are those that SECURITY.md states."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from grader.engine.traces import Traces
from tests.hostile import channel
from tests.sandboxes import Opened

STATED = Path(__file__).parents[2] / "SECURITY.md"


@pytest.mark.weekly
def test_ten_checks_let_out_no_more_bits_than_stated(hidden: Traces, opened: Opened) -> None:
    with opened(hidden) as marker:
        found = channel.measured(marker)
    (stated,) = re.findall(r"([\d.]+) bits a grading by these ten", STATED.read_text(encoding="utf-8"))
    assert channel.bits(found) <= float(stated)
