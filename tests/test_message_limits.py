"""Tests that limits fit each other: any accepted submission can be sent to a worker, and any answer can be sent back in a question."""

from __future__ import annotations

import pytest

from grader.engine.grader import Marker
from grader.intake.file_budget import MAX_FILES
from tests.corpus.pieces import edit, verbatim
from tests.single_faults import marked

LARGE = edit(
    verbatim(),
    "imu_reader.py",
    ("    return {\n", "    more = {f'more{n}': np.zeros(585_000) for n in range(7)}\n    return {**more,\n"),
)
"""A recording just below the cap of an answer, 32 MiB: 4,095,000 numbers beside its three series."""


@pytest.mark.parametrize("part", ["data_collection", "visualization"])
def test_a_recording_just_below_the_cap_is_judged_in_every_question(marker: Marker, part: str) -> None:
    result = marked(marker, LARGE, part)
    assert result.status == "graded"
    assert {check.outcome for check in result.criteria[0].checks} == {"passed"}


def test_a_recording_above_the_cap_costs_its_own_checks(marker: Marker) -> None:
    larger = {**LARGE, "imu_reader.py": LARGE["imu_reader.py"].replace("range(7)", "range(8)")}
    result = marked(marker, larger)
    assert result.status == "graded"
    assert [criterion.points for criterion in result.criteria] == [20, 0, 20, 20, 20]


@pytest.mark.parametrize("letter", ["m", "語"])
def test_a_thousand_programs_and_a_thousand_tables_with_the_longest_names_are_sent(marker: Marker, letter: str) -> None:
    wide = max(1, 240 // len(letter.encode()))
    folder = "/".join([letter * wide] * 3)
    more = {f"{folder}/{n:04}.py": "x = 1\n" for n in range(MAX_FILES)}
    more |= {f"{folder}/{n:04}.csv": "1,2\n" for n in range(MAX_FILES)}
    result = marked(marker, {**verbatim(), **more}, "filtering")
    assert (result.status, result.criteria[0].points) == ("graded", 20)
