"""The hostile corpus on the best isolation level that there is: in a reduced form on every change, all of it each week."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from grader.engine.grader import Marker
from grader.engine.results import to_json
from grader.intake import read_submission
from grader.labs.imu.lab import LAB
from grader.sandbox.isolation_levels import NO_ISOLATION
from tests.corpus.pieces import FILTER_INCREMENT, tidy
from tests.corpus.writing import write
from tests.durability import grade, results
from tests.fake_results import without_durations
from tests.hostile.corpus import PROGRAMS
from tests.hostile.judging import AttackJudge
from tests.hostile.program import FAMILIES

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks for leftovers in /proc")

REDUCED = (
    "numpy-comparisons-say-yes", "json-writes-another-answer", "axes-lie-about-their-labels", "canned-picture-copied-at-run-time",
    "exits-hard-with-success", "an-answer-with-a-guessed-nonce", "a-thief-reads-the-next-question", "changes-the-worker-code-in-memory",

    "forks-twenty-times", "returns-a-huge-view",

    "tcp", "signals-another-process", "reads-outside", "writes-outside", "daemon", "leaves-files-for-the-next", "finds-what-another-left",

    "zip-whose-entries-overlap", "png-of-no-pixels",

    "error-says-ansi", "labels-say-html", "carries-hidden-states-in-a-line-number",
)
BY_NAME = {program.name: program for program in PROGRAMS}


@pytest.fixture(scope="module")
def attack_judge() -> Iterator[AttackJudge]:
    """One judge on the best isolation level of this machine."""
    with AttackJudge(None) as attack_judge:
        if attack_judge.isolation_level == NO_ISOLATION.name:
            pytest.skip("nothing isolates here")
        yield attack_judge


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.plain] if name == REDUCED[0] else [] if name in REDUCED else [pytest.mark.weekly])
        for name in BY_NAME
    ],
)
def test_a_hostile_submission_gains_nothing_and_touches_nothing(attack_judge: AttackJudge, name: str) -> None:
    assert attack_judge.try_(BY_NAME[name]).troubles == []


def test_names_are_unique_every_family_is_there_and_every_forgery_has_its_honest_twin() -> None:
    assert len(BY_NAME) == len(PROGRAMS) >= 80
    assert {BY_NAME[name].family for name in REDUCED} == set(FAMILIES)
    assert [program.name for program in PROGRAMS if program.family == "forgery" and program.twin is None] == []


NEIGHBOURS = ("builtins-say-yes", "daemon", "error-says-ansi")


def test_a_class_has_the_same_marks_with_and_without_hostile_neighbours(tmp_path: Path, marker: Marker) -> None:
    wrong = "import numpy as np\n\n\n" + FILTER_INCREMENT.replace("self.alpha * (x", "0.5 * self.alpha * (x")
    expected = {}
    for name, code in (("m-sound", str(tidy()["filters.py"])), ("p-wrong", wrong)):
        path = write({"filters.py": code}, tmp_path / "mixed" / name)
        expected[name] = json.loads(to_json(marker.mark(read_submission(path, LAB.files))))
    for number, name in enumerate(NEIGHBOURS):
        alone = {"filters.py": BY_NAME[name].files["filters.py"]}  # where all of these attacks are
        write(alone, tmp_path / "mixed" / f"{'ago'[number % 3]}-hostile{number}")
    assert grade(tmp_path / "mixed", tmp_path / "out").returncode == 0
    found = results(tmp_path / "out")
    assert len(found) == len(expected) + len(NEIGHBOURS)
    assert {name: found[name] for name in expected} == without_durations(expected)

