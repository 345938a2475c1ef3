"""Suggested repairs: which broken programs have the sound one among the candidates that would be graded."""

from __future__ import annotations

import ast
import itertools
import time
from collections import Counter
from dataclasses import replace

import pytest

from grader.course.repairs import suggestions
from grader.course.repairs.candidates import Candidates, candidates, limited
from grader.course.repairs.suggestions import MOST, suggest
from grader.engine.findings import Where
from grader.engine.results import CheckResult, CriterionResult, Result
from grader.intake import Submission
from grader.labs.imu.lab import LAB
from tests.corpus.cases import Case, of
from tests.corpus.pieces import tidy, verbatim

pytestmark = pytest.mark.quick
DEFINED = {"imu_reader.py": "get_imu_readings", "noisy_imu.py": "NoisyIMU", "filters.py": "LowPassFilter"}
FOUND = {
    "syntax": 22, "unknown name": 12, "no return": 3, "array": 3, "another method": 0, "call that raises": 0, "put together": 5,
}  # fmt: skip
"""Programs of each group whose sound version is a candidate: 45 of 113."""


def _row(case: Case) -> int:
    """The line that Python names, or the first one that differs from the sound program."""
    try:
        ast.parse(case.text)
    except SyntaxError as refused:
        return (refused.lineno or 0) - 1
    sound = str((tidy() if "MODEL_PATH" in case.text else verbatim())[case.file]).split("\n")
    pairs = enumerate(zip(sound, case.text.split("\n"), strict=False))
    return next((row for row, (one, other) in pairs if one != other), -1)


def _is_found(case: Case) -> bool:
    sound = {ast.dump(ast.parse(str(base[case.file]))) for base in (verbatim(), tidy())}
    made = itertools.islice(candidates(case.text.encode(), _row(case), DEFINED[case.file]), MOST)
    return any(ast.dump(ast.parse(each.decode())) in sound for each in made)


def test_the_sound_program_is_among_the_candidates_of_as_many_as_before() -> None:
    found = Counter(case.name.partition(":")[0] for case in of("repairable") if _is_found(case))
    assert {group: found[group] for group in FOUND} == FOUND


@pytest.mark.parametrize(
    ("written", "meant", "row"),
    [
        ("def f(x):\n    retrun x\n", "def f(x):\n    return x\n", 1),
        ("dfe f(x):\n    return x\n", "def f(x):\n    return x\n", 0),
        ("for k in x:\n    brek\n", "for k in x:\n    break\n", 1),
        (">>> def f(x):\n...     return x\n...\n", "def f(x):\n    return x\n", 0),
        ("import math\n>>> y = math.pi\n", "import math\ny = math.pi\n", 1),
        ("def f(x)):\n    return x\n", "def f(x):\n    return x\n", 0),
    ],
)
def test_a_misspelt_keyword_a_pasted_prompt_and_a_token_too_many_are_put_right(
    written: str, meant: str, row: int
) -> None:
    made = itertools.islice(candidates(written.encode(), row, "f"), MOST)
    assert ast.dump(ast.parse(meant)) in [ast.dump(ast.parse(each.decode())) for each in made]


@pytest.mark.parametrize("content", [b"\xff", b"x" * 100_001, b"(" * 5000, b""])
def test_what_cannot_be_read_has_no_candidates(content: bytes) -> None:
    assert list(itertools.islice(candidates(content, 0, "f"), MOST)) == []


def test_edits_are_made_in_a_process_that_a_limit_ends() -> None:
    assert limited(b"y = f(g(x, 1)\n", 0, "", 1).files == (b"y = f(g(x, 1))\n",)  # and not f(g(x), 1)
    began = time.monotonic()
    endless = b"x = ((((\n" + b"a, " * 30_000 + b"\n" + b"b, " * 300  # no edit closes it; 1500 are read to the end
    assert limited(endless, 2, "f", MOST, cpu_s=1) == Candidates(cpu_s=1)
    assert time.monotonic() - began < 20


BROKEN = Submission("x", "x", {"filters.py": b"broken", "noisy_imu.py": b"broken"}, (), "ready", "0")


def graded(handed_in: Submission, cpu_s: float | None = None) -> Result:
    """The result of files that are broken or hold the points that they earn, of 6 and of 8."""
    rows = [
        CheckResult(id_, "", "error", 0.0, most, where=Where(file, row))
        if handed_in.files[file] == b"broken"
        else CheckResult(id_, "", "partial", float(handed_in.files[file]), most)
        for id_, file, row, most in (
            ("filtering.follows_recursion", "filters.py", 1, 6.0), ("noise_model.noise_size", "noisy_imu.py", 2, 8.0)
        )
    ]  # fmt: skip
    parts = (CriterionResult(row.id.partition(".")[0], "", row.max_points, (row,)) for row in rows)
    return Result("x", "graded", tuple(parts), cpu_s=0.1)


@pytest.mark.parametrize(
    ("filters", "noisy", "suggested"),
    [
        ((b"2", b"2.0"), (b"3", b"3.0"), ("noisy_imu.py", b"3", 1)),
        ((b"2", b"2.0"), (b"3", b"4"), ("filters.py", b"2", 1)),
        ((b"2", b"3"), (b"3", b"4"), None),
    ],
)
def test_the_costliest_place_whose_edits_earn_the_same_score_is_suggested_with_its_first_edit(
    filters: tuple[bytes, ...], noisy: tuple[bytes, ...], suggested: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(suggestions, "limited", lambda content, row, *_: Candidates((filters, noisy)[row]))
    found = suggest(BROKEN, graded(BROKEN), LAB, graded)
    assert (found and (found.file, found.content, found.alike)) == suggested


def test_candidates_and_cpu_time_are_those_of_the_whole_submission(monkeypatch: pytest.MonkeyPatch) -> None:
    budgets: list[float | None] = []
    broken = graded(BROKEN)

    def asked(edits_cpu_s: float, mark_cpu_s: float) -> list[float | None]:
        def made(content: bytes, row: int, name: str, most: int) -> Candidates:
            return Candidates(tuple(b"%d" % number for number in range(most)), edits_cpu_s)

        def mark(submission: Submission, cpu_s: float | None = None) -> Result:
            budgets.append(cpu_s)
            return replace(broken, cpu_s=mark_cpu_s)

        budgets.clear()
        monkeypatch.setattr(suggestions, "limited", made)
        assert suggest(BROKEN, broken, LAB, mark) is None
        return budgets

    assert asked(edits_cpu_s=2.0, mark_cpu_s=1.0) == [float(left) for left in range(18, 0, -1)]
    assert len(asked(edits_cpu_s=0.0, mark_cpu_s=0.1)) == MOST
