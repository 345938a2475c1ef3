"""Pictures that were handed in and that no code draws: they are looked at, and what they show counts for a half."""

from __future__ import annotations

from pathlib import PurePath

from grader.engine.conversation import Missing
from grader.engine.figures import Figure
from grader.engine.findings import A_PERSON_MAY, Raised
from grader.engine.traces import Traces
from grader.ground.errors import NoAnswer
from grader.labs.imu import bundles
from grader.labs.imu.checks.plot_runs import drawing_of_data, has_curves, series_of
from grader.labs.imu.diagnosis import comparing
from grader.labs.imu.diagnosis.handed_in import sensors_shown
from grader.labs.imu.robot import LAB_MODEL, is_of
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


def counts(student: Student, truth: Traces) -> bool:
    """Whether the handed-in plot shows both sensors of the recording, and no code draws any plot."""
    return student.once("handed in", lambda: _counts(student, truth))


def _counts(student: Student, truth: Traces) -> bool:
    picture = student.picture(PICTURE)
    if picture is None or min(picture.size_px) < _SMALLEST_PX or _is_drawn(student, truth):
        return False
    shown = sensors_shown(picture.preview, picture.palette, series_of(_public(truth), "push"))
    if shown == {0, 1}:
        student.note(
            f"{PICTURE} was handed in, and no code draws it: its labels were not read, and {A_PERSON_MAY} for them"
        )
    return shown == {0, 1}


def _public(truth: Traces) -> Traces:
    """Of the lab's robot the public traces, whatever is graded with: whoever made a picture beforehand knew no secret."""
    return bundles.shipped() if is_of(LAB_MODEL, truth) else truth


def _is_drawn(student: Student, truth: Traces) -> bool:
    try:
        if any(map(has_curves, drawing_of_data(student, truth).figures)):
            return True
    except (Missing, NoAnswer, Raised):
        pass
    return any(_is_of_data(figure) for drawing in student.scripts() for figure in drawing.figures)


def _is_of_data(figure: Figure) -> bool:
    """Whether a script's figure is the plot of the data: it goes by that name, or is none of raw and filtered data.

    What a broken filter makes of the data may look like neither; then the name of the file tells.
    """
    if not has_curves(figure):
        return False
    name = PurePath(figure.path or "").name
    compares = bool(comparing.comparisons(figure) or comparing.named_comparisons(figure) or "filter" in name)
    return name == PICTURE or (len(figure.axes) > 1 and not compares)
