"""What a check says: how large an error is, where an exception came from, and what of it can be shown."""

from __future__ import annotations

import pytest

from grader.engine.findings import (
    Fault,
    Size,
    Where,
)

pytestmark = pytest.mark.quick


@pytest.mark.parametrize(
    ("value", "unit", "said"),
    [
        (None, "m/s²", "it is off"),
        (0.123, "m/s²", "it is off by 0.1 to 1 m/s²"),
        (-0.123, "m/s²", "it is off by 0.1 to 1 m/s²"),
        (9.99, "", "it is off by 1 to 10"),
        (1.1e-12, "s", "it is off by 1e-12 to 1e-11 s"),
    ],
)
def test_of_a_size_the_power_of_ten_is_told(value: float | None, unit: str, said: str) -> None:
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
    fault = Fault("ValueError", "no", file, line, None)
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
    assert Fault("SyntaxError", "no", "a.py", 1, text).lines == lines
