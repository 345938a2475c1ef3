"""The shipped rubric as text, with parts replaced."""

from __future__ import annotations

from grader.engine import rubric
from grader.labs.imu.lab import LAB

SHIPPED = rubric.shipped(LAB).read_text(encoding="utf-8")


def edited(old: str, new: str, text: str = SHIPPED) -> str:
    """Return a rubric with one part replaced, where it stands first."""
    assert old in text, old
    return text.replace(old, new, 1)


def line_of(text: str, part: str) -> int:
    """Return the number of the line in which a part begins that stands once or is meant where it stands first."""
    return text[: text.index(part)].count("\n") + 1
