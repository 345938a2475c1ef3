"""What a check says: how large an error is, where an exception came from, and what of it can be shown."""

from __future__ import annotations

import numpy as np
import pytest

from grader.engine.findings import CheckFailed, Raised, Size, StudentError, Where, raised
from grader.labs.imu.compare import distinct_texts
from tests.judging import test_filtering
from tests.judging.fake_students import all_cases, pinned

pytestmark = pytest.mark.quick
_ERROR = StudentError("ValueError", "no", "imu_reader.py", 12, "    return 1 / 0")


@pytest.mark.parametrize(
    ("value", "unit", "said"),
    [
        (None, "m/s²", "it is off"),
        (-0.123, "m/s²", "it is off by 0.1 to 10 m/s²"),
        (1.1e-12, "s", "it is off by less than 0.1 s"),
        (float("nan"), "s", "it is off by more than 10 s"),
        (1e12, "s", "it is off by more than 10 s"),
    ],
)
def test_of_a_size_one_of_three_steps_is_told(value: float | None, unit: str, said: str) -> None:
    assert str(Size("it is off", value, unit)) == said


@pytest.mark.parametrize(
    ("file", "line", "where", "at"),
    [
        ("imu_reader.py", 12, "imu_reader.py, line 12", Where("imu_reader.py", 12)),
        ("lab.ipynb:cell 3", 4, "lab.ipynb, cell 3, line 4", Where("lab.ipynb")),
        ("a\x1bb.py", 1, "a\\x1bb.py, line 1", Where("a\\x1bb.py", 1)),
        (f"{'a' * 130}.py", 1, f"{'a' * 119}…, line 1", Where(f"{'a' * 119}…", 1)),
        (None, 12, "", None),
    ],
)
def test_a_place_is_told_by_file_and_line(file: str | None, line: int | None, where: str, at: Where | None) -> None:
    fault = StudentError("ValueError", "no", file, line, None)
    assert (fault.where, fault.at) == (where, at)


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        (None, []),
        ("    return 1 / 0", ["    return 1 / 0"]),
        ("def f(:\n      ^\nmore", ["def f(:", "      ^"]),
        ("x = '\x1b'", ["x = '\\x1b'"]),
        ("x" * 161, ["x" * 159 + "…"]),
    ],
)
def test_of_a_line_what_can_be_shown_is_shown_with_the_caret_below(text: str | None, lines: list[str]) -> None:
    assert StudentError("SyntaxError", "no", "a.py", 1, text).lines == lines


def test_a_loss_says_what_was_expected_and_what_came() -> None:
    lost = CheckFailed("1 m/s²", "2 m/s²")
    assert str(lost) == "expected 1 m/s²; got 2 m/s²"
    assert (lost.expected, lost.got, lost.off, lost.hint, lost.where) == ("1 m/s²", "2 m/s²", None, "", None)
    assert (lost.faults, lost.keeps) == ((), 0.0)
    size = Size("it is off", 1.0)
    more = CheckFailed("a", "b", faults=["no-bias"], keeps=0.5, hint="Look.", off=size, error=_ERROR)
    assert (more.faults, more.keeps, more.hint, more.off) == (("no-bias",), 0.5, "Look.", size)
    assert more.where == Where("imu_reader.py", 12)


def test_an_exception_stops_a_check_and_says_what_was_done() -> None:
    raised(None, "reading the sensors")
    with pytest.raises(Raised) as stopped:
        raised(_ERROR, "reading the sensors")
    assert str(stopped.value) == "ValueError: no"
    assert (stopped.value.error, stopped.value.doing) == (_ERROR, "reading the sensors")


def test_two_vectors_are_never_shown_with_the_same_digits_where_they_differ() -> None:
    assert distinct_texts(np.array([1.0, 2.0]), np.array([1.00004, 2.0])) == ("[1.00000 2.00000]", "[1.00004 2.00000]")
    assert distinct_texts(np.array([1.0]), np.array([2.0])) == ("[1.000]", "[2.000]")


def test_the_words_are_those_of_cases_that_each_have_a_name_of_their_own() -> None:
    names = [case.id for case in all_cases()]
    assert len(set(names)) == len(names)
    assert set(pinned()) <= {*names, *test_filtering.all_words()}
