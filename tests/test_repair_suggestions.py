"""Suggested repairs: which broken programs have the sound one among the candidates that would be graded."""

from __future__ import annotations

import ast
import itertools
from collections import Counter

import pytest

from grader.course.repair_suggestions import MOST, _candidates, _Place
from tests.corpus.pieces import tidy, verbatim
from tests.corpus.repairable import REPAIRABLE, Repairable

pytestmark = pytest.mark.quick
DEFINED = {"imu_reader.py": "get_imu_readings", "noisy_imu.py": "NoisyIMU", "filters.py": "LowPassFilter"}
FOUND = {
    "syntax": 22, "unknown name": 12, "no return": 3, "array": 3, "another method": 0, "call that raises": 0, "put together": 5,
}  # fmt: skip
"""Programs of each group whose sound version is a candidate: 45 of 113."""


def _row(case: Repairable) -> int:
    """The line that Python names, or the first one that differs from the sound program."""
    try:
        ast.parse(case.text)
    except SyntaxError as refused:
        return (refused.lineno or 0) - 1
    sound = str((tidy() if "MODEL_PATH" in case.text else verbatim())[case.path]).split("\n")
    pairs = enumerate(zip(sound, case.text.split("\n"), strict=False))
    return next((row for row, (one, other) in pairs if one != other), -1)


def _is_found(case: Repairable) -> bool:
    sound = {ast.dump(ast.parse(str(base[case.path]))) for base in (verbatim(), tidy())}
    place = _Place(case.path, _row(case), DEFINED[case.path])
    candidates = itertools.islice(_candidates(case.text.encode(), place), MOST)
    return any(ast.dump(ast.parse(each.decode())) in sound for each in candidates)


def test_the_sound_program_is_among_the_candidates_of_as_many_as_before() -> None:
    found = Counter(case.name.partition(":")[0] for case in REPAIRABLE if _is_found(case))
    assert {group: found[group] for group in FOUND} == FOUND


@pytest.mark.parametrize("content", [b"\xff", b"x" * 100_001, b"(" * 5000, b""])
def test_what_cannot_be_read_has_no_candidates(content: bytes) -> None:
    assert list(itertools.islice(_candidates(content, _Place("f.py", 0, "f")), MOST)) == []
