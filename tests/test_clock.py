"""Code that looks at the clock gets the same marks and words in every run, whatever else the machine does."""

from __future__ import annotations

import pytest

from grader.engine.grader import Marker
from tests.corpus.pieces import COLLECT_WHILE, lab
from tests.single_faults import marked

BY_THE_CLOCK = COLLECT_WHILE.replace(
    "while data.time < duration_seconds:", "start = time.CLOCK()\n    while time.CLOCK() - start < SECONDS:"
)


def told(marker: Marker, files: dict[str, str]) -> list[tuple[str, float | None, str]]:
    (criterion,) = marked(marker, files, "data_collection").criteria
    return [(check.id, check.points, check.message) for check in criterion.checks]


@pytest.mark.parametrize(
    ("clock", "seconds"),
    [("time", "duration_seconds"), ("perf_counter", "duration_seconds"), ("time_ns", "1e9"), ("process_time", "0.5")],
)
def test_a_loop_that_goes_by_the_clock_makes_as_many_rounds_in_every_run(
    marker: Marker, clock: str, seconds: str
) -> None:
    collect = "import time\n\n\n" + BY_THE_CLOCK.replace("CLOCK", clock).replace("SECONDS", seconds)
    first, second = (told(marker, lab(collect=collect)) for _ in range(2))
    assert first == second
    lost = {check for check, points, _ in first if not points}
    assert "data_collection.sample_count" in lost, "it is not the simulation's time"


def test_a_loop_that_keeps_pace_with_the_clock_is_sound(marker: Marker) -> None:
    pace = "        began = time.time()\n        mujoco.mj_step(model, data)\n        time.sleep(max(0.0, model.opt.timestep - (time.time() - began)))\n"
    collect = "import time\n\n\n" + COLLECT_WHILE.replace("        mujoco.mj_step(model, data)\n", pace)
    assert all(points for _, points, _ in told(marker, lab(collect=collect)))
