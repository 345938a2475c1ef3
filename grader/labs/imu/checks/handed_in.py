"""Pictures that were handed in: one that no code draws counts for a half, any other one is held against what the code draws."""

from __future__ import annotations

from collections.abc import Sequence

from grader.base.errors import NoAnswer
from grader.engine.figures import Figure, Picture
from grader.engine.findings import A_PERSON_MAY, ANOTHER_VERSION, Missing, Ours, Raised
from grader.engine.submission_session import found_once
from grader.engine.traces import Traces
from grader.labs.imu import bundles
from grader.labs.imu.answers import Drawing
from grader.labs.imu.checks.plot_runs import (
    candidates,
    drawing_of_data,
    has_curves,
    sensors_in_words,
    series_of,
)
from grader.labs.imu.diagnosis import comparing
from grader.labs.imu.diagnosis.channel_match import sensors_of
from grader.labs.imu.diagnosis.handed_in import sensors_shown
from grader.labs.imu.robot import LAB_MODEL, is_of
from grader.labs.imu.student import Student

PICTURE = "imu_data.png"
_INK = (0.005, 0.6)
"""Share of a picture that is of none of its commonest colours: less is a blank sheet, more a photograph or noise.

The sheet's figure has 0.05 to 0.13 in any style and frame; axes without curves 0.009, noise 0.66 and more.
"""
_SMALLEST_PX = 150
_BOTH = {0, 1}
_MOST_CURVES = 100


def shows_something(student: Student, name: str) -> bool:
    """Whether a picture of that name was handed in, and may be a plot."""
    picture = student.picture(name)
    return picture is not None and _INK[0] < picture.ink < _INK[1] and min(picture.size_px) >= _SMALLEST_PX


@found_once
def counts(student: Student, truth: Traces) -> bool:
    """Return whether the handed-in plot shows both sensors and no code draws a plot of the data; if so, add a note."""
    picture = _plot(student)
    if picture is None or _is_drawn(student, truth) or not _shows_both(picture, truth):
        return False
    student.note(
        Ours(
            f"{PICTURE} was handed in, and no code draws it. The grader cannot read its labels; {A_PERSON_MAY} for them"
        )
    )
    return True


def _plot(student: Student) -> Picture | None:
    picture = student.picture(PICTURE)
    return None if picture is None or min(picture.size_px) < _SMALLEST_PX else picture


def _shows_both(picture: Picture, truth: Traces) -> bool:
    return sensors_shown(picture.preview, picture.palette, series_of(_public(truth), "push")) == _BOTH


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
    return figure.file_name == PICTURE or (len(figure.axes) > 1 and not _compares(figure))


def _compares(figure: Figure) -> bool:
    return bool(comparing.comparisons(figure) or comparing.named_comparisons(figure) or "filter" in figure.file_name)


# --- held against the code -----------------------------------------------------------------------------------------------


def hold_against_code(student: Student, truth: Traces) -> None:
    """A note where the picture shows both sensors and nothing that the code draws can be one of them; it costs nothing.

    That a picture is not recognised tells nothing: of honest ones one in eleven is not. So a picture is looked at only where the
    code draws too little, and all that the code draws is taken for the recording that it may be.
    """
    if PICTURE not in student.files:
        return
    missing = _missing_from_plot(student, truth)
    picture = _plot(student) if missing else None
    if picture is None or not _shows_both(picture, truth):
        return
    scripts = list(student.scripts())
    plots = [figure for drawing in scripts for figure in drawing.figures if _may_be_the_plot(figure)]
    missing &= _missing_from(plots, truth) if all(map(_is_known, scripts)) else set()
    if missing:
        student.note(
            Ours(
                f"{PICTURE} was handed in and shows both sensors. The plot that the code draws shows no "
                f"{sensors_in_words(missing)}: {ANOTHER_VERSION}"
            )
        )


def _missing_from_plot(student: Student, truth: Traces) -> set[int]:
    """The sensors of which `plot_imu_data` draws no curve in any of its figures; none where it draws nothing at all."""
    try:
        drawing = drawing_of_data(student, truth)
    except (Missing, NoAnswer, Raised):
        return set()
    if not any(map(has_curves, drawing.figures)):
        return set()
    drawn = {sensor for plot in candidates(student, truth, drawing) for sensor, _ in plot.drawn}
    return _missing_from(drawing.figures, truth) if drawn != _BOTH and _is_known(drawing) else set()


def _may_be_the_plot(figure: Figure) -> bool:
    """Return whether a figure may be the data plot: it is saved as `PICTURE`, or does not compare raw and filtered data."""
    return figure.file_name == PICTURE or not _compares(figure)


def _missing_from(figures: Sequence[Figure], truth: Traces) -> set[int]:
    """The sensors that no curve of the figures can be; none where there are too many curves to tell."""
    recordings = [series_of(truth), series_of(truth, "push"), series_of(_public(truth), "push")]
    curves = [curve for figure in figures for axes in figure.axes for curve in axes.curves]
    if len(curves) > _MOST_CURVES:
        return set()
    return _BOTH - {sensor for curve in curves for sensor in sensors_of(curve, recordings)}


def _is_known(drawing: Drawing) -> bool:
    """Whether it came to its end, and every picture is of a figure that could be read."""
    strange = [picture for picture in drawing.strange if not picture.reason]
    return drawing.fault is None and not strange and all(figure.pixels.size for figure in drawing.figures)
