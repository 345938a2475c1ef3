"""Handed-in pictures: one that no code draws earns half of what the drawn plot would."""

from __future__ import annotations

from grader.base.errors import NoAnswer
from grader.engine.findings import A_PERSON_MAY, Missing, Ours, Raised
from grader.engine.submission_session import found_once
from grader.engine.traces import Traces
from grader.labs.imu.checks.plot_runs import drawing_of_data, has_curves
from grader.labs.imu.student import Student

PICTURE = "imu_data.png"
_INK = (0.005, 0.6)
"""Share of a picture that is of none of its commonest colours: less is a blank sheet, more a photograph or noise.

The sheet's figure has 0.05 to 0.13 in any style and frame; axes without curves 0.009, noise 0.66 and more.
"""
_SMALLEST_PX = 150


def shows_something(student: Student, name: str) -> bool:
    """Whether a picture of that name was handed in, and may be a plot."""
    picture = student.picture(name)
    return picture is not None and _INK[0] < picture.ink < _INK[1] and min(picture.size_px) >= _SMALLEST_PX


@found_once
def counts(student: Student, truth: Traces) -> bool:
    """Return whether a plot was handed in that `plot_imu_data` does not draw; if so, add a note that sends it to a person."""
    if not shows_something(student, PICTURE) or _is_drawn(student, truth):
        return False
    student.note(
        Ours(
            f"{PICTURE} was handed in, and plot_imu_data does not draw it. The grader cannot read its curves and labels; "
            f"{A_PERSON_MAY}"
        )
    )
    return True


def _is_drawn(student: Student, truth: Traces) -> bool:
    try:
        return any(map(has_curves, drawing_of_data(student, truth).figures))
    except (Missing, NoAnswer, Raised):
        return False
