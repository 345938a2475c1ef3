"""Handed-in pictures of plots, whose curves nobody can read: only whether there is one that may be a plot."""

from __future__ import annotations

from grader.labs.imu.lab import LAB
from grader.labs.imu.student import Student

PICTURE, COMPARISON = LAB.pictures
_INK = (0.005, 0.6)
"""Share of a handed-in picture that has none of its commonest colours: less is a blank sheet, more a photograph or noise.

The sheet's figure has 0.05 to 0.13 in any style and frame, noise 0.66 and more.
"""
_SMALLEST_PX = 150


def was_handed_in(student: Student, name: str) -> bool:
    """Return whether a picture of that name was handed in and may be a plot: not tiny, not blank, no photograph."""
    picture = student.picture(name)
    return picture is not None and _INK[0] < picture.ink < _INK[1] and min(picture.size_px) >= _SMALLEST_PX
